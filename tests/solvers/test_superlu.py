"""SuperLU: its ordering, and solutions without refinement."""

import numpy as np
import pytest
from linear_systems import right_hand_sides, shifted_laplacian
from scipy.sparse import csc_array

from lbskel import SolveError, factorize
from lbskel.shapes import flat_grid
from lbskel.solvers import solve_once
from lbskel.solvers.superlu import GeneralLU


def test_a_reused_ordering_causes_no_more_fill():
    """The inverse of a permutation is one too, and gives right solutions of a matrix that fills up."""
    A = shifted_laplacian(flat_grid(40, 40))
    first = factorize(A, "superlu")
    again = factorize(A, "superlu", like=first)
    assert again._factor.L.nnz < 1.1 * first._factor.L.nnz


def test_a_reused_ordering_is_applied_to_the_matrix_and_to_the_right_hand_sides():
    A = shifted_laplacian(flat_grid(12, 10))
    first = factorize(A, "superlu")
    again = factorize((2 * A).tocsc(), "superlu", like=first)
    assert (again.ordering == first.ordering).all()
    B = right_hand_sides(120)
    assert again._solve_unrefined(B) == pytest.approx(first._solve_unrefined(B) / 2, rel=1e-10, abs=1e-12)


def test_solve_once_takes_any_square_matrix():
    A = csc_array([[0.0, 2.0], [1.0, 1.0]])  # not symmetric, a zero pivot without row exchanges
    assert solve_once(A, np.array([4.0, 5.0])) == pytest.approx([3, 2])
    assert solve_once(A, np.array([[4.0, 2.0], [5.0, 1.0]])) == pytest.approx(np.array([[3, 0], [2, 1]]))


@pytest.mark.parametrize(("entry", "message"), [(np.nan, "not finite"), (np.inf, "not finite"), (0.0, "factorized")])
def test_solve_once_refuses_singular_matrices_and_entries_that_are_not_finite(entry, message):
    A = csc_array([[1.0, 0.0], [0.0, 1.0]])
    A.data[1] = entry
    with pytest.raises(SolveError, match=message):
        solve_once(A, np.ones(2))


def test_general_lu_solves_what_is_not_definite_and_refuses_singular_matrices():
    A = csc_array([[0.0, 2.0], [1.0, 1.0]])
    assert GeneralLU(A).solve(np.array([4.0, 5.0])) == pytest.approx([3, 2])
    with pytest.raises(SolveError, match="factorized"):
        GeneralLU(csc_array((3, 3)))
