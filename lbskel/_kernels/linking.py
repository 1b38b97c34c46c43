"""Sums along trees and around vertices, and crossings of projected segments: what linking numbers are made of.

Sums are of unsigned integers modulo 2^64.
"""

from __future__ import annotations

__all__ = ["crossings_above", "sums_around_vertices", "sums_from_root", "sums_to_root"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython

LEAF = cython.declare(cython.Py_ssize_t, 4)  # faces in a leaf, as in bvh
DEPTH = cython.declare(cython.Py_ssize_t, 64)  # length of a traversal stack, as in bvh


@np.errstate(over="ignore")  # where this is not compiled
@cython.locals(row=cython.Py_ssize_t, node=cython.longlong)
def sums_to_root(
    order: cython.const[cython.longlong][::1],
    parent: cython.const[cython.longlong][::1],
    values: cython.const[cython.ulonglong][::1],
) -> NDArray[np.uint64]:
    """(n,) sum of the values over each node and all nodes below it.

    Parameters
    ----------
    order : (n,) array of int
        The nodes, every parent before its children; the first is the root.
    parent : (n,) array of int
    values : (n,) array of uint64
    """
    array = np.array(values)
    result: cython.ulonglong[::1] = array
    with cython.nogil:
        for row in range(order.shape[0] - 1, 0, -1):
            node = order[row]
            result[parent[node]] += result[node]
    return array


@np.errstate(over="ignore")  # where this is not compiled
@cython.locals(row=cython.Py_ssize_t, node=cython.longlong)
def sums_from_root(
    order: cython.const[cython.longlong][::1],
    parent: cython.const[cython.longlong][::1],
    values: cython.const[cython.ulonglong][::1],
) -> NDArray[np.uint64]:
    """(n,) sum of the values over each node and all nodes above it; parameters as for :func:`sums_to_root`."""
    array = np.array(values)
    result: cython.ulonglong[::1] = array
    with cython.nogil:
        for row in range(1, order.shape[0]):
            node = order[row]
            result[node] += result[parent[node]]
    return array


@np.errstate(over="ignore")  # where this is not compiled
@cython.locals(side=cython.Py_ssize_t, at=cython.Py_ssize_t, before=cython.Py_ssize_t)
def sums_around_vertices(
    twins: cython.const[cython.longlong][::1], values: cython.const[cython.ulonglong][::1]
) -> NDArray[np.uint64]:
    """(3 m,) sums of the values of the half-edges that leave a vertex, in their order around it.

    The first half-edge of each vertex has the sum zero, and each has its own value more than the one before it.

    Parameters
    ----------
    twins : (3 m,) array of int
        The opposite half-edge of each. Half-edge k lies opposite corner k // m of face k % m, as in
        ``Mesh.half_edges``.
    values : (3 m,) array of uint64
    """
    m: cython.Py_ssize_t = twins.shape[0] // 3
    array = np.zeros(3 * m, dtype=np.uint64)
    result: cython.ulonglong[::1] = array
    is_seen: cython.schar[::1] = np.zeros(3 * m, dtype=np.int8)
    with cython.nogil:
        for side in range(3 * m):
            at = side
            while not is_seen[at]:
                is_seen[at] = 1
                before = at
                at = (twins[before] + m) % (3 * m)  # turns clockwise: the half-edge that follows the twin
                if not is_seen[at]:
                    result[at] = result[before] + values[at]
    return array


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _turn(
    ax: cython.double, ay: cython.double, bx: cython.double, by: cython.double, cx: cython.double, cy: cython.double
) -> cython.double:
    """Twice the signed area of a triangle in the plane."""
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(a=cython.double, b=cython.double, c=cython.double, d=cython.double, height=cython.double)
@cython.locals(x=cython.double, y=cython.double, z=cython.double, u=cython.double, v=cython.double, w=cython.double)
def _passes_above(
    segments: cython.const[cython.double][:, ::1],
    slot: cython.Py_ssize_t,
    x: cython.double,
    y: cython.double,
    z: cython.double,
    u: cython.double,
    v: cython.double,
    w: cython.double,
) -> cython.int:
    """1 if a segment passes above the one from (x, y, z) to (u, v, w) from right to left, -1 from left to right, or 0.

    The sign of an area depends on its three points alone, so that chains of segments cross without gaps.
    """
    a = _turn(x, y, u, v, segments[slot, 0], segments[slot, 1])
    b = _turn(x, y, u, v, segments[slot, 3], segments[slot, 4])
    if (a >= 0) == (b >= 0):
        return 0
    c = _turn(segments[slot, 0], segments[slot, 1], segments[slot, 3], segments[slot, 4], x, y)
    d = _turn(segments[slot, 0], segments[slot, 1], segments[slot, 3], segments[slot, 4], u, v)
    if (c >= 0) == (d >= 0):
        return 0
    height = segments[slot, 2] + (segments[slot, 5] - segments[slot, 2]) * (a / (a - b)) - z - (w - z) * (c / (c - d))
    if height < 0:
        return 0
    return 1 if b >= 0 else -1


@cython.locals(
    row=cython.Py_ssize_t,
    slot=cython.Py_ssize_t,
    node=cython.Py_ssize_t,
    top=cython.Py_ssize_t,
    sign=cython.int,
    low_x=cython.double,
    low_y=cython.double,
    low_z=cython.double,
    high_x=cython.double,
    high_y=cython.double,
)
@cython.locals(x=cython.double, y=cython.double, z=cython.double, u=cython.double, v=cython.double, w=cython.double)
def crossings_above(
    queries: cython.const[cython.double][:, ::1],
    skipped: cython.const[cython.longlong][:, ::1],
    segments: cython.const[cython.double][:, ::1],
    groups: cython.const[cython.longlong][::1],
    boxes: cython.const[cython.double][:, ::1],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Find where segments pass above others in the projection along the third axis.

    Parameters
    ----------
    queries : (q, 6) array of float
        Both ends of each segment below.
    skipped : (q, 2) array of int
        The groups of segments with which each query is not compared.
    segments : (s, 6) array of float
        Both ends of each segment above, in the order of the leaves of the tree.
    groups : (s,) array of int
        The group of each.
    boxes : (2 p, 6) array of float
        Of :func:`lbskel._kernels.bvh.bounding_boxes`.

    Returns
    -------
    queries, segments : (c,) arrays of int
        Row of each of the two segments of a crossing.
    signs : (c,) array of int
        1 if the upper one crosses the lower one from its right to its left, else -1.
    """
    p: cython.Py_ssize_t = boxes.shape[0] // 2
    count: cython.Py_ssize_t = 0
    room: cython.Py_ssize_t = 4 * queries.shape[0] + 16
    found_array = np.empty((room, 3), dtype=np.int64)
    found: cython.longlong[:, ::1] = found_array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    with cython.nogil:
        for row in range(queries.shape[0]):
            x, y, z = queries[row, 0], queries[row, 1], queries[row, 2]
            u, v, w = queries[row, 3], queries[row, 4], queries[row, 5]
            low_x, high_x, low_y, high_y, low_z = min(x, u), max(x, u), min(y, v), max(y, v), min(z, w)
            top = 1
            stack[0] = 1
            while top > 0:
                top -= 1
                node = stack[top]
                if boxes[node, 0] > high_x or boxes[node, 3] < low_x or boxes[node, 1] > high_y:
                    continue
                if boxes[node, 4] < low_y or boxes[node, 5] < low_z:
                    continue
                if node < p:
                    stack[top], stack[top + 1] = 2 * node + 1, 2 * node
                    top += 2
                    continue
                for slot in range((node - p) * LEAF, min((node - p + 1) * LEAF, segments.shape[0])):
                    if groups[slot] == skipped[row, 0] or groups[slot] == skipped[row, 1]:
                        continue
                    sign = _passes_above(segments, slot, x, y, z, u, v, w)
                    if sign == 0:
                        continue
                    if count == room:
                        room *= 2
                        with cython.gil:
                            found_array = np.concatenate([found_array, np.empty_like(found_array)])
                            found = found_array
                    found[count, 0], found[count, 1], found[count, 2] = row, slot, sign
                    count += 1
    queries_found, segments_found, signs = found_array[:count].T.copy()
    return queries_found, segments_found, signs
