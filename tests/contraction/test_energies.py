"""Energies of a contraction step: the linear systems, and the minimizers they lead to."""

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array

from lbskel import Laplacian, laplacian
from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES, ContractionStepInput, stacked_system
from lbskel.shapes import torus

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
def test_a_shift_of_the_mesh_does_not_change_the_displacement(energy):
    mesh = torus(1.0, 0.3, 20, 10)
    D, shifted = (solution(ENERGIES[energy](step_input(given, "none"))) for given in (mesh, shifted_torus()))
    assert shifted == pytest.approx(D, abs=1e-9)
