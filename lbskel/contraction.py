"""Contraction of a surface to the neighbourhood of its curve skeleton by an implicit Laplacian flow.

Each step minimises one of the energies of :mod:`lbskel.energies` on operators rebuilt on the positions so far. Weights,
their growth and the stop are those of Au, Tai, Chu, Cohen-Or, Lee 2008, "Skeleton extraction by mesh contraction",
https://doi.org/10.1145/1399504.1360643, section 4, made free of units.
"""

from __future__ import annotations

__all__ = ["DEGENERATE", "PRESETS", "Contraction", "ContractionSettings", "Status", "Step", "contract"]

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from lbskel.energies import ENERGIES, Pull
from lbskel.errors import MeshError, SolveError, UnknownChoice, choose
from lbskel.mesh import Mesh
from lbskel.operators import Operator, operator_named
from lbskel.operators.clamped_cotangent import corner_cotangents
from lbskel.solvers import SOLVERS, factorize

AREA_GROWTH = 1 + 1e-9  # over a step that is no more than rounding
BOX_GROWTH = 1.01  # over a step that held vertices may cause and that does no harm
THINNEST = 1e-12  # ring areas are not let fall below this share of their start, which bounds the hold


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


@dataclass(frozen=True)
class ContractionSettings:
    """Parameters of a contraction; none has a unit.

    Parameters
    ----------
    operator : str, callable or None
        A name in OPERATORS or a function. None takes ``intrinsic_delaunay`` on a closed edge-manifold mesh and
        ``robust`` on any other.
    energy : str
        A name in ENERGIES.
    start_weight : float
        Reach of the first step, as a fraction of the mesh's extent.
    growth : float
        Factor on tau, or on W_L, after each step.
    degenerate : str
        What becomes of the rows of L at vertices of triangles with an angle under ``degenerate_angle``, for
        ``least_squares``: ``none`` leaves them; ``identity`` puts an identity row with the right-hand side that holds
        the vertex; ``identity_zero`` the one with right-hand side zero, which pulls it to the origin.
    degenerate_angle : float
        In radians.
    volume_ratio, area_ratio : float
        The contraction is done when the volume of a closed mesh, or the area of an open one, has fallen to this
        fraction.
    max_steps : int
    solver : str
        A name in SOLVERS.
    """

    operator: str | Operator | None = None
    energy: str = "first_order"
    start_weight: float = 0.02
    growth: float = 2.0
    degenerate: str = "none"
    degenerate_angle: float = 1e-3
    volume_ratio: float = 1e-4
    area_ratio: float = 5e-3
    max_steps: int = 30
    solver: str = "cholmod"

    def __post_init__(self) -> None:
        choose(ENERGIES, self.energy, "energy")
        choose(SOLVERS, self.solver, "solver")
        choose(dict.fromkeys(DEGENERATE), self.degenerate, "treatment of degenerate triangles")
        if self.operator is not None:
            operator_named(self.operator)
        if self.degenerate != "none" and self.energy != "least_squares":
            raise UnknownChoice(
                "identity rows belong to the energy 'least_squares'; 'first_order' has no rows to replace"
            )
        for name in ("start_weight", "growth", "volume_ratio", "area_ratio", "max_steps"):
            if not getattr(self, name) > 0:
                raise UnknownChoice(f"{name} must be positive, not {getattr(self, name)}")


