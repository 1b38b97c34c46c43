"""Tables of operators by name, and the functions that apply one to a mesh, a polygon mesh or a point cloud."""

from __future__ import annotations

__all__ = [
    "OPERATORS",
    "POINT_OPERATORS",
    "POLYGON_OPERATORS",
    "STAR_OPERATORS",
    "Operator",
    "apply_operator",
    "laplacian",
    "operator_named",
]

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from scipy.sparse import csc_array

from lbskel.errors import MeshError, OperatorError, UnknownChoice, choose
from lbskel.geometry.mesh import Mesh, PointCloud, as_mesh
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

STAR_OPERATORS: dict[str, Operator] = {"local_delaunay": points.local_delaunay_of_stars}

POLYGON_OPERATORS: dict[str, Callable[[PolygonMesh], Laplacian]] = {"cotangent": polygon_cotangent}


def operator_named(operator: str | Operator) -> Operator:
    """Look up an operator by its name in OPERATORS or STAR_OPERATORS; return a callable unchanged.

    Raises
    ------
    UnknownChoice
        If no operator has that name.
    """
    if isinstance(operator, str) and operator in STAR_OPERATORS:
        return STAR_OPERATORS[operator]
    return operator if callable(operator) else choose(OPERATORS, operator, "operator")


def apply_operator(operator: str | Operator, mesh: Mesh) -> Laplacian:
    """Apply an operator to a mesh; check what a function of the caller returns.

    Parameters
    ----------
    operator : str or callable
        A name in OPERATORS or STAR_OPERATORS, or a function from a Mesh to a Laplacian.
    mesh : Mesh

    Raises
    ------
    UnknownChoice
        If no operator has that name.
    MeshError
        If the operator is not defined on the mesh.
    OperatorError
        If a function returns no Laplacian, one of another size, or one with libigl's negative sign.
    """
    result = operator_named(operator)(mesh)
    return _checked(operator, result, len(mesh.vertices)) if callable(operator) else result


def _checked(operator: Callable[..., Any], result: Any, n: int) -> Laplacian:
    """Return the result as a Laplacian of n vertices in csc_arrays, or raise an error that says what to return."""
    name = getattr(operator, "__name__", repr(operator))
    if not isinstance(result, Laplacian):
        raise OperatorError(
            f"the operator {name} returned {_described(result)}, not a Laplacian; return Laplacian(stiffness, mass) "
            "with a positive semidefinite stiffness, or from_igl(L, M) with libigl's matrices"
        )
    laplacian: Laplacian = result
    for part, matrix in (("stiffness", laplacian.stiffness), ("mass", laplacian.mass)):
        if matrix.shape != (n, n):
            raise OperatorError(
                f"the operator {name} returned a {part} of shape {matrix.shape} for {n} vertices; "
                f"both matrices of a Laplacian must be {(n, n)}"
            )
    if not (isinstance(laplacian.stiffness, csc_array) and isinstance(laplacian.mass, csc_array)):
        laplacian = replace(laplacian, stiffness=csc_array(laplacian.stiffness), mass=csc_array(laplacian.mass))
    diagonal = laplacian.stiffness.diagonal()
    n_negative, n_positive = np.count_nonzero(diagonal < 0), np.count_nonzero(diagonal > 0)
    if n_negative > n_positive:  # rounding may make a few entries negative at thin triangles
        raise OperatorError(
            f"the operator {name} returned a stiffness with {n_negative} negative entries of {n} on its diagonal: "
            "this is libigl's sign; return from_igl(L, M), or Laplacian(-L, M)"
        )
    return laplacian


def _described(value: Any) -> str:
    """Describe a value that is not a Laplacian by its type, and a tuple by the types of its items."""
    if isinstance(value, tuple):
        return f"a tuple ({', '.join(type(item).__name__ for item in value)})"
    return f"a value of type {type(value).__name__}"


def laplacian(
    shape: Any,
    *,
    operator: str | Callable[[Any], Laplacian] | None = None,
    mass: str | None = None,
) -> Laplacian:
    """Build the discrete Laplace-Beltrami operator of a mesh, a polygon mesh or a point cloud.

    The default is the cotangent Laplacian, since it describes the mesh as given: it is the stiffness of linear finite
    elements, couples only vertices that share an edge, and agrees with libigl's. :func:`lbskel.contract` has another
    default, the intrinsic Delaunay or tufted operator, since contraction makes triangles thin on purpose: there
    cotangent weights turn negative and grow without bound. With Au's energy the contraction of 7 of 13 shapes broke
    with the cotangent operator, and of none with the intrinsic Delaunay one (``benchmarks/results/influence.md``).

    Parameters
    ----------
    shape : Mesh, PolygonMesh, PointCloud, or what :func:`lbskel.as_mesh` takes
    operator : str or callable, optional
        A name in OPERATORS, POLYGON_OPERATORS or POINT_OPERATORS, depending on the shape, or a function from the
        shape to a Laplacian. By default ``cotangent``; for a point cloud, which has no faces, ``robust``.
    mass : {"voronoi", "barycentric", "full"}, optional
        For a mesh; by default the operator's own, which is the Voronoi mass unless its docstring names another.

    Raises
    ------
    UnknownChoice
        If no operator or mass has that name, or a mass is given for weights of one over a length.
    FormatError
        If the shape is a path and no mesh can be read from it.
    MeshError
        If the shape is not a mesh, the operator is not defined on it, or a mass is given for a polygon mesh or cloud.
    OperatorError
        If a function given as operator returns no Laplacian, one of another size, or one with libigl's negative sign.

    Examples
    --------
    >>> import lbskel
    >>> square = lbskel.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> L = lbskel.laplacian(square, operator="cotangent", mass="barycentric")
    >>> L.stiffness.toarray()[1], L.mass.diagonal().round(3)
    (array([-0.5,  1. , -0.5,  0. ]), array([0.333, 0.167, 0.333, 0.167]))
    """
    if isinstance(shape, PointCloud | PolygonMesh):
        is_cloud = isinstance(shape, PointCloud)
        table: dict[str, Any] = POINT_OPERATORS if is_cloud else POLYGON_OPERATORS
        chosen = operator or ("robust" if is_cloud else "cotangent")
        function = chosen if callable(chosen) else choose(table, chosen, "operator")
        result: Laplacian = function(shape)
        if callable(operator):
            result = _checked(operator, result, len(shape.points if isinstance(shape, PointCloud) else shape.vertices))
        if mass is not None:
            choose(MASSES, mass, "mass")
            raise MeshError(f"{shape!r} has the mass of its operator only; leave mass out")
        return result
    mesh = as_mesh(shape)
    result = apply_operator(operator or "cotangent", mesh)
    if mass is None:
        return result
    mass_of = choose(MASSES, mass, "mass")
    if result.mass_unit == "length":
        name = getattr(operator, "__name__", operator)
        raise UnknownChoice(
            f"the weights of the operator {name!r} are one over a length, and M^-1 S with areas as mass is no "
            "Laplacian; leave mass out, as its own masses are lengths"
        )
    return replace(result, mass=mass_of(mesh), mass_unit="area")
