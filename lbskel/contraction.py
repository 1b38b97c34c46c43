"""Contraction of a surface to the neighbourhood of its curve skeleton by an implicit Laplacian flow.

Each step minimises one of the energies of :mod:`lbskel.energies` on operators rebuilt on the positions so far. Weights,
their growth and the stop are those of Au, Tai, Chu, Cohen-Or, Lee 2008, "Skeleton extraction by mesh contraction",
https://doi.org/10.1145/1399504.1360643, section 4, made free of units.
"""

from __future__ import annotations

__all__ = ["PRESETS", "Contraction", "ContractionSettings", "Status", "Step", "contract"]

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from lbskel.degeneracy import DEGENERATE
from lbskel.energies import ENERGIES, Pull, System
from lbskel.errors import MeshError, SolveError, UnknownChoice
from lbskel.mesh import Mesh
from lbskel.operators import Laplacian, Operator, operator_named
from lbskel.operators.clamped_cotangent import corner_cotangents
from lbskel.settings import PRESETS, ContractionSettings
from lbskel.solvers import factorize, relative_residual, solve_once
from lbskel.weights import HOLDS, STARTS, mean_ring_area, ring_areas

AREA_GROWTH = 1 + 1e-9  # over a step that is no more than rounding
BOX_GROWTH = 1.01  # over a step that held vertices may cause and that does no harm
ASYMMETRY = 1e-12  # of the largest entry, which rounding leaves in a symmetric matrix


class Status(str, Enum):
    """Why a contraction ended, as a sentence that a person reads."""

    VOLUME = "the volume fell below its target"
    AREA = "the area fell below its target"
    STALLED = "the area no longer falls"
    STEPS = "the number of steps allowed was reached"
    AREA_GREW = "the area began to grow, the last good step was kept"
    BOX_GREW = "the bounding box began to grow, the last good step was kept"
    NOT_FINITE = "a coordinate was no longer finite, the last good step was kept"
    NOT_SOLVED = "the system could no longer be solved, the last good step was kept"


FAILURES = (Status.AREA_GREW, Status.BOX_GREW, Status.NOT_FINITE, Status.NOT_SOLVED)


@dataclass(frozen=True)
class Step:
    """What one step did; ratios are to the start of the contraction.

    ``weight`` is tau or W_L^2, ``hold`` the smallest and largest entry of H or W_H^2, ``worst_angle`` the smallest
    angle in degrees before the step. ``n_treated`` counts the vertices that the operator's guard or the treatment of
    degenerate triangles has touched, ``n_replaced_rows`` those of the treatment alone; ``drift`` is how far the
    farthest of them went in this step, as a fraction of the extent. ``fault`` is why a guarded contraction would have
    undone the step.
    """

    area_ratio: float
    volume_ratio: float
    box_ratio: float
    weight: float
    hold: tuple[float, float]
    worst_angle: float
    n_clamped_angles: int
    n_treated: int
    n_replaced_rows: int
    drift: float
    residual: float
    seconds: float
    fault: Status | None = None


@dataclass(frozen=True, eq=False)
class Contraction:
    """A contracted mesh, with the record of how it came about.

    Parameters
    ----------
    source : Mesh
        The mesh given.
    mesh : Mesh
        The same faces on the contracted vertices, in the coordinates of the source.
    steps : tuple of Step
        The steps that were kept.
    status : Status
        Why it ended.
    treated_vertices : tuple of (t,) arrays of int
        Of each step, the vertices that ``n_treated`` counts.
    """

    source: Mesh
    mesh: Mesh
    steps: tuple[Step, ...]
    status: Status
    treated_vertices: tuple[NDArray[np.int64], ...] = ()

    @property
    def broke_at(self) -> int | None:
        """Number of the first step, from 1, that failed or was no step at all; None if there was none."""
        faults = [number for number, step in enumerate(self.steps, 1) if step.fault]
        if faults:
            return faults[0]
        return len(self.steps) + 1 if self.status in FAILURES else None


