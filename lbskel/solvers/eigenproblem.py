"""Smallest eigenpairs of the generalized symmetric eigenproblem S x = lambda M x, for sparse matrices.

Shift-invert Lanczos iteration: the largest eigenvalues 1 / (lambda + sigma) of (S + sigma M)^-1 M belong to the
smallest lambda (:mod:`lbskel.solvers.lanczos`). That none is missing is checked by Sylvester's law of inertia. Each
connected component of the matrices is solved separately, so that the eigenvalue zero of a Laplacian is found once per
component.
"""

from __future__ import annotations

__all__ = ["Eigenpairs", "count_below", "smallest_eigenpairs"]

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cholesky, eigh, solve_triangular
from scipy.sparse import csc_array, diags_array
from scipy.sparse.csgraph import connected_components

from lbskel.errors import SolveError, checked_count
from lbskel.solvers import DIRECT_SOLVERS, factorize
from lbskel.solvers.cholmod import count_negative_pivots
from lbskel.solvers.lanczos import ThickRestartLanczos

# Components of at most this many rows are solved as dense problems, and so are those of at most three times as many
# rows as eigenvalues are wanted, since Lanczos' method needs more vectors than it finds. A guess.
MAX_DENSE_SIZE = 100
# Bound on the runs of Lanczos' method on one component; another follows only if an eigenvalue is missing. A guess.
MAX_RUNS = 10
# Eigenvalues less than this below the largest one found, relative to it, count as equal to it when missing eigenvalues
# are counted. A guess, far above the errors of those found.
RELATIVE_GAP = 1e-6
# Relative amount by which a bound is moved if a leading minor is exactly singular there; far below RELATIVE_GAP, so
# that the count is the same.
NEARBY = 1e-9
# Mass given to rows without mass, relative to the mean mass: M must be definite in Lanczos' method. A guess.
MASS_FLOOR = 1e-14
EPSILON = float(np.finfo(np.float64).eps)
SEED = 0  # of Lanczos' starting vectors, so that two runs give the same bytes

Eigenpairs: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]


def smallest_eigenpairs(S: csc_array, M: csc_array, k: int, *, solver: str = "cholmod") -> Eigenpairs:
    """Find the k smallest eigenvalues of S x = lambda M x and their eigenvectors.

    Parameters
    ----------
    S : (n, n) csc_array
        Symmetric, positive semidefinite.
    M : (n, n) csc_array
        Symmetric, positive semidefinite. Connected components without mass have no eigenpairs.
    k : int
        Number of eigenpairs; fewer are returned if the components with mass have fewer rows, or those of at most 100
        rows, or of 3 k if these are more, have fewer with a mass.
    solver : str
        A name in SOLVERS, for the matrix S + sigma M.

    Returns
    -------
    values : (k,) array of float
        Ascending.
    vectors : (n, k) array of float
        Columns with X^T M X = I; the entry of largest magnitude of each is positive.

    Raises
    ------
    UnknownChoice
        If no solver has that name, or k is not a positive integer.
    SolveError
        If S + sigma M is not positive definite, or Lanczos' method does not find all eigenpairs.
    """
    k = checked_count(k, "the number of eigenpairs", 1)
    S, s = _near_unit_scale(S)
    M, m = _near_unit_scale(M)
    component = connected_components(abs(S) + abs(M), directed=False)[1]
    order = np.argsort(component, kind="stable")
    S, M = S[order][:, order], M[order][:, order]
    ends = np.cumsum(np.bincount(component))
    found: list[tuple[float, slice, NDArray[np.float64]]] = []
    for start, end in zip(ends - np.bincount(component), ends, strict=True):
        block = slice(start, end)
        if M[block, block].sum() > 0:
            values, X = _component_eigenpairs(S[block, block].tocsc(), M[block, block].tocsc(), k, solver)
            found.extend((value, block, vector) for value, vector in zip(values, X.T, strict=True))
    found = sorted(found, key=lambda pair: pair[0])[:k]
    vectors = np.zeros((len(order), len(found)))
    for column, (_, block, vector) in enumerate(found):
        vectors[order[block], column] = vector * np.sign(vector[np.abs(vector).argmax()])
    values = np.ldexp(np.array([value for value, _, _ in found]), 2 * (s - m))
    return values, np.ldexp(vectors, -m)


