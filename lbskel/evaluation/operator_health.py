"""How healthy a discrete Laplacian is on the mesh at hand, measured.

No discrete Laplacian on general meshes is symmetric, local, linearly precise and of positive weights at once:
Wardetzky, Mathur, Kaelberer, Grinspun 2007, "Discrete Laplace operators: no free lunch",
https://doi.org/10.2312/SGP/SGP07/033-037. :func:`laplacian_diagnostics` measures these four, whether constants are all that has no
energy, the maximum principle, and what a contraction needs besides.
"""

from __future__ import annotations

__all__ = ["LaplacianDiagnostics", "laplacian_diagnostics"]

from dataclasses import dataclass

import igl
import numpy as np
from scipy.sparse import coo_array, csc_array, diags_array, triu
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import ArpackError, eigsh, splu

from lbskel.errors import SolveError
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators import Laplacian
from lbskel.solvers.eigenproblem import count_below, smallest_eigenpairs

ROUNDING = 1e-12  # of the largest entry, or of the mean weight: sums of a few dozen rounded numbers
FLAT = 1e-10  # what counts as a plane, in lengths of the longest edge of a row
STRAIGHT = 1e-8  # linear precision on such a plane: FLAT times the growth by weights of needles
NEAR_ZERO = 1e-10  # of the eigenvalues of D^-1 S, which are between 0 and 2; the first true one is about 1 / n
OVERSHOOT = 1e-9  # of values between 0 and 1: the error of the solve
SAME_AREA = 1e-6  # edges made longer by a guard change areas this much
HELD, N_PROBLEMS = 0.05, 16  # share of the vertices held, and sets of values there, for the maximum principle
SEED = 0


@dataclass(frozen=True)
class LaplacianDiagnostics:
    """The measures; None where one is not defined or could not be found.

    Parameters
    ----------
    asymmetry : float
        Largest |S - S^T| over largest |S|.
    off_edges : float
        Share of the off-diagonal entries that belong to no edge of the mesh.
    constants : float
        Largest |S 1| over largest |S|.
    linear_precision : float or None
        Largest |(S V)_i| over sum_j |w_ij| |e_ij|, of the inner vertices whose row sees a plane only; None without any.
    n_negative, negative_share, worst_negative : int, float, float
        Pairs of vertices with a negative weight, their share, and the worst in mean sizes of a weight.
    smallest_eigenvalue : float or None
        Of D^-1 (S + S^T) / 2 with D the diagonal of S; 0 where none is below rounding.
    n_zero_eigenvalues : int or None
        Number of functions without energy.
    n_components : int
        Connected components of the mesh, which that number should equal.
    overshoot : float or None
        How far solutions of Dirichlet problems leave the range of the values given, over that range.
    condition : float or None
        Largest over smallest non-zero eigenvalue of (S + S^T) / 2 on the largest component.
    n_fallback_rows : int
        Vertices whose row a guard changed.
    area_ratio : float or None
        Total mass over the area of the mesh.
    """

    asymmetry: float
    off_edges: float
    constants: float
    linear_precision: float | None
    n_negative: int
    negative_share: float
    worst_negative: float
    smallest_eigenvalue: float | None
    n_zero_eigenvalues: int | None
    n_components: int
    overshoot: float | None
    condition: float | None
    n_fallback_rows: int
    area_ratio: float | None

    @property
    def passed(self) -> dict[str, bool | None]:
        """Each property by name: held up to rounding, not held, or None where it was not measured."""
        semidefinite = None if self.smallest_eigenvalue is None else self.smallest_eigenvalue >= -NEAR_ZERO
        return {
            "symmetric": self.asymmetry <= ROUNDING,
            "local": self.off_edges == 0,
            "constants": self.constants <= ROUNDING,
            "linear": None if self.linear_precision is None else self.linear_precision <= STRAIGHT,
            "positive": self.n_negative == 0,
            "semidefinite": semidefinite,
            "null space": None if self.n_zero_eigenvalues is None else self.n_zero_eigenvalues == self.n_components,
            "maximum": None if self.overshoot is None else self.overshoot <= OVERSHOOT,
            "untreated": self.n_fallback_rows == 0,
            "area": None if self.area_ratio is None else abs(self.area_ratio - 1) <= SAME_AREA,
        }


