"""Edge flips of an intrinsic triangulation until it is Delaunay.

Half-edge k of face f is 3 f + k in all arrays: it lies opposite corner k.
"""

from __future__ import annotations

__all__ = ["cotangents", "flip_to_delaunay"]

import numpy as np

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython
if cython.compiled:
    from cython.cimports.libc.math import fabs, sqrt
else:
    from math import fabs, sqrt

TOLERANCE = cython.declare(cython.double, 1e-9)  # relative to 1 + the cotangents, for rounding (a guess)
INFINITY = cython.declare(cython.double, float("inf"))


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _four_areas(a: cython.double, b: cython.double, c: cython.double) -> cython.double:
    """Four times the area of a triangle with these edge lengths, by Heron's formula in Kahan's stable order."""
    low: cython.double = min(a, b)
    high: cython.double = max(a, b)
    short: cython.double = min(low, c)
    middle: cython.double = max(low, min(high, c))
    long: cython.double = max(high, c)
    product: cython.double = (long + (middle + short)) * (short - (long - middle)) * (short + (long - middle))
    return sqrt(max(product * (long + (middle - short)), 0.0))


@cython.locals(face=cython.Py_ssize_t)
def cotangents(L: cython.const[cython.double][::1], C: cython.double[::1]) -> None:
    """Write to C the cotangent of the angle opposite each edge of triangles with edge lengths L, both (3 m,) arrays."""
    with cython.nogil:
        for face in range(L.shape[0] // 3):
            _face_cotangents(L, C, face)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(at=cython.Py_ssize_t)
def _face_cotangents(
    L: cython.const[cython.double][::1], C: cython.double[::1], face: cython.Py_ssize_t
) -> cython.void:
    """Write the three cotangents of one triangle; infinite or NaN where its area is 0."""
    first: cython.double = L[3 * face]
    second: cython.double = L[3 * face + 1]
    third: cython.double = L[3 * face + 2]
    area: cython.double = _four_areas(first, second, third)
    squares: cython.double = first * first + second * second + third * third
    inverse: cython.double = 1 / area if area > 0 else INFINITY
    for at in range(3 * face, 3 * face + 3):
        C[at] = (squares - 2 * (L[at] * L[at])) * inverse


@cython.locals(edge=cython.Py_ssize_t, twin=cython.Py_ssize_t, at=cython.Py_ssize_t, side=cython.Py_ssize_t)
def flip_to_delaunay(
    F: cython.longlong[::1], L: cython.double[::1], T: cython.longlong[::1], max_flips: cython.Py_ssize_t
) -> int:
    """Flip edges while the two cotangents opposite them have a negative sum; F, L and T are changed in place.

    Parameters
    ----------
    F : (3 m,) array of int
        Vertex at each corner.
    L : (3 m,) array of float
        Length of each half-edge.
    T : (3 m,) array of int
        Twin of each half-edge, or -1 on the boundary.
    max_flips : int
        Maximum number of flips.

    Returns
    -------
    int
        Number of flips.
    """
    n: cython.Py_ssize_t = T.shape[0]
    top: cython.Py_ssize_t = 0
    flips: cython.Py_ssize_t = 0
    C: cython.double[::1] = np.empty(n)
    stack: cython.longlong[::1] = np.empty(n, dtype=np.int64)
    is_queued: cython.schar[::1] = np.zeros(n, dtype=np.int8)
    cotangents(L, C)
    with cython.nogil:
        for edge in range(n - 1, -1, -1):
            if edge < T[edge]:
                stack[top], is_queued[edge] = edge, 1
                top += 1
        while top > 0 and flips < max_flips:
            top -= 1
            edge = stack[top]
            is_queued[edge], twin = 0, T[edge]
            # since it was queued, an adjacent flip may have stored another edge here, even one of the boundary
            if (
                twin < 0
                or edge // 3 == twin // 3
                or not C[edge] + C[twin] < -TOLERANCE * (1 + fabs(C[edge]) + fabs(C[twin]))
            ):
                continue
            _flip(F, L, T, edge, twin)
            flips += 1
            for side in range(2):
                _face_cotangents(L, C, (edge if side == 0 else twin) // 3)
            for side in range(6):
                at = (edge if side < 3 else twin) // 3 * 3 + side % 3
                if T[at] >= 0:
                    at = min(at, T[at])
                    if is_queued[at] == 0:
                        stack[top], is_queued[at] = at, 1
                        top += 1
    return flips


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _glue(T: cython.longlong[::1], edge: cython.longlong, other: cython.longlong) -> cython.void:
    """Make two half-edges twins, or the first a boundary if the second is -1."""
    T[edge] = other
    if other >= 0:
        T[other] = edge


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _flip(
    F: cython.longlong[::1],
    L: cython.double[::1],
    T: cython.longlong[::1],
    h: cython.longlong,
    t: cython.longlong,
) -> cython.void:
    """Flip edge ab of the triangles abc and bad to cd of cad and dbc; its length is measured in their common plane."""
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
    outer_ad: cython.longlong = _relocated(T[t_b], t_b, h_b, h_a, t_a, f, g)
    outer_ca: cython.longlong = _relocated(T[h_b], t_b, h_b, h_a, t_a, f, g)
    outer_bc: cython.longlong = _relocated(T[h_a], t_b, h_b, h_a, t_a, f, g)
    outer_db: cython.longlong = _relocated(T[t_a], t_b, h_b, h_a, t_a, f, g)
    F[f], F[f + 1], F[f + 2], F[g], F[g + 1], F[g + 2] = c, a, d, d, b, c
    L[f], L[f + 1], L[f + 2], L[g], L[g + 1], L[g + 2] = ad, cd, ca, bc, cd, db
    _glue(T, f, outer_ad)
    _glue(T, f + 1, g + 1)
    _glue(T, f + 2, outer_ca)
    _glue(T, g, outer_bc)
    _glue(T, g + 2, outer_db)


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _relocated(
    edge: cython.longlong,
    t_b: cython.longlong,
    h_b: cython.longlong,
    h_a: cython.longlong,
    t_a: cython.longlong,
    f: cython.longlong,
    g: cython.longlong,
) -> cython.longlong:
    """Index of a half-edge after a flip, which moves the four sides of the two triangles."""
    if edge == t_b:
        return f
    if edge == h_b:
        return f + 2
    if edge == h_a:
        return g
    if edge == t_a:
        return g + 2
    return edge
