"""Contraction of a surface to the neighborhood of its curve skeleton by an implicit Laplacian flow.

Each step minimizes one of the energies of :mod:`lbskel.contraction.energies` on operators rebuilt on the positions so far. Weights,
their growth and the stop are those of Au, Tai, Chu, Cohen-Or, Lee 2008, "Skeleton extraction by mesh contraction",
https://doi.org/10.1145/1399504.1360643, section 4, made free of units.
"""

from __future__ import annotations

__all__ = ["PRESETS", "Contraction", "ContractionSettings", "Status", "Step", "contract"]

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.coarsening import Coarsened, coarsen
from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES, ContractionStepInput, LinearSystem
from lbskel.contraction.result import Contraction, Status, Step, fault_of, success_of
from lbskel.contraction.settings import PRESETS, ContractionSettings
from lbskel.contraction.weights import ATTRACTIONS, INITIAL_WEIGHT_RULES, mean_ring_area, ratio_of_areas, ring_areas
from lbskel.errors import MeshError, SolveError, UnknownChoice
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.vertex_map import VertexMap
from lbskel.operators import Laplacian, Operator, operator_named
from lbskel.operators.corner_angles import corner_cotangents
from lbskel.solvers import factorize, relative_residual, solve_once

FINEST = 0.004  # of the extent: where vertices may be merged no shorter edge is kept after the first, smoothing step
ASYMMETRY = 1e-12  # of the largest entry, which rounding leaves in a symmetric matrix


def _smallest_angles(mesh: Mesh) -> NDArray[np.float64]:
    """(m,) smallest angle of each face in radians; 0 where an edge has no length."""
    a, b, c = corner_cotangents(mesh).T
    return np.arctan2(1.0, np.nan_to_num(np.maximum(np.maximum(a, b), c), nan=np.inf, posinf=np.inf))


