"""Bounding volume hierarchy of axis-aligned boxes over faces.

The tree is a complete binary tree without pointers: node i has the children 2 i and 2 i + 1, node 1 is the root, and
the last half of the nodes are leaves. Leaf k holds the LEAF faces from ``order[LEAF * k]`` on.
"""

from __future__ import annotations

__all__ = ["bounding_boxes", "spatial_order"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython

LEAF = cython.declare(cython.Py_ssize_t, 4)  # faces in a leaf; a guess, the same in the kernels that search the tree
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # length of a traversal stack: no tree of 2^63 faces is deeper
EMPTY = cython.declare(cython.double, 1e150)  # coordinate of boxes without faces: its square is large, but finite
INFINITY = cython.declare(cython.double, float("inf"))


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
