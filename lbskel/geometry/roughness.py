"""Roughness: the height of noise on a surface, relative to its edge length.

With x the vertices, P x the mean of each vertex's neighbors, n the normals of the surface (x + P x) / 2, and e the mean
length of a vertex's edges, roughness is

    median | n . (I - P)^2 x | / e

It is small for a smooth surface, which lies near P x and nearer still to P (2 I - P) x. Creases have few of the
vertices and hardly change the median. Noise along the normals with a standard deviation of s edge lengths gives 0.9 s;
less where it makes edges steep, and never more than 0.65. Where neighbors move together, as the corners of a voxel do,
this is too low; so the same is measured of (x + P x) / 2, relative to what independent noise leaves there, and the
larger of the two is taken.

The operator is that of Taubin 1995, "A signal processing approach to fair surface design",
https://doi.org/10.1145/218380.218473.
"""

from __future__ import annotations

__all__ = ["ROUGHNESS_LIMIT", "evenness", "roughness"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.connectivity import neighbor_sums
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_vertices
from lbskel.geometry.surface_queries import Surface

# Roughness, in edge lengths, above which a surface is smoothed: noise with a standard deviation of a sixth of an edge,
# where skeletons are as accurate with smoothing as without. benchmarks/results/noise.md
ROUGHNESS_LIMIT = 0.15

MIN_VERTICES = 500  # vertices below which noise and detail are not told apart, and roughness is 0; a guess

# What the mean with the neighbors, (I + P) / 2, leaves at most of the height of independent noise, as measured above:
# 0.356 on the triangular lattice, by its closed walks; by hand, 0.34 to 0.393 on the 34 meshes of benchmarks/noise.py
# and gallery_meshes.py with noise of 0.15 to 0.3 edges, whose roughness is thus that of x, not of (x + P x) / 2
LEFT_BY_MEAN = 0.4

MAX_SAMPLES = 5000  # vertices, at most about this many, whose median is taken; a guess that bounds the time

# Lower bound on the shortest edge over the longest one at a vertex, the median over the vertices. Where edges are less
# even, the mean of the neighbors tells nothing of noise: the edges of constructed parts follow their shape. 25 meshes
# with noise have at least 0.294, "evenness, least" in benchmarks/results/noise.md; by hand, 23 constructed parts, whose
# vertices smoothing moved by 0.4 to 4.8 local radii, have at most 0.26
MIN_EVENNESS = 0.275

# Largest deviation from 1/2 of the fraction of vertices that noise moves outwards. Noise moves half of them outwards,
# spikes on every face two thirds. A guess.
MAX_ASYMMETRY = 0.1


def roughness(mesh: Mesh) -> float:
    """Measure the roughness of a surface, in edge lengths; 0 where noise cannot be told from detail.

    The value is cached in the mesh.

    Parameters
    ----------
    mesh : Mesh
        With vertices that are shared by faces, not a triangle soup.

    Examples
    --------
    >>> import numpy as np
    >>> from lbskel.shapes import torus
    >>> smooth = torus(1.0, 0.3, 48, 24)
    >>> noise = np.random.default_rng(0).normal(scale=0.1, size=smooth.vertices.shape)
    >>> roughness(smooth) < ROUGHNESS_LIMIT < roughness(smooth.with_vertices(smooth.vertices + noise))
    True
    """
    return float(Surface(mesh).memoize("roughness", lambda: _roughness(mesh)))


def _roughness(mesh: Mesh) -> float:
    """Measure the roughness of a surface."""
    used = mesh.used_vertices
    if len(used) < MIN_VERTICES:
        return 0.0
    sample, V = used[:: 1 + len(used) // MAX_SAMPLES], unit_vertices(mesh)[0]
    is_near = np.zeros(len(V), dtype=bool)
    is_near[sample] = True
    A, B, C = mesh.faces.T
    for _ in range(2):  # rings around the sample, on whose vertices the mean with the neighbors must be right
        faces = mesh.faces[is_near[A] | is_near[B] | is_near[C]]
        is_near[faces] = True
    i, j = mesh.edges.T
    edges = mesh.edges[is_near[i] | is_near[j]]  # all edges at the vertices of the rings
    degrees = np.maximum(np.bincount(edges.ravel(), minlength=len(V)), 1)

    def residual(X: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 3) (I - P) X, without a sparse matrix, which would take longer to assemble than to apply twice."""
        difference: NDArray[np.float64] = X - neighbor_sums(edges, X) / degrees[:, None]
        return difference

    def heights(X: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) how far each vertex of the sample stands out of the surface X."""
        first_difference = residual(X)
        normals = np.nan_to_num(igl.per_vertex_normals(X - first_difference / 2, faces))
        out: NDArray[np.float64] = np.einsum("ij,ij->i", residual(first_difference), normals)[sample]
        return out

    fine, coarse = heights(V), heights(V - residual(V) / 2)
    along = V[edges[:, 0]] - V[edges[:, 1]]
    lengths = np.repeat(np.sqrt(np.einsum("ei,ei->e", along, along)), 2)
    edge = (np.bincount(edges.ravel(), lengths, len(V)) / degrees)[sample]
    has_edge = edge > 0
    if abs((fine > 0).mean() - 0.5) > MAX_ASYMMETRY or not has_edge.any():
        return 0.0
    if np.median(evenness(edges, lengths[::2], len(V))[sample][has_edge]) < MIN_EVENNESS:
        return 0.0
    shares = [np.median(np.abs(each[has_edge]) / edge[has_edge]) for each in (fine, coarse / LEFT_BY_MEAN)]
    return float(max(shares))


def evenness(edges: NDArray[np.int64], lengths: NDArray[np.float64], n: int) -> NDArray[np.float64]:
    """(n,) the shortest edge at each of n vertices over the longest; infinite without an edge.

    Parameters
    ----------
    edges : (e, 2) array of int
    lengths : (e,) array of float
    n : int
    """
    shortest, longest = np.full(n, np.inf), np.zeros(n)
    for ends in edges.T:
        np.minimum.at(shortest, ends, lengths)
        np.maximum.at(longest, ends, lengths)
    np.divide(shortest, longest, out=shortest, where=longest > 0)
    return shortest
