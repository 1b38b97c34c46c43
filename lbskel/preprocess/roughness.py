"""How rough a surface is: its second differences across itself against its edges, which noise has and no shape.

With x the vertices, P x the mean of each one's neighbours, n the normals of the surface half smoothed by that, and e
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

from lbskel.mesh import Mesh
from lbskel.operators.corners import unit_scale
from lbskel.operators.graph import random_walk

ROUGH = 0.3  # beyond: noise of a third of an edge; of a quarter it is 0.22 to 0.25, of scans and models up to 0.1
FEWEST_VERTICES = 500  # that tell noise from shape: of fewer each may be meant
LOPSIDED = 0.1  # noise stands out at half of the vertices, but for this share; spikes on every face, at two thirds


def roughness(mesh: Mesh) -> float:
    """The roughness of a surface; 0 where what is rough may be its shape.

    Parameters
    ----------
    mesh : Mesh
        With vertices that its faces share.

    Examples
    --------
    >>> from lbskel.shapes import torus
    >>> round(roughness(torus(1.0, 0.3, 48, 24)), 2)
    0.01
    """
    used = mesh.used_vertices
    if len(used) < FEWEST_VERTICES:
        return 0.0
    V, (i, j) = unit_scale(mesh.vertices)[0], mesh.edges.T
    walk = random_walk(mesh).strong()
    once = walk @ V
    normals = np.nan_to_num(igl.per_vertex_normals(V - once / 2, mesh.faces))
    heights = np.einsum("ij,ij->i", walk @ once, normals)[used]
    lengths = np.linalg.norm(V[i] - V[j], axis=1)
    ends = mesh.edges.T.ravel()
    edge = (np.bincount(ends, np.tile(lengths, 2), len(V)) / np.maximum(np.bincount(ends, minlength=len(V)), 1))[used]
    has_edge = edge > 0
    if abs((heights > 0).mean() - 0.5) > LOPSIDED or not has_edge.any():
        return 0.0
    return float(np.median(np.abs(heights[has_edge]) / edge[has_edge]))
