"""Quadratic energies with prescribed values: factorized once, solved for many right-hand sides and values.

Hard: min tr(X^T Q X) / 2 - tr(X^T B) with X = C at the constrained rows, by elimination: Q_ff X_f = B_f - Q_fc C.
Soft: the energy plus w / 2 |X_c - C|^2. Sorkine 2005, "Laplacian mesh processing", section 3,
https://doi.org/10.2312/egst.20051044. For a matrix Q that is not symmetric positive definite, such as that of an
operator that is not symmetric, the system Q X = B itself is solved, by sparse LU.
"""

from __future__ import annotations

__all__ = ["ConstrainedSystem", "checked_indices", "factorize_square"]

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array

from lbskel.applications.symmetric import is_symmetric
from lbskel.errors import MeshError, SolveError, first_few
from lbskel.operators.assembly import diagonal_matrix
from lbskel.solvers import Factorization, factorize
from lbskel.solvers.superlu import GeneralLU


def factorize_square(A: csc_array, *, solver: str = "cholmod") -> Factorization:
    """Factorize by a solver of symmetric positive definite systems, or by LU if the matrix is not of that kind.

    Parameters
    ----------
    A : (n, n) csc_array
    solver : str
        A name in SOLVERS.

    Raises
    ------
    SolveError
        If A is singular.
    """
    if is_symmetric(A):
        try:
            return factorize(A, solver)
        except SolveError:  # indefinite, as with clamped negative weights, or singular: LU tells which
            pass
    return GeneralLU(A)


def checked_indices(indices: ArrayLike, n: int, what: str, *, distinct: bool = True) -> NDArray[np.int64]:
    """Copy vertex indices to a (k,) int64 array.

    Parameters
    ----------
    indices : (k,) array_like of int, or (n,) array_like of bool
        A mask stands for the vertices where it is true.
    n : int
        Number of vertices.
    what : str
        Their name in messages, in the plural.
    distinct : bool
        Whether no index may be given twice.

    Raises
    ------
    MeshError
        If an index is out of range, no whole number, or given twice where they have to be distinct.
    """
    try:
        given = np.asarray(indices)
    except ValueError as error:  # rows of different lengths
        raise MeshError(f"{what} must be a list of vertex indices: {error}") from None
    if given.dtype == bool and given.shape == (n,):
        return np.flatnonzero(given)
    if given.ndim != 1 or (given.size and given.dtype.kind not in "iu"):
        raise MeshError(
            f"{what} must be a list of vertex indices or a mask of all {n} vertices, not {given.dtype} of shape "
            f"{given.shape}"
        )
    numbers = given.astype(np.int64)
    outside = numbers[(numbers < 0) | (numbers >= n)]
    if outside.size:
        raise MeshError(f"{what} {first_few(outside)} are no vertices of the mesh, which has 0..{n - 1}")
    values, counts = np.unique(numbers, return_counts=True)
    if distinct and (counts > 1).any():
        raise MeshError(f"{what} {first_few(values[counts > 1])} are given twice")
    return numbers


class ConstrainedSystem:
    """A quadratic energy on n rows with prescribed values at some of them.

    Parameters
    ----------
    Q : (n, n) csc_array
        Positive semidefinite; definite on the rows that are not constrained.
    constrained : (k,) array of int
    weight : float, optional
        The weight w of soft constraints, in units of the entries of Q; by default they are hard.
    held : (h,) array of int, optional
        Rows whose value is fixed to zero; none of ``constrained``.
    solver : str
        A name in SOLVERS.

    Raises
    ------
    SolveError
        If the free part is singular.
    """

    def __init__(
        self,
        Q: csc_array,
        constrained: NDArray[np.int64],
        *,
        weight: float | None = None,
        held: NDArray[np.int64] | None = None,
        solver: str = "cholmod",
    ):
        self._n, self._constrained, self._weight = Q.shape[0], constrained, weight
        is_free = np.ones(self._n, dtype=bool)
        is_free[constrained] = weight is not None
        if held is not None:
            is_free[held] = False
        if weight is not None:
            added = np.zeros(self._n)
            added[constrained] = weight
            Q = (Q + diagonal_matrix(added)).tocsc()
        self._free = np.flatnonzero(is_free)
        rows = Q.tocsr()[self._free]
        self._coupling = rows[:, constrained].tocsr()
        self._factor = factorize_square(rows[:, self._free].tocsc(), solver=solver) if len(self._free) else None

    def solve(
        self, values: NDArray[np.float64], B: NDArray[np.float64] | None = None, *, refined: bool = True
    ) -> NDArray[np.float64]:
        """Find the (n, c) minimizer for (k, c) prescribed values and an (n, c) linear term B, by default zero.

        ``refined`` is as for :meth:`lbskel.solvers.Factorization.solve`.

        Raises
        ------
        SolveError
            If the system is singular to working accuracy.
        """
        X = np.zeros((self._n, values.shape[1]))
        right = np.zeros_like(X) if B is None else np.array(B, dtype=np.float64)
        if self._weight is not None:
            right[self._constrained] += self._weight * values
        else:
            X[self._constrained] = values
        if self._factor is not None:
            free = right[self._free]
            if self._weight is None:
                free = free - self._coupling @ values
            X[self._free] = self._factor.solve(free, refined=refined)
        return X
