"""Smoothing: the transfer function of each method, invariances, what is held, and what is refused."""

import numpy as np
import pytest
from helpers import joined, moved
from numpy.polynomial.polynomial import polyval
from scipy.linalg import eigh

from lbskel import Mesh, MeshError, SolveError, UnknownChoice, laplacian, smooth
from lbskel.applications.smoothing import SMOOTHING_METHODS
from lbskel.applications.smoothing_filters import FILTER, FILTERS, FIRST_FACTOR, PASS_BAND
from lbskel.operators import OPERATORS, Laplacian
from lbskel.operators.combinatorial import random_walk
from lbskel.operators.mean_value import mean_value
from lbskel.shapes import flat_grid, sphere, torus


@pytest.fixture(scope="module")
def bumpy():
    """A torus with noise."""
    mesh = torus(1.0, 0.4, 24, 12)
    return mesh.with_vertices(mesh.vertices + 0.02 * np.random.default_rng(0).standard_normal(mesh.vertices.shape))


def transferred(mesh, function, *, mass=None):
    """The positions with each coefficient in the eigenbasis of S x = lambda M x multiplied by function(lambda)."""
    L = laplacian(mesh)
    M = L.mass.toarray() if mass is None else mass
    values, X = eigh(L.stiffness.toarray(), M)
    return X @ (function(values)[:, None] * (X.T @ M @ mesh.vertices))


@pytest.mark.parametrize(
    ("method", "t", "function"),
    [
        ("explicit", 1e-3, lambda s: (1 - s) ** 3),
        ("implicit", 0.05, lambda s: 1 / (1 + s) ** 3),
        ("bilaplacian", 0.05, lambda s: 1 / (1 + s * s) ** 3),
    ],
)
def test_each_frequency_is_damped_as_the_formula_says(bumpy, method, t, function):
    result = smooth(bumpy, method=method, time_step=t, iterations=3)
    assert result.vertices == pytest.approx(transferred(bumpy, lambda values: function(t * values)), abs=1e-10)


def test_taubins_filter_has_his_transfer_function():
    mesh = sphere(2)  # positive weights, so that no eigenvalue is above 2
    second = 1 / (PASS_BAND - 1 / FIRST_FACTOR)
    assert second < -FIRST_FACTOR
    degrees = np.diag(laplacian(mesh).stiffness.diagonal())
    expected = transferred(mesh, lambda k: ((1 - FIRST_FACTOR * k) * (1 - second * k)) ** 5, mass=degrees)
    assert smooth(mesh, method="taubin", iterations=5).vertices == pytest.approx(expected, abs=1e-10)


def test_mean_curvature_flow_shrinks_a_sphere_at_its_rate():
    """R^2 = R_0^2 - 4 t; backward Euler: R' = R / (1 + 2 t / R^2)."""
    radius, t, n = 1.0, 0.01, 10
    for _ in range(n):
        radius /= 1 + 2 * t / radius**2
    result = smooth(sphere(4), method="curvature_flow", time_step=t, iterations=n)
    assert np.linalg.norm(result.vertices, axis=1) == pytest.approx(radius, rel=0.01)  # h^2 = 0.005


def test_the_flow_of_a_sound_surface_is_that_of_implicit_steps(bumpy):
    twice = bumpy
    for _ in range(2):
        twice = smooth(twice, method="implicit", time_step=0.01, iterations=1)
    flow = smooth(bumpy, method="curvature_flow", time_step=0.01, iterations=2)
    assert flow.vertices == pytest.approx(twice.vertices, abs=1e-14)


@pytest.mark.parametrize(("radius", "operator"), [(0.1, "robust"), (0.03, "cotangent")])
def test_a_part_that_the_flow_shrinks_to_a_point_stays_where_it_is(radius, operator):
    """Rounding errors threw it 952 diameters away, or the system was singular."""
    ball, dot = sphere(3), sphere(2)
    both = joined(ball, moved(dot.with_vertices(radius * dot.vertices), 2.0))
    result = smooth(both, method="curvature_flow", iterations=12, operator=operator)
    place = both.vertices[642:].mean(axis=0)
    assert result.vertices[642:] == pytest.approx(np.tile(place, (162, 1)), abs=1e-4)


