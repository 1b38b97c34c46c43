"""Differential coordinates: closed forms, reconstruction against dense least squares, libigl and error bounds."""

import igl
import numpy as np
import pytest
from helpers import joined, moved
from scipy.linalg import lstsq
from scipy.sparse import csc_matrix

from lbskel import Mesh, MeshError, UnknownChoice, delta_coordinates, laplacian, reconstruct
from lbskel.operators import OPERATORS
from lbskel.shapes import flat_grid, sphere, torus
from lbskel.solvers import SOLVERS


@pytest.fixture(scope="module")
def shape():
    return torus(1.0, 0.4, 20, 10)


def test_deltas_of_a_plane_are_zero_inside_and_those_of_a_sphere_point_outward():
    grid = flat_grid(6, 6)
    inner = np.setdiff1d(np.arange(36), grid.edges[grid.faces_per_edge == 1])
    assert np.abs(delta_coordinates(grid)[inner]).max() < 1e-14
    ball = sphere(3)
    deltas = delta_coordinates(ball) / laplacian(ball).mass.diagonal()[:, None]
    assert deltas == pytest.approx(2 * ball.vertices, abs=0.02)  # 2 H n; h^2 = 0.02


@pytest.mark.parametrize("operator", OPERATORS)
def test_deltas_turn_with_the_surface_and_ignore_where_it_is(shape, operator):
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    placed = shape.with_vertices(shape.vertices @ turn.T + [5, -2, 1])
    expected = delta_coordinates(shape, operator=operator) @ turn.T
    scale = np.abs(expected).max()
    assert delta_coordinates(placed, operator=operator) == pytest.approx(expected, abs=1e-7 * scale)


@pytest.mark.parametrize("solver", SOLVERS)
def test_heavy_anchors_at_their_places_give_the_shape_back_by_every_solver(shape, solver):
    found = reconstruct(shape, delta_coordinates(shape), [0, 60, 130], anchor_weight=1e4, solver=solver)
    assert found.vertices == pytest.approx(shape.vertices, abs=1e-8)  # the condition of S^2 is 1e5


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("weight", [None, 1.0])
def test_the_surface_comes_back_from_its_deltas_and_one_anchor(shape, operator, weight):
    deltas = delta_coordinates(shape, operator=operator)
    result = reconstruct(shape, deltas, [17], operator=operator, anchor_weight=weight)
    # the condition number of S is below 1e3, and is squared with soft anchors
    assert result.vertices == pytest.approx(shape.vertices, abs=1e-8)


def test_soft_anchors_give_the_dense_least_squares_solution(shape):
    rng = np.random.default_rng(1)
    deltas, anchors, positions = rng.standard_normal((200, 3)), [3, 60, 100], rng.standard_normal((3, 3))
    S = laplacian(shape).stiffness.toarray()
    A = np.concatenate([S, 0.7 * np.eye(200)[anchors]])
    expected = lstsq(A, np.concatenate([deltas, 0.7 * positions]))[0]
    result = reconstruct(shape, deltas, anchors, positions, anchor_weight=0.7)
    assert result.vertices == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_hard_anchors_give_the_solution_of_libigl(shape):
    rng = np.random.default_rng(2)
    deltas, anchors, positions = rng.standard_normal((200, 3)), np.array([3, 60, 100]), rng.standard_normal((3, 3))
    S = csc_matrix(laplacian(shape).stiffness)
    empty = csc_matrix((0, 200))
    expected = igl.min_quad_with_fixed(S, -deltas, anchors, positions, empty, np.zeros((0, 3)), True)
    result = reconstruct(shape, deltas, anchors, positions)
    assert result.vertices[anchors] == pytest.approx(positions, abs=1e-15)
    assert result.vertices == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())


def test_more_anchors_condition_the_system_and_bound_the_error(ring):
    """The error of the positions is at most that of the deltas over the smallest singular value."""
    S = laplacian(ring, operator="graph").stiffness.toarray()
    noise = 1e-3 * np.random.default_rng(3).standard_normal((128, 3))
    noisy = delta_coordinates(ring, operator="graph") + noise
    smallest = 0.0
    for n in (1, 4, 16, 64):
        anchors = np.arange(n) * (128 // n)
        sigma = np.linalg.svd(np.concatenate([S, np.eye(128)[anchors]]), compute_uv=False)[-1]
        assert sigma > smallest
        smallest = sigma
        result = reconstruct(ring, noisy, anchors, operator="graph", anchor_weight=1.0)
        assert np.linalg.norm(result.vertices - ring.vertices) <= np.linalg.norm(noise) / sigma


def test_each_component_needs_an_anchor_and_isolated_vertices_stay(shape):
    both = joined(shape, moved(shape, 4.0))
    mesh = Mesh([*both.vertices, [9.0, 9, 9]], both.faces)
    deltas = delta_coordinates(mesh)
    with pytest.raises(MeshError, match="1 component without an anchor, with vertices 200: give each"):
        reconstruct(mesh, deltas, [0])
    assert reconstruct(mesh, deltas, [0, 300]).vertices == pytest.approx(mesh.vertices, abs=1e-10)


@pytest.mark.parametrize(
    ("error", "arguments", "options"),
    [
        (MeshError, (np.zeros((3, 3)), [0]), {}),
        (MeshError, (np.zeros((200, 3)), []), {}),
        (MeshError, (np.zeros((200, 3)), [200]), {}),
        (MeshError, (np.zeros((200, 3)), [0], np.zeros((2, 3))), {}),
        (MeshError, (np.full((200, 3), np.nan), [0]), {}),
        (UnknownChoice, (np.zeros((200, 3)), [0]), {"anchor_weight": 0.0}),
        (UnknownChoice, (np.zeros((200, 3)), [0]), {"anchor_weight": "a"}),
        (UnknownChoice, (np.zeros((200, 3)), [0]), {"operator": "tutte"}),
    ],
)
def test_wrong_input_is_named(shape, error, arguments, options):
    with pytest.raises(error):
        reconstruct(shape, *arguments, **options)


@pytest.mark.parametrize("operator", OPERATORS)
def test_soft_anchors_are_as_strong_in_every_unit(shape, operator):
    anchors, found = [0, 77], []
    for scale in (1.0, 1e-3):
        mesh = shape.with_vertices(scale * shape.vertices)
        deltas = delta_coordinates(mesh, operator=operator)
        wanted = scale * np.array([[2.0, 0.0, 0.0], [-1.0, 1.0, 0.0]])
        soft = reconstruct(mesh, deltas, anchors, wanted, operator=operator, anchor_weight=0.1)
        found.append(soft.vertices / scale)
    assert found[1] == pytest.approx(found[0], abs=1e-7)  # the system's condition number is about 1e6
