"""The heat kernel Laplacian: w_ij = A_i A_j exp(-|x_i - x_j|^2 / 4t) / (4 pi t^2), independent of triangle shape.

Belkin, Sun, Wang 2008, "Discrete Laplace operator on meshed surfaces", https://doi.org/10.1145/1377676.1377725. They
prove pointwise convergence, whatever the shape of the triangles, for t = h^(1 / (2.5 + a)) with any a > 0, where h
bounds the edge lengths and the errors of the normals. The kernel is cut off at r = c sqrt(2t). Within this radius it
captures the fraction 1 - (1 + c^2/2) exp(-c^2/2) of the second moment |x|^2 of a plane; the weights are divided by this
fraction.
"""

from __future__ import annotations

__all__ = ["heat_kernel", "heat_kernel_stiffness"]

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.spatial import KDTree

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators.assembly import stiffness_of_pairs
from lbskel.operators.base import Laplacian
from lbskel.operators.masses import barycentric_mass

TIME = 1.0  # t in squared mean edge lengths; a guess, the lower end of the customary range of 1 to 4
CUT_OFF = 3.0  # radius of the kernel in sqrt(2t), 93.9 % of the second moment; a guess, the customary range is 3 to 4


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
    """
    i, j = KDTree(points).query_pairs(cut_off * np.sqrt(2 * time), output_type="ndarray").T
    squared_distances = ((points[i] - points[j]) ** 2).sum(axis=1)
    captured = 1 - (1 + cut_off**2 / 2) * np.exp(-(cut_off**2) / 2)
    weights = areas[i] * areas[j] * np.exp(-squared_distances / (4 * time)) / (4 * np.pi * time**2 * captured)
    return stiffness_of_pairs(len(points), i, j, weights)


def heat_kernel(mesh: Mesh, *, time: float = TIME, cut_off: float = CUT_OFF) -> Laplacian:
    """Build the heat kernel Laplacian with the barycentric mass.

    Parameters
    ----------
    mesh : Mesh
    time : float
        t in squared mean edge lengths. For pointwise convergence let it grow as the mesh is refined, as
        benchmarks/operators_convergence.py does with the inverse of the edge length.
    cut_off : float
        Radius of the kernel, in sqrt(2t).
    """
    V, k = unit_scale(mesh.vertices)
    mean_edge = igl.edge_lengths(V, mesh.faces).mean()
    mass = barycentric_mass(mesh)
    n = len(V)
    if mean_edge == 0:
        return Laplacian(csc_array((n, n)), mass, treated_vertices=np.unique(mesh.faces))
    stiffness = heat_kernel_stiffness(V, np.ldexp(mass.diagonal(), -2 * k), time * mean_edge**2, cut_off)
    return Laplacian(stiffness, mass)
