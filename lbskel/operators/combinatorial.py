"""The graph Laplacian S = D - A with unit weights, and the random-walk Laplacian: connectivity without geometry.

Taubin 1995, "A signal processing approach to fair surface design", https://doi.org/10.1145/218380.218473.
"""

from __future__ import annotations

__all__ = ["graph", "random_walk"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.geometry.mesh import Mesh
from lbskel.operators.assembly import diagonal_matrix, symmetric_matrix
from lbskel.operators.base import Laplacian
from lbskel.operators.masses import voronoi_mass


def _degrees_minus_adjacency(mesh: Mesh) -> tuple[csc_array, NDArray[np.int64]]:
    """Build D - A, and the (n,) degrees on the diagonal of D."""
    n = len(mesh.vertices)
    # only the pattern is used; -inf keeps the entries on the diagonal negative, where faces that use a vertex twice add
    # ones, and all other entries are positive
    matrix = symmetric_matrix(mesh.faces, np.ones((len(mesh.faces), 3)), np.full(n, -np.inf))
    degrees = np.diff(matrix.indptr).astype(np.int64) - 1
    is_diagonal = matrix.data < 0
    matrix.data.fill(-1.0)
    matrix.data[is_diagonal] = degrees
    if not degrees.all():
        matrix.eliminate_zeros()
    return matrix, degrees


def graph(mesh: Mesh) -> Laplacian:
    """Build the graph Laplacian D - A with the Voronoi mass."""
    return Laplacian(_degrees_minus_adjacency(mesh)[0], voronoi_mass(mesh))


def random_walk(mesh: Mesh) -> Laplacian:
    """Build D - A with the degrees as mass: the strong form is I - D^-1 A, a value minus the mean of its neighbors'."""
    stiffness, degrees = _degrees_minus_adjacency(mesh)
    return Laplacian(stiffness, diagonal_matrix(degrees), mass_unit="number")
