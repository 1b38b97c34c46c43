"""Gradients of functions that are linear on triangles given by their edge lengths alone.

Each triangle lies in a plane of its own, with its first corner at the origin and its second on the x axis. The gradient
of the hat function of a corner is the opposite edge, turned by a right angle, over twice the area. Botsch, Kobbelt,
Pauly, Alliez, Levy 2010, "Polygon mesh processing", section 3.3.
"""

from __future__ import annotations

__all__ = ["gradient_matrix", "unit_gradients"]

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

TINY = np.finfo(np.float64).tiny  # smallest number by which is divided


def gradient_matrix(
    faces: NDArray[np.int64], lengths: NDArray[np.float64], n: int
) -> tuple[csr_array, NDArray[np.float64]]:
    """Build the matrix from values at vertices to gradients of triangles.

    Parameters
    ----------
    faces : (m, 3) array of int
    lengths : (m, 3) array of float
        Length of the edge opposite each corner.
    n : int
        Number of vertices.

    Returns
    -------
    gradient : (2m, n) csr_array
        The x components of all triangles, then the y components; zero rows for triangles without area.
    areas : (m,) array of float
    """
    a, b, c = lengths.T
    double_areas = igl.doublearea(np.ascontiguousarray(lengths), 0.0)
    is_flat = ~(double_areas > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = (b * b + c * c - a * a) / (2 * c), double_areas / c
        edges = np.stack([[x - c, -x, c], [y, -y, np.zeros_like(y)]]).transpose(0, 2, 1)  # opposite each corner
        hats = np.stack([-edges[1], edges[0]]) / double_areas[:, None]
    hats[:, is_flat] = 0.0
    m = len(faces)
    entries = (hats.ravel(), np.tile(faces, (2, 1)).ravel(), 3 * np.arange(2 * m + 1))
    gradient = csr_array(entries, shape=(2 * m, n))
    gradient.sum_duplicates()
    return gradient, np.where(is_flat, 0.0, double_areas / 2)


def unit_gradients(gradient: csr_array, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the (2m,) gradients of unit length, also of values whose squares underflow; zero where there is none.

    Parameters
    ----------
    gradient : (2m, n) csr_array
        As of :func:`gradient_matrix`.
    values : (n,) array of float
    """
    directions: NDArray[np.float64] = (gradient @ values).reshape(2, -1)
    with np.errstate(under="ignore"):
        directions /= np.maximum(np.abs(directions).max(axis=0), TINY)
        directions /= np.maximum(np.hypot(*directions), TINY)
    return directions.ravel()
