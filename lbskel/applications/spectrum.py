"""The spectrum of a Laplacian: S x = lambda M x, smallest eigenvalues first.

Lanczos' method on (S + sigma M)^-1 M, whose largest eigenvalues 1 / (lambda + sigma) belong to the smallest lambda:
Lehoucq, Sorensen, Yang 1998, "ARPACK users' guide", https://doi.org/10.1137/1.9780898719628. Each component of the
surface is solved for by itself, so that the eigenvalue zero comes as often as there are components.
"""

from __future__ import annotations

__all__ = ["count_below", "eigenpairs"]

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, eigh, solve_triangular
from scipy.sparse import csc_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from lbskel.errors import MeshError
from lbskel.operators import Laplacian
from lbskel.solvers import factorize

DENSE = 100  # up to this size, or up to three times the number of eigenvalues, all are found at once
ATTEMPTS = 10
SEED = 0

Pairs = tuple[NDArray[np.float64], NDArray[np.float64]]


def eigenpairs(laplacian: Laplacian, k: int, *, solver: str = "cholmod") -> Pairs:
    """The k smallest eigenvalues of S x = lambda M x and their functions.

    Parameters
    ----------
    laplacian : Laplacian
        Symmetric, positive semidefinite.
    k : int
        How many; fewer come back from a surface that has fewer vertices with an area.
    solver : str
        A name in SOLVERS.

    Returns
    -------
    values : (k,) array of float
        Ascending.
    functions : (n, k) array of float
        Columns with X^T M X = I; the largest value of each is positive.

    Raises
    ------
    MeshError
        If the operator is not symmetric, or the mesh has no area.
    SolveError
        If it is not positive semidefinite.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.applications import eigenpairs
    >>> from lbskel.shapes import sphere
    >>> values, functions = eigenpairs(lbskel.laplacian(sphere(3)), 4)
    >>> values.round(1) + 0
    array([0., 2., 2., 2.])
    """
    S, M = laplacian.stiffness, laplacian.mass
    if not M.sum() > 0:
        raise MeshError("the mesh has no area: every face is degenerate, so there is no spectrum")
    if abs(S - S.T).max() > 1e-12 * abs(S).max():
        raise MeshError("the operator is not symmetric; take one that is, for example 'mean_value_symmetric'")
    component = connected_components(abs(S) + abs(M), directed=False)[1]
    order = np.argsort(component, kind="stable")
    S, M = S[order][:, order], M[order][:, order]
    ends = np.cumsum(np.bincount(component))
    found: list[tuple[float, slice, NDArray[np.float64]]] = []
    for start, end in zip(ends - np.bincount(component), ends, strict=True):
        block = slice(start, end)
        if M[block, block].sum() > 0:
            values, X = _pairs_of_one(S[block, block].tocsc(), M[block, block].tocsc(), k, solver)
            found.extend((value, block, function) for value, function in zip(values, X.T, strict=True))
    found = sorted(found, key=lambda pair: pair[0])[:k]
    functions = np.zeros((len(order), len(found)))
    for place, (_, block, function) in enumerate(found):
        functions[order[block], place] = function * np.sign(function[np.abs(function).argmax()])
    return np.array([value for value, _, _ in found]), functions


def _pairs_of_one(S: csc_array, M: csc_array, k: int, solver: str) -> Pairs:
    """The smallest eigenpairs of one component."""
    n = S.shape[0]
    areas = M.diagonal()
    M = (M + diags_array(np.where(areas > 0, 0.0, 1e-14 * areas.mean()))).tocsc()  # vertices without area
    if n <= max(DENSE, 3 * k):
        values, X = eigh(S.toarray(), M.toarray(), subset_by_index=[0, min(k, n) - 1])
    else:
        values, X = _lanczos(S, M, k, solver)
    R = cholesky(X.T @ (M @ X))
    return values, solve_triangular(R, X.T, trans="T").T


def _lanczos(S: csc_array, M: csc_array, k: int, solver: str) -> Pairs:
    """The k smallest eigenpairs by Lanczos' method, and again beside those found while one is missing.

    In exact arithmetic the method sees one function of each eigenvalue, and ARPACK does miss some of the others.
    """
    n = S.shape[0]
    sigma = float(np.median(S.diagonal() / M.diagonal())) / n  # about their distance, 4 pi / area by Weyl's law
    factor = factorize((S + sigma * M).tocsc(), solver)
    random = np.random.default_rng(SEED)
    values, X = np.empty(0), np.empty((n, 0))

    def inverse(b: NDArray[np.float64]) -> NDArray[np.float64]:
        x = factor.solve(b.reshape(-1, 1)).ravel()
        return x - X @ (X.T @ (M @ x))

    wanted = k
    for _ in range(ATTEMPTS):
        operator = LinearOperator((n, n), matvec=inverse, dtype=np.float64)
        found, Y = eigsh(S, wanted, M, sigma=-sigma, OPinv=operator, v0=random.uniform(0.5, 1.5, n))
        order = np.argsort(np.concatenate([values, found]), kind="stable")[:k]
        values = np.concatenate([values, found])[order]
        X = np.concatenate([X, Y], axis=1)[:, order]
        below = values[-1] - 1e-6 * (values[-1] + sigma)
        wanted = min(k, count_below(S, M, below) - int((values < below).sum()))
        if wanted <= 0:
            break
    return values, X


def count_below(S: csc_array, M: csc_array, bound: float) -> int:
    """How many eigenvalues are below a bound: the negative pivots of S - bound M, by Sylvester's law of inertia."""
    options = {"SymmetricMode": True}
    factor = splu((S - bound * M).tocsc(), permc_spec="COLAMD", diag_pivot_thresh=0.0, options=options)
    return int((factor.U.diagonal() < 0).sum())
