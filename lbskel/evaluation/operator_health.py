"""Measurement of the properties of a discrete Laplacian on its mesh.

No discrete Laplacian on general meshes is symmetric, local, linearly precise and of positive weights at once:
Wardetzky, Mathur, Kaelberer, Grinspun 2007, "Discrete Laplace operators: no free lunch",
https://doi.org/10.2312/SGP/SGP07/033-037. :func:`laplacian_diagnostics` measures these four, whether the operator is
semidefinite and its null space consists of the constants, the maximum principle, and two properties that a contraction
needs: no row is changed at a degenerate triangle, and the total mass is the area.
"""

from __future__ import annotations

__all__ = ["laplacian_diagnostics"]

import sys
from typing import Any

import igl
import numpy as np
from scipy.sparse import coo_array, csc_array, diags_array, triu
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import ArpackError, eigsh, splu

from lbskel.errors import MeshError, SolveError, counted
from lbskel.evaluation.operator_report import ROUNDING, ZERO_EIGENVALUE, LaplacianDiagnostics
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.scaling import unit_vertices
from lbskel.operators import Laplacian
from lbskel.solvers.eigenproblem import count_below, smallest_eigenpairs

PLANE_TOLERANCE = 1e-10  # largest height over a plane, relative to the longest edge of the row; a guess above rounding
FIXED_FRACTION = 0.05  # fraction of the vertices with a given value in the test of the maximum principle; a guess
N_PROBLEMS = 16  # sets of random boundary values for the maximum principle; a guess
SEED = 0  # of all random numbers here


def laplacian_diagnostics(laplacian: Laplacian, mesh: Any) -> LaplacianDiagnostics:
    """Measure the properties of an operator on its mesh.

    Parameters
    ----------
    laplacian : Laplacian
    mesh : Mesh, or what :func:`lbskel.as_mesh` takes
        The mesh of the operator.

    Raises
    ------
    MeshError
        If the mesh has another number of vertices than the operator.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.evaluation.operator_health import laplacian_diagnostics
    >>> from lbskel.shapes import sphere
    >>> mesh = sphere(2)
    >>> laplacian_diagnostics(lbskel.laplacian(mesh, operator="graph"), mesh).passed["symmetric"]
    True
    """
    mesh = as_mesh(mesh)
    S = laplacian.stiffness
    if S.shape[0] != len(mesh.vertices):
        raise MeshError(
            f"the operator has {counted(S.shape[0], 'vertex')} and the mesh {len(mesh.vertices):,}; "
            "give the mesh it was built on"
        )
    largest = max(float(np.abs(S.data).max(initial=0.0)), sys.float_info.min)
    symmetric = ((S + S.T) / 2).tocsc()
    used = mesh.used_vertices
    n_negative, negative_fraction, most_negative = _negative_weights(S)
    smallest, n_zero = _definiteness(symmetric[used][:, used])
    asymmetry = float(abs(S - S.T).max()) / largest
    return LaplacianDiagnostics(
        asymmetry=asymmetry,
        nonlocal_fraction=_nonlocal_fraction(S, mesh),
        row_sum_error=float(np.abs(S.sum(axis=1)).max()) / largest,
        linear_precision_error=_linear_precision_error(S, mesh),
        n_negative_weights=n_negative,
        negative_fraction=negative_fraction,
        most_negative_weight=most_negative,
        smallest_eigenvalue=smallest,
        n_zero_eigenvalues=n_zero if asymmetry <= ROUNDING else None,
        n_components=mesh.n_components,
        overshoot=_overshoot(S, mesh),
        condition_number=_condition_number(symmetric),
        n_fallback_rows=len(laplacian.treated_vertices),
        area_ratio=float(laplacian.mass.sum()) / mesh.area if mesh.area > 0 else None,
    )


def _weights(S: csc_array) -> coo_array:
    """Return the off-diagonal entries with the sign of weights."""
    W = (diags_array(S.diagonal()) - S).tocsc()
    W.eliminate_zeros()
    return W.tocoo()


