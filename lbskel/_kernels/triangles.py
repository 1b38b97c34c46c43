"""Areas and corner products of triangles, and integrals over a surface and over the volume that it encloses."""

from __future__ import annotations

__all__ = ["corner_products", "integrals", "mixed_voronoi_areas"]

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


@cython.locals(face=cython.Py_ssize_t, k=cython.Py_ssize_t, axis=cython.Py_ssize_t, longest=cython.Py_ssize_t)
@cython.locals(p=cython.Py_ssize_t, q=cython.Py_ssize_t, x=cython.double, y=cython.double, z=cython.double)
def corner_products(
    V: cython.const[cython.double][:, ::1], F: cython.const[cython.longlong][:, ::1]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(m, 3) dot product of the sides at each corner, (m, 3) squared length of the opposite side, (m,) double areas.

    The cotangent at a corner is its dot product over the double area, which is the length of the cross product of the
    two shortest sides, for the least rounding error.
    """
    m: cython.Py_ssize_t = F.shape[0]
    products_array, squares_array, areas_array = np.empty((m, 3)), np.empty((m, 3)), np.empty(m)
    products: cython.double[:, ::1] = products_array
    squares: cython.double[:, ::1] = squares_array
    areas: cython.double[::1] = areas_array
    sides: cython.double[:, ::1] = np.empty((3, 3))
    with cython.nogil:
        for face in range(m):
            for axis in range(3):
                x, y, z = V[F[face, 0], axis], V[F[face, 1], axis], V[F[face, 2], axis]
                sides[0, axis], sides[1, axis], sides[2, axis] = z - y, x - z, y - x
            longest = 0
            for k in range(3):
                p, q = (k + 1) % 3, (k + 2) % 3
                squares[face, k] = sides[k, 0] * sides[k, 0] + sides[k, 1] * sides[k, 1] + sides[k, 2] * sides[k, 2]
                products[face, k] = -(sides[p, 0] * sides[q, 0] + sides[p, 1] * sides[q, 1] + sides[p, 2] * sides[q, 2])
                if squares[face, k] > squares[face, longest]:
                    longest = k
            p, q = (longest + 1) % 3, (longest + 2) % 3
            x = sides[p, 1] * sides[q, 2] - sides[p, 2] * sides[q, 1]
            y = sides[p, 2] * sides[q, 0] - sides[p, 0] * sides[q, 2]
            z = sides[p, 0] * sides[q, 1] - sides[p, 1] * sides[q, 0]
            areas[face] = sqrt(x * x + y * y + z * z)
    return products_array, squares_array, areas_array


@cython.locals(face=cython.Py_ssize_t, k=cython.Py_ssize_t, obtuse=cython.Py_ssize_t, left=cython.Py_ssize_t)
@cython.locals(right=cython.Py_ssize_t, max_product=cython.double, total=cython.double)
def mixed_voronoi_areas(
    products: cython.const[cython.double][:, ::1],
    squares: cython.const[cython.double][:, ::1],
    areas: cython.const[cython.double][::1],
    limit: cython.double,
) -> NDArray[np.float64]:
    """(m, 3) mixed Voronoi area of each corner.

    Meyer, Desbrun, Schroeder, Barr 2003, "Discrete differential-geometry operators for triangulated 2-manifolds",
    https://doi.org/10.1007/978-3-662-05105-4_2, section 3.3.

    Parameters
    ----------
    products, squares, areas
        As :func:`corner_products` returns them.
    limit : float
        A corner whose cotangent exceeds it in magnitude contributes nothing to the areas of the other two.
    """
    m: cython.Py_ssize_t = products.shape[0]
    array = np.empty((m, 3))
    result: cython.double[:, ::1] = array
    with cython.nogil:
        for face in range(m):
            max_product = limit * areas[face]
            obtuse = -1
            for k in range(3):
                if products[face, k] < 0 and -products[face, k] <= max_product:
                    obtuse = k
            for k in range(3):
                left, right, total = (k + 1) % 3, (k + 2) % 3, 0.0
                if obtuse >= 0:
                    result[face, k] = areas[face] / 4 if k == obtuse else areas[face] / 8
                elif areas[face] > 0:
                    if fabs(products[face, left]) <= max_product:
                        total += squares[face, left] * products[face, left]
                    if fabs(products[face, right]) <= max_product:
                        total += squares[face, right] * products[face, right]
                    result[face, k] = total / (8 * areas[face])
                else:
                    result[face, k] = 0.0
    return array


@cython.locals(face=cython.Py_ssize_t, axis=cython.Py_ssize_t, area=cython.double)
@cython.locals(x=cython.double, y=cython.double, z=cython.double)
def integrals(
    V: cython.const[cython.double][:, ::1], F: cython.const[cython.longlong][:, ::1]
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """(m,) face areas, (3,) centroid of the surface, signed enclosed volume.

    The centroid is the mean of the vertices where the total area is zero. The volume is the sum of the signed volumes
    of tetrahedra from that mean to each face: positive where faces are oriented outwards.
    """
    m: cython.Py_ssize_t = F.shape[0]
    n: cython.Py_ssize_t = V.shape[0]
    areas_array, center_array = np.empty(m), np.empty(3)
    areas: cython.double[::1] = areas_array
    center: cython.double[::1] = center_array
    origin: cython.double[::1] = np.zeros(3)  # mean of the vertices: an origin near the surface reduces rounding errors
    moment: cython.double[::1] = np.zeros(3)
    corner: cython.double[:, ::1] = np.empty((3, 3))
    volume: cython.double = 0.0
    total: cython.double = 0.0
    with cython.nogil:
        for face in range(n):
            for axis in range(3):
                origin[axis] += V[face, axis] / n
        for face in range(m):
            for axis in range(3):
                corner[0, axis] = V[F[face, 0], axis] - origin[axis]
                corner[1, axis] = V[F[face, 1], axis] - origin[axis]
                corner[2, axis] = V[F[face, 2], axis] - origin[axis]
            x = _cross(corner, 1, 2)
            y = _cross(corner, 2, 0)
            z = _cross(corner, 0, 1)
            area = sqrt(x * x + y * y + z * z) / 2
            areas[face] = area
            total += area
            for axis in range(3):
                moment[axis] += area * (corner[0, axis] + corner[1, axis] + corner[2, axis])
            volume += x * corner[0, 0] + y * corner[0, 1] + z * corner[0, 2]
        for axis in range(3):
            center[axis] = origin[axis] + (moment[axis] / (3 * total) if total > 0 else 0.0)
    return areas_array, center_array, volume / 6


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
def _cross(corner: cython.double[:, ::1], i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> cython.double:
    """One coordinate of the cross product of the two sides at the first of three corners."""
    a: cython.double = (corner[1, i] - corner[0, i]) * (corner[2, j] - corner[0, j])
    b: cython.double = (corner[1, j] - corner[0, j]) * (corner[2, i] - corner[0, i])
    return a - b
