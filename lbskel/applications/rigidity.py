"""The as-rigid-as-possible energy of a deformation, and its two alternating steps.

E(X) = sum_i sum_j w_ij |(x_i - x_j) - R_i (v_i - v_j)|^2 over the neighbors j of each vertex i, with the rotations R_i
that make it smallest. Local step: R_i is the rotation closest to sum_j w_ij (x_i - x_j) (v_i - v_j)^T. Global step:
S X = C^T R / 2, where C is the matrix that maps X to these sums, and S is factorized once. Sorkine, Alexa 2007,
"As-rigid-as-possible surface modeling", equations 3, 5 and 9, https://doi.org/10.2312/SGP/SGP07/109-116.
"""

from __future__ import annotations

__all__ = ["RigidityEnergy"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, csr_array

from lbskel.applications.rotation_fitting import nearest_rotations


class RigidityEnergy:
    """The energy of the deformations of one surface.

    Parameters
    ----------
    stiffness : (n, n) csc_array
        S, symmetric; its weights and neighbors are those of the energy.
    vertices : (n, 3) array of float
        V, the surface at rest.
    """

    def __init__(self, stiffness: csc_array, vertices: NDArray[np.float64]):
        self._stiffness = stiffness.tocsr()
        self._at_rest = vertices
        self._differences = _difference_matrix(stiffness, vertices)
        self._transposed = self._differences.T.tocsr()

    def rotations(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 3, 3) rotation of each vertex's ring that fits (n, 3) positions best."""
        return nearest_rotations(self._covariances(positions))

    def right_hand_side(self, rotations: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 3) right-hand side of the global step, C^T R / 2."""
        stacked = rotations.transpose(0, 2, 1).reshape(-1, 3)
        right: NDArray[np.float64] = self._transposed @ stacked / 2
        return right

    def value(self, positions: NDArray[np.float64]) -> float:
        """Compute the energy of (n, 3) positions, with their best rotations; in squared units of length."""
        rotations = self.rotations(positions)
        linear = float((rotations * self._covariances(positions)).sum())
        lengths = sum(float((X * (self._stiffness @ X)).sum()) for X in (positions, self._at_rest))
        return max(0.0, 2 * lengths - 2 * linear)

    def _covariances(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 3, 3) sums w_ij (x_i - x_j) (v_i - v_j)^T."""
        sums = (self._differences @ positions).reshape(-1, 3, 3)
        covariances: NDArray[np.float64] = sums.transpose(0, 2, 1)
        return covariances


def _difference_matrix(stiffness: csc_array, vertices: NDArray[np.float64]) -> csr_array:
    """Build C, (3 n, n): row 3 i + b maps x to the sum over j of w_ij (v_i - v_j)_b (x_i - x_j)."""
    entries = stiffness.tocoo()
    is_pair = (entries.row != entries.col) & (entries.data != 0)
    i, j = entries.row[is_pair].astype(np.int64), entries.col[is_pair].astype(np.int64)
    weighted = -entries.data[is_pair][:, None] * (vertices[i] - vertices[j])
    rows = (3 * i[:, None] + np.arange(3)).ravel()
    n = len(vertices)
    data = np.concatenate([weighted.ravel(), -weighted.ravel()])
    columns = np.concatenate([np.repeat(i, 3), np.repeat(j, 3)])
    return coo_array((data, (np.tile(rows, 2), columns)), shape=(3 * n, n)).tocsr()
