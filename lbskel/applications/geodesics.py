"""Geodesic distance and extended values in one call each; many queries on one mesh: :class:`lbskel.HeatMethod`."""

from __future__ import annotations

__all__ = ["extend_values", "geodesic_distance"]

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.applications.heat_method import HeatMethod, Sources
from lbskel.geometry.mesh import as_mesh
from lbskel.operators import Operator


def geodesic_distance(
    mesh: Any, sources: Sources, *, operator: str | Operator = "robust", unfolded: bool = True
) -> NDArray[np.float64]:
    """Compute the geodesic distance of every vertex to the nearest source, by the heat method.

    For many queries on one mesh, make one :class:`lbskel.HeatMethod`, which factorizes once.

    Parameters
    ----------
    mesh : Mesh, or what :func:`lbskel.as_mesh` takes
    sources : int, (s,) array_like of int, or (n,) array_like of bool
        Vertices; a mask stands for those where it is true.
    operator : str or callable
        A name in OPERATORS or a function from a Mesh to a Laplacian: symmetric.
    unfolded : bool
        Whether distances are propagated across unfolded triangles in the order of the heat. If not, they are those of
        the paper, less accurate and smoother: see :meth:`lbskel.HeatMethod.distance`.

    Returns
    -------
    (n,) array of float
        In the units of the mesh; infinite in components without a source and at vertices that no face uses. If not
        unfolded, also infinite at vertices that the operator does not connect to a source.

    Raises
    ------
    MeshError
        If a source is no vertex, the mesh has no area, or the operator is not symmetric or not defined on it.
    SolveError
        If the operator is not positive semidefinite.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import flat_grid
    >>> distance = lbskel.geodesic_distance(flat_grid(30, 30), 0)
    >>> float(distance.max().round(1))
    1.4
    """
    return HeatMethod(as_mesh(mesh), operator).distance(sources, unfolded=unfolded)


def extend_values(
    mesh: Any, sources: ArrayLike, values: ArrayLike, *, operator: str | Operator = "robust"
) -> NDArray[np.float64]:
    """Extend values at some vertices to all: nearly the value of the nearest source, blended where two are near.

    Parameters
    ----------
    mesh : Mesh, or what :func:`lbskel.as_mesh` takes
    sources : (s,) array_like of int, or (n,) array_like of bool
        Vertices; a mask stands for those where it is true, in ascending order.
    values : (s,) or (s, c) array_like of float
    operator : str or callable
        As in :func:`geodesic_distance`.

    Returns
    -------
    (n,) or (n, c) array of float
        NaN where no heat arrives: in components without a source.

    Raises
    ------
    MeshError
        As :func:`geodesic_distance`, or if there is not one finite value for each source.
    SolveError
        If the operator is not positive semidefinite.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import flat_grid
    >>> halves = lbskel.extend_values(flat_grid(20, 20), [0, 399], [1.0, 2.0])
    >>> float(halves.min().round(2)), float(halves.max().round(2))
    (1.0, 2.0)
    """
    return HeatMethod(as_mesh(mesh), operator).extend(sources, values)
