"""The heat kernel Laplacian: w_ij = A_i A_j exp(-|x_i - x_j|^2 / 4t) / (4 pi t^2), blind to the triangles' shape.

Belkin, Sun, Wang 2008, "Discrete Laplace operator on meshed surfaces", https://doi.org/10.1145/1377676.1377725. It
converges pointwise on any mesh when t goes to zero more slowly than the square of the edge length. The kernel is cut
off at r = c sqrt(2t); of a plane's |x|^2 it then sees only 1 - (1 + c^2/2) exp(-c^2/2), by which it is divided.
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

TIME = 1.0
CUT_OFF = 3.0


def heat_kernel_stiffness(
    points: NDArray[np.float64], areas: NDArray[np.float64], time: float, cut_off: float
) -> csc_array:
    """D - W of points with areas, for a time in squares of the points' unit."""
    i, j = KDTree(points).query_pairs(cut_off * np.sqrt(2 * time), output_type="ndarray").T
    squares = ((points[i] - points[j]) ** 2).sum(axis=1)
    seen = 1 - (1 + cut_off**2 / 2) * np.exp(-(cut_off**2) / 2)
    weights = areas[i] * areas[j] * np.exp(-squares / (4 * time)) / (4 * np.pi * time**2 * seen)
    return stiffness_of_pairs(len(points), i, j, weights)


def heat_kernel(mesh: Mesh, *, time: float = TIME, cut_off: float = CUT_OFF) -> Laplacian:
    """The heat kernel Laplacian with the barycentric mass.

    Parameters
    ----------
    mesh : Mesh
    time : float
        t in squares of the mean edge length. For pointwise convergence let it grow as the mesh is refined, for example
        with the inverse of the edge length.
    cut_off : float
        Where the kernel ends, in sqrt(2t).
    """
    V, k = unit_scale(mesh.vertices)
    edge = igl.edge_lengths(V, mesh.faces).mean()
    mass = barycentric_mass(mesh)
    n = len(V)
    if edge == 0:
        return Laplacian(csc_array((n, n)), mass, treated_vertices=np.unique(mesh.faces))
    stiffness = heat_kernel_stiffness(V, np.ldexp(mass.diagonal(), -2 * k), time * edge**2, cut_off)
    return Laplacian(stiffness, mass)
