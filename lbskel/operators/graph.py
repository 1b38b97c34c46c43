"""The graph Laplacian S = D - A, w_ij = 1: connectivity alone, blind to shape.

Taubin 1995, "A signal processing approach to fair surface design", https://doi.org/10.1145/218380.218473.
"""

from __future__ import annotations

__all__ = ["graph", "stiffness_of_edge_weights"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from lbskel.mesh import Mesh
from lbskel.operators.laplacian import Laplacian
from lbskel.operators.masses import voronoi_mass


def stiffness_of_edge_weights(mesh: Mesh, weights: NDArray[np.float64]) -> csc_array:
    """S with -w_ij off the diagonal and the sums of the weights on it, one weight for each of ``mesh.edges``."""
    n = len(mesh.vertices)
    i, j = mesh.edges.T
    rows = np.concatenate([i, j, i, j])
    columns = np.concatenate([j, i, i, j])
    entries = np.concatenate([-weights, -weights, weights, weights])
    return coo_array((entries, (rows, columns)), shape=(n, n)).tocsc()


def graph(mesh: Mesh) -> Laplacian:
    """The graph Laplacian D - A with the Voronoi mass."""
    return Laplacian(stiffness_of_edge_weights(mesh, np.ones(len(mesh.edges))), voronoi_mass(mesh))
