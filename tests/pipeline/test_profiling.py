"""The timer of stages: seconds, peak memory, and stages that a time limit skips."""

import time

import pytest

from lbskel.pipeline import profiling
from lbskel.pipeline.profiling import StageTimer


@pytest.fixture
def clock(monkeypatch):
    """A clock that stands still until it is advanced."""
    now = [100.0]
    monkeypatch.setattr(profiling.time, "perf_counter", lambda: now[0])

    def advance(seconds):
        now[0] += seconds

    return advance


def test_the_seconds_of_a_stage_add_up(clock):
    timer = StageTimer(_began=100.0)
    for seconds in (1.0, 2.5):
        with timer("contract"):
            clock(seconds)
    with timer("score"):
        clock(0.5)
    assert timer.seconds == {"contract": 3.5, "score": 0.5}


def test_the_caller_is_called_as_a_stage_begins(clock):
    names = []
    timer = StageTimer(on_stage=names.append)
    with timer("read"):
        assert names == ["read"]


def test_a_stage_without_time_is_skipped_and_listed_once(clock):
    timer = StageTimer(time_limit=2.0, _began=100.0)
    assert timer.has_time_for("recenter")
    clock(1.5)
    assert timer.seconds_left == pytest.approx(0.5)
    clock(1.0)
    assert not timer.has_time_for("extend tips")
    assert not timer.has_time_for("extend tips")
    assert timer.skipped == ["extend tips"]


def test_without_a_limit_there_is_always_time():
    timer = StageTimer()
    assert timer.seconds_left == float("inf")
    assert timer.has_time_for("anything")
    assert timer.skipped == []


@pytest.mark.skipif(not profiling.RESET_PEAK.exists(), reason="this system keeps no record of the peak")
def test_memory_is_the_peak_within_the_stage(python):
    program = """
import numpy as np
from lbskel.pipeline.profiling import StageTimer
timer = StageTimer(measures_memory=True)
with timer("large"):
    np.ones(25_000_000)
with timer("small"):
    pass
print(timer.megabytes["large"] - timer.megabytes["small"])
"""
    done = python("-c", program)  # a process of its own: memory that other tests have freed may be reused
    assert float(done.stdout) > 150, done.stderr


def test_a_stage_begins_only_if_what_it_is_expected_to_take_is_left(monkeypatch):
    monkeypatch.setattr(time, "perf_counter", lambda: 101.0)
    timer = StageTimer(time_limit=2.0, _began=100.0)  # one second left, and another of grace
    assert timer.has_time_for("simplify", seconds=1.5)
    assert not timer.has_time_for("simplify", seconds=2.5)
    assert timer.skipped == ["simplify"]
