"""Half-edges in the order of their edges, and the gluing of two copies of a surface around each edge.

Half-edge 3 f + k lies opposite corner k of face f.
"""

from __future__ import annotations

__all__ = ["glue_copies", "half_edges_by_edge"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython


@cython.locals(face=cython.Py_ssize_t, k=cython.Py_ssize_t, place=cython.Py_ssize_t, half_edge=cython.longlong)
@cython.locals(low=cython.longlong, high=cython.longlong, last_low=cython.longlong, last_high=cython.longlong)
def half_edges_by_edge(
    F: cython.const[cython.longlong][:, ::1], n: cython.Py_ssize_t
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(3 m,) half-edges in the order of their lower, then higher vertices, and (e + 1,) where those of each edge begin.

    Half-edges of the same edge are in ascending order.

    Parameters
    ----------
    F : (m, 3) array of int
    n : int
        Number of vertices.
    """
    m: cython.Py_ssize_t = F.shape[0]
    n_edges: cython.Py_ssize_t = 0
    by_low: cython.longlong[::1] = np.zeros(n + 1, dtype=np.int64)
    by_high: cython.longlong[::1] = np.zeros(n + 1, dtype=np.int64)
    higher: cython.longlong[::1] = np.empty(3 * m, dtype=np.int64)
    order_array, begins_array = np.empty(3 * m, dtype=np.int64), np.empty(3 * m + 1, dtype=np.int64)
    order: cython.longlong[::1] = order_array
    begins: cython.longlong[::1] = begins_array
    with cython.nogil:
        for face in range(m):
            for k in range(3):
                low, high = F[face, (k + 1) % 3], F[face, (k + 2) % 3]
                by_low[min(low, high) + 1] += 1
                by_high[max(low, high) + 1] += 1
        for place in range(n):
            by_low[place + 1] += by_low[place]
            by_high[place + 1] += by_high[place]
        for face in range(m):
            for k in range(3):
                high = max(F[face, (k + 1) % 3], F[face, (k + 2) % 3])
                higher[by_high[high]] = 3 * face + k
                by_high[high] += 1
        for place in range(3 * m):
            half_edge = higher[place]
            face, k = half_edge // 3, half_edge % 3
            low = min(F[face, (k + 1) % 3], F[face, (k + 2) % 3])
            order[by_low[low]] = half_edge
            by_low[low] += 1
        last_low, last_high = -1, -1
        for place in range(3 * m):
            face, k = order[place] // 3, order[place] % 3
            low, high = F[face, (k + 1) % 3], F[face, (k + 2) % 3]
            low, high = min(low, high), max(low, high)
            if low != last_low or high != last_high:
                begins[n_edges] = place
                n_edges += 1
                last_low, last_high = low, high
        begins[n_edges] = 3 * m
    return order_array, begins_array[: n_edges + 1]


@cython.locals(edge=cython.Py_ssize_t, place=cython.Py_ssize_t, ahead=cython.longlong, back=cython.longlong)
def glue_copies(
    F: cython.const[cython.longlong][:, ::1],
    order: cython.const[cython.longlong][::1],
    begins: cython.const[cython.longlong][::1],
) -> NDArray[np.int64]:
    """(6 m,) twin of each half-edge of the faces and of their reversed copies, glued around each edge.

    The side of a face that looks towards larger angles is glued to the side of the next face that looks back. A face
    itself looks towards larger angles if it runs along the edge from the lower vertex, else its copy does.

    Parameters
    ----------
    F : (m, 3) array of int
    order : (3 m,) array of int
        Half-edges in the order of their edges, those of an edge in the order of the angles around it.
    begins : (e + 1,) array of int
        Where the half-edges of each edge begin.
    """
    array = np.empty(6 * F.shape[0], dtype=np.int64)
    twins: cython.longlong[::1] = array
    with cython.nogil:
        for edge in range(begins.shape[0] - 1):
            for place in range(begins[edge], begins[edge + 1]):
                ahead = order[place]
                if not _is_forward(F, ahead):
                    ahead = _reversed_copy(ahead, F.shape[0])
                back = order[place + 1 if place + 1 < begins[edge + 1] else begins[edge]]
                if _is_forward(F, back):
                    back = _reversed_copy(back, F.shape[0])
                twins[ahead], twins[back] = back, ahead
    return array


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _is_forward(F: cython.const[cython.longlong][:, ::1], half_edge: cython.longlong) -> cython.bint:
    """Whether a half-edge runs from its lower to its higher vertex."""
    face: cython.Py_ssize_t = half_edge // 3
    k: cython.Py_ssize_t = half_edge % 3
    return F[face, (k + 1) % 3] < F[face, (k + 2) % 3]


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _reversed_copy(half_edge: cython.longlong, m: cython.Py_ssize_t) -> cython.longlong:
    """Half-edge of the reversed copy of its face, whose second and third corners change places."""
    face: cython.longlong = half_edge // 3
    return 3 * (face + m) + (3 - half_edge % 3) % 3
