"""The benchmark of interrupts, on programs that only sleep."""

import signal
from pathlib import Path

import pytest

from benchmarks import interrupts


@pytest.mark.parametrize("how", [signal.default_int_handler, signal.SIG_IGN])
def test_a_wait_is_from_the_signal_to_the_end(how, tmp_path):
    """Whether this process ignores the signal, as jobs behind a shell do, or not."""
    before = signal.signal(signal.SIGINT, how)
    written = tmp_path / "written"
    program = "import sys, time; print('begun', flush=True); time.sleep(60); open(sys.argv[1], 'x')"
    try:
        assert interrupts._seconds(program, written, 0.1) > 0
    finally:
        signal.signal(signal.SIGINT, before)
    assert not written.exists()  # it did not go on to its end


def test_what_has_ended_before_has_no_wait():
    assert interrupts._seconds("print('begun', flush=True)", Path("a"), 30.0) is None
    assert interrupts._seconds("print('begun', flush=True)", Path("a"), None) > 0
