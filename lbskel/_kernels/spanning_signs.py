"""Signs along a minimum spanning tree: Kruskal 1956, https://doi.org/10.1090/S0002-9939-1956-0078686-7.

Trees are merged as in Tarjan 1975, "Efficiency of a good but not linear set union algorithm",
https://doi.org/10.1145/321879.321884, where each node knows its sign relative to the node above it.
"""

from __future__ import annotations

__all__ = ["spanning_signs"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython


@cython.locals(i=cython.Py_ssize_t, j=cython.Py_ssize_t, row=cython.Py_ssize_t, sign=cython.schar)
@cython.locals(n_parts=cython.longlong)
def spanning_signs(
    links: cython.const[cython.longlong][:, ::1], signs: cython.const[cython.schar][::1], n: cython.Py_ssize_t
) -> tuple[NDArray[np.int8], NDArray[np.int64]]:
    """(n,) sign of each node, and (n,) number of its connected part, in the order of their first nodes.

    The sign of the first node of a part is 1; the others follow along the links that join two parts when it is their
    turn.

    Parameters
    ----------
    links : (l, 2) array of int
        In the order in which they are taken.
    signs : (l,) array of int8
        1 where both ends of a link have the same sign, otherwise -1.
    n : int
    """
    if signs.shape[0] != links.shape[0]:
        raise ValueError("there must be a sign for each link")
    sign_array, part_array = np.ones(n, dtype=np.int8), np.empty(n, dtype=np.int64)
    relative: cython.schar[::1] = sign_array
    part: cython.longlong[::1] = part_array
    above: cython.longlong[::1] = np.arange(n)
    with cython.nogil:
        for row in range(links.shape[0]):
            i, j = _root(above, relative, links[row, 0]), _root(above, relative, links[row, 1])
            if i == j:
                continue
            # each end is a root or right under it
            sign = signs[row] * relative[links[row, 0]] * relative[links[row, 1]]
            if i < j:
                above[j], relative[j] = i, sign
            else:
                above[i], relative[i] = j, sign
        n_parts = 0
        for i in range(n):
            j = _root(above, relative, i)
            if i == j:
                part[i] = n_parts
                n_parts += 1
            else:
                part[i] = part[j]
    return sign_array, part_array


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(root=cython.Py_ssize_t, following=cython.Py_ssize_t, sign=cython.schar, own=cython.schar)
def _root(above: cython.longlong[::1], relative: cython.schar[::1], node: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Root of a node, under which all nodes on the path to it are put; the sign of a root is 1."""
    root, sign = node, 1
    while above[root] != root:
        sign *= relative[root]
        root = above[root]
    while above[node] != node:
        following, own = above[node], relative[node]
        above[node], relative[node] = root, sign
        node, sign = following, sign * own
    return root
