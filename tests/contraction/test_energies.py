"""Energies of a contraction step: the linear systems, and the minimizers they lead to."""

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array

from lbskel import Laplacian, laplacian
from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES, ContractionStepInput, stacked_system
from lbskel.shapes import flat_grid, torus

TREATED = np.arange(0, 200, 7)


def shifted_torus():
    """A torus of 200 vertices whose center is not the origin."""
    mesh = torus(1.0, 0.3, 20, 10)
    return mesh.with_vertices(mesh.vertices + [5.0, 0.0, 0.0])


def step_input(mesh, treatment, rows=TREATED, weight=3.0, shrinkage=1.0):
    n = len(mesh.vertices)
    return ContractionStepInput(
        laplacian(mesh),
        mesh.vertices,
        weight,
        np.full(n, shrinkage),
        np.ones(n),
        lambda L: ROW_TREATMENTS[treatment](L, rows),
    )


def two_points(weight, shrinkage, initial_mass):
    """Two vertices on the x-axis joined by an edge of weight 1: S = [[1, -1], [-1, 1]]."""
    S = csc_array(np.array([[1.0, -1.0], [-1.0, 1.0]]))
    return ContractionStepInput(
        Laplacian(S, csc_array(np.eye(2))),
        np.array([[-1.0, 0, 0], [1.0, 0, 0]]),
        weight,
        np.full(2, shrinkage),
        np.full(2, initial_mass),
        lambda L: ROW_TREATMENTS["none"](L, np.empty(0, dtype=int)),
    )


def solution(system):
    return np.linalg.solve(system.A.toarray(), system.B)


def test_curvature_flow_moves_two_points_as_its_closed_form_says():
    """Their distance d is an eigenvector of S to the value 2, so d' = d / (1 + 2 tau / H), H = mass * A_0 / A_t."""
    tau, shrinkage, mass = 0.7, 4.0, 0.3
    D = solution(ENERGIES["curvature_flow"](two_points(tau, shrinkage, mass)))
    assert 1 + D[1, 0] == pytest.approx(1 / (1 + 2 * tau / (mass * shrinkage)))
    assert D[0] == pytest.approx(-D[1])


def test_least_squares_moves_two_points_as_its_closed_form_says():
    """L = 2 S has the value 4 on their distance, so d' = d / (1 + 16 W_L^2 / W_H^2), W_H^2 = A_0 / A_t."""
    weight, shrinkage = 0.7, 4.0
    D = solution(ENERGIES["least_squares"](two_points(weight, shrinkage, initial_mass=0.3)))
    assert 1 + D[1, 0] == pytest.approx(1 / (1 + 16 * weight / shrinkage))


@pytest.mark.parametrize("energy", ENERGIES)
def test_the_system_reports_the_attraction_it_was_built_with(energy):
    system = ENERGIES[energy](two_points(1.0, 4.0, 0.3))
    expected = {"curvature_flow": 4.0 * 0.3, "least_squares": 4.0}[energy]
    assert system.attraction == pytest.approx([expected, expected])
    assert system.replaced_rows.tolist() == []


@pytest.mark.parametrize("treatment", ROW_TREATMENTS)
@pytest.mark.parametrize("shrinkage", [1.0, 9.0])
def test_the_stacked_system_has_the_same_solution(treatment, shrinkage):
    step = step_input(shifted_torus(), treatment, shrinkage=shrinkage)
    K, b = stacked_system(step)
    assert isinstance(K, csr_array)
    # condition number about 1e3, so the normal equations keep nine digits
    assert np.linalg.lstsq(K.toarray(), b)[0] == pytest.approx(solution(ENERGIES["least_squares"](step)), abs=1e-9)


@pytest.mark.parametrize("energy", ENERGIES)
@pytest.mark.parametrize("treatment", ["none", "identity", "identity_zero"])
def test_positions_and_displacements_have_the_same_solution(energy, treatment):
    mesh = shifted_torus()
    system = ENERGIES[energy](step_input(mesh, treatment))
    # rounding of positions of size 6
    assert system.positions - system.A @ mesh.vertices == pytest.approx(system.B, abs=1e-10)


