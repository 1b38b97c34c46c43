"""Cycles inside a surface: those that can be shrunk are told from those around tunnels."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.contraction.cycle_classes import are_around_tunnels, tunnels_missed
from lbskel.geometry.deadline import Deadline, OutOfTime
from lbskel.geometry.surface_queries import Surface
from lbskel.shapes import chain_of_tori, sphere, torus


def ring(center, radius, axes=(0, 1)):
    """Nodes and edges of a circle around a center, in the plane of two axes."""
    angle = np.arange(32) * 2 * np.pi / 32
    nodes = np.tile(np.array(center, float), (32, 1))
    nodes[:, axes[0]] += radius * np.cos(angle)
    nodes[:, axes[1]] += radius * np.sin(angle)
    return nodes, np.stack([np.arange(32), np.roll(np.arange(32), -1)], axis=1)


@pytest.mark.parametrize("turned", [False, True])
def test_a_cycle_that_can_be_shrunk_inside_misses_the_tunnel(turned):
    mesh = torus(1.0, 0.3, 32, 12)
    mesh = Mesh(mesh.vertices, mesh.faces[:, ::-1]) if turned else mesh
    axis, edges = ring([0, 0, 0], 1.0)
    assert tunnels_missed(axis, edges, mesh) == 0
    assert tunnels_missed(axis, edges[:-1], mesh) == 1
    assert tunnels_missed(*ring([1, 0, 0], 0.15), mesh) == 1
    assert tunnels_missed(*ring([1, 0, 0], 0.15, axes=(0, 2)), mesh) == 1
    off_axis = axis + [0, 0, 0.2] * np.sin(5 * np.arange(32))[:, None]
    assert tunnels_missed(off_axis, edges, mesh) == 0


@pytest.mark.parametrize(("second", "n_missed"), [(([2, 0, 0], 1.0), 0), (([0, 0, 0], 0.95), 1)])
def test_two_cycles_around_one_tunnel_miss_another(second, n_missed):
    """Two rings of radius 1 around (0, 0, 0) and (2, 0, 0)."""
    (one, edges), (other, _) = ring([0, 0, 0], 1.0), ring(*second)
    joined = np.concatenate([edges, edges + 32, [[0, 32 + (16 if second[0][0] else 0)]]])
    assert tunnels_missed(np.concatenate([one, other]), joined, chain_of_tori(2)) == n_missed


def test_tunnels_of_a_sphere_are_none():
    assert tunnels_missed(*ring([0, 0, 0], 0.5), sphere(2)) == 0


def test_loops_around_tunnels_are_told_from_others():
    mesh = chain_of_tori(2)
    one, other, small = (ring(*query)[0] for query in (([0, 0, 0], 1.0), ([2, 0, 0], 1.0), ([1, 0, 0], 0.1)))
    there_and_back = np.concatenate([one, one[::-1]])
    loops = [one, small, other[::-1], there_and_back]
    assert are_around_tunnels(loops, Surface(mesh)).tolist() == [True, False, True, False]
    rolled = [np.roll(there_and_back, k, axis=0) for k in range(len(there_and_back))]
    assert not are_around_tunnels(rolled, Surface(mesh)).any()
    assert not are_around_tunnels([one], Surface(sphere(2))).any()


def test_no_loop_is_known_to_go_around_a_tunnel_of_an_open_surface():
    mesh = torus(1.0, 0.3, 32, 12)
    opened = Surface(Mesh(mesh.vertices, mesh.faces[1:]))
    assert are_around_tunnels([ring([0, 0, 0], 1.0)[0]], Surface(mesh)).tolist() == [True]
    assert are_around_tunnels([ring([0, 0, 0], 1.0)[0]], opened).tolist() == [False]
    assert are_around_tunnels([], opened).tolist() == []


def test_after_a_deadline_nothing_is_computed():
    mesh = torus(1.0, 0.3, 16, 8)
    with pytest.raises(OutOfTime):
        tunnels_missed(np.zeros((1, 3)), np.empty((0, 2), dtype=np.int64), mesh, deadline=Deadline(0.0))
    with pytest.raises(OutOfTime):
        are_around_tunnels([np.zeros((3, 3))], Surface(mesh, deadline=Deadline(0.0)))
