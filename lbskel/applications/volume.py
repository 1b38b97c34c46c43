"""Volumes kept while a surface moves: each component is offset along its vertex normals.

The positions x + c n, with n the unit gradient of the volume at each vertex (the area-weighted normal) and zero at
fixed vertices, enclose a volume that is a cubic polynomial in c; Newton's method finds the c of the wanted volume. On
a sphere this is the rescaling of Desbrun, Meyer, Schroeder, Barr 1999, section 2.4,
https://doi.org/10.1145/311535.311576. Unlike a rescaling, an offset also works where vertices are fixed, and does not
move limbs away from the center.
"""

from __future__ import annotations

__all__ = ["has_volume", "keep_volumes"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import SolveError, first_few
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import normalized

NEWTON_STEPS = 50  # at most; a smoothing step needs about five
TOLERANCE = 1e-12  # of the volume, relative to the volume within an offset of the component's size: rounding errors


def has_volume(mesh: Mesh, is_fixed: NDArray[np.bool_]) -> bool:
    """Whether the change of the volume is defined: faces consistently oriented, and every boundary vertex fixed.

    Parameters
    ----------
    mesh : Mesh
    is_fixed : (n,) array of bool
    """
    key = mesh.half_edges[:, 0] * len(mesh.vertices) + mesh.half_edges[:, 1]
    boundary = mesh.edges[mesh.faces_per_edge == 1]
    return bool(len(np.unique(key)) == len(key) and is_fixed[boundary].all())


def _determinants(A: NDArray[np.float64], B: NDArray[np.float64], C: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the (m,) determinants of rows of three (m, 3) arrays."""
    values: NDArray[np.float64] = np.einsum("mx,mx->m", A, np.cross(B, C))
    return values


def keep_volumes(
    before: NDArray[np.float64],
    after: NDArray[np.float64],
    mesh: Mesh,
    is_fixed: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """Offset positions so that each component has the volume that it had before.

    Parameters
    ----------
    before, after : (n, 3) array of float
        Of about unit size.
    mesh : Mesh
        The faces.
    is_fixed : (n,) array of bool
        Vertices that the offset does not move.

    Raises
    ------
    SolveError
        If no offset gives a component its volume, since it has shrunk too far.
    """
    F, label = mesh.faces, mesh.component_of_vertex[mesh.faces[:, 0]]
    n_components = mesh.n_components
    vertex_label = mesh.component_of_vertex.clip(max=n_components)  # n_components: of vertices without a face
    # means of the components, far from which small volumes lose digits
    counts = np.bincount(vertex_label, minlength=n_components + 1)[:, None]
    totals = [np.bincount(vertex_label, values, n_components + 1) for values in before.T]
    center = (np.stack(totals, axis=1) / np.maximum(counts, 1))[vertex_label]
    start, end = before - center, after - center
    size = np.zeros(n_components + 1)
    np.maximum.at(size, vertex_label, np.linalg.norm(start, axis=1))
    A, B, C = end[F].transpose(1, 0, 2)
    gradient = np.zeros_like(after)
    for corner, vectors in enumerate((np.cross(B, C), np.cross(C, A), np.cross(A, B))):
        for axis in range(3):
            gradient[:, axis] += np.bincount(F[:, corner], vectors[:, axis], len(after))
    offset = normalized(gradient)
    offset[is_fixed] = 0
    P, Q, R = offset[F].transpose(1, 0, 2)
    terms = (
        _determinants(A, B, C) - _determinants(*start[F].transpose(1, 0, 2)),
        _determinants(P, B, C) + _determinants(A, Q, C) + _determinants(A, B, R),
        _determinants(A, Q, R) + _determinants(P, B, R) + _determinants(P, Q, C),
        _determinants(P, Q, R),
    )
    p = np.array([np.bincount(label, term, n_components) for term in terms])
    p[:, p[1] <= 0] = 0  # every vertex is fixed, or the surface has no area: nothing to offset
    slope = np.where(p[1] > 0, p[1], 1.0)
    tolerance = TOLERANCE * slope * size[:n_components]
    c = np.zeros(n_components)
    for _ in range(NEWTON_STEPS):
        error = p[0] + c * (p[1] + c * (p[2] + c * p[3]))
        is_left = np.abs(error) > tolerance
        if not is_left.any():
            result: NDArray[np.float64] = after + np.append(c, 0.0)[vertex_label][:, None] * offset
            return result
        derivative = p[1] + c * (2 * p[2] + 3 * c * p[3])
        c = c - np.divide(error, derivative, out=np.zeros_like(c), where=np.abs(derivative) > TOLERANCE * slope)
    lost = F[np.unique(label, return_index=True)[1][is_left], 0]  # a vertex of each component
    raise SolveError(
        f"no offset restores the volumes of the components with the vertices {first_few(lost)}, which have shrunk too "
        "far; take a smaller time_step, or smooth these components alone"
    )
