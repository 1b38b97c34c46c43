"""Deadlines, and queries in slices."""

import time

import numpy as np
import pytest

from lbskel.geometry import deadline
from lbskel.geometry.deadline import NEVER, Deadline, OutOfTime, in_slices
from lbskel.geometry.surface_queries import Surface
from lbskel.shapes import torus


def test_a_deadline_passes():
    assert NEVER.seconds_left == float("inf")
    NEVER.check()
    later = Deadline(time.perf_counter() + 1e9)
    assert 9e8 < later.seconds_left <= 1e9
    later.check()
    past = Deadline(time.perf_counter() - 1)
    assert past.seconds_left < 0
    with pytest.raises(OutOfTime):
        past.check()


@pytest.mark.parametrize("size", [1, 3, 7, 1000])
def test_slices_are_put_together_again(monkeypatch, size):
    monkeypatch.setattr(deadline, "SLICE", size)
    calls = []

    def query(x, y):
        calls.append(len(x))
        return x + y, np.stack([x, y], axis=1)

    x, y = np.arange(7.0), np.arange(7.0) ** 2
    total, pairs = in_slices(query, x, y)
    assert np.array_equal(total, x + y)
    assert np.array_equal(pairs, np.stack([x, y], axis=1))
    assert max(calls) == min(size, 7)
    assert [len(each) for each in in_slices(query, x[:0], y[:0])] == [0, 0]


def test_no_slice_begins_after_the_deadline(monkeypatch):
    monkeypatch.setattr(deadline, "SLICE", 2)
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    calls, now = [], [0.0]
    monkeypatch.setattr(deadline.time, "perf_counter", lambda: now[0])

    def query(x):
        calls.append(x.tolist())
        now[0] += 1.0
        return (x,)

    with pytest.raises(OutOfTime):
        in_slices(query, np.arange(9), deadline=Deadline(1.5))
    assert calls == [[0, 1], [2, 3]]


@pytest.mark.parametrize("query", ["closest", "contains", "ray_distance"])
def test_queries_of_a_surface_are_the_same_in_slices_and_end_at_its_deadline(monkeypatch, query):
    P = np.random.default_rng(0).normal(size=(20, 3))
    arguments = (P, P / np.linalg.norm(P, axis=1, keepdims=True)) if query == "ray_distance" else (P,)
    expected = getattr(Surface(torus(1.0, 0.3)), query)(*arguments)
    monkeypatch.setattr(deadline, "SLICE", 6)
    mesh = torus(1.0, 0.3)
    with pytest.raises(OutOfTime):
        getattr(Surface(mesh, deadline=Deadline(0.0)), query)(*arguments)
    found = getattr(Surface(mesh), query)(*arguments)
    assert all(map(np.array_equal, found, expected))


def test_items_come_until_the_deadline():
    assert list(NEVER.until("ab")) == ["a", "b"]
    with pytest.raises(OutOfTime):
        list(Deadline(0.0).until("ab"))
    assert list(Deadline(0.0).until("")) == []
