"""Weights of bones by heat: each bone is kept at temperature 1 for its own vertices, and the surface conducts.

(S + M H) w_b = M H p_b with the stiffness S and mass M of a Laplacian, p_b = 1 at the vertices of bone b, and H = c/d^2
at distance d from a vertex's own bone: Baran, Popovic 2007, "Automatic rigging and animation of 3D characters",
https://doi.org/10.1145/1276377.1276467. There, p_b is 1 where b is the nearest bone and in sight. Here b is the nearest
among the bone of the vertex's region on the skeleton and the bones that meet it, so that a finger does not follow the
one beside it. As in Blender, a bone counts as farther where the normal does not point away from it. All bones share one
matrix. The weights of a vertex sum to 1, since the right-hand sides sum to M H; they are not negative if the edge
weights of the Laplacian are positive.
"""

from __future__ import annotations

__all__ = ["bone_weights", "keep_largest"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, dia_array

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import normalized
from lbskel.operators import laplacian
from lbskel.solvers import factorize

# The factor c, no unit; the paper has 1, and Blender, whose Laplacian is a quarter of this one, 4. Weights change over
# 1 / sqrt(c) of the distance to the bone (benchmarks/results/rig.md, "Heat").
HEAT = 4.0
# Lower bound on d / sqrt(c), in lengths of the longest edge at the vertex, so that weights change over several edges
# also where a limb is as thin as its triangles: it bounds the jump of a weight along an edge (same file, "Constants").
EDGES = 1.25
# Both are Blender's: the relative difference of distances up to which bones are equally near, as where they meet; and
# the number added to the cosine of the angle between the normal and the offset from the bone, which makes a bone on the
# outer side of a vertex 2,000 times as far as one straight below it.
EQUAL, MIN_COSINE = 1e-4, 1.001
EPSILON = np.finfo(np.float64).eps  # lower bound on lengths and masses in units of the whole, by which is divided


def bone_weights(
    mesh: Mesh,
    heads: NDArray[np.float64],
    tails: NDArray[np.float64],
    parents: NDArray[np.int64],
    bone_of_vertex: NDArray[np.int64],
) -> NDArray[np.float64]:
    """(n, b) weights of all bones, with rows that sum to 1.

    Parameters
    ----------
    mesh : Mesh
    heads, tails : (b, 3) array of float
    parents : (b,) array of int
        -1 for a root.
    bone_of_vertex : (n,) array of int
        The bone that the region of each vertex belongs to.

    Raises
    ------
    SolveError
        If the system cannot be solved.
    """
    n = len(mesh.vertices)
    size = mesh.diameter_bound
    at_unit_size = mesh.with_vertices((mesh.vertices - mesh.centroid) / size)
    operator = laplacian(at_unit_size, operator="robust")
    is_own = _nearest_bones(mesh, heads, tails, parents, bone_of_vertex)
    first = is_own.argmax(axis=1)
    distances = np.linalg.norm(_offsets(mesh.vertices, heads[first], tails[first]), axis=1) / size
    reach = np.maximum(distances / np.sqrt(HEAT), np.maximum(EDGES * mesh.longest_edges / size, EPSILON))
    mass = operator.mass.diagonal()
    contact = np.maximum(mass, EPSILON * mass.mean()) / reach**2
    source = contact[:, None] * is_own
    A = csc_array(operator.stiffness + dia_array((source.sum(axis=1)[None], [0]), shape=(n, n)))
    weights = np.clip(factorize(A).solve(source), 0.0, None)
    total = weights.sum(axis=1, keepdims=True)
    return np.where(total > 0, weights / np.where(total > 0, total, 1.0), np.eye(len(heads))[first])


def _offsets(points: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) vectors to points, each from the nearest point of its segment."""
    along, offset = end - start, points - start
    squared = (along * along).sum(axis=-1)
    share = (offset * along).sum(axis=-1) / np.where(squared > 0, squared, 1.0)
    away: NDArray[np.float64] = offset - np.clip(share, 0, 1)[..., None] * along
    return away


def _nearest_bones(
    mesh: Mesh,
    heads: NDArray[np.float64],
    tails: NDArray[np.float64],
    parents: NDArray[np.int64],
    bone_of_vertex: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """(n, b) whether a bone is nearest among that of the vertex's region, its parent, its children and its siblings.

    Where bones meet, several are nearest.
    """
    normals = np.zeros((len(mesh.vertices), 3))
    np.add.at(normals, mesh.faces, mesh.face_normals[:, None])
    normals = normalized(normals)
    distances = np.full((len(mesh.vertices), len(heads)), np.inf)
    for bone in np.unique(bone_of_vertex).tolist():
        parent = int(parents[bone])
        is_near = (parents == bone) | ((parents == parent) & (parent >= 0))
        is_near[[bone, parent] if parent >= 0 else [bone]] = True
        rows = np.flatnonzero(bone_of_vertex == bone)
        for other in np.flatnonzero(is_near).tolist():
            away = _offsets(mesh.vertices[rows], heads[other], tails[other])
            distance = np.linalg.norm(away, axis=1)
            cosine = np.einsum("nx,nx->n", away, normals[rows]) / np.where(distance > 0, distance, 1.0)
            distances[rows, other] = distance / (cosine + MIN_COSINE)
    nearest: NDArray[np.bool_] = distances <= (1 + EQUAL) * distances.min(axis=1, keepdims=True)
    return nearest


def keep_largest(weights: NDArray[np.float64], number: int) -> NDArray[np.float64]:
    """(n, b) weights with only the largest ones of each row, which sum to 1 again.

    Of equal weights all or none are kept, since a vertex in the plane of symmetry would else follow one arm only. If
    more than ``number`` weights share the largest value, the first of them are kept.

    Parameters
    ----------
    weights : (n, b) array of float
    number : int
        Largest number of positive weights in a row.
    """
    if number >= weights.shape[1]:
        return weights
    order = np.argsort(-weights, axis=1, kind="stable")
    least = np.take_along_axis(weights, order[:, [number]], axis=1)
    kept = np.where(weights > (1 + EQUAL) * least, weights, 0.0)
    undecided = ~kept.any(axis=1)  # more than that number are equally large
    kept[undecided] = weights[undecided]
    kept[np.flatnonzero(undecided)[:, None], order[undecided][:, number:]] = 0.0
    kept /= kept.sum(axis=1, keepdims=True)
    return kept
