"""Discrete Laplace-Beltrami operators of meshes, polygon meshes and point clouds, in weak form and one sign: S >= 0."""

from lbskel.operators.base import Laplacian, from_igl, to_igl
from lbskel.operators.masses import MASSES
from lbskel.operators.polygons import PolygonMesh
from lbskel.operators.registry import (
    OPERATORS,
    POINT_OPERATORS,
    POLYGON_OPERATORS,
    STAR_OPERATORS,
    Operator,
    apply_operator,
    laplacian,
    operator_named,
)

__all__ = [
    "MASSES",
    "OPERATORS",
    "POINT_OPERATORS",
    "POLYGON_OPERATORS",
    "STAR_OPERATORS",
    "Laplacian",
    "Operator",
    "PolygonMesh",
    "apply_operator",
    "from_igl",
    "laplacian",
    "operator_named",
    "to_igl",
]
