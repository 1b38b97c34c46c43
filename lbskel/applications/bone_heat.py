"""Weights of bones by heat: each bone is kept at temperature 1 for its own vertices, and the surface conducts.

(S + M H) w_b = M H p_b with the stiffness S and mass M of a Laplacian, p_b = 1 at the vertices of bone b, and H = c/d^2
at distance d from the own bone: Baran, Popovic 2007, "Automatic rigging and animation of 3D characters",
https://doi.org/10.1145/1276377.1276467. There, p_b is 1 where b is the nearest bone and in sight; here it is the bone
of the vertex's region on the skeleton, so that a finger does not follow the one beside it. The matrix is one for all
bones. The weights of a vertex sum to 1, since the p do; they are not negative with an operator of positive weights.
"""

from __future__ import annotations

__all__ = ["bone_weights", "keep_largest"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, dia_array

from lbskel.geometry.mesh import Mesh
from lbskel.operators import laplacian
from lbskel.solvers import factorize

# The factor c, no unit; the paper has 1. Weights change over 1 / sqrt(c) of the distance to the bone: from 2 to 6 short
# bones keep more of the volume than at 1, and weights are closer to Blender's (benchmarks/results/rig.md, "Heat").
HEAT = 3.0
# Lower bound on that length, in lengths of the longest edge at the vertex, so that weights change over several edges
# also where a limb is as thin as its triangles: it bounds the jump of a weight along an edge (same file, "Constants").
EDGES = 1.5
MIN_DISTANCE = 1e-3  # lower bound on the same, relative to the diameter bound, where bones touch the surface
MIN_MASS = 1e-6  # lower bound on masses, relative to their mean, for vertices without area; rounding errors are 1e-12


def bone_weights(
    mesh: Mesh, heads: NDArray[np.float64], tails: NDArray[np.float64], bone_of_vertex: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(n, b) weights of all bones, with rows that sum to 1.

    Parameters
    ----------
    mesh : Mesh
    heads, tails : (b, 3) array of float
    bone_of_vertex : (n,) array of int
        The own bone of each vertex.

    Raises
    ------
    SolveError
        If the system cannot be solved.
    """
    n, b = len(mesh.vertices), len(heads)
    size = mesh.diameter_bound
    at_unit_size = mesh.with_vertices((mesh.vertices - mesh.centroid) / size)
    operator = laplacian(at_unit_size, operator="robust")
    start, end = heads[bone_of_vertex], tails[bone_of_vertex]
    along, offset = (end - start) / size, (mesh.vertices - start) / size
    squared = np.einsum("nx,nx->n", along, along)
    share = np.einsum("nx,nx->n", offset, along) / np.where(squared > 0, squared, 1.0)
    away = offset - np.clip(share, 0, 1)[:, None] * along
    longest = np.zeros(n)
    np.maximum.at(longest, mesh.edges, mesh.edge_lengths[:, None] / size)
    reach = np.maximum(np.linalg.norm(away, axis=1) / np.sqrt(HEAT), np.maximum(EDGES * longest, MIN_DISTANCE))
    mass = operator.mass.diagonal()
    contact = np.maximum(mass, MIN_MASS * mass.mean()) / reach**2
    A = csc_array(operator.stiffness + dia_array((contact[None], [0]), shape=(n, n)))
    source = np.zeros((n, b))
    source[np.arange(n), bone_of_vertex] = contact
    weights = np.clip(factorize(A).solve(source), 0.0, None)
    total = weights.sum(axis=1, keepdims=True)
    own = np.eye(b)[bone_of_vertex]
    return np.where(total > 0, weights / np.where(total > 0, total, 1.0), own)


def keep_largest(weights: NDArray[np.float64], number: int) -> NDArray[np.float64]:
    """(n, b) weights with only the largest ones of each row, which sum to 1 again.

    Parameters
    ----------
    weights : (n, b) array of float
    number : int
        Largest number of positive weights in a row.
    """
    if number >= weights.shape[1]:
        return weights
    dropped = np.argsort(-weights, axis=1, kind="stable")[:, number:]
    kept = weights.copy()
    np.put_along_axis(kept, dropped, 0.0, axis=1)
    kept /= kept.sum(axis=1, keepdims=True)
    return kept
