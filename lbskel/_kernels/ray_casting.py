# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""What rays meet first, and how often in all, by the tree of boxes of :mod:`lbskel._kernels.bvh`."""

from __future__ import annotations

__all__ = ["first_hits", "windings"]

import cython
import numpy as np
from cython.cimports.libc.math import fabs
from numpy.typing import NDArray

LEAF = cython.declare(cython.Py_ssize_t, 4)  # faces
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # levels of any tree
STEEP = cython.declare(cython.double, 1e150)  # what one over a direction is at most
NEVER = cython.declare(cython.double, float("inf"))
EDGE = cython.declare(cython.double, 1e-12)  # share of an edge that triangles are larger, so that no ray passes between


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
@cython.locals(first=cython.double, last=cython.double, axis=cython.Py_ssize_t)
def _enters(
    boxes: cython.const[cython.double][:, ::1],
    node: cython.Py_ssize_t,
    origins: cython.const[cython.double][:, ::1],
    i: cython.Py_ssize_t,
    slowness: cython.double[::1],
    best: cython.double,
) -> cython.double:
    """How far along a ray a box begins; infinite where it is missed, or begins beyond the best."""
    start: cython.double = 0.0
    end: cython.double = best
    for axis in range(3):
        first = (boxes[node, axis] - origins[i, axis]) * slowness[axis]
        last = (boxes[node, axis + 3] - origins[i, axis]) * slowness[axis]
        if first > last:
            first, last = last, first
        start, end = max(start, first), min(end, last)
    return start if start <= end else NEVER


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _met(
    corners: cython.const[cython.double][:, ::1],
    at: cython.Py_ssize_t,
    origins: cython.const[cython.double][:, ::1],
    ways: cython.const[cython.double][:, ::1],
    i: cython.Py_ssize_t,
) -> cython.double:
    """How far along a ray a triangle is met; infinite where it is missed. After Moeller, Trumbore 1997."""
    px: cython.double = corners[at, 3] - corners[at, 0]
    py: cython.double = corners[at, 4] - corners[at, 1]
    pz: cython.double = corners[at, 5] - corners[at, 2]
    qx: cython.double = corners[at, 6] - corners[at, 0]
    qy: cython.double = corners[at, 7] - corners[at, 1]
    qz: cython.double = corners[at, 8] - corners[at, 2]
    sx: cython.double = ways[i, 1] * qz - ways[i, 2] * qy
    sy: cython.double = ways[i, 2] * qx - ways[i, 0] * qz
    sz: cython.double = ways[i, 0] * qy - ways[i, 1] * qx
    volume: cython.double = px * sx + py * sy + pz * sz
    if volume == 0:
        return NEVER
    ox: cython.double = origins[i, 0] - corners[at, 0]
    oy: cython.double = origins[i, 1] - corners[at, 1]
    oz: cython.double = origins[i, 2] - corners[at, 2]
    u: cython.double = (ox * sx + oy * sy + oz * sz) / volume
    if u < -EDGE or u > 1 + EDGE:
        return NEVER
    sx, sy, sz = oy * pz - oz * py, oz * px - ox * pz, ox * py - oy * px
    v: cython.double = (ways[i, 0] * sx + ways[i, 1] * sy + ways[i, 2] * sz) / volume
    if v < -EDGE or u + v > 1 + EDGE:
        return NEVER
    far: cython.double = (qx * sx + qy * sy + qz * sz) / volume
    return far if far >= 0 else NEVER


