"""Paths that pass each tunnel on the side of others: on a torus, where both ways around are known."""

import numpy as np
import pytest

from lbskel.contraction.cycle_classes import are_around_tunnels, tunnel_cochain
from lbskel.geometry.deadline import Deadline, OutOfTime
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement import tunnel_paths
from lbskel.refinement.tunnel_paths import paths_on_side_of
from lbskel.shapes import sphere, torus

RING = Surface(torus(1.0, 0.3, 60, 20))


def arc(first, last, radius=1.0, n=20):
    turn = np.linspace(first, last, n)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), 0 * turn], axis=1)


@pytest.mark.parametrize("last", [1.0, 1.0 - 2 * np.pi, 1.0 + 2 * np.pi])
def test_a_path_goes_around_the_ring_as_the_given_one_does(last):
    [path] = paths_on_side_of([arc(0.0, last, 1.05)], RING)
    assert RING.contains(path).all()
    assert path[[0, -1]] == pytest.approx(arc(0.0, 1.0, 1.05)[[0, -1]])
    turns = np.unwrap(np.arctan2(path[:, 1], path[:, 0]))
    assert turns[-1] - turns[0] == pytest.approx(last)
    # a path along edges is up to 2 / sqrt(3) times as long as a straight line; 0.3, a radius, for the ends
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() < 2 / np.sqrt(3) * 1.05 * abs(last) + 0.3


def test_paths_from_everywhere_on_the_ring_keep_their_side(monkeypatch):
    monkeypatch.setattr(tunnel_paths, "MAX_PATHS", 1000)
    starts = np.linspace(0, 2 * np.pi, 60, endpoint=False) + 0.01
    olds = [arc(start, start + 0.3, radius) for start in starts for radius in (0.85, 1.15)]
    for path in paths_on_side_of(olds, RING):
        turns = np.unwrap(np.arctan2(path[:, 1], path[:, 0]))
        assert turns[-1] - turns[0] == pytest.approx(0.3)


def test_a_path_stays_if_there_are_no_tunnels():
    path = arc(0.0, 1.0, 0.5)
    [same] = paths_on_side_of([path], Surface(sphere(3)))
    assert same is path


def test_a_path_stays_if_the_search_is_too_long(monkeypatch):
    monkeypatch.setattr(tunnel_paths, "MAX_STATES", 10)
    path = arc(0.0, 1.0)
    [same] = paths_on_side_of([path], RING)
    assert same is path


def test_only_the_first_paths_are_searched():
    olds = [arc(0.0, 1.0, radius) for radius in np.linspace(0.9, 1.1, tunnel_paths.MAX_PATHS + 2)]
    news = paths_on_side_of(olds, RING)
    assert [new is old for new, old in zip(news, olds, strict=True)] == [False] * tunnel_paths.MAX_PATHS + [True] * 2


def test_no_search_begins_after_the_deadline():
    with pytest.raises(OutOfTime):
        paths_on_side_of([arc(0.0, 1.0)], Surface(RING.mesh, deadline=Deadline(0.0)))


def test_the_cochain_tells_loops_around_the_tunnel():
    loops = [arc(0, 2 * np.pi, n=30)[:-1], arc(0, 1.0)]
    sums = [tunnel_cochain(np.stack([loop, np.roll(loop, -1, axis=0)], axis=1), RING).sum() for loop in loops]
    assert [value != 0 for value in sums] == are_around_tunnels(loops, RING).tolist() == [True, False]
