"""Quadrics of lines: the squared distance of a point to several lines as one quadratic form.

Garland, Heckbert 1997, https://doi.org/10.1145/258734.258849, with the lines of edges in place of the planes of faces
(Au, Tai, Chu, Cohen-Or, Lee 2008, https://doi.org/10.1145/1399504.1360643, section 5).
"""

from __future__ import annotations

__all__ = ["line_quadrics"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array


def line_quadrics(P: NDArray[np.float64], edges: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n, 4, 4) quadrics: sum over the edges at each vertex of the squared distance to the edge's line.

    Parameters
    ----------
    P : (n, 3) array of float
    edges : (k, 2) array of int
        An edge of no length has no line and adds nothing.
    """
    start, end = P.take(edges.T, axis=0)
    vector = end - start
    length = np.linalg.norm(vector, axis=1, keepdims=True)
    direction = np.divide(vector, length, out=np.zeros_like(vector), where=length > 0)
    A = np.eye(3) - direction[:, :, None] * direction[:, None, :]
    A[length[:, 0] == 0] = 0
    shifted = np.einsum("kij,kj->ki", A, start)
    line = np.empty((len(edges), 4, 4))
    line[:, :3, :3], line[:, :3, 3], line[:, 3, :3] = A, -shifted, -shifted
    line[:, 3, 3] = np.einsum("ki,ki->k", start, shifted)
    places = edges.T.ravel(), np.tile(np.arange(len(edges)), 2)
    ends = coo_array((np.ones(2 * len(edges)), places), shape=(len(P), len(edges)))
    quadrics: NDArray[np.float64] = (ends.tocsr() @ line.reshape(-1, 16)).reshape(-1, 4, 4)
    return quadrics
