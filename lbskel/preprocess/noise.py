"""How rough a surface is: its second differences across itself against its edges, which noise has and no shape.

With x the vertices, P x the mean of each one's neighbors, n the normals of the surface half smoothed by that, and e
the mean length of a vertex's edges, roughness is

    median | n . (I - P)^2 x | / e

A curved surface lies near P x and even nearer P (2 I - P) x, and a crease has few of the vertices; noise along the
normals with a standard deviation of s edges has 0.9 s, from where edges become steep less, and never over 0.65.

The operator is that of Taubin 1995, "A signal processing approach to fair surface design",
https://doi.org/10.1145/218380.218473.
"""

from __future__ import annotations

__all__ = ["ROUGH", "roughness"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.connectivity import neighbor_sums
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale

ROUGH = 0.3  # beyond: noise of a third of an edge; of a quarter it is 0.22 to 0.25, of scans and models up to 0.1
FEWEST_VERTICES = 500  # that tell noise from shape: of fewer each may be meant
SAMPLES = 5000  # vertices at most that are looked at
LOPSIDED = 0.1  # noise stands out at half of the vertices, but for this share; spikes on every face, at two thirds


def roughness(mesh: Mesh) -> float:
    """The roughness of a surface; 0 where what is rough may be its shape.

    Parameters
    ----------
    mesh : Mesh
        With vertices that its faces share.

    Examples
    --------
    >>> import numpy as np
    >>> from lbskel.shapes import torus
    >>> smooth = torus(1.0, 0.3, 48, 24)
    >>> noise = np.random.default_rng(0).normal(scale=0.1, size=smooth.vertices.shape)
    >>> roughness(smooth) < ROUGH < roughness(smooth.with_vertices(smooth.vertices + noise))
    True
    """
    used = mesh.used_vertices
    if len(used) < FEWEST_VERTICES:
        return 0.0
    sample, V = used[:: 1 + len(used) // SAMPLES], unit_scale(mesh.vertices)[0]
    is_near = np.zeros(len(V), dtype=bool)
    is_near[sample] = True
    A, B, C = mesh.faces.T
    faces = mesh.faces[is_near[A] | is_near[B] | is_near[C]]
    is_near[faces] = True
    i, j = mesh.edges.T
    edges = mesh.edges[is_near[i] | is_near[j]]  # all that the mean of a near vertex's neighbors needs
    degrees = np.maximum(np.bincount(edges.ravel(), minlength=len(V)), 1)

    def residual(X: NDArray[np.float64]) -> NDArray[np.float64]:
        """(I - P) X, without a matrix, which takes longer to set up than to use twice."""
        return X - neighbor_sums(edges, X) / degrees[:, None]

    once = residual(V)
    normals = np.nan_to_num(igl.per_vertex_normals(V - once / 2, faces))
    heights = np.einsum("ij,ij->i", residual(once), normals)[sample]
    along = V[edges[:, 0]] - V[edges[:, 1]]
    lengths = np.repeat(np.sqrt(np.einsum("ei,ei->e", along, along)), 2)
    edge = (np.bincount(edges.ravel(), lengths, len(V)) / degrees)[sample]
    has_edge = edge > 0
    if abs((heights > 0).mean() - 0.5) > LOPSIDED or not has_edge.any():
        return 0.0
    return float(np.median(np.abs(heights[has_edge]) / edge[has_edge]))
