"""Differential coordinates, delta = S V, and surfaces from them and from the positions of some anchors.

- hard anchors: S x = delta in the other rows, x = c at the anchors (the invertible Laplacian)
- soft anchors: min |S x - delta|^2 + w^2 sum_j |x_j - c_j|^2 (the k-anchor rectangular Laplacian)

Deltas do not change when the surface is moved, and are rotated and scaled with it. Divided by the areas they are twice
the mean curvature normals (:meth:`lbskel.Laplacian.delta`). Sorkine 2005, "Laplacian mesh processing", sections 2 and
3, https://doi.org/10.2312/egst.20051044.
"""

from __future__ import annotations

__all__ = ["AnchoredLaplacian", "delta_coordinates", "reconstruct"]

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array
from scipy.sparse.csgraph import connected_components

from lbskel.applications.constrained_systems import ConstrainedSystem, checked_indices
from lbskel.applications.squared_matrices import matrix_product
from lbskel.errors import MeshError, UnknownChoice, counted, first_few, is_number
from lbskel.geometry.arrays import checked_points
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.operators import Operator, apply_operator


def delta_coordinates(mesh: Any, *, operator: str | Operator = "cotangent") -> NDArray[np.float64]:
    """Compute S V: each vertex minus the weighted mean of its neighbors, times the sum of the weights.

    Parameters
    ----------
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
    operator : str or callable
        A name in OPERATORS, or a function from a Mesh to a Laplacian.

    Returns
    -------
    (n, 3) array of float
        In the caller's unit of length, for operators whose weights have no unit.

    Raises
    ------
    MeshError
        If the operator is not defined on the mesh.
    UnknownChoice
        If no operator has that name.

    References
    ----------
    Sorkine 2005, equation 1.

    Examples
    --------
    >>> import lbskel
    >>> square = lbskel.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> lbskel.delta_coordinates(square, operator="graph")[1]  # minus its two neighbors
    array([ 1., -1.,  0.])
    """
    given: Mesh = as_mesh(mesh)
    deltas: NDArray[np.float64] = apply_operator(operator, given).stiffness @ (given.vertices - given.centroid)
    return deltas


def uncoupled_rows(stiffness: csc_array) -> NDArray[np.bool_]:
    """(n,) whether a row is zero, as of a vertex without a face."""
    zero: NDArray[np.bool_] = abs(stiffness).sum(axis=1) == 0
    return zero


def coupled_components(stiffness: csc_array) -> NDArray[np.int64]:
    """(n,) number of the connected component of each vertex in the graph of the entries that are not zero."""
    entries = stiffness.copy()
    entries.eliminate_zeros()
    labels: NDArray[np.int64] = connected_components(entries, directed=False)[1].astype(np.int64)
    return labels


