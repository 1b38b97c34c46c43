"""Distances by unfolding: one triangle, a strip, an order that is wrong, and the limit on sweeps."""

import numpy as np
import pytest

from lbskel.shapes import flat_grid

INFINITY = float("inf")


def arrays(mesh):
    F = mesh.faces.ravel().astype(np.int64)
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    L = np.stack([np.linalg.norm(c - b, axis=1), np.linalg.norm(a - c, axis=1), np.linalg.norm(b - a, axis=1)], axis=1)
    first = np.append(0, np.cumsum(np.bincount(F, minlength=len(mesh.vertices))))
    return F, L.ravel(), first, np.argsort(F, kind="stable")


def lowered(kernel, near, lengths, max_sweeps=10):
    """Distance of the last corner of one triangle from those of the two others."""
    D = np.array([*near, INFINITY])
    F, every = np.arange(3), np.arange(4)
    kernel.lower_distances(F, np.array(lengths), every, F, np.array([2]), D, max_sweeps)
    return D[2]


def test_a_source_across_an_edge(kernel):
    # a at 0, b at 2, the corner at (1, 1), the source at (1, -1)
    assert lowered(kernel, [np.sqrt(2), np.sqrt(2)], [np.sqrt(2), np.sqrt(2), 2.0]) == pytest.approx(2.0, rel=1e-14)


def test_paths_along_edges_where_no_line_crosses(kernel):
    sides = [np.sqrt(2), np.sqrt(2), 2.0]
    assert lowered(kernel, [0.0, 2.0], sides) == pytest.approx(np.sqrt(2), rel=1e-14)  # the source is a corner
    assert lowered(kernel, [5.0, 1.0], sides) == 1 + np.sqrt(2)  # no source is so far from one and near the other
    assert lowered(kernel, [1.0, INFINITY], sides) == 1 + np.sqrt(2)
    assert lowered(kernel, [1.0, 1.0], [0.5, 0.5, 0.0]) == 1.5  # an edge without length
    assert lowered(kernel, [INFINITY, INFINITY], sides) == INFINITY


@pytest.mark.parametrize("seed", [None, 0, 1])
def test_any_order_gives_the_distances_of_the_plane(kernel, seed):
    mesh = flat_grid(7, 9)
    exact = np.linalg.norm(mesh.vertices - mesh.vertices[4], axis=1)
    order = np.argsort(exact) if seed is None else np.random.default_rng(seed).permutation(len(exact))
    D = np.full(len(exact), INFINITY)
    D[4] = 0.0
    sweeps = kernel.lower_distances(*arrays(mesh), order, D, 100)
    assert np.abs(D - exact).max() < 1e-12  # rounding
    assert sweeps <= 4 or seed is not None


def test_the_sweeps_are_limited_and_others_keep_what_they_have(kernel):
    mesh = flat_grid(7, 9)
    far_first = np.argsort(-np.linalg.norm(mesh.vertices - mesh.vertices[4], axis=1))[5:]
    D = np.full(len(mesh.vertices), INFINITY)
    D[4] = 0.0
    assert kernel.lower_distances(*arrays(mesh), far_first, D, 2) == 2
    assert np.isinf(D).sum() > 5
    kernel.lower_distances(*arrays(mesh), far_first, D, 100)
    assert np.isinf(D).sum() == 5
