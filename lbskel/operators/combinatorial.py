"""The graph Laplacian S = D - A, w_ij = 1, and that of the random walk on it: connectivity alone, blind to shape.

Taubin 1995, "A signal processing approach to fair surface design", https://doi.org/10.1145/218380.218473.
"""

from __future__ import annotations

__all__ = ["graph", "random_walk"]

import numpy as np
from scipy.sparse import csc_array

from lbskel.geometry.mesh import Mesh
from lbskel.operators.assembly import diagonal_matrix, stiffness_of_pairs
from lbskel.operators.base import Laplacian
from lbskel.operators.masses import voronoi_mass


def _degrees_less_adjacency(mesh: Mesh) -> csc_array:
    """D - A."""
    i, j = mesh.edges.T
    return stiffness_of_pairs(len(mesh.vertices), i, j, np.ones(len(i)))


def graph(mesh: Mesh) -> Laplacian:
    """The graph Laplacian D - A with the Voronoi mass."""
    return Laplacian(_degrees_less_adjacency(mesh), voronoi_mass(mesh))


def random_walk(mesh: Mesh) -> Laplacian:
    """D - A with the degrees as mass, so that the strong form is I - D^-1 A: a vertex less its neighbors' mean."""
    stiffness = _degrees_less_adjacency(mesh)
    return Laplacian(stiffness, diagonal_matrix(stiffness.diagonal()))