def _smallest_angles(mesh: Mesh) -> NDArray[np.float64]:
    """(m,) smallest angle of each face in radians; 0 where an edge has no length."""
    largest = np.nan_to_num(corner_cotangents(mesh).max(axis=1), nan=np.inf, posinf=np.inf)
    return np.arctan2(1.0, largest)


def contract(
    mesh: Mesh,
    settings: ContractionSettings = PRESETS["flow"],
    *,
    on_step: Callable[[Step, Mesh], None] | None = None,
) -> Contraction:
    """Contract a mesh until nearly nothing of its volume is left.

    A step after which the area or the bounding box has grown, or a number is not finite, is undone and ends the
    contraction: what comes back is always the last good step, unless the settings take the guard away.

    Parameters
    ----------
    mesh : Mesh
        One connected surface, closed or open.
    settings : ContractionSettings
    on_step : callable, optional
        Called after each step that was kept, with its record and the mesh so far, scaled to extent 1.

    Returns
    -------
    Contraction

    Raises
    ------
    MeshError
        If the mesh has no area, or the operator is not defined on it.
    UnknownChoice
        If the operator is not symmetric and the energy needs it to be.

    References
    ----------
    Au, Tai, Chu, Cohen-Or, Lee 2008, https://doi.org/10.1145/1399504.1360643

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> contraction = lbskel.contract(torus(1.0, 0.2))
    >>> contraction.status.value, contraction.steps[-1].volume_ratio < 1e-4
    ('the volume fell below its target', True)
    """
    centre, scale = mesh.centroid, mesh.extent
    if not (scale > 0 and mesh.area > 0):
        raise MeshError("the mesh has no area: every face is degenerate, so there is nothing to contract")
    start = mesh.with_vertices((mesh.vertices - centre) / scale)
    settings = replace(settings, operator=_operator_for(start, settings))
    steps, treated, contracted, status = _flow(start, settings, on_step)
    return Contraction(mesh, mesh.with_vertices(contracted.vertices * scale + centre), steps, status, treated)


def _operator_for(mesh: Mesh, settings: ContractionSettings) -> str | Operator:
    """The operator asked for, or the best that is defined on such a mesh."""
    if settings.operator is not None:
        return settings.operator
    return "intrinsic_delaunay" if mesh.is_closed and mesh.is_edge_manifold else "robust"


def _flow(
    start: Mesh, settings: ContractionSettings, on_step: Callable[[Step, Mesh], None] | None
) -> tuple[tuple[Step, ...], tuple[NDArray[np.int64], ...], Mesh, Status]:
    """Steps until a reason to stop, on a mesh of extent 1, and the vertices treated in each."""
    operator = operator_named(settings.operator or "robust")
    now, factorization = start, None
    weight, largest_weight = _weights(start, settings)
    steps: list[Step] = []
    treated: list[NDArray[np.int64]] = []

    def ended(status: Status) -> tuple[tuple[Step, ...], tuple[NDArray[np.int64], ...], Mesh, Status]:
        return tuple(steps), tuple(treated), now, status

    while len(steps) < settings.max_steps:
        began = time.perf_counter()
        angles = _smallest_angles(now)
        degenerate = np.unique(now.faces[angles < settings.degenerate_angle])
        try:
            laplacian = operator(now)
        except MeshError:
            if not steps:
                raise
            return ended(Status.NOT_FINITE)
        system = _system(start, now, laplacian, min(weight, largest_weight), degenerate, settings)
        try:
            if settings.guard:
                factorization = factorize(system.A, settings.solver, like=factorization)
                D = factorization.solve(system.B)
            else:
                D = solve_once(system.A, system.positions) - now.vertices
        except SolveError:
            _require_symmetric(system, settings)
            return ended(Status.NOT_SOLVED)
        moved = now.vertices + D
        if not np.isfinite(moved).all():
            return ended(Status.NOT_FINITE)
        following = now.with_vertices(moved)
        touched = np.union1d(laplacian.treated_vertices, system.replaced)
        step = Step(
            area_ratio=following.area / start.area,
            volume_ratio=abs(following.volume / start.volume) if start.is_closed and start.volume else float("nan"),
            box_ratio=following.diagonal / start.diagonal,
            weight=min(weight, largest_weight),
            hold=(float(system.hold.min()), float(system.hold.max())),
            worst_angle=float(np.degrees(angles.min())),
            n_clamped_angles=laplacian.n_clamped_angles,
            n_treated=len(touched),
            n_replaced_rows=len(system.replaced),
            drift=float(np.linalg.norm(D[touched], axis=1).max(initial=0.0)),
            residual=relative_residual(system.A, D, system.B),
            seconds=time.perf_counter() - began,
        )
        before = steps[-1] if steps else None
        fault = _fault(step, before)
        if fault and settings.guard:
            return ended(fault)
        steps, treated, now = [*steps, replace(step, fault=fault)], [*treated, touched], following
        if on_step is not None:
            on_step(steps[-1], now)
        if not fault and (success := _success(step, before, settings)):
            return ended(success)
        weight *= settings.growth if settings.energy == "first_order" else settings.growth**2
    return ended(Status.STEPS)


