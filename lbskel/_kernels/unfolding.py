"""Distances along a surface, carried from triangle to triangle by unfolding.

The distances of two vertices of a triangle place a source in its plane, on the far side of their edge; if the straight
line from there to the third vertex crosses the edge, its length is the distance of that vertex, else the path leads
along an edge. Novotni, Klein 2002, "Computing geodesic distances on triangular meshes"; Melvaer, Reimers 2012,
"Geodesic polar coordinates on polygonal meshes", https://doi.org/10.1111/j.1467-8659.2012.03187.x.
"""

from __future__ import annotations

__all__ = ["lower_distances"]

import numpy as np

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython
if cython.compiled:
    from cython.cimports.libc.math import sqrt
else:
    from math import sqrt

INFINITY = cython.declare(cython.double, float("inf"))
# Share of a distance by which it has to get smaller: many times the rounding of a few operations, which would go on
# lowering distances around a vertex
ROUNDING = cython.declare(cython.double, 1e-12)


@cython.locals(rank=cython.Py_ssize_t, v=cython.longlong, slot=cython.Py_ssize_t, sweep=cython.Py_ssize_t)
@cython.locals(corner=cython.longlong, face=cython.longlong, left=cython.longlong, right=cython.longlong)
def lower_distances(
    F: cython.const[cython.longlong][::1],
    L: cython.const[cython.double][::1],
    first: cython.const[cython.longlong][::1],
    corners: cython.const[cython.longlong][::1],
    order: cython.const[cython.longlong][::1],
    D: cython.double[::1],
    max_sweeps: cython.Py_ssize_t,
) -> int:
    """Lower distances across the triangles until none gets smaller; D is changed in place.

    Parameters
    ----------
    F : (3 m,) array of int
        Vertex at each corner of m triangles.
    L : (3 m,) array of float
        Length of the edge opposite each corner.
    first : (n + 1,) array of int
    corners : (3 m,) array of int
        Corners at each vertex: those at vertex v are ``corners[first[v]:first[v + 1]]``.
    order : (k,) array of int
        Vertices in the order of a sweep; others keep what they have. The nearer it is to that of the distances, the
        fewer the sweeps.
    D : (n,) array of float
        Zero at the sources, infinite elsewhere.
    max_sweeps : int
        Maximum number of sweeps.

    Returns
    -------
    int
        Number of sweeps, of which the last changes nothing.
    """
    best: cython.double
    is_open: cython.schar[::1] = np.ones(D.shape[0], dtype=np.int8)  # what is around it has changed
    n_changed: cython.Py_ssize_t = 1
    sweep = 0
    with cython.nogil:
        while n_changed > 0 and sweep < max_sweeps:
            n_changed = 0
            sweep += 1
            for rank in range(order.shape[0]):
                v = order[rank]
                if is_open[v] == 0:
                    continue
                is_open[v], best = 0, D[v]
                for slot in range(first[v], first[v + 1]):
                    corner = corners[slot]
                    face = corner - corner % 3
                    left, right = face + (corner + 1) % 3, face + (corner + 2) % 3
                    best = min(best, _across(D[F[left]], D[F[right]], L[corner], L[right], L[left]))
                if best < D[v] * (1 - ROUNDING):
                    D[v] = best
                    n_changed += 1
                    for slot in range(first[v], first[v + 1]):
                        face = corners[slot] - corners[slot] % 3
                        is_open[F[face]] = is_open[F[face + 1]] = is_open[F[face + 2]] = 1
    return sweep


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _across(
    from_a: cython.double, from_b: cython.double, ab: cython.double, va: cython.double, vb: cython.double
) -> cython.double:
    """Distance of a corner v of a triangle from those of the two others, by the lengths of its edges."""
    along_edge: cython.double = min(from_a + va, from_b + vb)
    if from_a == INFINITY or from_b == INFINITY or not ab > 0:
        return along_edge
    # a at 0 and b at ab on the first axis, the source below it and v above
    source_x: cython.double = (from_a * from_a - from_b * from_b + ab * ab) / (2 * ab)
    source_y: cython.double = from_a * from_a - source_x * source_x
    x: cython.double = (va * va - vb * vb + ab * ab) / (2 * ab)
    y: cython.double = va * va - x * x
    if source_y < 0 or y <= 0:
        return along_edge
    source_y, y = sqrt(source_y), sqrt(y)
    crossing: cython.double = source_x * y + x * source_y  # times the height of v over the source
    if crossing < 0 or crossing > ab * (source_y + y):
        return along_edge
    x, y = x - source_x, y + source_y
    return min(along_edge, sqrt(x * x + y * y))