@pytest.mark.parametrize(
    ("method", "t"),
    # the eigenvalues are up to 1e3: at 1e5, (t lambda)^2 leaves no digit of the identity, and SolveError is raised
    [(method, t) for method in ("implicit", "bilaplacian", "curvature_flow") for t in (1e-12, 1.0, 1e4)]
    + [("implicit", 1e12), ("curvature_flow", 1e12)],
)
def test_implicit_steps_are_stable_for_every_time_step(bumpy, method, t):
    result = smooth(bumpy, method=method, time_step=t, iterations=2)
    assert np.linalg.norm(result.vertices, axis=1).max() <= np.linalg.norm(bumpy.vertices, axis=1).max() * (1 + 1e-9)


def test_an_unstable_explicit_step_names_the_bound(bumpy):
    with pytest.raises(SolveError, match="stable up to a time_step of") as raised:
        smooth(bumpy, method="explicit", time_step=1.0)
    bound = float(str(raised.value).split("time_step of ")[1].split()[0])
    L = laplacian(bumpy)
    largest = eigh(L.stiffness.toarray(), L.mass.toarray(), eigvals_only=True)[-1]
    assert bound <= 2 / largest * 1.01  # three digits are printed
    smooth(bumpy, method="explicit", time_step=0.99 * bound)
    with pytest.raises(SolveError, match="stable up to"):
        smooth(bumpy, method="explicit", time_step=1.01 * bound)


def test_the_polynomial_has_the_transfer_function_of_its_filter():
    mesh = sphere(2)
    degrees = np.diag(laplacian(mesh).stiffness.diagonal())
    expected = transferred(mesh, lambda k: polyval(1 - k, FILTER) ** 2, mass=degrees)
    assert smooth(mesh, method="polynomial", iterations=2).vertices == pytest.approx(expected, abs=1e-10)


def test_the_boundary_of_a_mesh_stays_and_a_vertex_without_faces():
    grid = flat_grid(6, 5)
    bumpy = grid.vertices + np.random.default_rng(0).normal(scale=0.01, size=grid.vertices.shape)
    mesh = Mesh(np.concatenate([bumpy, [[5.0, 5, 5]]]), grid.faces)
    moved = (smooth(mesh, method="polynomial").vertices != mesh.vertices).any(axis=1)
    on_boundary = np.zeros(len(mesh.vertices), dtype=bool)
    on_boundary[mesh.edges[mesh.faces_per_edge == 1]] = True
    assert (moved == ~on_boundary)[:-1].all()
    assert not moved[-1]


@pytest.mark.parametrize("method", FILTERS)
def test_the_short_way_of_random_walk_is_the_matrix(bumpy, method):
    """A function of the caller always gets matrices."""
    holed = Mesh(np.concatenate([bumpy.vertices, [[5.0, 5, 5]]]), bumpy.faces[20:])
    for options in ({}, {"fix_boundary": False, "fixed": [3, 100]}, {"keep_volume": True}):
        by_edges = smooth(holed, method=method, operator="random_walk", **options).vertices
        by_matrix = smooth(holed, method=method, operator=random_walk, **options).vertices
        assert by_edges == pytest.approx(by_matrix, abs=1e-12)
        assert not np.array_equal(by_edges, holed.vertices)


def test_taubins_filter_does_not_grow_on_a_flat_triangle():
    """Its eigenvalue is 3, since one weight is negative: unscaled, the filter multiplies that part by -1.3."""
    cap = Mesh([[0, 0, 0], [1, 0, 0], [0.5, 0.01, 0]], [[0, 1, 2]])
    smoothed = smooth(cap, method="taubin", iterations=30, fix_boundary=False).vertices
    assert np.abs(smoothed[:, 1]).max() < 0.01


@pytest.mark.parametrize("operator", OPERATORS)
def test_every_operator_smooths_noise(operator):
    ball = sphere(3)
    noisy = ball.with_vertices(ball.vertices * (1 + 0.02 * np.random.default_rng(1).standard_normal((642, 1))))
    result = smooth(noisy, operator=operator, keep_volume=True)
    spread = [np.linalg.norm(mesh.vertices, axis=1).std() for mesh in (noisy, result)]
    assert spread[1] < 0.6 * spread[0]
    assert result.volume == pytest.approx(noisy.volume, rel=1e-9)


@pytest.mark.parametrize("method", SMOOTHING_METHODS)
def test_a_similarity_of_the_mesh_is_one_of_the_result(bumpy, method):
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    placed = bumpy.with_vertices(250.0 * bumpy.vertices @ turn.T + [1e3, 0, -5])
    first, second = (smooth(mesh, method=method, keep_volume=True).vertices for mesh in (bumpy, placed))
    assert second == pytest.approx(250.0 * first @ turn.T + [1e3, 0, -5], abs=1e-8)


