"""First hits of rays and winding numbers of points, by the boxes of :mod:`lbskel._kernels.bvh`."""

from __future__ import annotations

__all__ = ["first_hits", "winding_numbers"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython
if cython.compiled:
    from cython.cimports.libc.math import fabs
else:
    from math import fabs

LEAF = cython.declare(cython.Py_ssize_t, 4)  # faces in a leaf, as in bvh
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # length of a traversal stack, as in bvh
MAX_SLOWNESS = cython.declare(cython.double, 1e150)  # bound on 1 / direction: its products stay finite
INFINITY = cython.declare(cython.double, float("inf"))
EDGE_TOLERANCE = cython.declare(cython.double, 1e-12)  # barycentric: no ray passes between two triangles (a guess)


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _box_entry(
    boxes: cython.const[cython.double][:, ::1],
    node: cython.Py_ssize_t,
    ox: cython.double,
    oy: cython.double,
    oz: cython.double,
    slowness: cython.double[::1],
    best: cython.double,
) -> cython.double:
    """Ray parameter at which a ray enters a box; infinite if it misses the box, or enters it beyond ``best``."""
    x0: cython.double = (boxes[node, 0] - ox) * slowness[0]
    x1: cython.double = (boxes[node, 3] - ox) * slowness[0]
    y0: cython.double = (boxes[node, 1] - oy) * slowness[1]
    y1: cython.double = (boxes[node, 4] - oy) * slowness[1]
    z0: cython.double = (boxes[node, 2] - oz) * slowness[2]
    z1: cython.double = (boxes[node, 5] - oz) * slowness[2]
    start: cython.double = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), 0.0))
    end: cython.double = min(min(max(x0, x1), max(y0, y1)), min(max(z0, z1), best))
    return start if start <= end else INFINITY


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _triangle_hit(
    corners: cython.const[cython.double][:, ::1],
    row: cython.Py_ssize_t,
    origins: cython.const[cython.double][:, ::1],
    directions: cython.const[cython.double][:, ::1],
    i: cython.Py_ssize_t,
) -> cython.double:
    """Ray parameter at which a ray hits a triangle; infinite if it misses. Möller, Trumbore 1997."""
    px: cython.double = corners[row, 3] - corners[row, 0]
    py: cython.double = corners[row, 4] - corners[row, 1]
    pz: cython.double = corners[row, 5] - corners[row, 2]
    qx: cython.double = corners[row, 6] - corners[row, 0]
    qy: cython.double = corners[row, 7] - corners[row, 1]
    qz: cython.double = corners[row, 8] - corners[row, 2]
    sx: cython.double = directions[i, 1] * qz - directions[i, 2] * qy
    sy: cython.double = directions[i, 2] * qx - directions[i, 0] * qz
    sz: cython.double = directions[i, 0] * qy - directions[i, 1] * qx
    volume: cython.double = px * sx + py * sy + pz * sz
    ox: cython.double = origins[i, 0] - corners[row, 0]
    oy: cython.double = origins[i, 1] - corners[row, 1]
    oz: cython.double = origins[i, 2] - corners[row, 2]
    u: cython.double = ox * sx + oy * sy + oz * sz
    sx, sy, sz = oy * pz - oz * py, oz * px - ox * pz, ox * py - oy * px
    v: cython.double = directions[i, 0] * sx + directions[i, 1] * sy + directions[i, 2] * sz
    # barycentric coordinates times the volume are compared, without a branch for each: most triangles are missed
    size: cython.double = fabs(volume)
    u, v = (u, v) if volume > 0 else (-u, -v)
    least: cython.double = -EDGE_TOLERANCE * size
    if (u < least) | (v < least) | (u + v > size - least) | (size == 0):
        return INFINITY
    hit: cython.double = (qx * sx + qy * sy + qz * sz) / volume
    return hit if hit >= 0 else INFINITY


