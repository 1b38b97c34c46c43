"""Bounding volume hierarchy of axis-aligned boxes over faces, and closest points by it.

The tree is a complete binary tree without pointers: node i has the children 2 i and 2 i + 1, node 1 is the root, and
the last half of the nodes are leaves. Leaf k holds the LEAF faces from ``order[LEAF * k]`` on.
"""

from __future__ import annotations

__all__ = ["bounding_boxes", "nearest_points", "spatial_order"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython
if cython.compiled:
    from cython.cimports.libc.math import sqrt
else:
    from math import sqrt

LEAF = cython.declare(cython.Py_ssize_t, 4)  # faces in a leaf; a guess, the same in ray_casting and cross_sections
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # length of a traversal stack: no tree of 2^63 faces is deeper
EMPTY = cython.declare(cython.double, 1e150)  # coordinate of boxes without faces: its square is large, but finite
INFINITY = cython.declare(cython.double, float("inf"))
BOUND_MARGIN = cython.declare(cython.double, 1e-9)  # relative; above the rounding error of a squared distance (a guess)


@cython.locals(begin=cython.Py_ssize_t, end=cython.Py_ssize_t, half=cython.Py_ssize_t, row=cython.Py_ssize_t)
@cython.locals(widest=cython.Py_ssize_t)
def spatial_order(
    V: cython.const[cython.double][:, ::1], F: cython.const[cython.longlong][:, ::1]
) -> NDArray[np.int64]:
    """(m,) order of the faces in which those of every node of the tree are consecutive.

    The faces of a node are split at a rank of their centroids along the axis on which these extend farthest, so that
    the first child is full.
    """
    m: cython.Py_ssize_t = F.shape[0]
    centers: cython.double[:, ::1] = np.empty((m, 3))
    top: cython.Py_ssize_t = 1
    size: cython.Py_ssize_t = LEAF
    array = np.arange(m)
    order: cython.longlong[::1] = array
    stack: cython.longlong[:, ::1] = np.empty((DEPTH, 3), dtype=np.int64)
    with cython.nogil:
        for row in range(m):
            for half in range(3):
                centers[row, half] = V[F[row, 0], half] + V[F[row, 1], half] + V[F[row, 2], half]
        while size < m:
            size *= 2
        stack[0, 0], stack[0, 1], stack[0, 2] = 0, m, size
        while top > 0:
            top -= 1
            begin, end, size = stack[top, 0], stack[top, 1], stack[top, 2]
            while size > LEAF:
                size //= 2
                half = begin + size
                if half >= end:
                    continue
                widest = _longest_side(centers, begin, end)
                _partition(centers, order, begin, end, half, widest)
                stack[top, 0], stack[top, 1], stack[top, 2] = half, end, size
                top += 1
                end = half
    return array


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(row=cython.Py_ssize_t, x=cython.double, y=cython.double, z=cython.double)
def _longest_side(
    centers: cython.const[cython.double][:, ::1], begin: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """Axis along which the centers in rows ``begin`` to ``end`` extend farthest."""
    x, y, z = centers[begin, 0], centers[begin, 1], centers[begin, 2]
    high_x: cython.double = x
    high_y: cython.double = y
    high_z: cython.double = z
    for row in range(begin + 1, end):
        x, high_x = min(x, centers[row, 0]), max(high_x, centers[row, 0])
        y, high_y = min(y, centers[row, 1]), max(high_y, centers[row, 1])
        z, high_z = min(z, centers[row, 2]), max(high_z, centers[row, 2])
    x, y, z = high_x - x, high_y - y, high_z - z
    return 0 if x >= max(y, z) else 1 if y >= z else 2


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(i=cython.Py_ssize_t, j=cython.Py_ssize_t, pivot=cython.double, row=cython.Py_ssize_t)
def _partition(
    centers: cython.double[:, ::1],
    order: cython.longlong[::1],
    begin: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    half: cython.Py_ssize_t,
    axis: cython.Py_ssize_t,
) -> cython.void:
    """Reorder rows so that those smallest along an axis come before ``half``: Hoare 1961, "Algorithm 65: find"."""
    first: cython.Py_ssize_t = begin
    last: cython.Py_ssize_t = end - 1
    while first < last:
        lowest: cython.double = centers[first, axis]
        middle: cython.double = centers[(first + last) // 2, axis]
        highest: cython.double = centers[last, axis]
        pivot = max(min(lowest, middle), min(max(lowest, middle), highest))
        i, j = first, last
        while i <= j:
            while centers[i, axis] < pivot:
                i += 1
            while pivot < centers[j, axis]:
                j -= 1
            if i <= j:
                for row in range(3):
                    centers[i, row], centers[j, row] = centers[j, row], centers[i, row]
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if half <= j:
            last = j
        elif half >= i:
            first = i
        else:
            return


@cython.locals(
    node=cython.Py_ssize_t,
    row=cython.Py_ssize_t,
    corner=cython.Py_ssize_t,
    axis=cython.Py_ssize_t,
    face=cython.Py_ssize_t,
    x=cython.double,
    lowest=cython.double,
    highest=cython.double,
)
def bounding_boxes(
    V: cython.const[cython.double][:, ::1],
    F: cython.const[cython.longlong][:, ::1],
    order: cython.const[cython.longlong][::1],
    margin: cython.double,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(m, 9) corners of the faces in their order, and (2 p, 6) lowest and highest corner of each node's box.

    Boxes are widened by ``margin`` on each side, in the units of the vertices. Row 0 is not used.
    """
    m: cython.Py_ssize_t = order.shape[0]
    p: cython.Py_ssize_t = 1
    while p * LEAF < m:
        p *= 2
    corners_array, boxes_array = np.empty((m, 9)), np.full((2 * p, 6), EMPTY)
    corners: cython.double[:, ::1] = corners_array
    boxes: cython.double[:, ::1] = boxes_array
    with cython.nogil:
        for row in range(m):
            for corner in range(3):
                for axis in range(3):
                    corners[row, 3 * corner + axis] = V[F[order[row], corner], axis]
        for node in range(p, p + (m + LEAF - 1) // LEAF):
            row = (node - p) * LEAF
            for axis in range(3):
                lowest, highest = INFINITY, -INFINITY
                for face in range(row, min(row + LEAF, m)):
                    for corner in range(3):
                        x = corners[face, 3 * corner + axis]
                        lowest, highest = min(lowest, x), max(highest, x)
                boxes[node, axis], boxes[node, axis + 3] = lowest - margin, highest + margin
        for node in range(p - 1, 0, -1):
            for axis in range(6):
                boxes[node, axis] = boxes[2 * node, axis]
            if boxes[2 * node + 1, 0] < EMPTY:
                for axis in range(3):
                    boxes[node, axis] = min(boxes[node, axis], boxes[2 * node + 1, axis])
                    boxes[node, axis + 3] = max(boxes[node, axis + 3], boxes[2 * node + 1, axis + 3])
    return corners_array, boxes_array


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def box_distance(
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


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _nearest_on_segment(
    x: cython.double,
    y: cython.double,
    z: cython.double,
    dx: cython.double,
    dy: cython.double,
    dz: cython.double,
    best: cython.double,
    offset: cython.double[::1],
) -> cython.double:
    """Squared distance from the origin to a segment, or ``best`` if smaller; the closest point is written if it is."""
    squared: cython.double = dx * dx + dy * dy + dz * dz
    t: cython.double = 0.0
    if squared > 0:
        t = min(max(-(x * dx + y * dy + z * dz) / squared, 0.0), 1.0)
    x, y, z = x + t * dx, y + t * dy, z + t * dz
    squared = x * x + y * y + z * z
    if squared < best:
        offset[0], offset[1], offset[2] = x, y, z
        return squared
    return best


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
@cython.locals(height=cython.double)
def _nearest_on_face(
    corners: cython.const[cython.double][:, ::1],
    row: cython.Py_ssize_t,
    x: cython.double,
    y: cython.double,
    z: cython.double,
    best: cython.double,
    offset: cython.double[::1],
) -> cython.double:
    """Squared distance from a point to a triangle, or ``best`` if that is smaller.

    Where the triangle is nearer, the vector from the point to it is written. The closest point is the foot of the
    perpendicular if that lies inside, otherwise the closest point of the three edges.
    """
    ax: cython.double = corners[row, 0] - x
    ay: cython.double = corners[row, 1] - y
    az: cython.double = corners[row, 2] - z
    bx: cython.double = corners[row, 3] - x
    by: cython.double = corners[row, 4] - y
    bz: cython.double = corners[row, 5] - z
    cx: cython.double = corners[row, 6] - x
    cy: cython.double = corners[row, 7] - y
    cz: cython.double = corners[row, 8] - z
    nx: cython.double = max(min(ax, min(bx, cx)), -max(ax, max(bx, cx)))
    ny: cython.double = max(min(ay, min(by, cy)), -max(ay, max(by, cy)))
    nz: cython.double = max(min(az, min(bz, cz)), -max(az, max(bz, cz)))
    nx, ny, nz = max(nx, 0.0), max(ny, 0.0), max(nz, 0.0)
    if nx * nx + ny * ny + nz * nz >= best:  # the box of the triangle is farther
        return best
    px: cython.double = bx - ax
    py: cython.double = by - ay
    pz: cython.double = bz - az
    qx: cython.double = cx - ax
    qy: cython.double = cy - ay
    qz: cython.double = cz - az
    nx, ny, nz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    area: cython.double = sqrt(nx * nx + ny * ny + nz * nz)  # double area
    u: cython.double = 0.0
    v: cython.double = 0.0
    if 0 < area < INFINITY:
        nx, ny, nz = nx / area, ny / area, nz / area
        height = ax * nx + ay * ny + az * nz
        if height * height >= best:  # the whole plane is farther
            return best
        # barycentric coordinates of the foot, times the double area, by Cramer's rule in the plane
        u = (az * qy - ay * qz) * nx + (ax * qz - az * qx) * ny + (ay * qx - ax * qy) * nz
        v = (ay * pz - az * py) * nx + (az * px - ax * pz) * ny + (ax * py - ay * px) * nz
        if u >= 0 and v >= 0 and u + v <= area:
            offset[0], offset[1], offset[2] = height * nx, height * ny, height * nz
            return height * height
    if v <= 0:  # only an edge that faces the foot can be closest
        best = _nearest_on_segment(ax, ay, az, px, py, pz, best, offset)
    if u <= 0:
        best = _nearest_on_segment(ax, ay, az, qx, qy, qz, best, offset)
    if u + v >= area or area == INFINITY:
        best = _nearest_on_segment(bx, by, bz, cx - bx, cy - by, cz - bz, best, offset)
    return best


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
@cython.locals(
    node=cython.Py_ssize_t, row=cython.Py_ssize_t, left=cython.double, right=cython.double, squared=cython.double
)
def _nearest(
    corners: cython.const[cython.double][:, ::1],
    boxes: cython.const[cython.double][:, ::1],
    x: cython.double,
    y: cython.double,
    z: cython.double,
    stack: cython.longlong[::1],
    lower_bounds: cython.double[::1],
    best: cython.double,
    offset: cython.double[::1],
    nearest_row: cython.longlong[::1],
) -> cython.double:
    """Squared distance from a point to all faces, or ``best`` if smaller, else vector and row of the face are set."""
    p: cython.Py_ssize_t = boxes.shape[0] // 2
    top: cython.Py_ssize_t = 1
    stack[0], lower_bounds[0] = 1, 0.0
    while top > 0:
        top -= 1
        node, left = stack[top], lower_bounds[top]
        while node < p and left < best:
            node *= 2
            left, right = box_distance(boxes, node, x, y, z), box_distance(boxes, node + 1, x, y, z)
            stack[top], lower_bounds[top] = node + 1, right
            if right < left:
                stack[top], lower_bounds[top] = node, left
                node, left = node + 1, right
            if lower_bounds[top] < best:
                top += 1
        if not left < best:
            continue
        for row in range((node - p) * LEAF, min((node - p + 1) * LEAF, corners.shape[0])):
            squared = _nearest_on_face(corners, row, x, y, z, best, offset)
            if squared < best:
                best, nearest_row[0] = squared, row
    return best


@cython.locals(
    i=cython.Py_ssize_t,
    x=cython.double,
    y=cython.double,
    z=cython.double,
    px=cython.double,
    py=cython.double,
    pz=cython.double,
    bound=cython.double,
)
def nearest_points(
    corners: cython.const[cython.double][:, ::1],
    boxes: cython.const[cython.double][:, ::1],
    points: cython.const[cython.double][:, ::1],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """(k,) distance from each point to the faces, (k, 3) the closest point on them, and (k,) the row of its face."""
    k: cython.Py_ssize_t = points.shape[0]
    distances_array, nearest_array, rows_array = np.empty(k), np.empty((k, 3)), np.zeros(k, dtype=np.int64)
    rows: cython.longlong[::1] = rows_array
    distances: cython.double[::1] = distances_array
    nearest: cython.double[:, ::1] = nearest_array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    lower_bounds: cython.double[::1] = np.empty(DEPTH)
    offset: cython.double[::1] = np.zeros(3)
    nearest_row: cython.longlong[::1] = np.zeros(1, dtype=np.int64)
    with cython.nogil:
        for i in range(k):
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            bound = INFINITY
            if i > 0:  # bounded by the closest point of the previous query, which is often near
                px, py, pz = nearest[i - 1, 0] - x, nearest[i - 1, 1] - y, nearest[i - 1, 2] - z
                bound = (px * px + py * py + pz * pz) * (1 + BOUND_MARGIN)
                bound = bound if bound < INFINITY else INFINITY
            distances[i] = _nearest(corners, boxes, x, y, z, stack, lower_bounds, bound, offset, nearest_row)
            if not distances[i] < bound:  # not below the bound: on the surface up to rounding, or not finite
                distances[i] = _nearest(corners, boxes, x, y, z, stack, lower_bounds, INFINITY, offset, nearest_row)
            nearest[i, 0], nearest[i, 1], nearest[i, 2] = x + offset[0], y + offset[1], z + offset[2]
            rows[i] = nearest_row[0]
    return np.sqrt(distances_array), nearest_array, rows_array
