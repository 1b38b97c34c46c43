"""The heat kernel Laplacian: w_ij = A_i A_j exp(-|x_i - x_j|^2 / 4t) / (4 pi t^2), independent of triangle shape.

Belkin, Sun, Wang 2008, "Discrete Laplace operator on meshed surfaces", https://doi.org/10.1145/1377676.1377725. They
prove pointwise convergence, whatever the shape of the triangles, for t = h^(1 / (2.5 + a)) with any a > 0, where h
bounds the edge lengths and the errors of the normals. The kernel is cut off at r = c sqrt(2t). Within this radius it
captures the fraction 1 - (1 + c^2/2) exp(-c^2/2) of the second moment |x|^2 of a plane; the weights are divided by this
fraction.
"""

from __future__ import annotations

__all__ = ["heat_kernel", "heat_kernel_stiffness", "median_length"]

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.spatial import KDTree

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import stiffness_of_pairs
from lbskel.operators.base import Laplacian
from lbskel.operators.masses import barycentric_mass

TIME = 1.0  # t in squared median edge lengths; a guess, the lower end of the customary range of 1 to 4
# Radius of the kernel in sqrt(2t), 95.2 % of the second moment; a guess, the customary range is 3 to 4. At 3, the
# rounding of a rotation would decide about points of a grid that are 3 sqrt(2) edges apart; at 3.1 there are none.
CUT_OFF = 3.1
# Upper bound on the coupled pairs, each of which takes 170 bytes while the matrix is built, as measured: 8.5 GB. An
# even mesh of 1.6 million vertices has as many.
MAX_PAIRS = 50_000_000


def heat_kernel_stiffness(
    points: NDArray[np.float64], areas: NDArray[np.float64], time: float, cut_off: float
) -> csc_array:
    """Build the stiffness D - W of the heat kernel weights.

    Parameters
    ----------
    points : (n, 3) array of float
    areas : (n,) array of float
        The area of each point.
    time : float
        t, in squared units of the points.
    cut_off : float
        Radius of the kernel, in sqrt(2t).

    Raises
    ------
    MeshError
        If the kernel would couple so many pairs of points that memory might run out.
    """
    tree, radius = KDTree(points), cut_off * np.sqrt(2 * time)
    n = len(points)
    if n * (n - 1) // 2 > MAX_PAIRS and (n_pairs := (int(tree.count_neighbors(tree, radius)) - n) // 2) > MAX_PAIRS:
        raise MeshError(
            f"the heat kernel would couple {n_pairs:,} pairs of {n:,} points, at most {MAX_PAIRS:,}: its radius is too "
            "large where they are dense; give a smaller time or cut_off, thin them out, or use the operator 'robust'"
        )
    i, j = tree.query_pairs(radius, output_type="ndarray").T
    squared_distances = ((points[i] - points[j]) ** 2).sum(axis=1)
    captured = 1 - (1 + cut_off**2 / 2) * np.exp(-(cut_off**2) / 2)
    weights = areas[i] * areas[j] * np.exp(-squared_distances / (4 * time)) / (4 * np.pi * time**2 * captured)
    return stiffness_of_pairs(n, i, j, weights)


def median_length(lengths: NDArray[np.float64]) -> float:
    """Return the median of the lengths that are not zero; zero if all are.

    Unlike the mean, it does not grow with one long edge, as to a point far away.

    Parameters
    ----------
    lengths : array of float
    """
    return float(np.median(lengths[lengths > 0])) if lengths.any() else 0.0


def heat_kernel(mesh: Mesh, *, time: float = TIME, cut_off: float = CUT_OFF) -> Laplacian:
    """Build the heat kernel Laplacian with the barycentric mass.

    The kernel has one radius on the whole mesh, 4.4 median edges by default. Vertices that are farther from all others,
    as in the coarse parts of a mesh that is mostly fine, are coupled with none, and are listed as treated.

    Parameters
    ----------
    mesh : Mesh
    time : float
        t in squared median edge lengths. For pointwise convergence let it grow as the mesh is refined, as
        benchmarks/operators_convergence.py does with the inverse of the edge length.
    cut_off : float
        Radius of the kernel, in sqrt(2t).

    Raises
    ------
    MeshError
        If the kernel would couple so many pairs of vertices that memory might run out.
    """
    V, k = unit_scale(mesh.vertices)
    length = median_length(igl.edge_lengths(V, mesh.faces))
    mass = barycentric_mass(mesh)
    n = len(V)
    if length == 0:
        return Laplacian(csc_array((n, n)), mass, treated_vertices=np.unique(mesh.faces))
    stiffness = heat_kernel_stiffness(V, np.ldexp(mass.diagonal(), -2 * k), time * length**2, cut_off)
    used = mesh.used_vertices
    return Laplacian(stiffness, mass, treated_vertices=used[stiffness.diagonal()[used] == 0])