def _weights(start: Mesh, settings: ContractionSettings) -> tuple[float, float]:
    """tau, or W_L^2, of the first step on a mesh of extent 1, and the largest that it may become."""
    tau, mean_ring = STARTS[settings.start](start, settings.start_weight), mean_ring_area(start)
    largest = float("inf") if settings.largest_pull is None else settings.largest_pull**2
    return (tau, largest * mean_ring) if settings.energy == "first_order" else (tau / mean_ring, largest)


def _system(
    start: Mesh,
    now: Mesh,
    laplacian: Laplacian,
    weight: float,
    degenerate: NDArray[np.int64],
    settings: ContractionSettings,
) -> System:
    """What a step solves; the energies know neither how areas are compared nor what is degenerate."""
    rings = ring_areas(start)
    start_mass = np.where(rings > 0, rings / 3, mean_ring_area(start) / 3)
    area_kept = HOLDS[settings.hold](start, now)
    if settings.largest_hold is not None:
        area_kept = np.minimum(area_kept, settings.largest_hold**2)
    treatment = DEGENERATE[settings.degenerate]
    pull = Pull(laplacian, now.vertices, weight, area_kept, start_mass, lambda L: treatment(L, degenerate))
    return ENERGIES[settings.energy](pull)


def _require_symmetric(system: System, settings: ContractionSettings) -> None:
    """Tell that the operator is what cannot be solved with, if it is."""
    if abs(system.A - system.A.T).max() > ASYMMETRY * abs(system.A).max():
        raise UnknownChoice(
            f"the operator {settings.operator!r} is not symmetric, which the energy {settings.energy!r} needs; "
            "use the energy 'least_squares', whose equations are symmetric for any operator, or another operator"
        )


def _fault(step: Step, before: Step | None) -> Status | None:
    """Why a step must be undone, if it must."""
    if step.area_ratio > AREA_GROWTH * (before.area_ratio if before else 1.0):
        return Status.AREA_GREW
    if step.box_ratio > BOX_GROWTH * (before.box_ratio if before else 1.0):
        return Status.BOX_GREW
    return None


def _success(step: Step, before: Step | None, settings: ContractionSettings) -> Status | None:
    """Why a step is the last one needed, if it is.

    A signed volume may pass through zero early, so the area must be small too.
    """
    if step.volume_ratio <= settings.volume_ratio and step.area_ratio <= 0.1:
        return Status.VOLUME
    if not np.isfinite(step.volume_ratio) and step.area_ratio <= settings.area_ratio:
        return Status.AREA
    if before is not None and step.area_ratio > 0.999 * before.area_ratio and step.area_ratio <= 0.1:
        return Status.STALLED
    return None
