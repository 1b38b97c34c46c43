"""Unfolded distances: exact in the plane and on a cylinder, near libigl's exact ones elsewhere, in any order."""

import igl
import numpy as np
import pytest

from lbskel.applications.unfolded_distances import UnfoldedSurface
from lbskel.operators.intrinsic_triangulation import IntrinsicTriangulation, half_edge_twins
from lbskel.shapes import flat_grid, make, torus


def surface_of(mesh):
    lengths = igl.edge_lengths(mesh.vertices, mesh.faces)
    twins = half_edge_twins(mesh.faces)
    return UnfoldedSurface(IntrinsicTriangulation(mesh.faces, lengths, twins), len(mesh.vertices))


def exact_distances(mesh, source):
    V, F, none = np.array(mesh.vertices), np.array(mesh.faces), np.empty(0, dtype=np.int64)
    return igl.exact_geodesic(V, F, np.array([source]), none, np.arange(len(V)), none)


def test_developable_surfaces_are_exact():
    grid = flat_grid(20, 30)
    order = np.arange(len(grid.vertices))
    V = grid.vertices
    expected = np.linalg.norm(V - V[77], axis=1)
    assert np.abs(surface_of(grid).distance(np.array([77]), order) - expected).max() < 1e-12  # rounding
    x, y = V[:, 0], V[:, 1]  # rolled up halfway round a cylinder of strips, whose edges lie along its axis
    angle = np.pi * x / x.max()
    roll = grid.with_vertices(np.column_stack([np.cos(angle), np.sin(angle), 3 * y]))
    assert np.abs(surface_of(roll).distance(np.array([77]), order) - exact_distances(roll, 77)).max() < 1e-3


@pytest.mark.parametrize("shape", [lambda: torus(1.0, 0.4, 60, 30), lambda: make("tripod", n_vertices=1500).mesh])
def test_the_mean_error_is_below_one_percent(shape):
    mesh = shape()
    exact = exact_distances(mesh, 7)
    for order in (np.argsort(exact), np.arange(len(exact))):
        found = surface_of(mesh).distance(np.array([7]), order)
        assert np.abs(found - exact).mean() < 0.005 * exact.max()  # half of it, measured


def test_what_is_not_in_the_order_is_not_reached():
    grid = flat_grid(5, 5)
    found = surface_of(grid).distance(np.array([0, 3]), np.arange(10))
    assert found[0] == found[3] == 0
    assert np.isfinite(found[:10]).all()
    assert np.isinf(found[10:]).all()
