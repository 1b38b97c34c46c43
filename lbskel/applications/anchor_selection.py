"""Anchors chosen one by one where the reconstructed surface is farthest from the given one, and least-squares meshes.

Sorkine, Cohen-Or 2004, "Least-squares meshes", https://doi.org/10.1109/SMI.2004.1314506: the smoothest surface,
min |S x|^2 + w^2 sum_j |x_j - v_j|^2, through a few positions of a mesh. With A = S^T S + w^2 sum_j e_j e_j^T, a new
anchor a changes the solution by K (v_a - x_a), K = A^-1 e_a / (1 / w^2 + e_a^T A^-1 e_a), by the formula of Sherman and
Morrison; A is factorized again only when the number of anchors has doubled.
"""

from __future__ import annotations

__all__ = ["greedy_anchors", "least_squares_mesh"]

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.applications.differential_coordinates import (
    AnchoredLaplacian,
    checked_weight,
    coupled_components,
    uncoupled_rows,
)
from lbskel.errors import MeshError, UnknownChoice, checked_count
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators import Operator, apply_operator


def _first_anchors(stiffness: csc_array, vertices: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the vertex of each component that is farthest from the component's mean."""
    labels, coupled = coupled_components(stiffness), np.flatnonzero(~uncoupled_rows(stiffness))
    labels = labels[coupled]
    counts = np.bincount(labels)
    means = np.stack([np.bincount(labels, vertices[coupled, axis]) for axis in range(3)], axis=1)
    distances = np.linalg.norm(vertices[coupled] - (means / np.maximum(counts, 1)[:, None])[labels], axis=1)
    order = np.lexsort((coupled, -distances, labels))
    first = np.flatnonzero(np.diff(labels[order], prepend=-1))
    anchors: NDArray[np.int64] = coupled[order[first]]
    return anchors


def greedy_anchors(
    stiffness: csc_array,
    deltas: NDArray[np.float64],
    vertices: NDArray[np.float64],
    n_anchors: int,
    *,
    weight: float = 1.0,
    solver: str = "cholmod",
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Choose soft anchors, each the vertex with the largest error so far; the first ones are one of each component.

    Parameters
    ----------
    stiffness : (n, n) csc_array
    deltas, vertices : (n, 3) array of float
        The deltas to reconstruct from, and the positions to reach. Vertices with a zero row in S keep their positions.
    n_anchors : int
    weight : float
        The weight w of the anchors, in units of the entries of S; above zero.
    solver : str
        A name in SOLVERS.

    Returns
    -------
    anchors : (k,) array of int
        In the order in which they were chosen; fewer than asked for if the others have no error.
    positions : (n, 3) array of float
        Reconstructed with all anchors.

    Raises
    ------
    MeshError, SolveError, UnknownChoice
        As for :func:`least_squares_mesh`.
    """
    checked_count(n_anchors, "n_anchors", 1)
    if checked_weight(weight, "anchor_weight") is None:
        raise UnknownChoice("anchor_weight must be above zero: anchors chosen one by one are soft")
    anchors = list(_first_anchors(stiffness, vertices))
    if len(anchors) > n_anchors:
        raise MeshError(f"{len(anchors)} components need as many anchors: n_anchors is {n_anchors}")
    is_uncoupled = uncoupled_rows(stiffness)
    unit = np.zeros((len(vertices), 1))
    while True:
        chosen = np.array(anchors, dtype=np.int64)
        laplacian = AnchoredLaplacian(stiffness, chosen, weight=weight, solver=solver)
        X = laplacian.solve(deltas, vertices[chosen])
        X[is_uncoupled] = vertices[is_uncoupled]
        if len(anchors) >= n_anchors:
            return chosen, X
        target = min(n_anchors, max(2 * len(anchors), 1))  # there is none yet if every row is zero
        updates: list[tuple[NDArray[np.float64], float]] = []
        while len(anchors) < target:
            errors = np.linalg.norm(X - vertices, axis=1)
            errors[anchors] = 0
            new = int(errors.argmax())
            if errors[new] == 0:
                return np.array(anchors, dtype=np.int64), X
            unit[new] = 1
            column = laplacian.solve_normal(unit)[:, 0]
            unit[new] = 0
            for update, divisor in updates:
                column = column - update * (update[new] / divisor)
            divisor = 1 / weight**2 + float(column[new])
            X = X + column[:, None] * ((vertices[new] - X[new]) / divisor)
            updates.append((column, divisor))
            anchors.append(new)


def least_squares_mesh(
    mesh: Any,
    n_anchors: int,
    *,
    operator: str | Operator = "graph",
    anchor_weight: float = 1.0,
    solver: str = "cholmod",
) -> tuple[Mesh, NDArray[np.int64]]:
    """Approximate a surface by the smoothest one through a few anchors, chosen where the error is largest.

    Parameters
    ----------
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
    n_anchors : int
        At least one for each component.
    operator : str or callable
        A name in OPERATORS, or a function from a Mesh to a Laplacian. With ``graph`` the result follows from the
        connectivity and the anchors alone.
    anchor_weight : float
        The weight w of the anchors, in units of the operator's weights: for those of one over a length about one over
        the mean edge length.
    solver : str
        A name in SOLVERS.

    Returns
    -------
    surface : Mesh
        The same faces and order of vertices.
    anchors : (k,) array of int
        In the order in which they were chosen.

    Raises
    ------
    MeshError
        If there are fewer anchors than components, or a vertex has too many neighbors.
    SolveError
        If the system is singular to working accuracy.
    UnknownChoice
        If no operator or solver has that name, or a number is out of range.

    References
    ----------
    Sorkine, Cohen-Or 2004, equation 2 and section 4.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> ring = torus(1.0, 0.3, 24, 12)
    >>> surface, anchors = lbskel.least_squares_mesh(ring, 60)
    >>> len(anchors), float(abs(surface.vertices - ring.vertices).max()) < 0.2
    (60, True)
    """
    given: Mesh = as_mesh(mesh)
    laplacian = apply_operator(operator, given)
    scaled, exponent = unit_scale(given.vertices)  # squares of distances in huge units overflow
    center = given.with_vertices(scaled).centroid
    anchors, X = greedy_anchors(
        laplacian.stiffness / laplacian.weight_unit,
        np.zeros_like(scaled),
        scaled - center,
        n_anchors,
        weight=anchor_weight,
        solver=solver,
    )
    return given.with_vertices(np.ldexp(X + center, exponent)), anchors
