"""Nearest neighbors among points, by the boxes of :mod:`lbskel._kernels.bvh` around them.

The search goes down to the nearer child first and leaves out boxes that are farther than the farthest neighbor found
so far: Friedman, Bentley, Finkel 1977, "An algorithm for finding best matches in logarithmic expected time",
https://doi.org/10.1145/355744.355745. The distance to the k-th neighbor changes by no more than a query moves, so that
of the query before bounds the search from its start.
"""

from __future__ import annotations

__all__ = ["PointTree", "nearest_neighbors", "points_in_disks"]

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.bvh import bounding_boxes, spatial_order

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython
if cython.compiled:
    from cython.cimports.libc.math import sqrt
else:
    from math import sqrt

LEAF = cython.declare(cython.Py_ssize_t, 4)  # points in a leaf, as in bvh
BUCKET = cython.declare(cython.Py_ssize_t, 16)  # points whose own boxes are not looked at: 8 takes 6 % longer, 4 20 %
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # length of a traversal stack, as in bvh
INFINITY = cython.declare(cython.double, float("inf"))
NONE = cython.declare(cython.longlong, 2**62)  # number of a neighbor that is not found yet
MARGIN = cython.declare(cython.double, 1e-9)  # relative; above the rounding error of a squared distance (a guess)


