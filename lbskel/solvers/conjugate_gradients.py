"""Conjugate gradients, preconditioned by the diagonal or by algebraic multigrid.

Hestenes, Stiefel 1952, https://doi.org/10.6028/jres.049.044; smoothed aggregation by pyamg: Vanek, Mandel, Brezina
1996, https://doi.org/10.1007/BF02238511.
"""

from __future__ import annotations

__all__ = ["ConjugateGradientsJacobi", "ConjugateGradientsMultigrid"]

from abc import abstractmethod
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from lbskel.errors import MissingDependency
from lbskel.solvers.iterative import Iterates, Iterative, column_dot, ratios


class _ConjugateGradients(Iterative):
    """Conjugate gradients with steps of its own for each column."""

    @abstractmethod
    def _precondition(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        """Approximate A^-1 R."""

    def _iterates(self, X: NDArray[np.float64], R: NDArray[np.float64]) -> Iterates:
        P = Z = self._precondition(R)
        products = column_dot(R, Z)
        while True:
            Q = self._matrix @ P
            steps = ratios(products, column_dot(P, Q))
            X, R = X + steps * P, R - steps * Q
            yield X, R
            Z = self._precondition(R)
            previous, products = products, column_dot(R, Z)
            P = Z + ratios(products, previous) * P


class ConjugateGradientsJacobi(_ConjugateGradients):
    """Conjugate gradients preconditioned by the diagonal."""

    def _prepare(self, A: Any) -> None:
        self._inverse_diagonal: NDArray[np.float64] = (1 / A.diagonal())[:, None]

    def _precondition(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._inverse_diagonal * R


class ConjugateGradientsMultigrid(_ConjugateGradients):
    """Conjugate gradients preconditioned by one cycle of algebraic multigrid."""

    def _prepare(self, A: Any) -> None:
        try:
            pyamg = import_module("pyamg")
        except ImportError:
            raise MissingDependency("pyamg", "multigrid", "the solver 'cg_amg'") from None
        state = np.random.get_state()  # noqa: NPY002 - pyamg uses numpy's legacy global generator
        np.random.seed(0)  # noqa: NPY002
        try:
            M = csr_matrix(A)
            M.indices, M.indptr = M.indices.astype(np.int32), M.indptr.astype(np.int32)  # pyamg takes no others
            self._cycle = pyamg.smoothed_aggregation_solver(M).aspreconditioner()
        finally:
            np.random.set_state(state)  # noqa: NPY002

    def _precondition(self, R: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.stack([self._cycle @ column for column in R.T], axis=1)
