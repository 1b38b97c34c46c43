"""Editing a surface by handles: regions are moved rigidly, and the rest of the surface follows.

An :class:`Editor` factorizes once for a choice of regions and solves for any motions of them. The methods are in
:mod:`lbskel.applications.deformation_methods`.
"""

from __future__ import annotations

__all__ = ["Editor", "edit"]

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.applications.constrained_systems import checked_indices
from lbskel.applications.deformation_methods import EDITING_METHODS, ITERATIVE, Constraints
from lbskel.applications.differential_coordinates import checked_weight, coupled_components, uncoupled_rows
from lbskel.applications.rigid_motions import checked_motion
from lbskel.applications.rigidity import RigidityEnergy
from lbskel.errors import MeshError, SolveError, UnknownChoice, checked_count, choose
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators import Operator, apply_operator

ITERATIONS = 10  # of the methods that iterate: libigl's number. With many more, fine surfaces buckle under arap


class Editor:
    """A surface with handles, factorized once for any motions of these.

    Components without a handle, and vertices without a face, stay where they are. Triangles that share no vertices are
    components: merge vertices at one place first, by the preprocessing step ``merge_close``.

    Parameters
    ----------
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
    handles : sequence of (k,) array_like of int, or of (n,) array_like of bool
        The vertices of each handle; no vertex in two of them. A handle that shall stay is moved by the identity.
    method : {"arap", "similarity", "rotated", "naive", "biharmonic", "harmonic"}
    operator : str or callable
        A name in OPERATORS, or a function from a Mesh to a Laplacian; for ``arap`` a symmetric one.
    handle_weight : float, optional
        Weight of soft handles, relative to the mean of the diagonal of the energy's matrix; by default they are hard.
    solver : str
        A name in SOLVERS.

    Raises
    ------
    MeshError
        If a handle is no list of vertices, two overlap, there is none, the operator is not symmetric for ``arap``, or a
        vertex has too many neighbors for a method other than ``harmonic``.
    SolveError
        If the system is singular.
    UnknownChoice
        If no method, operator or solver has that name, or the weight is not above zero.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import capsule
    >>> rod = capsule(3.0, 0.4, 10)
    >>> z = rod.vertices[:, 2]
    >>> editor = lbskel.Editor(rod, [z < z.min() + 0.5, z > z.max() - 0.5])
    >>> bent = editor.edit([lbskel.rigid_motion(), lbskel.rigid_motion(axis=[0, 1, 0], angle_deg=60)])
    >>> bool(editor.rigidity_energy(bent) < editor.rigidity_energy(rod) + 1)
    True
    """

    def __init__(
        self,
        mesh: Any,
        handles: Sequence[ArrayLike],
        *,
        method: str = "arap",
        operator: str | Operator = "robust",
        handle_weight: float | None = None,
        solver: str = "cholmod",
    ):
        self.mesh: Mesh = as_mesh(mesh)
        make, self.method = choose(EDITING_METHODS, method, "method"), method
        n = len(self.mesh.vertices)
        self.handles = tuple(checked_indices(handle, n, "vertices of a handle") for handle in handles)
        if not sum(map(len, self.handles)):
            raise MeshError("there is no handle: give at least one region of vertices")
        vertices = checked_indices(np.concatenate(self.handles), n, "vertices of handles")
        weight = checked_weight(handle_weight, "handle_weight")
        laplacian = apply_operator(operator, self.mesh)
        labels = coupled_components(laplacian.stiffness)
        has_handle = np.zeros(labels.max() + 1, dtype=bool)
        has_handle[labels[vertices]] = True
        is_held = ~has_handle[labels] | uncoupled_rows(laplacian.stiffness)
        is_held[vertices] = False
        constraints = Constraints(vertices, np.flatnonzero(is_held), labels, weight, solver)
        scaled, self._exponent = unit_scale(self.mesh.vertices)
        self._center, self._laplacian = scaled[self.mesh.used_vertices].mean(axis=0), laplacian
        try:
            self._deform = make(laplacian, scaled - self._center, constraints)
        except SolveError as error:
            raise SolveError(
                f"{error}; the handles do not determine the surface: give each component more of their vertices, take "
                "another method, or merge vertices at one place by the preprocessing step merge_close",
                error.residual,
            ) from None

    def _scaled(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points in the coordinates of the solution: about the origin and of about unit size."""
        scaled: NDArray[np.float64] = np.ldexp(points, -self._exponent) - self._center
        return scaled

    def edit(self, motions: Sequence[ArrayLike], *, iterations: int | None = None, initial: Any = None) -> Mesh:
        """Move the handles, and the surface with them.

        Parameters
        ----------
        motions : sequence of (4, 4) array_like of float
            The motion of each handle from its place at rest, in homogeneous coordinates of column vectors: a rotation
            in the first three rows and columns, the translation in the last column, and 0, 0, 0, 1 in the last row;
            see :func:`lbskel.rigid_motion`.
        iterations : int, optional
            Iterations of ``arap`` and ``rotated``, ten by default.
        initial : Mesh or (n, 3) array_like of float, optional
            Positions from which these two start; by default ``rotated`` starts from the solution of ``naive``, and
            ``arap`` from five iterations of ``rotated``.

        Returns
        -------
        Mesh
            The same faces and order of vertices.

        Raises
        ------
        MeshError
            If there is not one (4, 4) matrix of a rigid motion for each handle, or not one initial position for each
            vertex.
        SolveError
            If the system is singular to working accuracy.
        UnknownChoice
            If iterations is no whole number from 0 on, or it or initial is given for a method that solves once.
        """
        if self.method not in ITERATIVE and not (iterations is None and initial is None):
            raise UnknownChoice(f"the method {self.method} solves once, without iterations and initial positions")
        iterations = checked_count(ITERATIONS if iterations is None else iterations, "iterations", 0)
        matrices = [checked_motion(motion, handle) for handle, motion in enumerate(motions)]
        if len(matrices) != len(self.handles):
            raise MeshError(f"give one (4, 4) matrix for each of the {len(self.handles)} handles, not {len(matrices)}")
        moved = [
            self.mesh.vertices[handle] @ matrix[:3, :3].T + matrix[:3, 3]
            for handle, matrix in zip(self.handles, matrices, strict=True)
        ]
        start = None
        if initial is not None:
            start = self._scaled(self._moved(getattr(initial, "vertices", initial)))
        X = self._deform(self._scaled(np.concatenate(moved)), iterations, start)
        return self.mesh.with_vertices(np.ldexp(X + self._center, self._exponent))

    def rigidity_energy(self, edited: Any) -> float:
        """Compute the as-rigid-as-possible energy of a deformation, in squared units of length.

        Parameters
        ----------
        edited : Mesh or anything that :func:`lbskel.as_mesh` takes
            With the vertices of the mesh, moved.

        Raises
        ------
        MeshError
            If it has another number of vertices.
        """
        energy = RigidityEnergy(self._laplacian.stiffness, self._scaled(self.mesh.vertices))
        with np.errstate(over="ignore"):  # squares of large units are infinite
            return float(
                np.ldexp(energy.value(self._scaled(self._moved(as_mesh(edited).vertices))), 2 * self._exponent)
            )

    def _moved(self, positions: ArrayLike) -> NDArray[np.float64]:
        """Return the positions of the mesh's vertices in a deformation of it."""
        if np.shape(positions) != self.mesh.vertices.shape:
            n = len(self.mesh.vertices)
            raise MeshError(f"give one position for each of the {n} vertices, not shape {np.shape(positions)}")
        return self.mesh.with_vertices(positions).vertices


def edit(
    mesh: Any,
    handles: Sequence[ArrayLike],
    motions: Sequence[ArrayLike],
    *,
    method: str = "arap",
    iterations: int | None = None,
    operator: str | Operator = "robust",
    handle_weight: float | None = None,
    solver: str = "cholmod",
) -> Mesh:
    """Move regions of a surface rigidly, and the rest of the surface with them.

    An :class:`lbskel.Editor` does the same for many motions of the same handles, and factorizes once.

    Parameters
    ----------
    mesh, handles, method, operator, handle_weight, solver
        As for :class:`lbskel.Editor`.
    motions, iterations
        As for :meth:`lbskel.Editor.edit`.

    Raises
    ------
    MeshError
        If handles or motions are not valid, the operator is not symmetric for ``arap``, or a vertex has too many
        neighbors for a method other than ``harmonic``.
    SolveError
        If the system is singular to working accuracy.
    UnknownChoice
        If no method, operator or solver has that name, or a number is out of range.

    References
    ----------
    Sorkine, Alexa 2007 (arap); Sorkine et al. 2004 (similarity); Lipman et al. 2004 (rotated).

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import capsule
    >>> rod = capsule(3.0, 0.4, 10)
    >>> z = rod.vertices[:, 2]
    >>> motions = [lbskel.rigid_motion(), lbskel.rigid_motion(translation=[0, 0, 1])]
    >>> longer = lbskel.edit(rod, [z < z.min() + 0.5, z > z.max() - 0.5], motions)
    >>> round(float(longer.vertices[:, 2].max() - z.max()), 9)
    1.0
    """
    editor = Editor(mesh, handles, method=method, operator=operator, handle_weight=handle_weight, solver=solver)
    return editor.edit(motions, iterations=iterations)
