"""Least squares by every method, and the iterative solvers: right, watched, warm-started, and refused where no use."""

import sys

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array, diags_array, eye_array, vstack

from lbskel import MissingDependency, SolveError, UnknownChoice, factorize, laplacian
from lbskel.shapes import torus
from lbskel.solvers import ALL_SOLVERS, DIRECT_SOLVERS
from lbskel.solvers.iterative import NormalMatrix, eigenvalue_upper_bound, estimate_smallest_eigenvalue
from lbskel.solvers.least_squares import LEAST_SQUARES, lstsq

WITHOUT_ITERATES = {"qr", "svd", "augmented", *DIRECT_SOLVERS}
every_method = pytest.mark.parametrize("method", LEAST_SQUARES)
every_iterative = pytest.mark.parametrize("method", sorted(set(LEAST_SQUARES) - WITHOUT_ITERATES))


def rectangular(weight=1.0):
    """W_L L over the identity, as in a step of the contraction; the condition number is about 13 times the weight."""
    L = laplacian(torus(1.0, 0.3, 14, 9), operator="graph").stiffness
    return csr_array(vstack([weight * L, eye_array(L.shape[0])]))


def right_hand_side(K, columns=3):
    return np.random.default_rng(0).normal(size=(K.shape[0], columns))


@every_method
def test_like_numpy(method):
    K = rectangular(0.3)
    B = right_hand_side(K)
    X = lstsq(K, B, method)
    # iterations end at a residual of 1e-10 of the start's, conditioned at 4 squared
    assert np.abs(X - np.linalg.lstsq(K.toarray(), B)[0]).max() < 1e-8
    assert X.shape == (K.shape[1], 3)


@every_method
def test_a_vector_gives_a_vector(method):
    K = rectangular(0.3)
    b = right_hand_side(K, 1)[:, 0]
    x = lstsq(K, b, method)
    assert x.shape == (K.shape[1],)
    assert x == pytest.approx(lstsq(K, b[:, None], method)[:, 0], abs=1e-12)


@every_method
def test_nothing_asked_nothing_found(method):
    K = rectangular(0.3)
    assert (lstsq(K, np.zeros((K.shape[0], 2)), method) == 0).all()


@every_iterative
def test_iterates_are_shown_in_order_and_come_nearer(method):
    K = rectangular(0.3)
    B = right_hand_side(K)
    exact = np.linalg.lstsq(K.toarray(), B)[0]
    seen = []
    X = lstsq(K, B, method, on_iterate=lambda number, X: seen.append((number, np.linalg.norm(X - exact))))
    numbers, errors = zip(*seen, strict=True)
    assert list(numbers) == sorted(set(numbers))
    assert numbers[0] == 1
    assert errors[0] > 1e-3
    assert errors[-1] == pytest.approx(np.linalg.norm(X - exact), abs=1e-12)
    assert errors[-1] < 1e-8


@every_iterative
def test_a_start_at_the_solution_is_left_where_it_is(method):
    K = rectangular(0.3)
    B = right_hand_side(K)
    exact = np.linalg.lstsq(K.toarray(), B)[0]
    assert lstsq(K, B, method, start=exact, iterations=3) == pytest.approx(exact, abs=1e-12)


@every_iterative
def test_a_near_start_is_nearer_after_as_many_iterations(method):
    K = rectangular()
    B = right_hand_side(K)
    exact = np.linalg.lstsq(K.toarray(), B)[0]
    cold, warm = (
        np.linalg.norm(lstsq(K, B, method, start=start, iterations=4) - exact) for start in (None, 1.001 * exact)
    )
    assert warm < 0.01 * cold


@every_iterative
def test_no_more_iterations_than_asked(method):
    K = rectangular()
    seen = []
    lstsq(K, right_hand_side(K), method, iterations=5, on_iterate=lambda number, X: seen.append(number))
    assert max(seen) == 5


def test_richardsons_iterates_are_landwebers():
    K = rectangular()
    B = right_hand_side(K)
    iterates = []
    lstsq(K, B, "richardson", iterations=3, on_iterate=lambda number, X: iterates.append(X))
    factor = (iterates[0] / (K.T @ B)).mean()
    assert 0 < factor < 2 / np.linalg.norm(K.toarray(), 2) ** 2
    X = np.zeros_like(iterates[0])
    for iterate in iterates:
        X = X + factor * (K.T @ (B - K @ X))
        assert iterate == pytest.approx(X, abs=1e-12)


def test_gauss_and_seidel_take_the_columns_one_after_the_other():
    K = rectangular()
    B = right_hand_side(K, 1)
    dense, X, R = K.toarray(), np.zeros((K.shape[1], 1)), np.array(B)
    for j in range(K.shape[1]):
        step = dense[:, j] @ R / (dense[:, j] @ dense[:, j])
        X[j] += step
        R -= dense[:, [j]] * step
    assert lstsq(K, B, "gauss_seidel", iterations=1) == pytest.approx(X, abs=1e-12)


def test_krylov_methods_need_the_root_of_what_stationary_ones_need():
    K = rectangular()
    B = right_hand_side(K)
    counts = {}
    for method in ("richardson", "chebyshev", "cgls", "cg_jacobi"):
        counts[method] = 0

        def count(number, X, method=method):
            counts[method] = number

        lstsq(K, B, method, on_iterate=count)
    # condition 13^2 of the normal equations: 169 / 2 iterations for each digit's e-fold against 13 / 2
    assert counts["chebyshev"] < counts["richardson"] / 3
    assert max(counts["cgls"], counts["cg_jacobi"]) < counts["chebyshev"]


