"""Operators that are symmetric and have a mass: what a spectrum and the heat equation need."""

from __future__ import annotations

__all__ = ["require_symmetric"]

from lbskel.errors import MeshError
from lbskel.operators import Laplacian

# Largest |S - S^T| over largest |S| up to which an operator counts as symmetric: rounding errors of sums of a few dozen
# terms. The same bound as ROUNDING in lbskel.evaluation.operator_report.
ROUNDING = 1e-12


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
    S = laplacian.stiffness
    if not laplacian.mass.sum() > 0:
        raise MeshError("the mesh has no area: every face is degenerate, so the operator has no mass")
    if abs(S - S.T).max() > ROUNDING * abs(S).max():
        raise MeshError("the operator is not symmetric; choose one that is, for example 'mean_value_symmetric'")
