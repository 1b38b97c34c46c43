"""The anisotropic Laplacian: diffusion slowed down along the directions in which the surface bends.

Andreux, Rodola, Aubry, Cremers 2014, "Anisotropic Laplace-Beltrami operators for shape analysis",
https://doi.org/10.1007/978-3-319-16220-1_21. In each triangle the gradient is multiplied by D = (I + s |K|)^-1, with K
the 2 x 2 shape operator; S_ij = grad_i . D grad_j A. Strength s = 0, or a plane, gives the cotangent Laplacian. (LaPy
damps by exp(-s |K|), which at a crease leaves entries of 1e-76 and a null space of any size.) K is the least-squares
fit to the differences of the vertex normals along the edges (Rusinkiewicz 2004,
https://doi.org/10.1109/TDPVT.2004.1335277), relative to the curvature of a sphere of the mesh's area.
"""

from __future__ import annotations

__all__ = ["anisotropic", "shape_operators"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.mesh import Mesh
from lbskel.operators.assembly import stiffness_of_corner_weights
from lbskel.operators.corners import (
    double_areas,
    edge_vectors,
    products,
    touched_vertices,
    unit_scale,
    without_degenerate,
)
from lbskel.operators.laplacian import Laplacian
from lbskel.operators.masses import voronoi_mass

STRENGTH = 1.0

Edges = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def _in_plane(edges: Edges) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(3, m, 2) the edges in an orthonormal frame of their triangle, and the frame's two (m, 3) axes."""
    a, _, c = edges
    with np.errstate(divide="ignore", invalid="ignore"):
        x = c / np.sqrt(products(c, c))[:, None]
        y = a - products(a, x)[:, None] * x
        y /= np.sqrt(products(y, y))[:, None]
    return np.stack([np.stack([products(e, x), products(e, y)], axis=1) for e in edges]), x, y


def shape_operators(mesh: Mesh) -> NDArray[np.float64]:
    """(3, m) entries xx, xy, yy of the shape operator of each face in its own frame; zero where it is degenerate.

    Curvatures are those of the mesh scaled by :func:`~lbskel.operators.corners.unit_scale`.
    """
    F = mesh.faces
    N = np.nan_to_num(igl.per_vertex_normals(unit_scale(mesh.vertices)[0], F))
    E, x, y = _in_plane(edge_vectors(mesh))
    turns = (N[F[:, 2]] - N[F[:, 1]], N[F[:, 0]] - N[F[:, 2]], N[F[:, 1]] - N[F[:, 0]])
    T = np.stack([np.stack([products(t, x), products(t, y)], axis=1) for t in turns])
    (uu, uv), (_, vv) = np.einsum("emi,emj->ijm", E, E)
    (b_xx, b_xy), (b_yx, b_yy) = np.einsum("emi,emj->ijm", T, E)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        xy = (b_xy + b_yx - uv * (b_xx / uu + b_yy / vv)) / ((uu + vv) * (1 - uv**2 / (uu * vv)))
        K = np.stack([(b_xx - uv * xy) / uu, xy, (b_yy - uv * xy) / vv])
    return np.where(np.isfinite(K).all(axis=0), K, 0.0)


def _diffusion(K: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, m) entries xx, xy, yy of (I + |K|)^-1, from the eigenvalues mean + spread and mean - spread of K."""
    xx, xy, yy = K
    mean, spread = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    high, low = 1 / (1 + np.abs(mean + spread)), 1 / (1 + np.abs(mean - spread))
    slope = np.divide((high - low) / 2, spread, out=np.zeros_like(spread), where=spread > 0)
    middle = (high + low) / 2
    return np.stack([middle + slope * (xx - yy) / 2, slope * xy, middle - slope * (xx - yy) / 2])


def anisotropic(mesh: Mesh, *, strength: float = STRENGTH) -> Laplacian:
    """The anisotropic Laplacian with the Voronoi mass.

    Parameters
    ----------
    mesh : Mesh
    strength : float
        s, the damping for each unit of curvature.
    """
    edges = edge_vectors(mesh)
    E = _in_plane(edges)[0]
    double_area = double_areas(*edges)
    radius = np.sqrt(double_area.sum() / (8 * np.pi))
    xx, xy, yy = _diffusion(strength * radius * shape_operators(mesh))
    # The gradient of a hat function is the opposite edge turned by 90 degrees over twice the area, so D turns as well.
    turned = np.stack([yy * E[..., 0] - xy * E[..., 1], xx * E[..., 1] - xy * E[..., 0]], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        halves = [-products(E[i], turned[j]) / (2 * double_area) for i, j in ((1, 2), (2, 0), (0, 1))]
    weights, degenerate = without_degenerate(np.stack(halves, axis=1))
    stiffness = stiffness_of_corner_weights(len(mesh.vertices), mesh.faces, weights)
    return Laplacian(stiffness, voronoi_mass(mesh), treated_vertices=touched_vertices(mesh, degenerate))
