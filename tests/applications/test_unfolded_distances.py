"""Unfolded distances: exact in the plane and on a cylinder, near libigl's exact ones elsewhere, in any order."""

import igl
import numpy as np
import pytest

from lbskel.applications.unfolded_distances import UnfoldedSurface
from lbskel.shapes import flat_grid, make, torus


def surface_of(mesh):
    lengths = igl.edge_lengths(mesh.vertices, mesh.faces)
    return UnfoldedSurface(mesh.faces, lengths, len(mesh.vertices))


def exact_distances(mesh, *sources):
    V, F, none = np.array(mesh.vertices), np.array(mesh.faces), np.empty(0, dtype=np.int64)
    return igl.exact_geodesic(V, F, np.array(sources), none, np.arange(len(V)), none)


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


def test_several_sources_in_a_plane_are_exact():
    """Where fronts meet, a triangle with distances from two of them must not be unfolded towards a point between."""
    grid = flat_grid(30, 30)
    V, sources = grid.vertices, np.array([31, 310, 700, 868])
    expected = np.linalg.norm(V[:, None] - V[sources], axis=2).min(axis=1)
    found = surface_of(grid).distance(sources, np.argsort(expected))
    assert np.abs(found - expected).mean() < 2e-5 * expected.max()  # of single vertices where three regions meet
    merged = surface_of(grid)._lowered(sources, np.argsort(expected))
    assert np.abs(merged - expected).mean() > 2e-4 * expected.max()


@pytest.mark.parametrize("n_sources", [2, 12, 60])
def test_several_sources_are_near_the_exact_ones(n_sources):
    mesh = torus(1.0, 0.4, 60, 30)
    sources = np.random.default_rng(0).choice(len(mesh.vertices), n_sources, replace=False)
    exact = exact_distances(mesh, *sources.tolist())
    found = surface_of(mesh).distance(sources, np.argsort(exact))
    assert np.abs(found - exact).mean() < 0.005 * exact.max()


def test_sources_that_are_given_twice_side_by_side_and_on_several_components():
    one = flat_grid(8, 8)
    V = np.concatenate([one.vertices, one.vertices + [0, 0, 3.0]])
    two = UnfoldedSurface(
        np.concatenate([one.faces, one.faces + 64]), np.tile(igl.edge_lengths(one.vertices, one.faces), (2, 1)), 128
    )
    sources = np.array([0, 1, 1, 9, 90])
    found = two.distance(sources, np.arange(128))
    gaps = np.linalg.norm(V[:, None] - V[sources], axis=2)
    expected = np.where(np.arange(128) < 64, gaps[:, :4].min(axis=1), gaps[:, 4])
    assert found == pytest.approx(expected, abs=0.01 * expected.max())
    alone = two.distance(sources[:4], np.arange(128))
    assert np.isinf(alone[64:]).all()
    assert np.isfinite(alone[:64]).all()


@pytest.mark.parametrize("sources", [[0, 455], [31, 310, 700, 868]])
def test_a_border_between_regions_is_where_both_sources_are_as_near(sources):
    """The regions found first differ from the true ones by many triangles."""
    grid = flat_grid(30, 30)
    alone = [surface_of(grid).distance(np.array([source]), np.arange(900)) for source in sources]
    expected = np.min(alone, axis=0)
    found = surface_of(grid).distance(np.array(sources), np.argsort(expected))
    assert np.abs(found - expected).max() < 0.002 * expected.max()  # 0.07 of it by the regions found first
