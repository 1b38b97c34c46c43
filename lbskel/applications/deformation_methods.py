"""Methods of surface editing: from a Laplacian and constrained vertices to a function of their targets.

With V the surface at rest, D = X - V, and the deltas S V:

- ``harmonic``:     min tr(D^T S D), the smoothest displacement of first order
- ``biharmonic``:   min tr(D^T S M^-1 S D), of second order
- ``naive``:        min |S X - S V|^2, deltas kept as they are
- ``rotated``:      min |S X - R S V|^2, deltas turned by the rotations of the rings in the previous solution
- ``similarity``:   min |S X - T(X) S V|^2, deltas turned and scaled by a linear function of X
- ``arap``:         as rigid as possible (:mod:`lbskel.applications.rigidity`)

The first three are linear in the displacements of the handles, and do not turn details. The last three work on each
component in the frame of the rigid motion that fits its handles best, so that a rotation of all of them is exact. There
``rotated`` starts from ``naive``, and ``arap`` from ``rotated``, since from a linear displacement it ends at folds of
the surface. Sorkine 2005, section 4, https://doi.org/10.2312/egst.20051044; Lipman, Sorkine, Cohen-Or, Levin, Roessl,
Seidel 2004, "Differential coordinates for interactive mesh editing" (rotated),
https://doi.org/10.1109/SMI.2004.1314505; Botsch, Kobbelt 2004 (biharmonic), https://doi.org/10.1145/1015706.1015772.
"""

from __future__ import annotations

__all__ = ["EDITING_METHODS", "ITERATIVE", "Constraints", "Deformation"]

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.applications.constrained_systems import ConstrainedSystem
from lbskel.applications.rigidity import RigidityEnergy
from lbskel.applications.rotation_fitting import rigid_fit
from lbskel.applications.similarity_invariance import invariant_matrix
from lbskel.applications.squared_matrices import matrix_product
from lbskel.applications.symmetric import require_symmetric
from lbskel.errors import SolveError
from lbskel.operators import Laplacian
from lbskel.solvers.factorization import MAX_RESIDUAL

# Iterations of ``rotated`` before ``arap``: fewer leave more energy, and so do 20 on one of three shapes
# (benchmarks/results/applications_editing.md, "Start").
START_ITERATIONS = 5
EPSILON = float(np.finfo(np.float64).eps)  # rounding error of an entry, relative to it

Positions = NDArray[np.float64]
# from the targets of the constrained vertices, a number of iterations, and positions to start from, to all positions
Deformation = Callable[[Positions, int, Positions | None], Positions]


@dataclass(frozen=True, eq=False)
class Constraints:
    """The vertices with targets, and those that stay.

    Parameters
    ----------
    vertices : (k,) array of int
        The vertices of all handles.
    held : (h,) array of int
        Vertices that stay where they are: those of components without a handle.
    component_of_vertex : (n,) array of int
        Components whose rows of the energy are not coupled.
    weight : float, optional
        Weight of soft constraints, relative to the mean of the diagonal of the energy's matrix; by default hard.
    solver : str
        A name in SOLVERS.
    """

    vertices: NDArray[np.int64]
    held: NDArray[np.int64]
    component_of_vertex: NDArray[np.int64]
    weight: float | None
    solver: str

    def system(self, Q: csc_array, dimensions: int = 1) -> ConstrainedSystem:
        """Factorize an energy whose matrix Q has ``dimensions`` rows for each vertex."""
        weight = None if self.weight is None else self.weight * float(Q.diagonal().mean())
        rows = [(dimensions * part[:, None] + np.arange(dimensions)).ravel() for part in (self.vertices, self.held)]
        return ConstrainedSystem(Q, rows[0], weight=weight, held=rows[1], solver=self.solver)


def _displaced(Q: csc_array, V: Positions, constraints: Constraints) -> Deformation:
    """Minimize tr(D^T Q D)."""
    system = constraints.system(Q)
    rest = V[constraints.vertices]
    return lambda targets, iterations, initial: V + system.solve(targets - rest)


def _harmonic(L: Laplacian, V: Positions, constraints: Constraints) -> Deformation:
    return _displaced(L.stiffness, V, constraints)


def _biharmonic(L: Laplacian, V: Positions, constraints: Constraints) -> Deformation:
    return _displaced(matrix_product(L.stiffness, L.strong()), V, constraints)


def _naive(L: Laplacian, V: Positions, constraints: Constraints) -> Deformation:
    return _displaced(matrix_product(L.stiffness.T, L.stiffness), V, constraints)


