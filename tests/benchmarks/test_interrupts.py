"""The benchmark of interrupts, on programs that only sleep."""

import signal
from pathlib import Path

import pytest

from benchmarks import interrupts


@pytest.mark.parametrize("how", [signal.default_int_handler, signal.SIG_IGN])
def test_a_wait_is_from_the_signal_to_the_end(how):
    """Whether this process ignores the signal, as jobs behind a shell do, or not."""
    before = signal.signal(signal.SIGINT, how)
    program = "import time; print('begun', flush=True); time.sleep(60)"
    try:
        assert interrupts._seconds(program, Path("a"), 0.1) < 30
    finally:
        signal.signal(signal.SIGINT, before)


def test_what_has_ended_before_has_no_wait():
    assert interrupts._seconds("print('begun', flush=True)", Path("a"), 30.0) is None
    assert interrupts._seconds("print('begun', flush=True)", Path("a"), None) > 0
