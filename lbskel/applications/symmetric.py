"""Tests for operators that are symmetric and have a mass, as a spectrum and the heat equation need them."""

from __future__ import annotations

__all__ = ["is_symmetric", "require_symmetric"]

from scipy.sparse import csc_array

from lbskel.errors import MeshError
from lbskel.operators import Laplacian

# Largest |S - S^T| over largest |S| up to which an operator counts as symmetric: rounding errors of sums of a few dozen
# terms. The same bound as ROUNDING in lbskel.evaluation.operator_report.
ROUNDING = 1e-12


def is_symmetric(matrix: csc_array) -> bool:
    """Whether a square matrix equals its transpose up to rounding errors."""
    return bool(abs(matrix - matrix.T).max() <= ROUNDING * abs(matrix).max())


def require_symmetric(laplacian: Laplacian) -> None:
    """Refuse an operator that is not symmetric, or that has no mass.

    Parameters
    ----------
    laplacian : Laplacian

    Raises
    ------
    MeshError
        If it is not symmetric, or the mesh has no area.
    """
    if not laplacian.mass.sum() > 0:
        raise MeshError("the mesh has no area: every face is degenerate, so the operator has no mass")
    if not is_symmetric(laplacian.stiffness):
        raise MeshError(
            "the operator is not symmetric; choose one that is, such as 'robust' or, of a mesh, 'mean_value_symmetric'"
        )
