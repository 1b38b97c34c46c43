"""Closest points on faces, by the boxes of :mod:`lbskel._kernels.bvh`."""

from __future__ import annotations

__all__ = ["nearest_points"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython
if cython.compiled:
    from cython.cimports.libc.math import fabs, sqrt
else:
    from math import fabs, sqrt

LEAF = cython.declare(cython.Py_ssize_t, 4)  # faces in a leaf, as in bvh
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # length of a traversal stack, as in bvh
INFINITY = cython.declare(cython.double, float("inf"))
BOUND_MARGIN = cython.declare(cython.double, 1e-9)  # relative; above the rounding error of a squared distance (a guess)


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _doubled_gap(x: cython.double, low: cython.double, high: cython.double) -> cython.double:
    """Twice the distance from a number to an interval, exactly; absolute values in place of branches, for speed."""
    below: cython.double = low - x
    above: cython.double = x - high
    return (below + fabs(below)) + (above + fabs(above))


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
    dx: cython.double = _doubled_gap(x, boxes[node, 0], boxes[node, 3])
    dy: cython.double = _doubled_gap(y, boxes[node, 1], boxes[node, 4])
    dz: cython.double = _doubled_gap(z, boxes[node, 2], boxes[node, 5])
    return 0.25 * (dx * dx + dy * dy + dz * dz)


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
    px: cython.double = bx - ax
    py: cython.double = by - ay
    pz: cython.double = bz - az
    qx: cython.double = cx - ax
    qy: cython.double = cy - ay
    qz: cython.double = cz - az
    nx: cython.double = py * qz - pz * qy
    ny: cython.double = pz * qx - px * qz
    nz: cython.double = px * qy - py * qx
    squared: cython.double = nx * nx + ny * ny + nz * nz
    height: cython.double = ax * nx + ay * ny + az * nz
    if squared > 0 and height * (height / squared) > (1 + BOUND_MARGIN) * best:  # the plane is farther, without a root
        return best
    area: cython.double = sqrt(squared)  # double area
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
            left, right = _box_distance(boxes, node, x, y, z), _box_distance(boxes, node + 1, x, y, z)
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
