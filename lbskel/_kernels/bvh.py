# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""A tree of boxes over runs of faces, and what is nearest to a point.

The tree is complete and has no pointers: node i has the children 2 i and 2 i + 1, and the last half are leaves, each
with LEAF faces of an order that is given.
"""

from __future__ import annotations

__all__ = ["halved", "nearest_places", "tree_of"]

import cython
import numpy as np
from cython.cimports.libc.math import sqrt
from numpy.typing import NDArray

LEAF = cython.declare(cython.Py_ssize_t, 4)  # faces
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # levels of any tree
NOWHERE = cython.declare(cython.double, 1e150)  # the place of boxes without a face: farther than anything
NEVER = cython.declare(cython.double, float("inf"))
WIDER = cython.declare(cython.double, 1e-9)  # share by which a bound must be more than the least, for rounding


@cython.locals(begin=cython.Py_ssize_t, end=cython.Py_ssize_t, half=cython.Py_ssize_t, at=cython.Py_ssize_t)
@cython.locals(widest=cython.Py_ssize_t)
def halved(V: cython.const[cython.double][:, ::1], F: cython.const[cython.longlong][:, ::1]) -> NDArray[np.int64]:
    """(m,) an order in which every node of a tree has faces that lie together.

    The faces of a node are parted by their centers across its longest side, so that the first of its children is full.
    """
    m: cython.Py_ssize_t = F.shape[0]
    centers: cython.double[:, ::1] = np.empty((m, 3))
    top: cython.Py_ssize_t = 1
    size: cython.Py_ssize_t = LEAF
    array = np.arange(m)
    order: cython.longlong[::1] = array
    stack: cython.longlong[:, ::1] = np.empty((DEPTH, 3), dtype=np.int64)
    for at in range(m):
        for half in range(3):
            centers[at, half] = V[F[at, 0], half] + V[F[at, 1], half] + V[F[at, 2], half]
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
            _part(centers, order, begin, end, half, widest)
            stack[top, 0], stack[top, 1], stack[top, 2] = half, end, size
            top += 1
            end = half
    return array


@cython.cfunc
@cython.exceptval(check=False)
@cython.locals(at=cython.Py_ssize_t, x=cython.double, y=cython.double, z=cython.double)
def _longest_side(
    centers: cython.const[cython.double][:, ::1], begin: cython.Py_ssize_t, end: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """The axis along which some centers lie farthest apart."""
    x, y, z = centers[begin, 0], centers[begin, 1], centers[begin, 2]
    high_x: cython.double = x
    high_y: cython.double = y
    high_z: cython.double = z
    for at in range(begin + 1, end):
        x, high_x = min(x, centers[at, 0]), max(high_x, centers[at, 0])
        y, high_y = min(y, centers[at, 1]), max(high_y, centers[at, 1])
        z, high_z = min(z, centers[at, 2]), max(high_z, centers[at, 2])
    x, y, z = high_x - x, high_y - y, high_z - z
    return 0 if x >= max(y, z) else 1 if y >= z else 2


@cython.cfunc
@cython.exceptval(check=False)
@cython.locals(i=cython.Py_ssize_t, j=cython.Py_ssize_t, pivot=cython.double, at=cython.Py_ssize_t)
def _part(
    centers: cython.double[:, ::1],
    order: cython.longlong[::1],
    begin: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    half: cython.Py_ssize_t,
    axis: cython.Py_ssize_t,
) -> cython.void:
    """Put the least along an axis before the half: Hoare 1961, "Algorithm 65: find"."""
    first: cython.Py_ssize_t = begin
    last: cython.Py_ssize_t = end - 1
    while first < last:
        low: cython.double = centers[first, axis]
        middle: cython.double = centers[(first + last) // 2, axis]
        high: cython.double = centers[last, axis]
        pivot = max(min(low, middle), min(max(low, middle), high))
        i, j = first, last
        while i <= j:
            while centers[i, axis] < pivot:
                i += 1
            while pivot < centers[j, axis]:
                j -= 1
            if i <= j:
                for at in range(3):
                    centers[i, at], centers[j, at] = centers[j, at], centers[i, at]
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
    at=cython.Py_ssize_t,
    corner=cython.Py_ssize_t,
    axis=cython.Py_ssize_t,
    face=cython.Py_ssize_t,
    x=cython.double,
    low=cython.double,
    high=cython.double,
)
def tree_of(
    V: cython.const[cython.double][:, ::1],
    F: cython.const[cython.longlong][:, ::1],
    order: cython.const[cython.longlong][::1],
    slack: cython.double,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(m, 9) corners of the faces in their order, and (2 p, 6) the lowest and highest places of each node's box.

    AABBTree are widened by some slack; node 0 is none.
    """
    m: cython.Py_ssize_t = order.shape[0]
    p: cython.Py_ssize_t = 1
    while p * LEAF < m:
        p *= 2
    corners_array, boxes_array = np.empty((m, 9)), np.full((2 * p, 6), NOWHERE)
    corners: cython.double[:, ::1] = corners_array
    boxes: cython.double[:, ::1] = boxes_array
    for at in range(m):
        for corner in range(3):
            for axis in range(3):
                corners[at, 3 * corner + axis] = V[F[order[at], corner], axis]
    for at in range(0, m, LEAF):
        node = p + at // LEAF
        for axis in range(3):
            low, high = NEVER, -NEVER
            for face in range(at, min(at + LEAF, m)):
                for corner in range(3):
                    x = corners[face, 3 * corner + axis]
                    low, high = min(low, x), max(high, x)
            boxes[node, axis], boxes[node, axis + 3] = low - slack, high + slack
    for node in range(p - 1, 0, -1):
        for axis in range(6):
            boxes[node, axis] = boxes[2 * node, axis]
        if boxes[2 * node + 1, 0] < NOWHERE:
            for axis in range(3):
                boxes[node, axis] = min(boxes[node, axis], boxes[2 * node + 1, axis])
                boxes[node, axis + 3] = max(boxes[node, axis + 3], boxes[2 * node + 1, axis + 3])
    return corners_array, boxes_array


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def box_distance(
    boxes: cython.const[cython.double][:, ::1],
    node: cython.Py_ssize_t,
    x: cython.double,
    y: cython.double,
    z: cython.double,
) -> cython.double:
    """The square of the distance of a place from a box."""
    dx: cython.double = max(max(boxes[node, 0] - x, x - boxes[node, 3]), 0.0)
    dy: cython.double = max(max(boxes[node, 1] - y, y - boxes[node, 4]), 0.0)
    dz: cython.double = max(max(boxes[node, 2] - z, z - boxes[node, 5]), 0.0)
    return dx * dx + dy * dy + dz * dz