class AnchoredLaplacian:
    """A Laplacian with anchors, factorized once, from which surfaces are reconstructed for many deltas and positions.

    Parameters
    ----------
    stiffness : (n, n) csc_array
    anchors : (k,) array of int
        At least one in each component.
    weight : float, optional
        The weight w of soft anchors, in units of the entries of S; by default they are hard.
    solver : str
        A name in SOLVERS.

    Raises
    ------
    MeshError
        If a component has no anchor, or a vertex has too many neighbors for soft anchors.
    SolveError
        If the system is singular.
    """

    def __init__(
        self, stiffness: csc_array, anchors: NDArray[np.int64], *, weight: float | None = None, solver: str = "cholmod"
    ):
        is_uncoupled = uncoupled_rows(stiffness)
        labels = coupled_components(stiffness)
        has_anchor = np.zeros(labels.max() + 1, dtype=bool)
        has_anchor[labels[anchors]] = True
        lost = np.flatnonzero(~has_anchor[labels] & ~is_uncoupled)
        if len(lost):
            first = lost[np.unique(labels[lost], return_index=True)[1]]
            raise MeshError(
                f"{counted(len(first), 'component')} without an anchor, with vertices {first_few(first)}: give each "
                "component at least one"
            )
        self._n_anchors = len(anchors)
        self._transposed = None if weight is None else stiffness.T.tocsr()
        matrix = stiffness if weight is None else matrix_product(stiffness.T, stiffness)
        held = np.setdiff1d(np.flatnonzero(is_uncoupled), anchors)
        squared = None if weight is None else weight * weight
        self._system = ConstrainedSystem(matrix, anchors, weight=squared, held=held, solver=solver)

    def solve(self, deltas: NDArray[np.float64], positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Reconstruct (n, c) positions from (n, c) deltas and (k, c) positions of the anchors; 0 at zero rows."""
        right = deltas if self._transposed is None else self._transposed @ deltas
        return self._system.solve(positions, right)

    def solve_normal(self, right: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve (S^T S + w^2 sum_j e_j e_j^T) X = B for (n, c) right-hand sides, with soft anchors only."""
        zeros = np.zeros((self._n_anchors, right.shape[1]))
        return self._system.solve(zeros, right)


def checked_weight(weight: float | None, name: str) -> float | None:
    """Return a weight of soft constraints, or None for hard ones; raise UnknownChoice if it is not above zero."""
    if weight is not None and not (is_number(weight) and math.isfinite(weight) and weight > 0):
        raise UnknownChoice(f"{name} must be above zero, or None for hard constraints, not {weight!r}")
    return weight


def reconstruct(
    mesh: Any,
    deltas: ArrayLike,
    anchors: ArrayLike,
    positions: ArrayLike | None = None,
    *,
    operator: str | Operator = "cotangent",
    anchor_weight: float | None = None,
    solver: str = "cholmod",
) -> Mesh:
    """Reconstruct a surface from differential coordinates and the positions of anchors.

    Parameters
    ----------
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
        The connectivity, and the geometry of the operator's weights. Vertices without a face keep its positions.
    deltas : (n, 3) array_like of float
        As :func:`delta_coordinates` returns them, by the same operator.
    anchors : (k,) array_like of int, or (n,) array_like of bool
        At least one vertex in each component.
    positions : (k, 3) array_like of float, optional
        Positions of the anchors; by default those of the mesh.
    operator : str or callable
        A name in OPERATORS, or a function from a Mesh to a Laplacian.
    anchor_weight : float, optional
        The weight w of soft anchors, in units of the operator's weights: for those of one over a length about one over
        the mean edge length. By default anchors are hard.
    solver : str
        A name in SOLVERS.

    Raises
    ------
    MeshError
        If an array has the wrong shape, an anchor is no vertex, a component has no anchor, or a vertex has too many
        neighbors for soft anchors.
    SolveError
        If the system is singular to working accuracy.
    UnknownChoice
        If no operator or solver has that name, or the weight is not above zero.

    References
    ----------
    Sorkine 2005, equations 6 and 7.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> ring = torus(1.0, 0.3, 24, 12)
    >>> copy = lbskel.reconstruct(ring, lbskel.delta_coordinates(ring), anchors=[0])
    >>> float(abs(copy.vertices - ring.vertices).max()) < 1e-10
    True
    """
    given: Mesh = as_mesh(mesh)
    chosen = checked_indices(anchors, len(given.vertices), "anchors")
    if not len(chosen):
        raise MeshError("there are no anchors: deltas do not determine where the surface is; give at least one")
    wanted = given.vertices[chosen] if positions is None else checked_points(positions, "positions")
    values = checked_points(deltas, "deltas")
    if len(values) != len(given.vertices) or len(wanted) != len(chosen):
        raise MeshError(
            f"there must be a delta for each of the {len(given.vertices)} vertices and a position for each of the "
            f"{len(chosen)} anchors, not {len(values)} and {len(wanted)}"
        )
    laplacian = apply_operator(operator, given)
    unit = laplacian.weight_unit
    stiffness, weight = laplacian.stiffness / unit, checked_weight(anchor_weight, "anchor_weight")
    center = wanted.mean(axis=0)
    system = AnchoredLaplacian(stiffness, chosen, weight=weight, solver=solver)
    X = system.solve(values / unit, wanted - center) + center
    is_kept = uncoupled_rows(stiffness)
    is_kept[chosen] = False
    X[is_kept] = given.vertices[is_kept]
    return given.with_vertices(X)
