"""The tables of operators by name, and the function that applies one to a mesh, a polygon mesh or a point cloud."""

from __future__ import annotations

__all__ = ["OPERATORS", "POINT_OPERATORS", "POLYGON_OPERATORS", "Operator", "laplacian", "operator_named"]

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeAlias

from lbskel.errors import MeshError, choose
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.operators import points
from lbskel.operators.anisotropic import anisotropic
from lbskel.operators.base import Laplacian
from lbskel.operators.clamped_cotangent import clamped_cotangent
from lbskel.operators.combinatorial import graph, random_walk
from lbskel.operators.cotangent import cotangent
from lbskel.operators.cotangent_identity import cotangent_identity
from lbskel.operators.heat_kernel import heat_kernel
from lbskel.operators.intrinsic_delaunay import intrinsic_delaunay
from lbskel.operators.inverse_distance import inverse_distance
from lbskel.operators.masses import MASSES
from lbskel.operators.mean_value import mean_value, mean_value_symmetric
from lbskel.operators.mollified import mollified
from lbskel.operators.polygons import PolygonMesh, polygon_cotangent
from lbskel.operators.robust import robust

Operator: TypeAlias = Callable[[Mesh], Laplacian]

OPERATORS: dict[str, Operator] = {
    "graph": graph,
    "random_walk": random_walk,
    "inverse_distance": inverse_distance,
    "cotangent": cotangent,
    "clamped_cotangent": clamped_cotangent,
    "cotangent_identity": cotangent_identity,
    "mean_value": mean_value,
    "mean_value_symmetric": mean_value_symmetric,
    "mollified": mollified,
    "intrinsic_delaunay": intrinsic_delaunay,
    "robust": robust,
    "heat_kernel": heat_kernel,
    "anisotropic": anisotropic,
}

POINT_OPERATORS: dict[str, Callable[[PointCloud], Laplacian]] = {
    "robust": points.robust,
    "local_delaunay": points.local_delaunay,
    "heat_kernel": points.heat_kernel,
}

POLYGON_OPERATORS: dict[str, Callable[[PolygonMesh], Laplacian]] = {"cotangent": polygon_cotangent}


def operator_named(operator: str | Operator) -> Operator:
    """The function of that name in OPERATORS, or the callable itself."""
    return operator if callable(operator) else choose(OPERATORS, operator, "operator")


def laplacian(
    shape: Mesh | PointCloud | PolygonMesh,
    *,
    operator: str | Callable[[Any], Laplacian] | None = None,
    mass: str | None = None,
) -> Laplacian:
    """The discrete Laplace-Beltrami operator of a mesh, a mesh of polygons or a point cloud.

    Parameters
    ----------
    shape : Mesh, PolygonMesh or PointCloud
    operator : str or callable, optional
        A name in OPERATORS, POLYGON_OPERATORS or POINT_OPERATORS, as the shape is, or a function from it to a
        Laplacian. By default ``cotangent``, for a point cloud ``robust``.
    mass : {"voronoi", "barycentric", "full"}, optional
        For a Mesh; by default the operator's own, which is the Voronoi mass wherever its docstring names no other.

    Raises
    ------
    UnknownChoice
        If no operator or mass has that name.
    MeshError
        If the operator is not defined on such a shape, or a mass is asked for of a shape that is no Mesh.

    Examples
    --------
    >>> import lbskel
    >>> square = lbskel.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> L = lbskel.laplacian(square, operator="cotangent", mass="barycentric")
    >>> L.stiffness.toarray()[1], L.mass.diagonal().round(3)
    (array([-0.5,  1. , -0.5,  0. ]), array([0.333, 0.167, 0.333, 0.167]))
    """
    table: dict[str, Any] = OPERATORS
    if isinstance(shape, PointCloud):
        table, default = POINT_OPERATORS, "robust"
    elif isinstance(shape, PolygonMesh):
        table, default = POLYGON_OPERATORS, "cotangent"
    else:
        default = "cotangent"
    chosen = operator or default
    result: Laplacian = (chosen if callable(chosen) else choose(table, chosen, "operator"))(shape)
    if mass is None:
        return result
    area = choose(MASSES, mass, "mass")
    if not isinstance(shape, Mesh):
        raise MeshError(f"{shape!r} has the mass of its operator only; leave mass out")
    return replace(result, mass=area(shape))
