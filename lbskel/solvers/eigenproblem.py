"""Smallest eigenpairs of the generalized symmetric eigenproblem S x = lambda M x, for sparse matrices.

Shift-invert Lanczos iteration: the largest eigenvalues 1 / (lambda + sigma) of (S + sigma M)^-1 M belong to the
smallest lambda. Lehoucq, Sorensen, Yang 1998, "ARPACK users' guide", https://doi.org/10.1137/1.9780898719628. Each
connected component of the matrices is solved separately, so that the eigenvalue zero of a Laplacian is found once per
component.
"""

from __future__ import annotations

__all__ = ["Eigenpairs", "count_below", "smallest_eigenpairs"]

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, eigh, solve_triangular
from scipy.sparse import csc_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from lbskel.solvers import factorize

# Rows up to which a component is solved as a dense problem, or three times the number of eigenvalues wanted, since
# Lanczos' method needs more vectors than it finds. A guess.
MAX_DENSE_SIZE = 100
# Bound on the runs of Lanczos' method on one component; another run follows only if an eigenvalue is missing. A guess.
MAX_RUNS = 10
# Relative distance below the largest eigenvalue found up to which eigenvalues are counted as equal to it when the
# missing ones are counted. A guess, far above the tolerance of ARPACK (machine precision).
RELATIVE_GAP = 1e-6
# Mass of rows without mass, relative to the mean mass, which makes M positive definite. A guess. The dense solution
# loses digits by it: its error can reach machine precision / MASS_FLOOR, about 2 %, of the mean ratio of S to M.
MASS_FLOOR = 1e-14
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
        Number of eigenpairs; fewer are returned if the components with mass have fewer rows.
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
    SolveError
        If S is not positive semidefinite.
    """
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
    return np.array([value for value, _, _ in found]), vectors


def count_below(S: csc_array, M: csc_array, bound: float) -> int:
    """Count the eigenvalues below a bound: the negative pivots of S - bound M, by Sylvester's law of inertia.

    Parameters
    ----------
    S : (n, n) csc_array
        Symmetric.
    M : (n, n) csc_array
        Symmetric, positive definite.
    bound : float
        In the units of the eigenvalues; not itself an eigenvalue.

    Raises
    ------
    RuntimeError
        If S - bound M is exactly singular.
    """
    options = {"SymmetricMode": True}
    factor = splu((S - bound * M).tocsc(), permc_spec="COLAMD", diag_pivot_thresh=0.0, options=options)
    return int((factor.U.diagonal() < 0).sum())


def _component_eigenpairs(S: csc_array, M: csc_array, k: int, solver: str) -> Eigenpairs:
    """Find the smallest eigenpairs of one connected component, M-orthonormal."""
    n = S.shape[0]
    masses = M.diagonal()
    M = (M + diags_array(np.where(masses > 0, 0.0, MASS_FLOOR * masses.mean()))).tocsc()
    if n <= max(MAX_DENSE_SIZE, 3 * k):
        values, X = eigh(S.toarray(), M.toarray(), subset_by_index=[0, min(k, n) - 1])
    else:
        values, X = _lanczos(S, M, k, solver)
    R = cholesky(X.T @ (M @ X))
    orthonormal: NDArray[np.float64] = solve_triangular(R, X.T, trans="T").T
    return values, orthonormal


def _lanczos(S: csc_array, M: csc_array, k: int, solver: str) -> Eigenpairs:
    """Find the k smallest eigenpairs by Lanczos' method, and run it again, deflated, while eigenvalues are missing.

    In exact arithmetic the method finds one eigenvector of each eigenvalue, and ARPACK does miss some of the others.
    Later runs work in the M-orthogonal complement of the eigenvectors already found.
    """
    n = S.shape[0]
    # about the mean distance between eigenvalues of a surface, 4 pi / area by Weyl's law
    sigma = float(np.median(S.diagonal() / M.diagonal())) / n
    factor = factorize((S + sigma * M).tocsc(), solver)
    random = np.random.default_rng(SEED)
    values, X = np.empty(0), np.empty((n, 0))

    def inverse(b: NDArray[np.float64]) -> NDArray[np.float64]:
        x = factor.solve(b.reshape(-1, 1)).ravel()
        deflated: NDArray[np.float64] = x - X @ (X.T @ (M @ x))
        return deflated

    n_wanted = k
    for _ in range(MAX_RUNS):
        operator = LinearOperator((n, n), matvec=inverse, dtype=np.float64)
        found, Y = eigsh(S, n_wanted, M, sigma=-sigma, OPinv=operator, v0=random.uniform(0.5, 1.5, n))
        order = np.argsort(np.concatenate([values, found]), kind="stable")[:k]
        values = np.concatenate([values, found])[order]
        X = np.concatenate([X, Y], axis=1)[:, order]
        bound = values[-1] - RELATIVE_GAP * (values[-1] + sigma)
        n_wanted = min(k, count_below(S, M, bound) - int((values < bound).sum()))
        if n_wanted <= 0:
            break
    return values, X