def _near_unit_scale(A: csc_array) -> tuple[csc_array, int]:
    """Divide a matrix by 4^k so that its largest entry is in [1/4, 1), exactly; products of entries do not overflow."""
    k = int(np.frexp(np.abs(A.data).max(initial=0.0))[1] + 1) // 2
    return (A * float(np.ldexp(1.0, -2 * k))).tocsc(), k


def count_below(S: csc_array, M: csc_array, bound: float, *, ordering: NDArray[np.int64] | None = None) -> int:
    """Count the eigenvalues below a bound: the negative pivots of S - bound M, by Sylvester's law of inertia.

    Parameters
    ----------
    S : (n, n) csc_array
        Symmetric.
    M : (n, n) csc_array
        Symmetric, positive definite.
    bound : float
        In the units of the eigenvalues; not itself an eigenvalue.
    ordering : (n,) array of int, optional
        A fill-reducing permutation.

    Raises
    ------
    SolveError
        If a leading minor of S - bound M is exactly singular, at the bound and at one nearby.
    """
    try:
        return count_negative_pivots((S - bound * M).tocsc(), ordering)
    except SolveError:  # a leading minor may be singular where the matrix is not: not so at a bound nearby
        return count_negative_pivots((S - bound * (1 + NEARBY) * M).tocsc(), ordering)


def _component_eigenpairs(S: csc_array, M: csc_array, k: int, solver: str) -> Eigenpairs:
    """Find the smallest eigenpairs of one connected component, M-orthonormal."""
    sigma = _shift(S, M)  # before rows without mass get one, which they may be most of
    if S.shape[0] <= max(MAX_DENSE_SIZE, 3 * k):
        values, X = _dense(S, M, k, sigma or 1.0)  # zero where S is
    else:
        masses = M.diagonal()
        M = (M + diags_array(np.where(masses > 0, 0.0, MASS_FLOOR * masses.mean()))).tocsc()
        values, X = _lanczos(S, M, k, sigma, solver)
    R = cholesky(X.T @ (M @ X))
    orthonormal: NDArray[np.float64] = solve_triangular(R, X.T, trans="T").T
    return values, orthonormal


def _shift(S: csc_array, M: csc_array) -> float:
    """Return sigma, about the mean distance between eigenvalues of a surface, 4 pi / area by Weyl's law."""
    masses = M.diagonal()
    has_mass = masses > 0
    return float(np.median(S.diagonal()[has_mass] / masses[has_mass])) / len(masses)


def _dense(S: csc_array, M: csc_array, k: int, sigma: float) -> Eigenpairs:
    """Find the k largest eigenvalues 1 / (lambda + sigma) of M x = mu (S + sigma M) x, which needs no inverse of M.

    Those that are zero up to rounding belong to rows without mass.
    """
    n = S.shape[0]
    try:
        inverses, X = eigh(M.toarray(), (S + sigma * M).toarray(), subset_by_index=[max(n - k, 0), n - 1])
    except LinAlgError:
        raise SolveError("the matrix is not positive definite") from None
    found = np.flatnonzero(inverses > n * EPSILON * inverses[-1])[::-1]
    return 1 / inverses[found] - sigma, X[:, found] / np.sqrt(inverses[found])


def _lanczos(S: csc_array, M: csc_array, k: int, sigma: float, solver: str) -> Eigenpairs:
    """Find the k smallest eigenpairs by Lanczos' method, with further starting vectors while eigenvalues are missing.

    In exact arithmetic one start finds one eigenvector of each eigenvalue; rounding errors bring some of the others.
    """
    factor = factorize((S + sigma * M).tocsc(), solver)
    ordering = factor.ordering if solver in DIRECT_SOLVERS else None
    lanczos = ThickRestartLanczos(lambda b: factor.solve(b, refined=False), M, k, np.random.default_rng(SEED))
    for _ in range(MAX_RUNS):
        inverses, X = lanczos.run()
        values = 1 / inverses - sigma
        bound = values[-1] - RELATIVE_GAP * (values[-1] + sigma)
        n_below = count_below(S, M, bound, ordering=ordering)
        if n_below <= (values < bound).sum():
            return values, X
        lanczos.add_direction()
    raise SolveError(f"Lanczos' method has missed eigenvalues in {MAX_RUNS} runs")