def contract(
    mesh: Mesh,
    settings: ContractionSettings = PRESETS["curvature_flow"],
    *,
    on_step: Callable[[Step, Mesh], None] | None = None,
    time_limit: float | None = None,
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
    time_limit : float, optional
        Seconds after which no step is begun.

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
    center, scale = mesh.centroid, mesh.diameter_bound
    if not (scale > 0 and mesh.area > 0):
        raise MeshError("the mesh has no area: every face is degenerate, so there is nothing to contract")
    start = mesh.with_vertices((mesh.vertices - center) / scale)
    settings = replace(settings, operator=_operator_for(start, settings))
    end = float("inf") if time_limit is None else time.perf_counter() + time_limit
    steps, treated, now, status = _flow(start, settings, on_step, end)
    coarse = now.mesh.with_vertices(now.mesh.vertices * scale + center)
    return Contraction(mesh, coarse, VertexMap(now.vertex_map), steps, status, treated)


def _operator_for(mesh: Mesh, settings: ContractionSettings) -> str | Operator:
    """The operator asked for, or the best that is defined on such a mesh."""
    if settings.operator is not None:
        return settings.operator
    return "intrinsic_delaunay" if mesh.is_closed and mesh.is_edge_manifold else "robust"


def _flow(
    start: Mesh, settings: ContractionSettings, on_step: Callable[[Step, Mesh], None] | None, end: float
) -> tuple[tuple[Step, ...], tuple[NDArray[np.int64], ...], Coarsened, Status]:
    """Steps until a reason to stop, on a mesh of extent 1, and the vertices treated in each."""
    operator = operator_named(settings.operator or "robust")
    rings, everything = ring_areas(start), np.arange(len(start.vertices))
    now, factorization = Coarsened(start, everything, everything, rings), None
    limits = np.maximum(settings.collapse_length * np.sqrt(rings), FINEST) if _may_coarsen(start, settings) else None
    weight, largest_weight = _weights(start, settings)
    steps: list[Step] = []
    treated: list[NDArray[np.int64]] = []

    def ended(status: Status) -> tuple[tuple[Step, ...], tuple[NDArray[np.int64], ...], Coarsened, Status]:
        return tuple(steps), tuple(treated), now, status

    while len(steps) < settings.max_steps:
        began = time.perf_counter()
        if began > end:
            return ended(Status.TIME_LIMIT)
        if steps and limits is not None:
            now = coarsen(now, limits)
        mesh = now.mesh
        angles = _smallest_angles(mesh)
        degenerate = np.unique(mesh.faces[angles < settings.degenerate_angle])
        try:
            laplacian = operator(mesh)
        except MeshError:
            if not steps:
                raise
            return ended(Status.NOT_FINITE)
        system = _system(start, now, laplacian, min(weight, largest_weight), degenerate, settings)
        try:
            if settings.rollback:
                is_same_size = factorization is not None and len(factorization.ordering) == len(mesh.vertices)
                like = factorization if is_same_size else None
                factorization = factorize(system.A, settings.solver, like=like)
                D = factorization.solve(system.B)
            else:
                D = solve_once(system.A, system.positions) - mesh.vertices
        except SolveError:
            if not steps:
                _require_symmetric(system, settings)
            return ended(Status.NOT_SOLVED)
        moved = mesh.vertices + D
        if not np.isfinite(moved).all():
            return ended(Status.NOT_FINITE)
        following = mesh.with_vertices(moved)
        touched = np.union1d(laplacian.treated_vertices, system.replaced)
        step = Step(
            area_ratio=following.area / start.area,
            volume_ratio=abs(following.volume / start.volume) if start.is_closed and start.volume else float("nan"),
            box_ratio=following.diagonal / start.diagonal,
            weight=min(weight, largest_weight),
            attraction=(float(system.attraction.min()), float(system.attraction.max())),
            min_angle_deg=float(np.degrees(angles.min())),
            n_vertices=len(mesh.vertices),
            n_clamped_angles=laplacian.n_clamped_angles,
            n_fallback_rows=len(touched),
            n_replaced_rows=len(system.replaced),
            max_displacement=float(np.linalg.norm(D[touched], axis=1).max(initial=0.0)),
            residual=relative_residual(system.A, D, system.B),
            seconds=time.perf_counter() - began,
        )
        before = steps[-1] if steps else None
        fault = fault_of(step, before)
        if fault and settings.rollback:
            return ended(fault)
        now = replace(now, mesh=following)
        steps, treated = [*steps, replace(step, fault=fault)], [*treated, now.kept[touched]]
        if on_step is not None:
            on_step(steps[-1], start.with_vertices(following.vertices[now.vertex_map]))
        if not fault and (success := success_of(step, before, settings)):
            return ended(success)
        weight *= settings.contraction_growth if settings.energy == "curvature_flow" else settings.contraction_growth**2
    return ended(Status.STEPS)


def _may_coarsen(start: Mesh, settings: ContractionSettings) -> bool:
    """Whether vertices may be merged: where the energy and the hold know how merged ones count."""
    knows_sums = settings.energy == "curvature_flow" and settings.attraction == "ring_areas" and settings.rollback
    return (
        settings.collapse_length > 0
        and knows_sums
        and start.is_closed_manifold
        and len(start.used_vertices) == len(start.vertices)
    )


def _weights(start: Mesh, settings: ContractionSettings) -> tuple[float, float]:
    """tau, or W_L^2, of the first step on a mesh of extent 1, and the largest that it may become."""
    tau, mean_ring = (
        INITIAL_WEIGHT_RULES[settings.initial_weight_rule](start, settings.initial_weight),
        mean_ring_area(start),
    )
    largest = float("inf") if settings.max_contraction_weight is None else settings.max_contraction_weight**2
    return (tau, largest * mean_ring) if settings.energy == "curvature_flow" else (tau / mean_ring, largest)


def _system(
    start: Mesh,
    now: Coarsened,
    laplacian: Laplacian,
    weight: float,
    degenerate: NDArray[np.int64],
    settings: ContractionSettings,
) -> LinearSystem:
    """What a step solves; the energies know neither how areas are compared nor what is degenerate."""
    start_mass = np.where(now.weights > 0, now.weights / 3, mean_ring_area(start) / 3)
    is_whole = len(now.kept) == len(start.vertices)
    area_kept = ATTRACTIONS[settings.attraction](start, now.mesh) if is_whole else ratio_of_areas(now.weights, now.mesh)
    if settings.max_attraction is not None:
        area_kept = np.minimum(area_kept, settings.max_attraction**2)
    treatment = ROW_TREATMENTS[settings.degenerate_rows]
    pull = ContractionStepInput(
        laplacian, now.mesh.vertices, weight, area_kept, start_mass, lambda L: treatment(L, degenerate)
    )
    return ENERGIES[settings.energy](pull)


def _require_symmetric(system: LinearSystem, settings: ContractionSettings) -> None:
    """Tell that the operator is what cannot be solved with, if it is."""
    if abs(system.A - system.A.T).max() > ASYMMETRY * abs(system.A).max():
        raise UnknownChoice(
            f"the operator {settings.operator!r} is not symmetric, which the energy {settings.energy!r} needs; "
            "use the energy 'least_squares', whose equations are symmetric for any operator, or another operator"
        )
