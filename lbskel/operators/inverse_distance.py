"""The scale-dependent umbrella operator: w_ij = 1 / |e_ij|.

Fujiwara 1995, "Eigenvalues of Laplacians on a closed Riemannian manifold and its nets", Proceedings of the AMS 123(8).
The strong form (4 / E_i) sum_j (u_i - u_j) / |e_ij|, with E_i the sum of the lengths of the edges at i, is twice that
of Desbrun et al. 1999 (https://doi.org/10.1145/311535.311576): in a plane the second derivative averaged over all
directions is half the Laplacian.
"""

from __future__ import annotations

__all__ = ["inverse_distance"]

import numpy as np

from lbskel.geometry.mesh import Mesh
from lbskel.operators.assembly import stiffness_of_pairs
from lbskel.operators.base import Laplacian
from lbskel.operators.masses import moment_mass


def inverse_distance(mesh: Mesh) -> Laplacian:
    """Build the Laplacian with weights 1 / |e_ij| and mass E_i / 4; an edge of length zero has weight zero."""
    i, j = mesh.edges.T
    lengths = mesh.edge_lengths
    has_length = lengths > np.finfo(np.float64).eps * np.abs(mesh.vertices[mesh.used_vertices]).max()
    weights = np.divide(1.0, lengths, out=np.zeros_like(lengths), where=has_length)
    stiffness = stiffness_of_pairs(len(mesh.vertices), i, j, weights)
    treated = np.unique(mesh.edges[~has_length & (i != j)])
    return Laplacian(stiffness, moment_mass(mesh, stiffness), treated_vertices=treated, mass_unit="length")
