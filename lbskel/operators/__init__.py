"""Discrete Laplace-Beltrami operators: one dict, one signature, one convention (weak form, positive semidefinite)."""

from __future__ import annotations

__all__ = ["OPERATORS", "Laplacian", "Operator", "laplacian", "operator_named"]

from collections.abc import Callable
from typing import TypeAlias

from lbskel.errors import choose
from lbskel.mesh import Mesh
from lbskel.operators.clamped_cotangent import clamped_cotangent
from lbskel.operators.cotangent import cotangent
from lbskel.operators.graph import graph
from lbskel.operators.intrinsic_delaunay import intrinsic_delaunay
from lbskel.operators.laplacian import Laplacian
from lbskel.operators.robust import robust

Operator: TypeAlias = Callable[[Mesh], Laplacian]

OPERATORS: dict[str, Operator] = {
    "graph": graph,
    "cotangent": cotangent,
    "clamped_cotangent": clamped_cotangent,
    "intrinsic_delaunay": intrinsic_delaunay,
    "robust": robust,
}


def operator_named(operator: str | Operator) -> Operator:
    """The function of that name in OPERATORS, or the callable itself."""
    return operator if callable(operator) else choose(OPERATORS, operator, "operator")


def laplacian(mesh: Mesh, *, operator: str | Operator = "cotangent") -> Laplacian:
    """The discrete Laplace-Beltrami operator of a mesh.

    Parameters
    ----------
    mesh : Mesh
    operator : str or callable
        A name in OPERATORS, or a function from a Mesh to a Laplacian.

    Raises
    ------
    UnknownChoice
        If no operator has that name.
    MeshError
        If the operator is not defined on such a mesh.

    Examples
    --------
    >>> import lbskel
    >>> square = lbskel.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> L = lbskel.laplacian(square, operator="cotangent")
    >>> abs(L.stiffness.sum(axis=1)).max() < 1e-12, round(float(L.mass.sum()), 12)
    (True, 1.0)
    """
    return operator_named(operator)(mesh)
