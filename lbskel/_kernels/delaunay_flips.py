# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Edges of an intrinsic triangulation flipped one after the other until it is Delaunay."""

from __future__ import annotations

__all__ = ["cotangents", "flip_to_delaunay"]

import cython
import numpy as np
from cython.cimports.libc.math import fabs, sqrt

TOLERANCE = cython.declare(cython.double, 1e-9)
NEVER = cython.declare(cython.double, float("inf"))


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _four_areas(a: cython.double, b: cython.double, c: cython.double) -> cython.double:
    """Four times the area of a triangle with these edge lengths, by Heron's formula in Kahan's order."""
    low: cython.double = min(a, b)
    high: cython.double = max(a, b)
    short: cython.double = min(low, c)
    middle: cython.double = max(low, min(high, c))
    long: cython.double = max(high, c)
    product: cython.double = (long + (middle + short)) * (short - (long - middle)) * (short + (long - middle))
    return sqrt(max(product * (long + (middle - short)), 0.0))


@cython.locals(face=cython.Py_ssize_t)
def cotangents(L: cython.const[cython.double][::1], C: cython.double[::1]) -> None:
    """Write the cotangent opposite each edge of triangles with these lengths, three by three."""
    for face in range(L.shape[0] // 3):
        _cotangents_of(L, C, face)


@cython.cfunc
@cython.exceptval(check=False)
@cython.locals(at=cython.Py_ssize_t)
def _cotangents_of(L: cython.const[cython.double][::1], C: cython.double[::1], face: cython.Py_ssize_t) -> cython.void:
    """Those of one triangle; infinite, or not a number, where it has no area."""
    first: cython.double = L[3 * face]
    second: cython.double = L[3 * face + 1]
    third: cython.double = L[3 * face + 2]
    area: cython.double = _four_areas(first, second, third)
    squares: cython.double = first * first + second * second + third * third
    share: cython.double = 1 / area if area > 0 else NEVER
    for at in range(3 * face, 3 * face + 3):
        C[at] = (squares - 2 * (L[at] * L[at])) * share


@cython.locals(edge=cython.Py_ssize_t, twin=cython.Py_ssize_t, at=cython.Py_ssize_t, side=cython.Py_ssize_t)
def flip_to_delaunay(
    F: cython.longlong[::1], L: cython.double[::1], T: cython.longlong[::1], at_most: cython.Py_ssize_t
) -> int:
    """Flip edges in place while the cotangents opposite them sum to less than zero; how many were flipped.

    Corner k of face f is 3 f + k in all arrays: its vertex, the length of the edge opposite, and the twin of that edge,
    or -1.
    """
    n: cython.Py_ssize_t = T.shape[0]
    top: cython.Py_ssize_t = 0
    flips: cython.Py_ssize_t = 0
    C: cython.double[::1] = np.empty(n)
    stack: cython.longlong[::1] = np.empty(n, dtype=np.int64)
    waits: cython.schar[::1] = np.zeros(n, dtype=np.int8)
    cotangents(L, C)
    for edge in range(n - 1, -1, -1):
        if edge < T[edge]:
            stack[top], waits[edge] = edge, 1
            top += 1
    while top > 0 and flips < at_most:
        top -= 1
        edge = stack[top]
        waits[edge], twin = 0, T[edge]
        # a flip beside may have put another edge in its place, of the boundary too
        if (
            twin < 0
            or edge // 3 == twin // 3
            or not C[edge] + C[twin] < -TOLERANCE * (1 + fabs(C[edge]) + fabs(C[twin]))
        ):
            continue
        _flip(F, L, T, edge, twin)
        flips += 1
        for side in range(2):
            _cotangents_of(L, C, (edge if side == 0 else twin) // 3)
        for side in range(6):
            at = (edge if side < 3 else twin) // 3 * 3 + side % 3
            if T[at] >= 0:
                at = min(at, T[at])
                if waits[at] == 0:
                    stack[top], waits[at] = at, 1
                    top += 1
    return flips


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _glue(T: cython.longlong[::1], edge: cython.longlong, beyond: cython.longlong) -> cython.void:
    """Make two edges twins, where there is a second."""
    T[edge] = beyond
    if beyond >= 0:
        T[beyond] = edge


@cython.cfunc
@cython.exceptval(check=False)
def _flip(
    F: cython.longlong[::1],
    L: cython.double[::1],
    T: cython.longlong[::1],
    h: cython.longlong,
    t: cython.longlong,
) -> cython.void:
    """Flip an edge: ab of the triangles abc and bad becomes cd of cad and dbc; its length is that in the plane."""
    f: cython.longlong = h - h % 3
    g: cython.longlong = t - t % 3
    h_a: cython.longlong = f + (h + 1) % 3
    h_b: cython.longlong = f + (h + 2) % 3
    t_b: cython.longlong = g + (t + 1) % 3
    t_a: cython.longlong = g + (t + 2) % 3
    a: cython.longlong = F[h_a]
    b: cython.longlong = F[h_b]
    c: cython.longlong = F[h]
    d: cython.longlong = F[t]
    ab: cython.double = L[h]
    bc: cython.double = L[h_a]
    ca: cython.double = L[h_b]
    ad: cython.double = L[t_b]
    db: cython.double = L[t_a]
    along: cython.double = (ca * ca - bc * bc - ad * ad + db * db) / (2 * ab)
    across: cython.double = (_four_areas(ab, bc, ca) + _four_areas(ab, ad, db)) / (2 * ab)
    cd: cython.double = sqrt(along * along + across * across)
    beyond_ad: cython.longlong = _moved(T[t_b], t_b, h_b, h_a, t_a, f, g)
    beyond_ca: cython.longlong = _moved(T[h_b], t_b, h_b, h_a, t_a, f, g)
    beyond_bc: cython.longlong = _moved(T[h_a], t_b, h_b, h_a, t_a, f, g)
    beyond_db: cython.longlong = _moved(T[t_a], t_b, h_b, h_a, t_a, f, g)
    F[f], F[f + 1], F[f + 2], F[g], F[g + 1], F[g + 2] = c, a, d, d, b, c
    L[f], L[f + 1], L[f + 2], L[g], L[g + 1], L[g + 2] = ad, cd, ca, bc, cd, db
    _glue(T, f, beyond_ad)
    _glue(T, f + 1, g + 1)
    _glue(T, f + 2, beyond_ca)
    _glue(T, g, beyond_bc)
    _glue(T, g + 2, beyond_db)


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _moved(
    edge: cython.longlong,
    t_b: cython.longlong,
    h_b: cython.longlong,
    h_a: cython.longlong,
    t_a: cython.longlong,
    f: cython.longlong,
    g: cython.longlong,
) -> cython.longlong:
    """Where an edge is after a flip: one of the four round the two triangles may be glued to another of them."""
    if edge == t_b:
        return f
    if edge == h_b:
        return f + 2
    if edge == h_a:
        return g
    if edge == t_a:
        return g + 2
    return edge
