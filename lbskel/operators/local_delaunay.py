"""The Delaunay star of each point of a cloud among its nearest neighbors, for all points at once.

With the point at the origin, its neighbors q in the star are those whose inversions q / |q|^2 are vertices of the
convex hull of all inversions and the origin: this hull is polar to the Voronoi cell. A neighbor inside the triangle of
the origin and the neighbors before and after it by angle is no vertex of the hull and is removed; after rounds of
removal only the hull is left. Of four points on a circle, as on a grid, the stars of all four have the diagonal whose
ends include the lowest of their numbers.
"""

from __future__ import annotations

__all__ = ["delaunay_stars"]

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

# Largest sine that counts as zero, and smallest distance of a neighbor relative to the farthest one; no unit. A guess:
# well above rounding, below any angle that changes a weight.
TOLERANCE = 1e-9


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cross products of plane vectors."""
    product: NDArray[np.float64] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _sine(a: NDArray[np.float64], b: NDArray[np.float64], norms: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sines of the angles from a to b, given the products of their norms; zero where a norm is zero."""
    return np.divide(_cross(a, b), norms, out=np.zeros_like(norms), where=norms > 0)


def _neighbors_in_plane(points: NDArray[np.float64], n_neighbors: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Find the (n, k) neighbors of each point sorted by angle, and their (n, k, 2) coordinates in its plane.

    The plane is that of least squares; the point itself is at the origin.
    """
    neighbors = KDTree(points).query(points, k=min(n_neighbors, len(points)))[1].reshape(len(points), -1)
    offsets = points[neighbors] - points[:, None]
    centered = offsets - offsets.mean(axis=1, keepdims=True)
    axes = np.linalg.eigh(np.einsum("nki,nkj->nij", centered, centered))[1][:, :, :0:-1]
    Q = np.einsum("nki,nij->nkj", offsets, axes)
    order = np.argsort(np.arctan2(Q[..., 1], Q[..., 0]), axis=1, kind="stable")
    return np.take_along_axis(neighbors, order, axis=1), np.take_along_axis(Q, order[..., None], axis=1)


def _cyclic_neighbors(active: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find the (n, k) columns of the last active entry before each column and the first after it, cyclically."""
    k = active.shape[1]
    columns = np.arange(k)
    last = np.maximum.accumulate(np.where(active, columns, -1), axis=1)
    before = np.concatenate([last[:, -1:], last[:, :-1]], axis=1)
    before = np.where(before < 0, last[:, -1:], before)
    first = np.minimum.accumulate(np.where(active, columns, k)[:, ::-1], axis=1)[:, ::-1]
    after = np.concatenate([first[:, 1:], first[:, :1]], axis=1)
    after = np.where(after == k, first[:, :1], after)
    return np.clip(before, 0, k - 1), np.clip(after, 0, k - 1)


def _take_vectors(values: NDArray[np.float64], columns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the vectors in these columns of each row."""
    return np.take_along_axis(values, columns[..., None], axis=1)


def delaunay_stars(points: NDArray[np.float64], n_neighbors: int) -> NDArray[np.int64]:
    """Compute the (t, 3) triangles of the Delaunay stars of all points, each with its center first.

    The star of a point at a boundary is an open fan.

    Parameters
    ----------
    points : (n, 3) array of float
    n_neighbors : int
        Number of nearest points considered for each star, the center included.
    """
    neighbors, Q = _neighbors_in_plane(points, n_neighbors)
    squared_norms = (Q**2).sum(axis=-1)
    active = squared_norms > TOLERANCE**2 * squared_norms.max(axis=1, keepdims=True)
    Z = np.divide(Q, squared_norms[..., None], out=np.zeros_like(Q), where=active[..., None])
    norms = np.sqrt((Z**2).sum(axis=-1))
    lower_end = np.minimum(neighbors, np.arange(len(points))[:, None])  # of the diagonal from the center
    while True:
        before, after = _cyclic_neighbors(active)
        B, A = _take_vectors(Z, before), _take_vectors(Z, after)
        norms_before, norms_after = (np.take_along_axis(norms, columns, axis=1) for columns in (before, after))
        sine_before, sine_after = _sine(B, Z, norms_before * norms), _sine(Z, A, norms * norms_after)
        # parallel to the neighbor before or after: the farther of the two (nearer after inversion) is hidden
        is_acute_before, is_acute_after = (B * Z).sum(axis=-1) > 0, (Z * A).sum(axis=-1) > 0
        is_other_before, is_other_after = (other != np.arange(active.shape[1]) for other in (before, after))
        is_parallel_before = (np.abs(sine_before) <= TOLERANCE) & is_acute_before & is_other_before
        is_parallel_after = (np.abs(sine_after) <= TOLERANCE) & is_acute_after & is_other_after
        is_hidden = (is_parallel_before & (norms_before >= norms)) | (is_parallel_after & (norms_after > norms))
        is_between = (sine_before > TOLERANCE) & (sine_after > TOLERANCE)
        other_end = np.minimum(*(np.take_along_axis(neighbors, columns, axis=1) for columns in (before, after)))
        slack = np.where(lower_end < other_end, -TOLERANCE, TOLERANCE)  # the four are on a circle within the tolerance
        is_inside = is_between & (_cross(Z - B, A - Z) <= slack * norms**2)
        removed = active & (is_hidden | is_inside)
        if not removed.any():
            break
        active &= ~removed
    point, column = np.nonzero(active & (sine_after > TOLERANCE))
    return np.stack([point, neighbors[point, column], neighbors[point, after[point, column]]], axis=1)