@dataclass(frozen=True)
class Step:
    """What one step did; ratios are to the start of the contraction.

    ``weight`` is tau or W_L^2, ``hold`` the smallest and largest entry of H or W_H^2, ``worst_angle`` the smallest
    angle in degrees before the step.
    """

    area_ratio: float
    volume_ratio: float
    box_ratio: float
    weight: float
    hold: tuple[float, float]
    worst_angle: float
    n_clamped_angles: int
    n_identity_rows: int
    residual: float
    seconds: float


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
    """

    source: Mesh
    mesh: Mesh
    steps: tuple[Step, ...]
    status: Status


DEGENERATE = ("none", "identity", "identity_zero")

PRESETS: dict[str, ContractionSettings] = {
    "flow": ContractionSettings(),
    "au2008": ContractionSettings(
        operator="clamped_cotangent", energy="least_squares", degenerate="identity", volume_ratio=1e-6
    ),
}


def _ring_areas(mesh: Mesh) -> NDArray[np.float64]:
    """Total area of the triangles at each vertex."""
    sums = np.bincount(mesh.faces.ravel(), weights=np.repeat(mesh.face_areas, 3), minlength=len(mesh.vertices))
    return np.asarray(sums, dtype=np.float64)


def _start_weight(settings: ContractionSettings, ring_areas: NDArray[np.float64]) -> float:
    """tau, or W_L^2, of the first step on a mesh of extent 1: a reach squared, for W_L per mean ring area."""
    reach = settings.start_weight**2
    return reach if settings.energy == "first_order" else reach / float(ring_areas.mean())


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
    contraction: what comes back is always the last good step.

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
    steps, contracted, status = _flow(start, settings, on_step)
    return Contraction(mesh, mesh.with_vertices(contracted.vertices * scale + centre), steps, status)


def _operator_for(mesh: Mesh, settings: ContractionSettings) -> str | Operator:
    """The operator asked for, or the best that is defined on such a mesh."""
    if settings.operator is not None:
        return settings.operator
    return "intrinsic_delaunay" if mesh.is_closed and mesh.is_edge_manifold else "robust"


def _flow(
    start: Mesh, settings: ContractionSettings, on_step: Callable[[Step, Mesh], None] | None
) -> tuple[tuple[Step, ...], Mesh, Status]:
    """Steps until a reason to stop, on a mesh of extent 1."""
    operator = operator_named(settings.operator or "robust")
    start_rings = _ring_areas(start)
    used = start_rings > 0
    start_mass = np.where(used, start_rings / 3, start_rings[used].mean() / 3)
    weight = _start_weight(settings, start_rings[used])
    now, factorization = start, None
    steps: list[Step] = []
    while len(steps) < settings.max_steps:
        began = time.perf_counter()
        rings = np.maximum(_ring_areas(now), THINNEST * start_rings)
        area_kept = np.where(used, start_rings / np.where(used, rings, 1.0), 1.0)
        angles = _smallest_angles(now)
        is_degenerate = angles < (0.0 if settings.degenerate == "none" else settings.degenerate_angle)
        rows = np.unique(now.faces[is_degenerate])
        laplacian = operator(now)
        pull = Pull(laplacian, now.vertices, weight, area_kept, start_mass, rows, settings.degenerate == "identity")
        try:
            A, B, H = ENERGIES[settings.energy](pull)
            factorization = factorize(A, settings.solver, like=factorization)
            D = factorization.solve(B)
        except SolveError:
            return tuple(steps), now, Status.NOT_SOLVED
        moved = now.vertices + D
        if not np.isfinite(moved).all():
            return tuple(steps), now, Status.NOT_FINITE
        following = now.with_vertices(moved)
        step = Step(
            area_ratio=following.area / start.area,
            volume_ratio=abs(following.volume / start.volume) if start.is_closed and start.volume else float("nan"),
            box_ratio=following.diagonal / start.diagonal,
            weight=weight,
            hold=(float(H.min()), float(H.max())),
            worst_angle=float(np.degrees(angles.min())),
            n_clamped_angles=laplacian.n_clamped_angles,
            n_identity_rows=len(rows),
            residual=factorization.residual(D, B),
            seconds=time.perf_counter() - began,
        )
        before = steps[-1] if steps else None
        if failure := _failure(step, before):
            return tuple(steps), now, failure
        steps, now = [*steps, step], following
        if on_step is not None:
            on_step(step, now)
        if success := _success(step, before, settings):
            return tuple(steps), now, success
        weight *= settings.growth if settings.energy == "first_order" else settings.growth**2
    return tuple(steps), now, Status.STEPS


def _failure(step: Step, before: Step | None) -> Status | None:
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