def _adjacency(mesh: Mesh) -> csc_array:
    """Build the adjacency matrix of distinct vertices that share an edge."""
    i, j = mesh.edges[mesh.edges[:, 0] != mesh.edges[:, 1]].T
    ones, n = np.ones(2 * len(i)), len(mesh.vertices)
    return coo_array((ones, (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(n, n)).tocsc()


def _nonlocal_fraction(S: csc_array, mesh: Mesh) -> float:
    """Return the fraction of the weights that belong to no edge."""
    W = abs(_weights(S)).sign()
    return float(1 - W.multiply(_adjacency(mesh)).sum() / W.nnz) if W.nnz else 0.0


def _negative_weights(S: csc_array) -> tuple[int, float, float]:
    """Return the number and fraction of pairs with a negative weight, and the lowest over the mean absolute weight."""
    W = _weights(S).tocsr()
    if W.nnz == 0:
        return 0, 0.0, 0.0
    mean = float(np.abs(W.data).mean())
    lower = triu(W.minimum(W.T), format="coo").data
    n_pairs = triu(abs(W) + abs(W.T), format="coo").nnz
    negative = lower < -ROUNDING * mean
    return int(negative.sum()), float(negative.sum() / n_pairs), float(lower.min(initial=0.0)) / mean


def _linear_precision_error(S: csc_array, mesh: Mesh) -> float | None:
    """Return the largest relative |S V| over inner vertices whose ring and row lie in one plane, None without any."""
    V, F, n = unit_vertices(mesh)[0], mesh.faces, len(mesh.vertices)
    face_normals = np.nan_to_num(igl.per_face_normals(V, F, np.zeros(3)))
    normals = np.nan_to_num(igl.per_vertex_normals(V, F))
    tilt = 1 - np.einsum("fx,fkx->fk", face_normals, normals[F])
    max_tilt = np.zeros(n)
    np.maximum.at(max_tilt, F.ravel(), tilt.ravel())
    max_tilt[mesh.edges[mesh.faces_per_edge != 2].ravel()] = np.inf
    W = _weights(S)
    row = np.concatenate([W.row, mesh.edges[:, 0], mesh.edges[:, 1]])
    column = np.concatenate([W.col, mesh.edges[:, 1], mesh.edges[:, 0]])
    E = V[column] - V[row]
    heights, lengths = np.zeros(n), np.zeros(n)
    np.maximum.at(heights, row, np.abs(np.einsum("ex,ex->e", E, normals[row])))
    np.maximum.at(lengths, row, np.linalg.norm(E, axis=1))
    edges = np.linalg.norm(V[W.col] - V[W.row], axis=1)
    scale = np.bincount(W.row, weights=np.abs(W.data) * edges, minlength=n)
    is_planar = (max_tilt <= PLANE_TOLERANCE) & (lengths > 0) & (heights <= PLANE_TOLERANCE * lengths) & (scale > 0)
    errors = np.linalg.norm(S @ V, axis=1)[is_planar] / scale[is_planar]
    return float(errors.max()) if is_planar.any() else None


def _definiteness(S: csc_array) -> tuple[float | None, int | None]:
    """Return the smallest eigenvalue of D^-1 S, 0 if not negative, and the number of zero ones; None on failure."""
    D = np.abs(S.diagonal())
    empty = D == 0
    S, D = S[~empty][:, ~empty].tocsc(), D[~empty]
    if len(D) < 3:
        return None, None
    scaled = (diags_array(D**-0.5) @ S @ diags_array(D**-0.5)).tocsc()
    identity = csc_array(diags_array(np.ones(len(D))))
    try:
        n_negative = count_below(scaled, identity, -ZERO_EIGENVALUE)
        n_zero = count_below(scaled, identity, ZERO_EIGENVALUE) - n_negative + int(empty.sum())
        start = np.random.default_rng(SEED).uniform(-1, 1, len(D))
        smallest = eigsh(scaled, 1, which="SA", tol=1e-2, v0=start)[0][0] if n_negative else 0.0
    except (SolveError, ArpackError):
        return None, None
    return float(smallest), n_zero


def _overshoot(S: csc_array, mesh: Mesh) -> float | None:
    """Return how far solutions of S u = 0 leave [0, 1] with random values 0 or 1 on the boundary and some vertices."""
    n, random = S.shape[0], np.random.default_rng(SEED)
    fixed = random.random(n) < FIXED_FRACTION
    fixed[mesh.edges[mesh.faces_per_edge == 1].ravel()] = True
    fixed[np.unique(connected_components(S, directed=False)[1], return_index=True)[1]] = True
    free = ~fixed
    if not free.any():
        return None
    fixed_values = random.integers(0, 2, (int(fixed.sum()), N_PROBLEMS)).astype(np.float64)
    rows = S[free]
    try:
        u = splu(rows[:, free].tocsc()).solve(-(rows[:, fixed] @ fixed_values))
    except RuntimeError:
        return None
    overshoot = max(float(u.max()) - 1.0, -float(u.min()), 0.0)
    return overshoot if np.isfinite(overshoot) else None


def _condition_number(S: csc_array) -> float | None:
    """Return largest over smallest non-zero eigenvalue of a symmetric S on its largest component.

    None if S is indefinite, or on failure.
    """
    component = connected_components(S, directed=False)[1]
    rows = component == np.bincount(component).argmax()
    S = S[rows][:, rows].tocsc()
    n = S.shape[0]
    if n < 3:
        return None
    start = np.random.default_rng(SEED).uniform(-1, 1, n)
    try:
        largest = eigsh(S, 1, which="LM", tol=1e-2, v0=start)[0][0]
        lowest, smallest = smallest_eigenpairs(S, csc_array(diags_array(np.ones(n))), 2)[0]
    except (SolveError, ArpackError):
        return None
    return float(largest / smallest) if smallest > 0 and lowest >= -ZERO_EIGENVALUE * largest else None
