"""Field of dipoles that are smoothed over a length each, summed by a tree: a smooth winding number of oriented points.

At x the field is ``sum_i m_i . (p_i - x) / (4 pi (|p_i - x|^2 + s_i^2)^(3/2))``. With m_i the area of a point of a
closed surface times its outward unit normal, this is near 1 inside and near 0 outside; smoothing by s_i removes the
singularity at the point. The tree is that of Barnes, Hut 1986, https://doi.org/10.1038/324446a0, with the first moment
of each node, as Barill et al. 2018, https://doi.org/10.1145/3197517.3201337, sum winding numbers.
"""

from __future__ import annotations

__all__ = ["dipole_field"]

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

DEPTH = cython.declare(cython.Py_ssize_t, 64)  # length of a traversal stack; a tree of 2^62 leaves has no deeper one
FOUR_PI = cython.declare(cython.double, 12.566370614359172)


@cython.locals(
    i=cython.Py_ssize_t,
    node=cython.Py_ssize_t,
    row=cython.Py_ssize_t,
    top=cython.Py_ssize_t,
    x=cython.double,
    y=cython.double,
    z=cython.double,
    squared=cython.double,
    inverse=cython.double,
    cubed=cython.double,
    product=cython.double,
    value=cython.double,
    gx=cython.double,
    gy=cython.double,
    gz=cython.double,
)
def dipole_field(
    nodes: cython.const[cython.double][:, ::1],
    points: cython.const[cython.double][:, ::1],
    queries: cython.const[cython.double][:, ::1],
    leaf_size: cython.Py_ssize_t,
    opening: cython.double,
    has_gradient: cython.bint,
) -> NDArray[np.float64]:
    """(q, 4) field and its gradient at each query, or (q, 1) the field alone.

    Parameters
    ----------
    nodes : (2 p, 8) array of float
        Center, moment, squared smoothing length and radius of each node of a complete binary tree whose root is row 1;
        the children of row i are rows 2 i and 2 i + 1, and rows p to 2 p - 1 are leaves.
    points : (p * leaf_size, 7) array of float
        Position, moment and squared smoothing length of each point, leaf by leaf.
    queries : (q, 3) array of float
    leaf_size : int
    opening : float
        A node counts as one dipole where the query is farther from its center than this many of its radii.
    has_gradient : bool
    """
    p: cython.Py_ssize_t = nodes.shape[0] // 2
    field_array = np.empty((queries.shape[0], 4 if has_gradient else 1))
    field: cython.double[:, ::1] = field_array
    stack: cython.longlong[::1] = np.empty(DEPTH, dtype=np.int64)
    with cython.nogil:
        for i in range(queries.shape[0]):
            value = gx = gy = gz = 0.0
            stack[0], top = 1, 1
            while top > 0:
                top -= 1
                node = stack[top]
                x, y, z = nodes[node, 0] - queries[i, 0], nodes[node, 1] - queries[i, 1], nodes[node, 2] - queries[i, 2]
                squared = x * x + y * y + z * z
                if squared > opening * opening * nodes[node, 7] * nodes[node, 7]:
                    inverse = 1 / (squared + nodes[node, 6])
                    cubed = inverse * sqrt(inverse)
                    product = nodes[node, 3] * x + nodes[node, 4] * y + nodes[node, 5] * z
                    value += product * cubed
                    if has_gradient:
                        product *= 3 * inverse
                        gx += (product * x - nodes[node, 3]) * cubed
                        gy += (product * y - nodes[node, 4]) * cubed
                        gz += (product * z - nodes[node, 5]) * cubed
                elif node < p:
                    stack[top], stack[top + 1], top = 2 * node, 2 * node + 1, top + 2
                else:
                    for row in range((node - p) * leaf_size, (node - p + 1) * leaf_size):
                        x = points[row, 0] - queries[i, 0]
                        y = points[row, 1] - queries[i, 1]
                        z = points[row, 2] - queries[i, 2]
                        squared = x * x + y * y + z * z + points[row, 6]
                        if squared > 0:
                            inverse = 1 / squared
                            cubed = inverse * sqrt(inverse)
                            product = points[row, 3] * x + points[row, 4] * y + points[row, 5] * z
                            value += product * cubed
                            if has_gradient:
                                product *= 3 * inverse
                                gx += (product * x - points[row, 3]) * cubed
                                gy += (product * y - points[row, 4]) * cubed
                                gz += (product * z - points[row, 5]) * cubed
            field[i, 0] = value / FOUR_PI
            if has_gradient:
                field[i, 1], field[i, 2], field[i, 3] = gx / FOUR_PI, gy / FOUR_PI, gz / FOUR_PI
    return field_array
