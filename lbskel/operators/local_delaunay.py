"""The Delaunay star of each point of a cloud among its nearest neighbors, for all points at once.

With the point at the origin, its neighbors q in the star are those whose inversions q / |q|^2 are corners of the
convex hull of all inversions and the origin: that hull is polar to the Voronoi cell. A neighbor in the triangle
of the origin and the neighbors before and after it by angle is no corner, and is dropped; rounds of this leave the
hull.
"""

from __future__ import annotations

__all__ = ["delaunay_stars"]

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

TOLERANCE = 1e-9


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cross products of vectors of the plane."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _sine(a: NDArray[np.float64], b: NDArray[np.float64], sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sines of the angles from a to b, given the products of their lengths; zero where one has none."""
    return np.divide(_cross(a, b), sizes, out=np.zeros_like(sizes), where=sizes > 0)


def _neighbors_in_plane(points: NDArray[np.float64], n_neighbors: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(n, k) neighbors of each point by angle, and their (n, k, 2) places in its plane; a point itself is at 0."""
    neighbors = KDTree(points).query(points, k=min(n_neighbors, len(points)))[1].reshape(len(points), -1)
    offsets = points[neighbors] - points[:, None]
    centered = offsets - offsets.mean(axis=1, keepdims=True)
    axes = np.linalg.eigh(np.einsum("nki,nkj->nij", centered, centered))[1][:, :, :0:-1]
    Q = np.einsum("nki,nij->nkj", offsets, axes)
    order = np.argsort(np.arctan2(Q[..., 1], Q[..., 0]), axis=1, kind="stable")
    return np.take_along_axis(neighbors, order, axis=1), np.take_along_axis(Q, order[..., None], axis=1)


def _around(active: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(n, k) columns of the active neighbors before and after each column, cyclically."""
    k = active.shape[1]
    columns = np.arange(k)
    latest = np.maximum.accumulate(np.where(active, columns, -1), axis=1)
    before = np.concatenate([latest[:, -1:], latest[:, :-1]], axis=1)
    before = np.where(before < 0, latest[:, -1:], before)
    soonest = np.minimum.accumulate(np.where(active, columns, k)[:, ::-1], axis=1)[:, ::-1]
    after = np.concatenate([soonest[:, 1:], soonest[:, :1]], axis=1)
    after = np.where(after == k, soonest[:, :1], after)
    return np.clip(before, 0, k - 1), np.clip(after, 0, k - 1)


def _at(values: NDArray[np.float64], columns: NDArray[np.int64]) -> NDArray[np.float64]:
    """The vectors in these columns of each row."""
    return np.take_along_axis(values, columns[..., None], axis=1)


def delaunay_stars(points: NDArray[np.float64], n_neighbors: int) -> NDArray[np.int64]:
    """(t, 3) triangles of the stars of all points, each with its center first; open fans at the rim.

    Parameters
    ----------
    points : (n, 3) array of float
    n_neighbors : int
        How many nearest points, itself among them, each point looks at.
    """
    neighbors, Q = _neighbors_in_plane(points, n_neighbors)
    squares = (Q**2).sum(axis=-1)
    active = squares > TOLERANCE**2 * squares.max(axis=1, keepdims=True)
    Z = np.divide(Q, squares[..., None], out=np.zeros_like(Q), where=active[..., None])
    sizes = np.sqrt((Z**2).sum(axis=-1))
    while True:
        before, after = _around(active)
        B, A = _at(Z, before), _at(Z, after)
        before_size, after_size = (np.take_along_axis(sizes, columns, axis=1) for columns in (before, after))
        from_before, to_after = _sine(B, Z, before_size * sizes), _sine(Z, A, sizes * after_size)
        follows, leads = (B * Z).sum(axis=-1) > 0, (Z * A).sum(axis=-1) > 0
        behind = (np.abs(from_before) <= TOLERANCE) & follows & (before != np.arange(active.shape[1]))
        ahead = (np.abs(to_after) <= TOLERANCE) & leads & (after != np.arange(active.shape[1]))
        hidden = (behind & (before_size >= sizes)) | (ahead & (after_size > sizes))
        inside = (from_before > TOLERANCE) & (to_after > TOLERANCE) & (_cross(Z - B, A - Z) <= TOLERANCE * sizes**2)
        dropped = active & (hidden | inside)
        if not dropped.any():
            break
        active &= ~dropped
    point, column = np.nonzero(active & (to_after > TOLERANCE))
    return np.stack([point, neighbors[point, column], neighbors[point, after[point, column]]], axis=1)