@pytest.mark.parametrize("method", ["richardson", "jacobi", "gauss_seidel", "sor", "chebyshev"])
def test_what_takes_too_long_is_refused_and_given_where_iterations_are_asked_for(method):
    mesh = torus(1.0, 0.1, 300, 4)
    L = laplacian(mesh, operator="graph").stiffness  # from a thousandth to ten, the constants aside
    K, V = csr_array(vstack([1e5 * L, eye_array(L.shape[0])])), mesh.vertices  # smooth: what these change last
    B = np.concatenate([np.zeros_like(V), V])
    with pytest.raises(SolveError, match="cholmod") as caught:
        lstsq(K, B, method)
    assert caught.value.residual > 1e-3
    partial = lstsq(K, B, method, iterations=20)
    assert 0 < np.linalg.norm(K @ partial - B) < np.linalg.norm(B)


@pytest.mark.parametrize("method", ["qr", "svd"])
def test_dense_matrices_that_would_not_fit_are_refused_before_any_is_made(method):
    n = 10_000  # 20,000 x 10,000 doubles are 1.6 GB
    K = csr_array(vstack([eye_array(n), eye_array(n)]))
    with pytest.raises(SolveError, match=r"20000 x 10000 takes 1\.6 GB.*augmented"):
        lstsq(K, np.ones(2 * n), method)


@pytest.mark.parametrize("method", ["augmented", "cholmod", "superlu"])
def test_dependent_columns_are_refused(method):
    K = csr_array([[1.0, 1.0], [2.0, 2.0], [0.0, 0.0]])
    with pytest.raises(SolveError):
        lstsq(K, [1.0, 1.0, 1.0], method)


@every_method
def test_what_is_not_finite_is_refused(method):
    K = rectangular()
    K.data[3] = np.nan
    with pytest.raises(SolveError, match="not finite"):
        lstsq(K, right_hand_side(K), method)


def test_an_unknown_method_is_answered_with_all_that_exist():
    with pytest.raises(UnknownChoice, match="lsmr"):
        lstsq(rectangular(), np.zeros(252), "magic")


def test_augmented_and_orthogonal_methods_do_not_square_the_condition():
    n = 200
    chain = diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1])
    K = csr_array(chain @ chain)  # condition 2.7e8, of which the square is beyond double precision
    X = np.ones((n, 1))
    errors = {method: np.abs(lstsq(K, K @ X, method) - X).max() for method in ("qr", "svd", "augmented")}
    assert max(errors.values()) < 1e-6  # 2.7e8 roundings
    assert np.abs(lstsq(K, K @ X, "cholmod") - X).max() > 1e-2  # it does


@pytest.mark.parametrize("solver", sorted(set(ALL_SOLVERS) - set(DIRECT_SOLVERS)))
def test_iterative_solvers_of_symmetric_systems(solver):
    S = laplacian(torus(1.0, 0.3, 14, 9), operator="graph").stiffness
    A = csc_array(S + eye_array(S.shape[0]))
    B = np.random.default_rng(1).normal(size=(A.shape[0], 3))
    seen = []
    factorization = factorize(A, solver)
    X = factorization.solve(B, on_iterate=lambda number, X: seen.append(number))
    assert np.abs(X - np.linalg.solve(A.toarray(), B)).max() < 1e-8  # as above
    assert seen == list(range(1, len(seen) + 1))
    assert factorization.solve(B[:, 0]) == pytest.approx(X[:, 0], abs=1e-8)
    assert factorization.residual(factorization.solve(B, start=X), B) < 1e-9


@pytest.mark.parametrize("solver", sorted(set(ALL_SOLVERS) - set(DIRECT_SOLVERS)))
def test_iterative_solvers_refuse_what_is_not_positive_definite(solver):
    with pytest.raises(SolveError, match="not positive definite"):
        factorize(csc_array([[0.0, 1.0], [1.0, 0.0]]), solver)


def test_the_same_bytes_and_the_callers_random_numbers_untouched():
    K = rectangular()
    B = right_hand_side(K)
    np.random.seed(3)  # noqa: NPY002
    before = np.random.get_state()[1].tobytes()  # noqa: NPY002
    first, second = (lstsq(K, B, "cg_amg") for _ in range(2))
    assert first.tobytes() == second.tobytes()
    assert np.random.get_state()[1].tobytes() == before  # noqa: NPY002


def test_without_pyamg_the_error_tells_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyamg", None)
    with pytest.raises(MissingDependency, match=r"lbskel\[multigrid\]"):
        factorize(eye_array(3, format="csc"), "cg_amg")


def test_a_normal_matrix_is_the_product_that_it_stands_for():
    K = rectangular(0.7)
    dense = (K.T @ K).toarray()
    normal = NormalMatrix(K)
    X = right_hand_side(K)[: K.shape[1]]
    assert normal @ X == pytest.approx(dense @ X)
    assert normal.diagonal() == pytest.approx(np.diag(dense))
    ones = np.ones(K.shape[1])
    eigenvalues = np.linalg.eigvalsh(dense)
    assert eigenvalue_upper_bound(normal, ones) >= eigenvalues[-1]
    assert eigenvalues[0] <= estimate_smallest_eigenvalue(normal, ones) < 2 * eigenvalues[0] + 0.05 * eigenvalues[-1]
