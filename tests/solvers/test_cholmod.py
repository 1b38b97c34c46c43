"""CHOLMOD: its options and its ordering."""

import threading

import numpy as np
import pytest
from cvxopt import cholmod
from linear_systems import ill_conditioned, right_hand_sides, shifted_laplacian
from scipy.sparse import csc_array

from lbskel import SolveError, factorize
from lbskel.shapes import flat_grid, torus
from lbskel.solvers.cholmod import count_negative_pivots


@pytest.mark.parametrize("A", [shifted_laplacian(flat_grid(4, 4)), csc_array(np.ones((3, 3)))], ids=["good", "bad"])
def test_options_of_cholmod_are_left_as_they_were(A, monkeypatch):
    monkeypatch.setitem(cholmod.options, "print", 0)
    before = dict(cholmod.options)
    try:
        factorize(A, "cholmod")
    except SolveError:
        assert A.shape == (3, 3)
    assert cholmod.options == before


def test_a_thread_waits_while_another_has_changed_the_options(monkeypatch):
    """While pivots are counted, by L D L^T, a second thread factorizes an indefinite matrix, which L L^T refuses."""
    indefinite = csc_array(np.diag([1.0, -1.0, 2.0]))
    before, numeric, outcomes, threads = dict(cholmod.options), cholmod.numeric, [], []

    def factorize_another():
        try:
            factorize(indefinite, "cholmod")
            outcomes.append("accepted")
        except SolveError:
            outcomes.append("refused")

    def numeric_beside_another_thread(X, factor):
        if not threads:
            threads.append(threading.Thread(target=factorize_another))
            threads[0].start()
            threads[0].join(timeout=0.5)  # which ends only if the thread does not wait
        numeric(X, factor)

    monkeypatch.setattr(cholmod, "numeric", numeric_beside_another_thread)
    assert count_negative_pivots(indefinite) == 1
    threads[0].join()
    assert outcomes == ["refused"]
    assert cholmod.options == before


def test_an_ordering_is_reused_for_the_same_pattern_only():
    first = factorize(shifted_laplacian(torus(1.0, 0.3, 20, 10)), "cholmod")
    same = factorize(shifted_laplacian(torus(1.0, 0.3, 20, 10), 0.3), "cholmod", like=first)
    assert (same.ordering == first.ordering).all()
    other = shifted_laplacian(torus(1.0, 0.3, 10, 20))
    assert (factorize(other, "cholmod", like=first).ordering == factorize(other, "cholmod").ordering).all()
    assert (factorize(other, "cholmod").ordering != first.ordering).any()


def test_a_solution_is_refined_once():
    A, _ = ill_conditioned(500)
    B = right_hand_sides(500)
    factor = factorize(A, "cholmod")
    X = factor._solve_unrefined(B)
    assert (factor.solve(B) == X + factor._solve_unrefined(B - A @ X)).all()


def test_no_column_is_named_since_its_number_is_that_of_the_permuted_matrix():
    with pytest.raises(SolveError, match=r"not positive definite$"):
        factorize(csc_array(np.diag([1.0, -1.0, 1.0])), "cholmod")


def test_negative_pivots_are_as_many_as_negative_eigenvalues():
    A = shifted_laplacian(torus(1.0, 0.3, 20, 10))
    eigenvalues = np.linalg.eigvalsh(A.toarray())
    for position in (0, 1, 57, 200):
        bound = np.mean([*eigenvalues, 2 * eigenvalues[-1]][max(position - 1, 0) : position + 1]) - 1e-3
        shifted = csc_array(A - bound * csc_array(np.eye(200)))
        for ordering in (None, factorize(A, "cholmod").ordering):
            assert count_negative_pivots(shifted, ordering) == (eigenvalues < bound).sum()
    with pytest.raises(SolveError, match="pivot of zero"):
        count_negative_pivots(csc_array(np.zeros((2, 2)) + [[0, 1], [1, 0]]))