@pytest.mark.parametrize("operator", [*OPERATORS, mean_value])
def test_the_default_time_step_follows_the_unit_and_moves_vertices_by_less_than_an_edge(bumpy, operator):
    first, second = (
        smooth(bumpy.with_vertices(unit * bumpy.vertices), operator=operator).vertices / unit for unit in (1.0, 1e3)
    )
    assert second == pytest.approx(first, abs=1e-9)
    assert np.linalg.norm(first - bumpy.vertices, axis=1).max() < bumpy.edge_lengths.mean()


def test_default_time_steps_are_alike_on_equilateral_triangles():
    """Of an icosahedron, with five at a vertex: the ratio of stiffness and mass is that of six, 20 % more."""
    ball = sphere(0)
    operators = ("cotangent", "inverse_distance", "mean_value", "mean_value_symmetric")
    shrunk = [smooth(ball, operator=each, method="implicit", iterations=1).vertices for each in operators]
    lost = [1 - np.linalg.norm(vertices[0]) for vertices in shrunk]
    assert lost == pytest.approx([lost[0]] * 4, rel=0.2)
    assert lost[1:] == pytest.approx([lost[1]] * 3)


@pytest.mark.parametrize("method", SMOOTHING_METHODS)
def test_fixed_vertices_and_the_boundary_stay(method):
    grid = flat_grid(9, 9)
    bumped = grid.with_vertices(grid.vertices + 0.02 * np.random.default_rng(0).standard_normal((81, 3)))
    boundary = np.unique(bumped.edges[bumped.faces_per_edge == 1])
    result = smooth(bumped, method=method, fixed=[40, 41], keep_volume=True)
    held = [*boundary, 40, 41]
    assert (result.vertices[held] == bumped.vertices[held]).all()
    assert (result.vertices[39] != bumped.vertices[39]).all()
    freed = smooth(bumped, method=method, fix_boundary=False)
    assert (freed.vertices[boundary] != bumped.vertices[boundary]).any(axis=1).all()


def test_components_do_not_influence_each_other(bumpy):
    other = moved(sphere(2), 5.0)
    both = joined(bumpy, other)
    alone = [smooth(mesh, time_step=0.01, keep_volume=True).vertices for mesh in (bumpy, other)]
    result = smooth(both, time_step=0.01, keep_volume=True)
    assert result.vertices == pytest.approx(np.concatenate(alone), abs=1e-10)


def test_isolated_vertices_stay(bumpy):
    with_point = Mesh([*bumpy.vertices, [9.0, 9, 9]], bumpy.faces)
    assert (smooth(with_point, time_step=0.01).vertices[-1] == 9).all()
    expected = smooth(bumpy, time_step=0.01).vertices
    assert smooth(with_point, time_step=0.01).vertices[:-1] == pytest.approx(expected, abs=1e-12)


def test_an_operator_of_the_caller_is_applied_to_the_mesh_as_given(bumpy):
    seen = []

    def own(mesh):
        seen.append(mesh)
        L = laplacian(mesh)
        return Laplacian(L.stiffness, L.mass)

    assert (smooth(bumpy, operator=own).vertices == smooth(bumpy).vertices).all()
    assert seen == [bumpy]


@pytest.mark.parametrize(
    ("error", "options"),
    [
        (UnknownChoice, {"method": "median"}),
        (UnknownChoice, {"operator": "tutte"}),
        (UnknownChoice, {"method": "taubin", "time_step": 1.0}),
        (UnknownChoice, {"method": "polynomial", "time_step": 1.0}),
        (UnknownChoice, {"time_step": 0.0}),
        (UnknownChoice, {"time_step": np.nan}),
        (UnknownChoice, {"time_step": "a"}),
        (UnknownChoice, {"iterations": 0}),
        (MeshError, {"fixed": [10**6]}),
        (MeshError, {"fixed": [[1], [2, 3]]}),
    ],
)
def test_wrong_options_are_named(bumpy, error, options):
    with pytest.raises(error):
        smooth(bumpy, **options)


def test_a_volume_that_is_not_defined_and_a_mesh_without_area_are_refused():
    with pytest.raises(MeshError, match="volume to keep is not defined"):
        smooth(flat_grid(4, 4), keep_volume=True, fix_boundary=False)
    with pytest.raises(MeshError, match="no area"):
        smooth(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]))
