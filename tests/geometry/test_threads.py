"""Threads: how many, the order of answers, and no further item after an error."""

import os
import threading
import time

import pytest

from lbskel.geometry import threads
from lbskel.geometry.threads import in_threads, n_processors, n_threads


@pytest.mark.parametrize(
    ("given", "expected"), [("3", 3), ("2,1", 2), ("0", None), ("", None), ("many", None), (None, None)]
)
def test_there_are_as_many_threads_as_the_environment_says_or_as_processors(monkeypatch, given, expected):
    if given is None:
        monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    else:
        monkeypatch.setenv("OMP_NUM_THREADS", given)
    assert n_threads() == (expected or n_processors())


def test_processors_are_counted_where_the_system_does_not_tell_which(monkeypatch):
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 5)
    assert n_processors() == 5
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert n_processors() == 1


@pytest.mark.parametrize("n", [1, 3])
def test_answers_come_in_the_order_of_the_items(monkeypatch, n):
    monkeypatch.setattr(threads, "n_threads", lambda: n)
    assert in_threads(lambda item: item**2, range(50)) == [item**2 for item in range(50)]
    assert in_threads(lambda item: item, []) == []


def test_items_are_answered_at_the_same_time(monkeypatch):
    monkeypatch.setattr(threads, "n_threads", lambda: 2)
    together = threading.Barrier(2, timeout=60)
    assert sorted(in_threads(lambda _: together.wait(), [0, 1])) == [0, 1]


@pytest.mark.parametrize("n", [1, 2])
def test_an_error_is_raised_and_ends_the_work(monkeypatch, n):
    monkeypatch.setattr(threads, "n_threads", lambda: n)
    begun = []

    def fail_at_0(item):
        begun.append(item)
        if item == 0:
            raise KeyError(item)
        time.sleep(0.01)  # so that the thread that waits for the answers has its turn

    with pytest.raises(KeyError, match="0"):
        in_threads(fail_at_0, range(1_000))
    assert len(begun) < 1_000
