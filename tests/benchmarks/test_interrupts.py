"""The benchmark of interrupts, on programs that only sleep."""

from pathlib import Path

from benchmarks import interrupts


def test_a_wait_is_from_the_signal_to_the_end():
    program = "import time; print('begun', flush=True); time.sleep(60)"
    assert interrupts._seconds(program, Path("a"), 0.1) < 30


def test_what_has_ended_before_has_no_wait():
    assert interrupts._seconds("print('begun', flush=True)", Path("a"), 30.0) is None
    assert interrupts._seconds("print('begun', flush=True)", Path("a"), None) > 0