@cython.locals(
    i=cython.Py_ssize_t,
    axis=cython.Py_ssize_t,
    node=cython.Py_ssize_t,
    row=cython.Py_ssize_t,
    top=cython.Py_ssize_t,
    left=cython.double,
    right=cython.double,
    best=cython.double,
    ox=cython.double,
    oy=cython.double,
    oz=cython.double,
)
def first_hits(
    corners: cython.const[cython.double][:, ::1],
    order: cython.const[cython.longlong][::1],
    boxes: cython.const[cython.double][:, ::1],
    origins: cython.const[cython.double][:, ::1],
    directions: cython.const[cython.double][:, ::1],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(k,) first face hit by each ray, or -1, and (k,) its distance in lengths of the direction, or infinity."""
    k: cython.Py_ssize_t = origins.shape[0]
    p: cython.Py_ssize_t = boxes.shape[0] // 2
    if directions.shape[0] != k:
        raise ValueError("there must be a direction for each origin")
    faces_array, distances_array = np.full(k, -1, dtype=np.int64), np.empty(k)
    faces: cython.longlong[::1] = faces_array
    distance: cython.double[::1] = distances_array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    entries: cython.double[::1] = np.empty(DEPTH)
    slowness: cython.double[::1] = np.empty(3)
    with cython.nogil:
        for i in range(k):
            for axis in range(3):
                slowness[axis] = (
                    1 / directions[i, axis] if fabs(directions[i, axis]) * MAX_SLOWNESS > 1 else MAX_SLOWNESS
                )
            ox, oy, oz = origins[i, 0], origins[i, 1], origins[i, 2]
            best = INFINITY
            stack[0], entries[0], top = 1, 0.0, 1
            while top > 0:
                top -= 1
                node, left = stack[top], entries[top]
                while node < p and left < best:
                    node *= 2
                    left = _box_entry(boxes, node, ox, oy, oz, slowness, best)
                    right = _box_entry(boxes, node + 1, ox, oy, oz, slowness, best)
                    stack[top], entries[top] = node + 1, right
                    if right < left:
                        stack[top], entries[top] = node, left
                        node, left = node + 1, right
                    if entries[top] < best:
                        top += 1
                if not left < best:
                    continue
                for row in range((node - p) * LEAF, min((node - p + 1) * LEAF, order.shape[0])):
                    left = _triangle_hit(corners, row, origins, directions, i)
                    if left < best:
                        best, faces[i] = left, order[row]
            distance[i] = best
    return faces_array, distances_array


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
@cython.locals(low=cython.Py_ssize_t, high=cython.Py_ssize_t, a=cython.Py_ssize_t, b=cython.Py_ssize_t)
def _crossing_above(
    corners: cython.const[cython.double][:, ::1],
    row: cython.Py_ssize_t,
    c: cython.Py_ssize_t,
    x: cython.double,
    y: cython.double,
    z: cython.double,
) -> cython.int:
    """Signed crossing of a triangle by the ray from a point along axis c: 1 or -1 by its orientation, or 0.

    x and y are the coordinates of the point along the two axes that follow c. The plane through the point at this y
    cuts two sides of the triangle. Adjacent triangles compute exactly the same point on a common side, so the segments
    between such points form closed curves, and rounding errors matter only for a point on a segment.
    """
    a, b = (c + 1) % 3, (c + 2) % 3
    first: cython.bint = corners[row, b] > y
    second: cython.bint = corners[row, 3 + b] > y
    third: cython.bint = corners[row, 6 + b] > y
    if first == second and second == third:
        return 0
    if min(corners[row, a], min(corners[row, 3 + a], corners[row, 6 + a])) > x:
        return 0
    if max(corners[row, a], max(corners[row, 3 + a], corners[row, 6 + a])) <= x:
        return 0
    if max(corners[row, c], max(corners[row, 3 + c], corners[row, 6 + c])) <= z:
        return 0
    single: cython.Py_ssize_t = 0 if second == third else 3 if third == first else 6  # alone on its side
    # whether the side that leaves that corner goes to larger y
    rises: cython.bint = not (first if single == 0 else second if single == 3 else third)
    following: cython.Py_ssize_t = (single + 3) % 9
    before: cython.Py_ssize_t = (single + 6) % 9
    low, high = (single, following) if rises else (before, single)
    t: cython.double = (y - corners[row, low + b]) / (corners[row, high + b] - corners[row, low + b])
    rising_x: cython.double = _interpolate(corners[row, low + a], corners[row, high + a], t)
    rising_z: cython.double = _interpolate(corners[row, low + c], corners[row, high + c], t)
    low, high = (single, before) if rises else (following, single)
    t = (y - corners[row, low + b]) / (corners[row, high + b] - corners[row, low + b])
    falling_x: cython.double = _interpolate(corners[row, low + a], corners[row, high + a], t)
    if (rising_x > x) == (falling_x > x):
        return 0
    falling_z: cython.double = _interpolate(corners[row, low + c], corners[row, high + c], t)
    if _interpolate(falling_z, rising_z, (x - falling_x) / (rising_x - falling_x)) <= z:
        return 0
    return 1 if rising_x > x else -1


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _interpolate(start: cython.double, end: cython.double, t: cython.double) -> cython.double:
    """Linear interpolation, clamped to the interval in spite of rounding."""
    return max(min(start, end), min(max(start, end), start + t * (end - start)))


@cython.locals(i=cython.Py_ssize_t, node=cython.Py_ssize_t, row=cython.Py_ssize_t, top=cython.Py_ssize_t)
@cython.locals(x=cython.double, y=cython.double, z=cython.double)
@cython.locals(a=cython.Py_ssize_t, b=cython.Py_ssize_t, c=cython.Py_ssize_t, axis=cython.Py_ssize_t)
def winding_numbers(
    corners: cython.const[cython.double][:, ::1],
    boxes: cython.const[cython.double][:, ::1],
    points: cython.const[cython.double][:, ::1],
) -> NDArray[np.int64]:
    """(k,) winding number of a closed surface around each point: the signed crossings of a ray along an axis.

    It is the axis along which the end of the bounding box is nearest: along a coil, a ray would cross every turn.
    """
    p: cython.Py_ssize_t = boxes.shape[0] // 2
    array = np.zeros(points.shape[0], dtype=np.int64)
    result: cython.longlong[::1] = array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    with cython.nogil:
        for i in range(points.shape[0]):
            c = 0
            for axis in range(1, 3):
                if boxes[1, 3 + axis] - points[i, axis] < boxes[1, 3 + c] - points[i, c]:
                    c = axis
            a, b = (c + 1) % 3, (c + 2) % 3
            x, y, z = points[i, a], points[i, b], points[i, c]
            stack[0], top = 1, 1
            while top > 0:
                top -= 1
                node = stack[top]
                if not (boxes[node, a] <= x <= boxes[node, 3 + a] and boxes[node, b] <= y <= boxes[node, 3 + b]):
                    continue
                if boxes[node, 3 + c] < z:
                    continue
                if node < p:
                    stack[top], stack[top + 1] = 2 * node, 2 * node + 1
                    top += 2
                    continue
                for row in range((node - p) * LEAF, min((node - p + 1) * LEAF, corners.shape[0])):
                    result[i] += _crossing_above(corners, row, c, x, y, z)
    return array
