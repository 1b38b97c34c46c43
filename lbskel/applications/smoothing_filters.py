"""Filters of positions by polynomials of K = D^-1 S, D the diagonal of S: Taubin's, and one with a given cutoff.

A filter repeats X -> X - K X, which is the mean of the neighbors for ``random_walk`` and ``graph``. For ``random_walk``
it is computed from the edges alone (:mod:`lbskel.applications.neighbor_means`). Taubin 1995, "A signal processing
approach to fair surface design", https://doi.org/10.1145/218380.218473.
"""

from __future__ import annotations

__all__ = ["FILTERS", "Positions", "Step", "average", "average_of_neighbors", "filter_coefficients"]

from collections.abc import Callable

import numpy as np
from numpy.polynomial.chebyshev import cheb2poly
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.applications.neighbor_means import NeighborMeans
from lbskel.operators import Laplacian

PASS_BAND = 0.1  # eigenvalue of K, in [0, 2], up to which Taubin's filter amplifies: his example
FIRST_FACTOR = 0.5  # lambda of Taubin's filter: removes the eigenvalue 2 at once
# Eigenvalue of K whose amplitude the polynomial divides by e, and the polynomial's degree. Both are swept in
# benchmarks/results/applications_smoothing.md, "Filter": higher degrees are hardly better.
CUTOFF, DEGREE = 0.4, 6
N_ANGLES = 64  # at which the filter is sampled: its coefficients are exact to rounding from 40 on

Positions = NDArray[np.float64]
Step = Callable[[Positions], Positions]


def filter_coefficients(cutoff: float, degree: int) -> NDArray[np.float64]:
    """(degree + 1,) coefficients of Chebyshev polynomials of 1 - k: nearly exp(-(k / cutoff)^2), and 1 at k = 0.

    Parameters
    ----------
    cutoff : float
        Eigenvalue k, from 0 to 2.
    degree : int
    """
    angles = np.pi * (np.arange(N_ANGLES) + 0.5) / N_ANGLES
    values = np.exp(-(((1 - np.cos(angles)) / cutoff) ** 2))
    coefficients: NDArray[np.float64] = np.cos(np.outer(np.arange(degree + 1), angles)) @ values
    coefficients[0] /= 2
    coefficients /= coefficients.sum()
    return coefficients


# coefficients of the powers of 1 - K, for Horner's scheme, which loses no digits at degrees as low as this
FILTER = cheb2poly(filter_coefficients(CUTOFF, DEGREE))


def average(L: Laplacian, held: NDArray[np.int64]) -> Step:
    """Return X -> X - K X with K = D^-1 S.

    Rows of K are zero for the vertices held. K is scaled down if negative weights give a row sum of magnitudes above 2,
    the bound on the eigenvalues.

    Parameters
    ----------
    L : Laplacian
    held : (h,) array of int
        Vertices that stay where they are.
    """
    S, diagonal = L.stiffness, L.stiffness.diagonal()
    inverse = np.divide(1.0, diagonal, out=np.zeros_like(diagonal), where=diagonal > 0)
    inverse[held] = 0
    values = S.data * inverse[S.indices]
    largest = float(np.bincount(S.indices, np.abs(values), len(diagonal)).max(initial=0.0))
    K = csc_array((values * (2 / max(2.0, largest)), S.indices, S.indptr), shape=S.shape)
    return lambda X: X - K @ X


def average_of_neighbors(means: NeighborMeans, held: NDArray[np.int64]) -> Step:
    """Return X -> X - K X for the operator ``random_walk``, from the means of neighbors.

    Parameters
    ----------
    means : NeighborMeans
    held : (h,) array of int
        Vertices that stay where they are.
    """

    def averaging(X: Positions) -> Positions:
        averaged = means @ X
        if len(held):
            averaged[held] = X[held]
        return averaged

    return averaging


def _taubin(averaging: Step) -> Step:
    second = 1 / (PASS_BAND - 1 / FIRST_FACTOR)

    def step(X: Positions) -> Positions:
        Y = X + FIRST_FACTOR * (averaging(X) - X)
        moved: Positions = Y + second * (averaging(Y) - Y) - X
        return moved

    return step


def _polynomial(averaging: Step) -> Step:
    def step(X: Positions) -> Positions:
        total: Positions = FILTER[-1] * X
        for coefficient in FILTER[-2::-1]:
            total = averaging(total)
            total += coefficient * X
        total -= X
        return total

    return step


FILTERS: dict[str, Callable[[Step], Step]] = {"taubin": _taubin, "polynomial": _polynomial}
