"""Greedy anchors: against the choice by solving anew each time, and least-squares meshes."""

import numpy as np
import pytest
from helpers import joined, moved
from scipy.sparse import csc_array

from lbskel import Mesh, MeshError, UnknownChoice, laplacian, least_squares_mesh
from lbskel.applications.anchor_selection import greedy_anchors
from lbskel.applications.differential_coordinates import AnchoredLaplacian
from lbskel.shapes import sphere


def test_updates_choose_the_same_anchors_as_new_factorizations(tripod):
    S = laplacian(tripod, operator="graph").stiffness
    deltas = np.zeros_like(tripod.vertices)
    anchors, X = greedy_anchors(S, deltas, tripod.vertices, 23)
    for k in range(1, 23):
        solution = AnchoredLaplacian(S, anchors[:k], weight=1.0).solve(deltas, tripod.vertices[anchors[:k]])
        errors = np.linalg.norm(solution - tripod.vertices, axis=1)
        errors[anchors[:k]] = 0
        assert errors[anchors[k]] == pytest.approx(errors.max(), rel=1e-6)  # the system's condition number is 1e9
    expected = AnchoredLaplacian(S, anchors, weight=1.0).solve(deltas, tripod.vertices[anchors])
    assert np.abs(X - expected).max() < 1e-12


def test_a_least_squares_mesh_approaches_the_surface(tripod):
    errors = []
    for n in (5, 20, 80, 320):
        surface, anchors = least_squares_mesh(tripod, n)
        assert len(anchors) == n
        errors.append(np.linalg.norm(surface.vertices - tripod.vertices, axis=1).max())
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.2 * errors[0]


@pytest.mark.parametrize("exponent", [-600, 510])  # units of 2e-181 and 3e153: squares vanish, and their sums overflow
def test_anchors_do_not_depend_on_the_unit(exponent):
    mesh = joined(sphere(1), moved(sphere(2), 4.0))
    surface, anchors = least_squares_mesh(mesh, 7)
    there, chosen = least_squares_mesh(mesh.with_vertices(np.ldexp(mesh.vertices, exponent)), 7)
    assert chosen.tolist() == anchors.tolist()
    assert np.array_equal(there.vertices, np.ldexp(surface.vertices, exponent))


def test_each_component_gets_an_anchor_and_isolated_vertices_stay():
    both = joined(sphere(1), moved(sphere(2), 4.0))
    mesh = Mesh([*both.vertices, [9.0, 9, 9]], both.faces)
    surface, anchors = least_squares_mesh(mesh, 2)
    assert (anchors[0] < 42) != (anchors[1] < 42)
    assert (surface.vertices[-1] == 9).all()
    with pytest.raises(MeshError, match="2 components"):
        least_squares_mesh(mesh, 1)


@pytest.mark.parametrize(
    "options",
    [*({"n_anchors": n} for n in (0, 2.5, None, True)), *({"n_anchors": 3, "anchor_weight": w} for w in (None, "a"))],
)
def test_wrong_options_are_named(tripod, options):
    with pytest.raises(UnknownChoice, match=f"{list(options)[-1]} must be"):
        least_squares_mesh(tripod, **options)


def test_rows_that_are_all_zero_need_no_anchor():
    V = np.random.default_rng(0).random((5, 3))
    anchors, X = greedy_anchors(csc_array((5, 5)), np.zeros_like(V), V, 3)
    assert (len(anchors), X.tolist()) == (0, V.tolist())


def test_more_anchors_than_vertices_are_all_of_them_and_give_the_surface():
    icosahedron = sphere(0)
    surface, anchors = least_squares_mesh(icosahedron, 100)
    again, chosen = least_squares_mesh(icosahedron, 12)
    assert sorted(anchors) == sorted(chosen) == list(range(12))
    np.testing.assert_allclose(surface.vertices, again.vertices, atol=1e-14)


@pytest.mark.parametrize("operator", ["graph", "inverse_distance", "mean_value", "mean_value_symmetric"])
def test_the_surface_does_not_depend_on_the_unit(tripod, operator):
    found = []
    for scale in (1.0, 1e-6):
        mesh = tripod.with_vertices(scale * tripod.vertices)
        found.append(least_squares_mesh(mesh, 12, operator=operator)[0].vertices / scale)
    assert found[1] == pytest.approx(found[0], abs=1e-7)  # the system's condition number is about 1e9