@cython.cfunc
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
    place: cython.double[::1],
) -> cython.double:
    """The square of the origin's distance from a segment; where it is less than the best, the place is written."""
    squared: cython.double = dx * dx + dy * dy + dz * dz
    share: cython.double = 0.0
    if squared > 0:
        share = min(max(-(x * dx + y * dy + z * dz) / squared, 0.0), 1.0)
    x, y, z = x + share * dx, y + share * dy, z + share * dz
    squared = x * x + y * y + z * z
    if squared < best:
        place[0], place[1], place[2] = x, y, z
        return squared
    return best


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
@cython.locals(height=cython.double)
def _nearest_on_face(
    corners: cython.const[cython.double][:, ::1],
    at: cython.Py_ssize_t,
    x: cython.double,
    y: cython.double,
    z: cython.double,
    best: cython.double,
    place: cython.double[::1],
) -> cython.double:
    """The square of a place's distance from a triangle; where it is less than the best, the way there is written.

    The foot of the perpendicular where it is inside, or else the nearest of the three edges.
    """
    ax: cython.double = corners[at, 0] - x
    ay: cython.double = corners[at, 1] - y
    az: cython.double = corners[at, 2] - z
    bx: cython.double = corners[at, 3] - x
    by: cython.double = corners[at, 4] - y
    bz: cython.double = corners[at, 5] - z
    cx: cython.double = corners[at, 6] - x
    cy: cython.double = corners[at, 7] - y
    cz: cython.double = corners[at, 8] - z
    nx: cython.double = max(min(ax, min(bx, cx)), -max(ax, max(bx, cx)))
    ny: cython.double = max(min(ay, min(by, cy)), -max(ay, max(by, cy)))
    nz: cython.double = max(min(az, min(bz, cz)), -max(az, max(bz, cz)))
    nx, ny, nz = max(nx, 0.0), max(ny, 0.0), max(nz, 0.0)
    if nx * nx + ny * ny + nz * nz >= best:  # its box is farther
        return best
    px: cython.double = bx - ax
    py: cython.double = by - ay
    pz: cython.double = bz - az
    qx: cython.double = cx - ax
    qy: cython.double = cy - ay
    qz: cython.double = cz - az
    nx, ny, nz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    area: cython.double = sqrt(nx * nx + ny * ny + nz * nz)  # twice
    u: cython.double = 0.0
    v: cython.double = 0.0
    if 0 < area < NEVER:
        nx, ny, nz = nx / area, ny / area, nz / area
        height = ax * nx + ay * ny + az * nz
        if height * height >= best:  # the whole plane is farther
            return best
        # the origin in the coordinates of the two edges, times twice the area, by Cramer's rule in the plane
        u = (az * qy - ay * qz) * nx + (ax * qz - az * qx) * ny + (ay * qx - ax * qy) * nz
        v = (ay * pz - az * py) * nx + (az * px - ax * pz) * ny + (ax * py - ay * px) * nz
        if u >= 0 and v >= 0 and u + v <= area:
            place[0], place[1], place[2] = height * nx, height * ny, height * nz
            return height * height
    if v <= 0:  # only what can be seen from the foot may be nearest
        best = _nearest_on_segment(ax, ay, az, px, py, pz, best, place)
    if u <= 0:
        best = _nearest_on_segment(ax, ay, az, qx, qy, qz, best, place)
    if u + v >= area or area == NEVER:
        best = _nearest_on_segment(bx, by, bz, cx - bx, cy - by, cz - bz, best, place)
    return best


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
@cython.locals(node=cython.Py_ssize_t, at=cython.Py_ssize_t, left=cython.double, right=cython.double)
def _nearest(
    corners: cython.const[cython.double][:, ::1],
    boxes: cython.const[cython.double][:, ::1],
    x: cython.double,
    y: cython.double,
    z: cython.double,
    stack: cython.longlong[::1],
    far: cython.double[::1],
    best: cython.double,
    place: cython.double[::1],
) -> cython.double:
    """The square of a place's distance from the faces; where it is less than the best, the way there is written."""
    p: cython.Py_ssize_t = boxes.shape[0] // 2
    top: cython.Py_ssize_t = 1
    stack[0], far[0] = 1, 0.0
    while top > 0:
        top -= 1
        node, left = stack[top], far[top]
        while node < p and left < best:
            node *= 2
            left, right = box_distance(boxes, node, x, y, z), box_distance(boxes, node + 1, x, y, z)
            stack[top], far[top] = node + 1, right
            if right < left:
                stack[top], far[top] = node, left
                node, left = node + 1, right
            if far[top] < best:
                top += 1
        if not left < best:
            continue
        for at in range((node - p) * LEAF, min((node - p + 1) * LEAF, corners.shape[0])):
            best = _nearest_on_face(corners, at, x, y, z, best, place)
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
def nearest_places(
    corners: cython.const[cython.double][:, ::1],
    boxes: cython.const[cython.double][:, ::1],
    points: cython.const[cython.double][:, ::1],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(k,) distance of each point from the faces, and (k, 3) the place on them that is nearest."""
    k: cython.Py_ssize_t = points.shape[0]
    distances_array, places_array = np.empty(k), np.empty((k, 3))
    distances: cython.double[::1] = distances_array
    places: cython.double[:, ::1] = places_array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    far: cython.double[::1] = np.empty(DEPTH)
    place: cython.double[::1] = np.zeros(3)
    for i in range(k):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        bound = NEVER
        if i > 0:  # the place nearest to the point before is no nearer than the nearest, and mostly not much farther
            px, py, pz = places[i - 1, 0] - x, places[i - 1, 1] - y, places[i - 1, 2] - z
            bound = (px * px + py * py + pz * pz) * (1 + WIDER)
            bound = bound if bound < NEVER else NEVER
        distances[i] = _nearest(corners, boxes, x, y, z, stack, far, bound, place)
        if not distances[i] < bound:  # on the surface to the last digit, or nowhere
            distances[i] = _nearest(corners, boxes, x, y, z, stack, far, NEVER, place)
        places[i, 0], places[i, 1], places[i, 2] = x + place[0], y + place[1], z + place[2]
    return np.sqrt(distances_array), places_array
