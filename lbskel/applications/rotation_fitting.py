"""Rotations nearest to matrices, in closed form but for one root: the orthogonal Procrustes problem with determinant 1.

The rotation R with the largest tr(R^T M) is, with the singular values s1 >= s2 >= |s3| of M, where s3 has the sign of
det M, and their sum l (Markley 1993, "Attitude determination using vector observations: a fast optimal matrix
algorithm"):

    R = ((k + |M|^2) M + l cof M - M M^T M) / (k l - det M),  k = (l^2 - |M|^2) / 2

where l is the largest root of x^4 - 2 |M|^2 x^2 - 8 det M x + |M|^4 - 4 |cof M|^2; Newton's method from sqrt(3) |M|
decreases to it. The denominator is (s1 + s2)(s2 + s3)(s3 + s1): where it vanishes, R is not unique, and the one nearest
to the identity is taken, by a singular value decomposition.
"""

from __future__ import annotations

__all__ = ["nearest_rotations", "rigid_fit"]

import numpy as np
from numpy.typing import NDArray

NEWTON_STEPS = 30  # at most; from sqrt(3) about six are needed where the root is single
CONVERGED = 1e-15  # step relative to |M|: rounding errors
# Smallest denominator, relative to |M|^3, for which the formula keeps ten digits; below it, the decomposition is used
MIN_DENOMINATOR = 1e-5
# Share of the identity added to M where R is not unique; R changes by about as much
TIE_BREAK = 1e-7


def _cofactors(M: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the (3, 3, n) cofactors of (3, 3, n) matrices, by cross products of their rows."""
    a, b, c = M
    rows = []
    for p, q in ((b, c), (c, a), (a, b)):
        rows.append([p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]])
    return np.array(rows)


def nearest_rotations(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Find the rotation R with the largest tr(R^T M) for each matrix M; the identity for zero.

    Parameters
    ----------
    matrices : (n, 3, 3) array of float

    Returns
    -------
    (n, 3, 3) array of float
    """
    largest = np.abs(matrices).max(axis=(1, 2))
    M = np.ascontiguousarray(matrices.transpose(1, 2, 0)) / np.where(largest > 0, largest, 1.0)
    norms = np.sqrt((M * M).sum(axis=(0, 1)))
    M /= np.where(norms > 0, norms, 1.0)  # |M| = 1 from here on
    cofactors = _cofactors(M)
    det = (M[0] * cofactors[0]).sum(axis=0)
    constant = 1 - 4 * (cofactors * cofactors).sum(axis=(0, 1))
    root = np.full(len(det), np.sqrt(3.0))
    for _ in range(NEWTON_STEPS):
        square = root * root
        slope = 4 * root * (square - 1) - 8 * det
        value = square * (square - 2) - 8 * det * root + constant
        step = np.divide(value, slope, out=np.zeros_like(root), where=slope > CONVERGED)
        root -= step
        if np.abs(step).max(initial=0.0) <= CONVERGED * 4:
            break
    k = (root * root - 1) / 2
    denominator = k * root - det
    R = (k + 1) * M + root * cofactors
    products = (M[:, None] * M[None]).sum(axis=2)  # M M^T
    for column in range(3):
        R[:, column] -= (products * M[:, column]).sum(axis=1)
    is_unique = denominator > MIN_DENOMINATOR
    R /= np.where(is_unique, denominator, 1.0)
    result: NDArray[np.float64] = np.ascontiguousarray(R.transpose(2, 0, 1))
    others = np.flatnonzero(~is_unique)
    if len(others):
        result[others] = _by_decomposition(M.transpose(2, 0, 1)[others] + TIE_BREAK * np.eye(3))
    return result


def _by_decomposition(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Find the rotations by singular value decompositions."""
    U, _, Vt = np.linalg.svd(matrices)
    U[:, :, 2] *= np.sign(np.linalg.det(U @ Vt))[:, None]
    rotations: NDArray[np.float64] = U @ Vt
    return rotations


def rigid_fit(
    source: NDArray[np.float64], target: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit the rigid motion x -> R x + t of points to others with the least sum of squared distances.

    Parameters
    ----------
    source, target : (k, 3) array of float

    Returns
    -------
    R : (3, 3) array of float
        The one nearest to the identity where several are best, as for one point.
    t : (3,) array of float
    """
    center, goal = source.mean(axis=0), target.mean(axis=0)
    R = nearest_rotations(((target - goal).T @ (source - center))[None])[0]
    return R, goal - R @ center