class PointTree:
    """Points in a search tree, whose queries many threads may make at a time.

    Parameters
    ----------
    points : (n, 3) array of float
        At least one.
    """

    def __init__(self, points: NDArray[np.float64]) -> None:
        points = np.ascontiguousarray(points)
        corners = np.repeat(np.arange(len(points)), 3).reshape(-1, 3)
        self.order = spatial_order(points, corners)
        self.boxes = bounding_boxes(points, corners, self.order, 0.0)[1]
        self.points = points[self.order]

    def nearest(self, queries: NDArray[np.float64], k: int = 1) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """(q, k) distances and (q, k) numbers of the nearest points, those of equal distance by their numbers.

        Fewer columns where there are fewer points.

        Parameters
        ----------
        queries : (q, 3) array of float
            Faster where each is near the one before.
        k : int
        """
        queries = np.ascontiguousarray(queries)
        squares, numbers = nearest_neighbors(self.points, self.order, self.boxes, queries, min(k, len(self.points)))
        return np.sqrt(squares), numbers

    def neighbors(self, k: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """(n, k) distances and (n, k) numbers of the points nearest to each point, of which it is itself one.

        Parameters
        ----------
        k : int
        """
        found = self.nearest(self.points, k)
        distances, numbers = np.empty_like(found[0]), np.empty_like(found[1])
        distances[self.order], numbers[self.order] = found
        return distances, numbers

    def in_disks(
        self,
        centers: NDArray[np.float64],
        radii: NDArray[np.float64],
        axes: NDArray[np.float64],
        widths: NDArray[np.float64],
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(f,) numbers of the points in some thick disks, one after the other, and (b,) how many points each has.

        Parameters
        ----------
        centers : (b, 3) array of float
        radii : (b,) array of float
        axes : (b, 3) array of float
            Of unit length.
        widths : (b,) array of float
            Half thickness of each disk.
        """
        centers, axes = np.ascontiguousarray(centers), np.ascontiguousarray(axes)
        return points_in_disks(self.points, self.order, self.boxes, centers, radii, axes, widths)


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _box_distance(
    boxes: cython.const[cython.double][:, ::1],
    node: cython.Py_ssize_t,
    x: cython.double,
    y: cython.double,
    z: cython.double,
) -> cython.double:
    """Squared distance from a point to a box; 0 inside."""
    dx: cython.double = max(max(boxes[node, 0] - x, x - boxes[node, 3]), 0.0)
    dy: cython.double = max(max(boxes[node, 1] - y, y - boxes[node, 4]), 0.0)
    dz: cython.double = max(max(boxes[node, 2] - z, z - boxes[node, 5]), 0.0)
    return dx * dx + dy * dy + dz * dz


@cython.locals(i=cython.Py_ssize_t, last=cython.Py_ssize_t, slot=cython.Py_ssize_t, row=cython.Py_ssize_t)
@cython.locals(node=cython.Py_ssize_t, top=cython.Py_ssize_t, end=cython.Py_ssize_t, number=cython.longlong)
@cython.locals(x=cython.double, y=cython.double, z=cython.double, dx=cython.double, dy=cython.double, dz=cython.double)
@cython.locals(left=cython.double, right=cython.double, bound=cython.double, squared=cython.double)
def nearest_neighbors(
    points: cython.const[cython.double][:, ::1],
    order: cython.const[cython.longlong][::1],
    boxes: cython.const[cython.double][:, ::1],
    queries: cython.const[cython.double][:, ::1],
    k: cython.Py_ssize_t,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(q, k) squared distances and (q, k) numbers of the points nearest to each query, in ascending order.

    Parameters
    ----------
    points : (n, 3) array of float
        In the order of the leaves, at least k.
    order : (n,) array of int
        Their numbers.
    boxes : (2 p, 6) array of float
        Of the nodes of the tree, as of :func:`lbskel._kernels.bvh.bounding_boxes`.
    queries : (q, 3) array of float
    k : int
    """
    p: cython.Py_ssize_t = boxes.shape[0] // 2
    size: cython.Py_ssize_t = LEAF
    while size < BUCKET and p > 1:
        p, size = p // 2, size * 2
    distances_array, neighbors_array = np.empty((queries.shape[0], k)), np.empty((queries.shape[0], k), dtype=np.int64)
    distances: cython.double[:, ::1] = distances_array
    neighbors: cython.longlong[:, ::1] = neighbors_array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    lower_bounds: cython.double[::1] = np.empty(DEPTH)
    last = k - 1
    with cython.nogil:
        for i in range(queries.shape[0]):
            x, y, z = queries[i, 0], queries[i, 1], queries[i, 2]
            bound = INFINITY
            if i > 0:
                dx, dy, dz = x - queries[i - 1, 0], y - queries[i - 1, 1], z - queries[i - 1, 2]
                bound = sqrt(dx * dx + dy * dy + dz * dz) + sqrt(distances[i - 1, last])
                bound = bound * bound * (1 + MARGIN)
            neighbors[i, last] = NONE
            while neighbors[i, last] == NONE:
                for slot in range(k):
                    distances[i, slot], neighbors[i, slot] = bound, NONE
                top = 1
                stack[0], lower_bounds[0] = 1, 0.0
                while top > 0:
                    top -= 1
                    node, left = stack[top], lower_bounds[top]
                    while node < p and left <= bound:
                        node *= 2
                        left, right = _box_distance(boxes, node, x, y, z), _box_distance(boxes, node + 1, x, y, z)
                        stack[top], lower_bounds[top] = node + 1, right
                        if right < left:
                            stack[top], lower_bounds[top] = node, left
                            node, left = node + 1, right
                        if lower_bounds[top] <= bound:
                            top += 1
                    if left > bound:
                        continue
                    end = min((node - p + 1) * size, points.shape[0])
                    for row in range((node - p) * size, end):
                        dx, dy, dz = x - points[row, 0], y - points[row, 1], z - points[row, 2]
                        squared = dx * dx + dy * dy + dz * dz
                        if squared > bound or (squared == bound and order[row] > neighbors[i, last]):
                            continue
                        number, slot = order[row], last
                        while slot > 0 and (
                            distances[i, slot - 1] > squared
                            or (distances[i, slot - 1] == squared and neighbors[i, slot - 1] > number)
                        ):
                            distances[i, slot], neighbors[i, slot] = distances[i, slot - 1], neighbors[i, slot - 1]
                            slot -= 1
                        distances[i, slot], neighbors[i, slot] = squared, number
                        bound = distances[i, last]
                bound = INFINITY  # where it was too small, as of numbers whose squares underflow
    return distances_array, neighbors_array


@cython.locals(disk=cython.Py_ssize_t, row=cython.Py_ssize_t, node=cython.Py_ssize_t, top=cython.Py_ssize_t)
@cython.locals(n=cython.Py_ssize_t, before=cython.Py_ssize_t, along=cython.double, bound=cython.double)
@cython.locals(x=cython.double, y=cython.double, z=cython.double, dx=cython.double, dy=cython.double, dz=cython.double)
def points_in_disks(
    points: cython.const[cython.double][:, ::1],
    order: cython.const[cython.longlong][::1],
    boxes: cython.const[cython.double][:, ::1],
    centers: cython.const[cython.double][:, ::1],
    radii: cython.const[cython.double][::1],
    axes: cython.const[cython.double][:, ::1],
    widths: cython.const[cython.double][::1],
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(f,) numbers of the points in some thick disks, one after the other, and (b,) how many points each has.

    A point is in a disk where it is in the ball around the center, and no farther from the plane than the width.

    Parameters
    ----------
    points, order, boxes
        As of :func:`nearest_neighbors`.
    centers : (b, 3) array of float
    radii : (b,) array of float
    axes : (b, 3) array of float
        Normals of the planes, of unit length.
    widths : (b,) array of float
    """
    if not centers.shape[0] == radii.shape[0] == axes.shape[0] == widths.shape[0]:
        raise ValueError("there must be a radius, an axis and a width for each center")
    p: cython.Py_ssize_t = boxes.shape[0] // 2
    counts_array = np.zeros(centers.shape[0], dtype=np.int64)
    counts: cython.longlong[::1] = counts_array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    found_array = np.empty(points.shape[0], dtype=np.int64)
    found: cython.longlong[::1] = found_array
    n = 0
    for disk in range(centers.shape[0]):
        if found.shape[0] - n < points.shape[0]:  # room for all points
            found_array = np.concatenate([found_array, np.empty(len(found_array) + len(points), dtype=np.int64)])
            found = found_array
        with cython.nogil:
            x, y, z = centers[disk, 0], centers[disk, 1], centers[disk, 2]
            bound = radii[disk] * radii[disk]
            before = n
            stack[0], top = 1, 1
            while top > 0:
                top -= 1
                node = stack[top]
                if _box_distance(boxes, node, x, y, z) > bound:
                    continue
                if node < p:
                    stack[top], stack[top + 1], top = 2 * node + 1, 2 * node, top + 2
                    continue
                for row in range((node - p) * LEAF, min((node - p + 1) * LEAF, points.shape[0])):
                    dx, dy, dz = x - points[row, 0], y - points[row, 1], z - points[row, 2]
                    along = dx * axes[disk, 0] + dy * axes[disk, 1] + dz * axes[disk, 2]
                    if dx * dx + dy * dy + dz * dz <= bound and -widths[disk] <= along <= widths[disk]:
                        found[n], n = order[row], n + 1
            counts[disk] = n - before
    return found_array[:n], counts_array
