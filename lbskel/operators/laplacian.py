"""The value that every discrete Laplacian comes in: a stiffness matrix and a mass matrix.

Weak form, positive semidefinite: ``stiffness`` S has -w_ij off its diagonal and rows that sum to zero, ``mass`` M holds
the areas, and M^-1 S approximates minus the Laplace-Beltrami operator (algorithms.md of the project, section 0;
Reuter et al. 2009, https://doi.org/10.1016/j.cag.2009.03.005).
"""

from __future__ import annotations

__all__ = ["Laplacian"]

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array


@dataclass(frozen=True, eq=False)
class Laplacian:
    """A discrete Laplace-Beltrami operator on the vertices of its mesh.

    Parameters
    ----------
    stiffness : (n, n) csc_array
        S, positive semidefinite wherever the operator is, rows sum to zero.
    mass : (n, n) csc_array
        M, the area of each vertex on the diagonal.
    treated_vertices : (t,) array of int
        Vertices whose row a guard changed because a triangle there was degenerate; empty where none was needed.
    n_clamped_angles : int
        Number of angles that a guard moved.
    """

    stiffness: csc_array
    mass: csc_array
    treated_vertices: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    n_clamped_angles: int = 0
