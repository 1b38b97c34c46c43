"""The anisotropic Laplacian: diffusion is damped along the directions in which the surface bends.

Andreux, Rodola, Aubry, Cremers 2014, "Anisotropic Laplace-Beltrami operators for shape analysis",
https://doi.org/10.1007/978-3-319-16220-1_21. In each triangle the gradient is multiplied by D = (I + s |K|)^-1, with K
the 2 x 2 shape operator; S_ij = grad_i . D grad_j A. A strength of s = 0, or a plane, gives the cotangent Laplacian.
(LaPy damps by exp(-s |K|), which at a crease gives entries of 1e-76 and a null space of the wrong dimension.) K is the
least-squares fit to the differences of the vertex normals along the edges (Rusinkiewicz 2004,
https://doi.org/10.1109/TDPVT.2004.1335277). Curvature is measured relative to a sphere of the mesh's area.
"""

from __future__ import annotations

__all__ = ["anisotropic", "shape_operators"]

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.triangles import corner_products
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_vertices
from lbskel.operators.assembly import stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import degenerate_faces, edge_vectors, incident_vertices, row_dot
from lbskel.operators.intrinsic_delaunay import require_orientation
from lbskel.operators.masses import voronoi_mass

# Damping per unit of relative curvature, no unit. A guess, which halves diffusion at the curvature of the sphere.
STRENGTH = 1.0


@dataclass(frozen=True, eq=False)
class _Frames:
    """An orthonormal frame of each triangle: (m, 3) axes x and y, and (3, m) coordinates u, v of its edges."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    u: NDArray[np.float64]
    v: NDArray[np.float64]


def _frames(edges: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]) -> _Frames:
    a, _, c = edges
    with np.errstate(divide="ignore", invalid="ignore"):
        x = c / np.sqrt(row_dot(c, c))[:, None]
        y = a - row_dot(a, x)[:, None] * x
        y /= np.sqrt(row_dot(y, y))[:, None]
    return _Frames(x, y, np.stack([row_dot(e, x) for e in edges]), np.stack([row_dot(e, y) for e in edges]))


def shape_operators(mesh: Mesh) -> NDArray[np.float64]:
    """Compute the (3, m) entries xx, xy, yy of each face's shape operator in its own frame; zero where degenerate.

    Curvatures are those of the mesh scaled by :func:`~lbskel.geometry.scaling.unit_scale`. Its faces must be oriented
    consistently.

    Parameters
    ----------
    mesh : Mesh
    """
    return _shape_operators(mesh, _frames(edge_vectors(mesh)))


def _shape_operators(mesh: Mesh, frames: _Frames) -> NDArray[np.float64]:
    """Fit the symmetric K for which K e is closest to the change of the normal along each edge e (three unknowns)."""
    N = igl.per_vertex_normals(unit_vertices(mesh)[0], mesh.faces)
    N = np.where(np.isfinite(N), N, 0.0)  # NaN where all faces of a vertex are so small that their areas underflow
    A, B, C = (N[mesh.faces[:, k]] for k in range(3))
    differences, u, v = (C - B, A - C, B - A), frames.u, frames.v
    p, q = (np.stack([row_dot(difference, axis) for difference in differences]) for axis in (frames.x, frames.y))
    uu, uv, vv, pu, pv, qu, qv = (
        np.einsum("em,em->m", s, t) for s, t in ((u, u), (u, v), (v, v), (p, u), (p, v), (q, u), (q, v))
    )
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        xy = (pv + qu - uv * (pu / uu + qv / vv)) / ((uu + vv) * (1 - uv**2 / (uu * vv)))
        K = np.stack([(pu - uv * xy) / uu, xy, (qv - uv * xy) / vv])
    return np.where(np.isfinite(K).all(axis=0), K, 0.0)


def _diffusion(K: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the (3, m) entries xx, xy, yy of (I + |K|)^-1 from the eigenvalues mean +- deviation of K."""
    xx, xy, yy = K
    mean, deviation = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    high, low = 1 / (1 + np.abs(mean + deviation)), 1 / (1 + np.abs(mean - deviation))
    slope = np.divide((high - low) / 2, deviation, out=np.zeros_like(deviation), where=deviation > 0)
    middle = (high + low) / 2
    return np.stack([middle + slope * (xx - yy) / 2, slope * xy, middle - slope * (xx - yy) / 2])


def anisotropic(mesh: Mesh, *, strength: float = STRENGTH) -> Laplacian:
    """Build the anisotropic Laplacian with the Voronoi mass.

    Parameters
    ----------
    mesh : Mesh
        Its faces are oriented consistently first, since curvature follows from the normals of vertices.
    strength : float
        s, the damping per unit of curvature relative to a sphere of the mesh's area; 0 gives the cotangent Laplacian.

    Raises
    ------
    MeshError
        If a face uses a vertex twice, an edge has more than two faces, or the mesh cannot be oriented.
    """
    mesh = Mesh(mesh.vertices, require_orientation(mesh, "anisotropic")[0])
    edges = edge_vectors(mesh)
    frames = _frames(edges)
    double_area = corner_products(unit_vertices(mesh)[0], mesh.faces)[2]
    radius = np.sqrt(double_area.sum() / (8 * np.pi))
    xx, xy, yy = _diffusion(strength * radius * _shape_operators(mesh, frames))
    # The gradient of a hat function is the opposite edge rotated by 90 degrees over twice the area: D rotates as well.
    u, v = frames.u, frames.v
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rotated_u, rotated_v = yy * u - xy * v, xx * v - xy * u
        weights = [
            -(u[i] * rotated_u[j] + v[i] * rotated_v[j]) / (2 * double_area) for i, j in ((1, 2), (2, 0), (0, 1))
        ]
    is_degenerate = degenerate_faces(mesh)[:, None]
    corner_weights = np.where(is_degenerate, 0.0, np.stack(weights, axis=1))
    stiffness = stiffness_of_corner_weights(len(mesh.vertices), mesh.faces, corner_weights)
    return Laplacian(stiffness, voronoi_mass(mesh), treated_vertices=incident_vertices(mesh, is_degenerate))