def _aligned(V: Positions, constraints: Constraints, deform: Deformation) -> Deformation:
    """Solve in the frames of the rigid motions that fit the handles of each component best; held vertices stay."""
    handles, held, component = constraints.vertices, constraints.held, constraints.component_of_vertex
    rest, of_handle, k = V[handles], component[handles], int(component.max()) + 1

    def solve(targets: Positions, iterations: int, initial: Positions | None) -> Positions:
        R, t = np.tile(np.eye(3), (k, 1, 1)), np.zeros((k, 3))
        for own in np.unique(of_handle).tolist():
            R[own], t[own] = rigid_fit(rest[of_handle == own], targets[of_handle == own])
        start = None if initial is None else _turned(initial - t[component], R.transpose(0, 2, 1)[component])
        X = deform(_turned(targets - t[of_handle], R.transpose(0, 2, 1)[of_handle]), iterations, start)
        X = _turned(X, R[component]) + t[component]
        X[held] = V[held]
        return X

    return solve


def _turned(points: Positions, rotations: NDArray[np.float64]) -> Positions:
    """(n, 3) points, each turned by its own of (n, 3, 3) rotations."""
    turned: Positions = np.einsum("nab,nb->na", rotations, points)
    return turned


def _rotated(L: Laplacian, V: Positions, constraints: Constraints) -> Deformation:
    S = L.stiffness
    system, rings = constraints.system(matrix_product(S.T, S)), RigidityEnergy(S, V)
    rest, deltas, transposed = V[constraints.vertices], S @ V, S.T.tocsr()

    def deform(targets: Positions, iterations: int, initial: Positions | None) -> Positions:
        X = V + system.solve(targets - rest) if initial is None else initial
        for _ in range(iterations):
            turned = _turned(deltas, rings.rotations(X))
            X = V + system.solve(targets - rest, transposed @ (turned - deltas))
        return X

    return _aligned(V, constraints, deform)


def _require_regular(system: ConstrainedSystem, L: Laplacian, n_values: int) -> None:
    """Refuse a singular system of three rows for each vertex, as where a part hangs on one vertex and may turn.

    Displacements of handles hardly meet the null space, so that their solution has a small residual wherever it leads.
    Random forces meet it: they leave a large residual, or move a vertex so far that rounding errors of its row count.
    They are as large as the weights, so that long thin triangles alone are not refused.
    """
    weights = np.repeat(np.abs(L.stiffness.diagonal()), 3)[:, None]
    forces = np.random.default_rng(0).standard_normal(weights.shape)
    try:
        moved = weights * system.solve(np.zeros((n_values, 1)), weights * forces)
        residual = EPSILON * float(np.abs(moved).max() / np.abs(forces).max())
    except SolveError as error:
        residual = error.residual
    if residual > MAX_RESIDUAL:
        raise SolveError(
            "the matrix is singular to working accuracy, as where a part hangs on one vertex and may turn and grow; "
            "take another method, or hold such parts by handles",
            residual,
        )


def _similarity(L: Laplacian, V: Positions, constraints: Constraints) -> Deformation:
    K = invariant_matrix(L.stiffness, V)
    system = constraints.system(matrix_product(K.T, K, dimensions=3), dimensions=3)
    rest = V[constraints.vertices]
    _require_regular(system, L, rest.size)

    def deform(targets: Positions, iterations: int, initial: Positions | None) -> Positions:
        return V + system.solve((targets - rest).reshape(-1, 1)).reshape(-1, 3)  # K V = 0

    return _aligned(V, constraints, deform)


def _arap(L: Laplacian, V: Positions, constraints: Constraints) -> Deformation:
    require_symmetric(L)
    system, energy = constraints.system(L.stiffness), RigidityEnergy(L.stiffness, V)
    start = cache(partial(_rotated, L, V, constraints))  # factorized when it is needed
    handles, S = constraints.vertices, L.stiffness.tocsr()

    def deform(targets: Positions, iterations: int, initial: Positions | None) -> Positions:
        X = start()(targets, START_ITERATIONS, None) if initial is None else initial
        for _ in range(iterations):
            right = energy.right_hand_side(energy.rotations(X))
            X = X + system.solve(targets - X[handles], right - S @ X, refined=False)
        return X

    return _aligned(V, constraints, deform)


EDITING_METHODS: dict[str, Callable[[Laplacian, Positions, Constraints], Deformation]] = {
    "arap": _arap,
    "similarity": _similarity,
    "rotated": _rotated,
    "naive": _naive,
    "biharmonic": _biharmonic,
    "harmonic": _harmonic,
}

ITERATIVE = ("arap", "rotated")
"""The methods that iterate; the others solve once, whatever the number of iterations."""