def laplacian_diagnostics(laplacian: Laplacian, mesh: Mesh) -> LaplacianDiagnostics:
    """Measure an operator on its mesh.

    Parameters
    ----------
    laplacian : Laplacian
    mesh : Mesh
        The mesh that it was made of.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.evaluation.operator_health import laplacian_diagnostics
    >>> from lbskel.shapes import sphere
    >>> mesh = sphere(2)
    >>> laplacian_diagnostics(lbskel.laplacian(mesh, operator="graph"), mesh).passed["symmetric"]
    True
    """
    S = laplacian.stiffness
    largest = max(float(np.abs(S.data).max(initial=0.0)), np.finfo(np.float64).tiny)
    symmetric = ((S + S.T) / 2).tocsc()
    used = np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices)) > 0
    n_negative, share, worst = _negative_weights(S)
    smallest, n_zero = _definiteness(symmetric[used][:, used])
    return LaplacianDiagnostics(
        asymmetry=float(abs(S - S.T).max()) / largest,
        off_edges=_off_edges(S, mesh),
        constants=float(np.abs(S.sum(axis=1)).max()) / largest,
        linear_precision=_linear_precision(S, mesh),
        n_negative=n_negative,
        negative_share=share,
        worst_negative=worst,
        smallest_eigenvalue=smallest,
        n_zero_eigenvalues=n_zero,
        n_components=mesh.n_components,
        overshoot=_overshoot(S, mesh),
        condition=_condition(symmetric),
        n_fallback_rows=len(laplacian.treated_vertices),
        area_ratio=float(laplacian.mass.sum()) / mesh.area if mesh.area > 0 else None,
    )


def _weights(S: csc_array) -> coo_array:
    """The entries off the diagonal, with the sign of weights."""
    W = (diags_array(S.diagonal()) - S).tocsc()
    W.eliminate_zeros()
    return W.tocoo()