@pytest.mark.parametrize("energy", ENERGIES)
def test_equal_weights_at_all_vertices_are_one_weight(energy):
    mesh = shifted_torus()
    one, each = (ENERGIES[energy](step_input(mesh, "none", weight=w)) for w in (3.0, np.full(200, 3.0)))
    # sums of products of weights in another order
    assert each.A.toarray() == pytest.approx(one.A.toarray(), abs=1e-10)
    assert pytest.approx(one.B, abs=1e-10) == each.B


def test_in_curvature_flow_each_vertex_has_its_own_weight():
    """The minimizer of V'^T S V' + sum_i H_i / tau_i |V'_i - V_i|^2, in closed form for two points."""
    tau, shrinkage, mass = np.array([0.5, 3.0]), 4.0, 0.3
    system = ENERGIES["curvature_flow"](two_points(tau, shrinkage, mass))
    a, b = shrinkage * mass / tau
    # a D_0 = b -D_1 = the force along the edge, whose length 2 becomes 2 + D_1 - D_0
    force = 2 / (1 + 1 / a + 1 / b)
    assert solution(system)[:, 0] == pytest.approx([force / a, -force / b])
    assert system.attraction == pytest.approx([shrinkage * mass] * 2)
    assert system.positions - system.A @ [[-1.0, 0, 0], [1.0, 0, 0]] == pytest.approx(system.B, abs=1e-12)


def test_weights_that_vary_move_no_vertex_along_a_flat_part():
    """Inside a flat sheet the mean curvature is zero: nothing is pulled to where the weights are larger."""
    mesh = flat_grid(9, 9)
    tau = 10.0 ** np.random.default_rng(0).uniform(-2, 2, 81)
    B = ENERGIES["curvature_flow"](step_input(mesh, "none", rows=np.empty(0, dtype=int), weight=tau)).B
    inner = (np.abs(mesh.vertices[:, :2] - 0.5) < 0.49).all(axis=1)
    assert np.abs(B[inner]).max() < 1e-12 < np.abs(B[~inner]).max()


def test_vertices_without_a_weight_have_a_finite_row():
    """Vertices without a face have the local radius 0, so tau is 0."""
    A = ENERGIES["curvature_flow"](two_points(np.array([0.0, 2.0]), 1.0, 6.0)).A.toarray()
    assert A.tolist() == [[1 + 6.0, -1], [-1, 1 + 3.0]]


def test_least_squares_weighs_each_row_by_the_weight_of_its_vertex():
    """The minimizer of sum_i w_i |(L V')_i|^2 + W_H^2 |V' - V|^2, by a dense solver of stacked equations."""
    weight, shrinkage = np.array([0.5, 3.0]), 4.0
    step = two_points(weight, shrinkage, 1.0)
    L = 2 * step.laplacian.stiffness.toarray()
    K = np.concatenate([np.sqrt(weight)[:, None] * L, np.sqrt(shrinkage) * np.eye(2)])
    b = np.concatenate([np.zeros((2, 3)), np.sqrt(shrinkage) * step.vertices])
    expected = np.linalg.lstsq(K, b)[0] - step.vertices
    assert solution(ENERGIES["least_squares"](step)) == pytest.approx(expected)
    K, b = stacked_system(step)
    assert np.linalg.lstsq(K.toarray(), b)[0] == pytest.approx(expected)


@pytest.mark.parametrize("energy", ENERGIES)
def test_a_shift_of_the_mesh_does_not_change_the_displacement(energy):
    mesh = torus(1.0, 0.3, 20, 10)
    D, shifted = (solution(ENERGIES[energy](step_input(given, "none"))) for given in (mesh, shifted_torus()))
    assert shifted == pytest.approx(D, abs=1e-9)
