"""Nearest round cones: the unions of balls along edges, whose centers and radii change evenly."""

from __future__ import annotations

__all__ = ["nearest_cones"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython
if cython.compiled:
    from cython.cimports.libc.math import sqrt
else:
    from math import sqrt

EPSILON = cython.declare(cython.double, np.finfo(np.float64).eps)
TINY = cython.declare(cython.double, np.finfo(np.float64).tiny)
INFINITY = cython.declare(cython.double, float("inf"))


@cython.locals(
    row=cython.Py_ssize_t,
    rank=cython.Py_ssize_t,
    at=cython.Py_ssize_t,
    edge=cython.longlong,
    i=cython.longlong,
    j=cython.longlong,
    ax=cython.double,
    ay=cython.double,
    az=cython.double,
    x=cython.double,
    y=cython.double,
    z=cython.double,
    squared=cython.double,
    extent=cython.double,
    share=cython.double,
    height=cython.double,
    sine=cython.double,
    radius=cython.double,
    length=cython.double,
    least=cython.double,
)
def nearest_cones(
    points: cython.const[cython.double][:, ::1],
    balls: cython.const[cython.longlong][:, ::1],
    positions: cython.const[cython.double][:, ::1],
    radii: cython.const[cython.double][::1],
    edges: cython.const[cython.longlong][:, ::1],
    first: cython.const[cython.longlong][::1],
    edges_of_ball: cython.const[cython.longlong][::1],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Find the cone nearest to each point among those that end at some balls.

    Parameters
    ----------
    points : (n, 3) array of float
    balls : (n, b) array of int
        The balls of each point; at least one of them has an edge.
    positions, radii : (k, 3) and (k,) arrays of float
        Of the balls.
    edges : (m, 2) array of int
        Between the balls.
    first, edges_of_ball : (k + 1,) and (2 m,) arrays of int
        The edges of ball k are ``edges_of_ball[first[k]:first[k + 1]]``.

    Returns
    -------
    edge : (n,) array of int
    feet : (n, 6) array of float
        The place along the edge, from 0 to 1, where a normal of the cone leads to the point; the radius of the cone
        there; the distance of the point from the cone's surface, negative inside; the unit vector of the normal.
    """
    if balls.shape[0] != points.shape[0] or first.shape[0] != positions.shape[0] + 1:
        raise ValueError("there must be balls for each point, and edges for each ball")
    nearest_array, feet_array = np.full(points.shape[0], -1), np.zeros((points.shape[0], 6))
    nearest: cython.longlong[::1] = nearest_array
    feet: cython.double[:, ::1] = feet_array
    with cython.nogil:
        for row in range(points.shape[0]):
            least = INFINITY
            for rank in range(balls.shape[1]):
                for at in range(first[balls[row, rank]], first[balls[row, rank] + 1]):
                    edge = edges_of_ball[at]
                    i, j = edges[edge, 0], edges[edge, 1]
                    ax, ay = positions[j, 0] - positions[i, 0], positions[j, 1] - positions[i, 1]
                    az = positions[j, 2] - positions[i, 2]
                    x, y = points[row, 0] - positions[i, 0], points[row, 1] - positions[i, 1]
                    z = points[row, 2] - positions[i, 2]
                    squared = max(ax * ax + ay * ay + az * az, TINY)
                    extent = sqrt(squared)
                    share = (ax * x + ay * y + az * z) / squared
                    height = sqrt(max(x * x + y * y + z * z - share * share * squared, 0.0))
                    # of half the cone's angle, by which its normals lean; from 1 on, one ball is in the other
                    sine = min(max((radii[i] - radii[j]) / extent, -1.0), 1.0)
                    share -= height * sine / (sqrt(max(1 - sine * sine, EPSILON)) * extent)
                    share = min(max(share, 0.0), 1.0)
                    x, y, z = x - share * ax, y - share * ay, z - share * az
                    length = sqrt(x * x + y * y + z * z)
                    radius = (1 - share) * radii[i] + share * radii[j]
                    if length - radius < least:
                        least = length - radius
                        nearest[row] = edge
                        feet[row, 0], feet[row, 1], feet[row, 2] = share, radius, least
                        length = max(length, TINY)
                        feet[row, 3], feet[row, 4], feet[row, 5] = x / length, y / length, z / length
    return nearest_array, feet_array
