"""The graph Laplacian S = D - A with unit weights, and the random-walk Laplacian: connectivity without geometry.

Taubin 1995, "A signal processing approach to fair surface design", https://doi.org/10.1145/218380.218473.
"""

from __future__ import annotations

__all__ = ["graph", "random_walk"]

import numpy as np
from scipy.sparse import csc_array

from lbskel.geometry.mesh import Mesh
from lbskel.operators.assembly import diagonal_matrix, symmetric_matrix
from lbskel.operators.base import Laplacian
from lbskel.operators.masses import voronoi_mass


def _degrees_minus_adjacency(mesh: Mesh) -> csc_array:
    """Build D - A."""
    n = len(mesh.vertices)
    matrix = symmetric_matrix(mesh.faces, np.ones((len(mesh.faces), 3)), np.ones(n))  # for its pattern
    entries = np.diff(matrix.indptr)
    is_diagonal = matrix.indices == np.repeat(np.arange(n, dtype=matrix.indices.dtype), entries)
    matrix.data.fill(-1.0)
    matrix.data[is_diagonal] = entries - 1
    if (entries == 1).any():
        matrix.eliminate_zeros()
    return matrix


def graph(mesh: Mesh) -> Laplacian:
    """Build the graph Laplacian D - A with the Voronoi mass."""
    return Laplacian(_degrees_minus_adjacency(mesh), voronoi_mass(mesh))


def random_walk(mesh: Mesh) -> Laplacian:
    """Build D - A with the degrees as mass: the strong form is I - D^-1 A, a vertex minus its neighbors' mean."""
    stiffness = _degrees_minus_adjacency(mesh)
    return Laplacian(stiffness, diagonal_matrix(stiffness.diagonal()))
