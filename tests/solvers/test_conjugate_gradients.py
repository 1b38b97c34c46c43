"""Preconditioned conjugate gradients: the same bytes every time, and the optional package."""

import sys

import numpy as np
import pytest
from linear_systems import rectangular, right_hand_side, right_hand_sides, shifted_laplacian
from scipy.sparse import diags_array, eye_array

from lbskel import MissingDependency, factorize
from lbskel.shapes import flat_grid
from lbskel.solvers import relative_residual
from lbskel.solvers.least_squares import lstsq


def test_the_same_bytes_and_the_callers_random_numbers_untouched():
    K = rectangular()
    B = right_hand_side(K)
    np.random.seed(3)  # noqa: NPY002
    before = np.random.get_state()[1].tobytes()  # noqa: NPY002
    first, second = (lstsq(K, B, "cg_amg") for _ in range(2))
    assert first.tobytes() == second.tobytes()
    assert np.random.get_state()[1].tobytes() == before  # noqa: NPY002


def test_without_pyamg_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyamg", None)
    with pytest.raises(MissingDependency, match=r"lbskel\[multigrid\]"):
        factorize(eye_array(3, format="csc"), "cg_amg")


def test_the_diagonal_preconditioner_solves_a_diagonal_matrix_at_once():
    A = diags_array(np.logspace(0, 8, 50)).tocsc()
    B = np.random.default_rng(0).normal(size=(50, 3))
    numbers = []
    found = factorize(A, "cg_jacobi").solve(B, on_iterate=lambda number, X: numbers.append(number))
    assert numbers == [1]
    assert found == pytest.approx(B / np.logspace(0, 8, 50)[:, None])


def test_multigrid_needs_far_fewer_iterations_than_the_diagonal():
    A = shifted_laplacian(flat_grid(40, 40), 1e-3)
    B = right_hand_sides(1600)
    counts = {}
    for solver in ("cg_jacobi", "cg_amg"):
        X = factorize(A, solver).solve(B, on_iterate=lambda number, X, solver=solver: counts.update({solver: number}))
        assert relative_residual(A, X, B) < 1e-8
    assert counts["cg_amg"] < counts["cg_jacobi"] / 3