def _adjacency(mesh: Mesh) -> csc_array:
    """One for each pair of different vertices that share an edge, both ways."""
    i, j = mesh.edges[mesh.edges[:, 0] != mesh.edges[:, 1]].T
    ones, n = np.ones(2 * len(i)), len(mesh.vertices)
    return coo_array((ones, (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(n, n)).tocsc()


def _off_edges(S: csc_array, mesh: Mesh) -> float:
    """Share of the weights that belong to no edge."""
    W = abs(_weights(S)).sign()
    return float(1 - W.multiply(_adjacency(mesh)).sum() / W.nnz) if W.nnz else 0.0


def _negative_weights(S: csc_array) -> tuple[int, float, float]:
    """Number and share of the pairs with a negative weight, and the worst over the mean size of a weight."""
    W = _weights(S).tocsr()
    if W.nnz == 0:
        return 0, 0.0, 0.0
    mean = float(np.abs(W.data).mean())
    lower = triu(W.minimum(W.T), format="coo").data
    n_pairs = triu(abs(W) + abs(W.T), format="coo").nnz
    negative = lower < -ROUNDING * mean
    return int(negative.sum()), float(negative.sum() / n_pairs), float(lower.min(initial=0.0)) / mean


def _linear_precision(S: csc_array, mesh: Mesh) -> float | None:
    """Largest relative |S V| at the inner vertices whose ring and row lie in one plane, or None."""
    V, F, n = unit_scale(mesh.vertices)[0], mesh.faces, len(mesh.vertices)
    face_normals = np.nan_to_num(igl.per_face_normals(V, F, np.zeros(3)))
    normals = np.nan_to_num(igl.per_vertex_normals(V, F))
    tilt = 1 - np.einsum("fx,fkx->fk", face_normals, normals[F])
    flat = np.zeros(n)
    np.maximum.at(flat, F.ravel(), tilt.ravel())
    flat[mesh.edges[mesh.faces_per_edge != 2].ravel()] = np.inf
    W = _weights(S)
    row = np.concatenate([W.row, mesh.edges[:, 0], mesh.edges[:, 1]])
    column = np.concatenate([W.col, mesh.edges[:, 1], mesh.edges[:, 0]])
    E = V[column] - V[row]
    heights, lengths = np.zeros(n), np.zeros(n)
    np.maximum.at(heights, row, np.abs(np.einsum("ex,ex->e", E, normals[row])))
    np.maximum.at(lengths, row, np.linalg.norm(E, axis=1))
    edges = np.linalg.norm(V[W.col] - V[W.row], axis=1)
    scale = np.bincount(W.row, weights=np.abs(W.data) * edges, minlength=n)
    inner = (flat <= FLAT) & (lengths > 0) & (heights <= FLAT * lengths) & (scale > 0)
    return float((np.linalg.norm(S @ V, axis=1)[inner] / scale[inner]).max()) if inner.any() else None


def _definiteness(S: csc_array) -> tuple[float | None, int | None]:
    """Smallest eigenvalue of D^-1 S if it is negative, else 0, and the number of zero ones; None where not found."""
    D = np.abs(S.diagonal())
    empty = D == 0
    S, D = S[~empty][:, ~empty].tocsc(), D[~empty]
    if len(D) < 3:
        return None, None
    scaled = (diags_array(D**-0.5) @ S @ diags_array(D**-0.5)).tocsc()
    one = csc_array(diags_array(np.ones(len(D))))
    try:
        n_negative = count_below(scaled, one, -NEAR_ZERO)
        n_zero = count_below(scaled, one, NEAR_ZERO) - n_negative + int(empty.sum())
        start = np.random.default_rng(SEED).uniform(-1, 1, len(D))
        smallest = eigsh(scaled, 1, which="SA", tol=1e-2, v0=start)[0][0] if n_negative else 0.0
    except (RuntimeError, ArpackError):
        return None, None
    return float(smallest), n_zero


def _overshoot(S: csc_array, mesh: Mesh) -> float | None:
    """How far solutions of S u = 0 leave [0, 1] where the boundary and some other vertices are held at 0 or 1."""
    n, random = S.shape[0], np.random.default_rng(SEED)
    held = random.random(n) < HELD
    held[mesh.edges[mesh.faces_per_edge == 1].ravel()] = True
    held[np.unique(connected_components(S, directed=False)[1], return_index=True)[1]] = True
    inner = ~held
    if not inner.any():
        return None
    given = random.integers(0, 2, (int(held.sum()), N_PROBLEMS)).astype(np.float64)
    rows = S[inner]
    try:
        u = splu(rows[:, inner].tocsc()).solve(-(rows[:, held] @ given))
    except RuntimeError:
        return None
    beyond = max(float(u.max()) - 1.0, -float(u.min()), 0.0)
    return beyond if np.isfinite(beyond) else None


def _condition(S: csc_array) -> float | None:
    """Largest over smallest non-zero eigenvalue of the largest component of a symmetric S."""
    component = connected_components(S, directed=False)[1]
    rows = component == np.bincount(component).argmax()
    S = S[rows][:, rows].tocsc()
    n = S.shape[0]
    if n < 3:
        return None
    start = np.random.default_rng(SEED).uniform(-1, 1, n)
    try:
        largest = eigsh(S, 1, which="LM", tol=1e-2, v0=start)[0][0]
        smallest = smallest_eigenpairs(S, csc_array(diags_array(np.ones(n))), 2)[0][1]
    except (SolveError, ArpackError):
        return None
    return float(largest / smallest) if smallest > 0 else None
