"""Deltas that turn and grow with the surface: the linear transformation of each ring as a function of its positions.

With ^ for the cross product, the transformation v -> s v + h ^ v + t that best fits the ring of vertex i, itself and
its neighbors with v_k - mean = p_k, to positions x_k has s = sum p_k . x_k / sum |p_k|^2 and h = J^-1 sum p_k ^ x_k
with J = sum (|p_k|^2 - p_k p_k^T). So the transformed delta, s delta_i + h ^ delta_i, is linear in the positions. The
transformation is a similarity up to first order in the angle. Sorkine, Cohen-Or, Lipman, Alexa, Roessl, Seidel 2004,
"Laplacian surface editing", section 3, https://doi.org/10.2312/SGP/SGP04/179-188.
"""

from __future__ import annotations

__all__ = ["invariant_matrix"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, eye_array, kron

# Largest weight, relative to the row's diagonal, of a vertex that is no neighbor: the rounding error of a weight of
# zero, as on the diagonal of a square
ROUNDING = 1e-12


def _cross_matrices(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3, 3) matrices of the map x -> v ^ x, the cross product, for (k, 3) vectors v."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.array(rows).transpose(2, 0, 1)


def invariant_matrix(stiffness: csc_array, vertices: NDArray[np.float64]) -> csc_array:
    """Build K, (3 n, 3 n): (K X)_i is the delta of vertex i minus its delta at rest, transformed with its ring.

    Parameters
    ----------
    stiffness : (n, n) csc_array
    vertices : (n, 3) array of float
        The surface at rest.

    Returns
    -------
    csc_array
        Rows and columns 3 i + a for coordinate a of vertex i.
    """
    n = len(vertices)
    entries = stiffness.tocoo()
    smallest = ROUNDING * np.abs(stiffness.diagonal())[entries.row]
    is_pair = (entries.row != entries.col) & (np.abs(entries.data) > smallest)
    center = np.concatenate([entries.row[is_pair], np.arange(n)]).astype(np.int64)
    member = np.concatenate([entries.col[is_pair], np.arange(n)]).astype(np.int64)
    deltas = stiffness @ vertices
    counts = np.bincount(center, minlength=n)
    means = np.stack([np.bincount(center, vertices[member, axis], n) for axis in range(3)], axis=1) / counts[:, None]
    p = vertices[member] - means[center]
    squares = np.bincount(center, (p * p).sum(axis=1), n)
    moments = np.zeros((n, 3, 3))
    np.add.at(moments, center, p[:, :, None] * p[:, None, :])
    inertia = squares[:, None, None] * np.eye(3) - moments
    inverse = np.linalg.pinv(inertia, rcond=1e-10, hermitian=True)  # singular where a ring is a line
    scale = np.divide(1.0, squares, out=np.zeros(n), where=squares > 0)
    # s delta = (delta p^T / sum |p|^2) x, and h ^ delta = -[delta] J^-1 [p] x with the matrices [v] of v ^
    grown = deltas[center][:, :, None] * (p * scale[center][:, None])[:, None, :]
    turned = (-_cross_matrices(deltas) @ inverse)[center] @ _cross_matrices(p)
    blocks = (grown + turned).ravel()
    a, b = (grid.ravel() for grid in np.meshgrid(np.arange(3), np.arange(3), indexing="ij"))
    rows = (3 * center[:, None] + a).ravel()
    columns = (3 * member[:, None] + b).ravel()
    transformed = coo_array((blocks, (rows, columns)), shape=(3 * n, 3 * n))
    K: csc_array = (kron(stiffness, eye_array(3)) - transformed).tocsc()
    return K