@cython.locals(
    i=cython.Py_ssize_t,
    axis=cython.Py_ssize_t,
    node=cython.Py_ssize_t,
    at=cython.Py_ssize_t,
    top=cython.Py_ssize_t,
    left=cython.double,
    right=cython.double,
    best=cython.double,
)
def first_hits(
    corners: cython.const[cython.double][:, ::1],
    order: cython.const[cython.longlong][::1],
    boxes: cython.const[cython.double][:, ::1],
    origins: cython.const[cython.double][:, ::1],
    ways: cython.const[cython.double][:, ::1],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(k,) the face that each ray meets first, -1 where there is none, and how far on, in lengths of its direction."""
    k: cython.Py_ssize_t = origins.shape[0]
    p: cython.Py_ssize_t = boxes.shape[0] // 2
    if ways.shape[0] != k:
        raise ValueError("there must be a direction for each origin")
    faces_array, far_array = np.full(k, -1, dtype=np.int64), np.empty(k)
    faces: cython.longlong[::1] = faces_array
    far: cython.double[::1] = far_array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    entries: cython.double[::1] = np.empty(DEPTH)
    slowness: cython.double[::1] = np.empty(3)
    for i in range(k):
        for axis in range(3):
            slowness[axis] = 1 / ways[i, axis] if fabs(ways[i, axis]) * STEEP > 1 else STEEP
        best = NEVER
        stack[0], entries[0], top = 1, 0.0, 1
        while top > 0:
            top -= 1
            node, left = stack[top], entries[top]
            while node < p and left < best:
                node *= 2
                left = _enters(boxes, node, origins, i, slowness, best)
                right = _enters(boxes, node + 1, origins, i, slowness, best)
                stack[top], entries[top] = node + 1, right
                if right < left:
                    stack[top], entries[top] = node, left
                    node, left = node + 1, right
                if entries[top] < best:
                    top += 1
            if not left < best:
                continue
            for at in range((node - p) * LEAF, min((node - p + 1) * LEAF, order.shape[0])):
                left = _met(corners, at, origins, ways, i)
                if left < best:
                    best, faces[i] = left, order[at]
        far[i] = best
    return faces_array, far_array


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
@cython.locals(low=cython.Py_ssize_t, high=cython.Py_ssize_t)
def _turns_above(
    corners: cython.const[cython.double][:, ::1],
    at: cython.Py_ssize_t,
    x: cython.double,
    y: cython.double,
    z: cython.double,
) -> cython.int:
    """1 or -1, by its orientation, where a triangle lies above a place, else 0.

    The plane through the place with this y cuts two sides, in points that are the same to the last digit for the other
    triangles there, so that the segments between such points close. Rounding counts only for a place on a segment.
    """
    first: cython.bint = corners[at, 1] > y
    second: cython.bint = corners[at, 4] > y
    third: cython.bint = corners[at, 7] > y
    if first == second and second == third:
        return 0
    if min(corners[at, 0], min(corners[at, 3], corners[at, 6])) > x:
        return 0
    if max(corners[at, 0], max(corners[at, 3], corners[at, 6])) <= x:
        return 0
    if max(corners[at, 2], max(corners[at, 5], corners[at, 8])) <= z:
        return 0
    lone: cython.Py_ssize_t = 0 if second == third else 3 if third == first else 6  # that corner alone is on its side
    rises: cython.bint = not (first if lone == 0 else second if lone == 3 else third)  # the side that begins there
    following: cython.Py_ssize_t = (lone + 3) % 9
    before: cython.Py_ssize_t = (lone + 6) % 9
    low, high = (lone, following) if rises else (before, lone)
    share: cython.double = (y - corners[at, low + 1]) / (corners[at, high + 1] - corners[at, low + 1])
    rising_x: cython.double = _between(corners[at, low], corners[at, high], share)
    rising_z: cython.double = _between(corners[at, low + 2], corners[at, high + 2], share)
    low, high = (lone, before) if rises else (following, lone)
    share = (y - corners[at, low + 1]) / (corners[at, high + 1] - corners[at, low + 1])
    falling_x: cython.double = _between(corners[at, low], corners[at, high], share)
    if (rising_x > x) == (falling_x > x):
        return 0
    falling_z: cython.double = _between(corners[at, low + 2], corners[at, high + 2], share)
    if _between(falling_z, rising_z, (x - falling_x) / (rising_x - falling_x)) <= z:
        return 0
    return 1 if rising_x > x else -1


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _between(start: cython.double, end: cython.double, share: cython.double) -> cython.double:
    """A number between two, which it never is beyond."""
    return max(min(start, end), min(max(start, end), start + share * (end - start)))


@cython.locals(i=cython.Py_ssize_t, node=cython.Py_ssize_t, at=cython.Py_ssize_t, top=cython.Py_ssize_t)
@cython.locals(x=cython.double, y=cython.double, z=cython.double)
def windings(
    corners: cython.const[cython.double][:, ::1],
    boxes: cython.const[cython.double][:, ::1],
    points: cython.const[cython.double][:, ::1],
) -> NDArray[np.int64]:
    """(k,) how often faces without a boundary wind round each point: those above it, counted by their orientation."""
    p: cython.Py_ssize_t = boxes.shape[0] // 2
    array = np.zeros(points.shape[0], dtype=np.int64)
    result: cython.longlong[::1] = array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        stack[0], top = 1, 1
        while top > 0:
            top -= 1
            node = stack[top]
            if not (boxes[node, 0] <= x <= boxes[node, 3] and boxes[node, 1] <= y <= boxes[node, 4]):
                continue
            if boxes[node, 5] < z:
                continue
            if node < p:
                stack[top], stack[top + 1] = 2 * node, 2 * node + 1
                top += 2
                continue
            for at in range((node - p) * LEAF, min((node - p + 1) * LEAF, corners.shape[0])):
                result[i] += _turns_above(corners, at, x, y, z)
    return array
