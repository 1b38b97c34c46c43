"""Contraction of a surface to the neighborhood of its curve skeleton by an implicit Laplacian flow.

Each step minimizes one of the energies of :mod:`lbskel.contraction.energies`, with the operator rebuilt on the present
positions. The weights, their growth and the stopping criterion are those of Au, Tai, Chu, Cohen-Or, Lee 2008,
"Skeleton extraction by mesh contraction", https://doi.org/10.1145/1399504.1360643, section 4, made dimensionless.
"""

from __future__ import annotations

__all__ = ["PRESETS", "Contraction", "ContractionSettings", "Status", "Step", "contract"]

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES, ContractionStepInput, LinearSystem
from lbskel.contraction.result import Contraction, Status, Step
from lbskel.contraction.settings import PRESETS, ContractionSettings
from lbskel.contraction.stop_rules import RULES
from lbskel.contraction.weights import ATTRACTIONS, INITIAL_WEIGHT_RULES, mean_ring_area, ring_areas, ring_shrinkage
from lbskel.errors import MeshError, SolveError, UnknownChoice, choose, is_number
from lbskel.geometry.coarsening import Coarsened, coarsen
from lbskel.geometry.deadline import NEVER, Deadline, OutOfTime
from lbskel.geometry.mesh import Mesh, PointCloud, as_mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.point_stars import PointStars
from lbskel.geometry.shape_diameter import local_radii, set_local_radii
from lbskel.geometry.sorting import distinct
from lbskel.geometry.vertex_map import VertexMap
from lbskel.operators import STAR_OPERATORS, Laplacian, Operator, apply_operator
from lbskel.operators.corner_angles import corner_cotangents
from lbskel.operators.intrinsic_delaunay import oriented_faces
from lbskel.operators.star_rings import stars_in_order
from lbskel.solvers import factorize, relative_residual, solve_once

MIN_EDGE_LENGTH = 0.1  # edges shorter than this, in initial local radii, are collapsed after the first step whatever
# positive collapse_length is chosen; a guess
MAX_ASYMMETRY = 1e-12  # entries of |A - A^T| relative to the largest entry that count as rounding; a guess


def contract(
    mesh: Any,
    settings: ContractionSettings | str = "curvature_flow",
    *,
    on_step: Callable[[Step, Mesh], None] | None = None,
    time_limit: float | None = None,
) -> Contraction:
    """Contract a mesh until nearly none of its volume is left, or the points of a cloud by their local triangles.

    A step after which the area or the bounding box has grown, or a coordinate is not finite, is undone and ends the
    contraction: the result is always that of the last good step, unless the settings switch the roll-back off. With the
    stop rule ``rings`` other criteria decide (:mod:`lbskel.contraction.stop_rules`).

    Parameters
    ----------
    mesh : Mesh, PointCloud, (vertices, faces), path or mesh object
        One connected surface, closed or open; whatever :func:`lbskel.as_mesh` takes. A cloud, or the vertices of a mesh
        where the operator is one of stars, become a :class:`~lbskel.geometry.point_stars.PointStars`.
    settings : ContractionSettings or str
        Or a name in PRESETS.
    on_step : callable, optional
        Called after each step that was kept, with its record and the present mesh, scaled to diameter bound 1.
    time_limit : float, optional
        In seconds. A step does not begin if less time is left than the step before it took, and its system is not
        solved once the time is over.

    Returns
    -------
    Contraction

    Raises
    ------
    FormatError
        If the mesh is a path and no mesh can be read from it.
    MeshError
        If the input is no mesh or has no area, or the operator is not defined on it.
    UnknownChoice
        If the operator is not symmetric at the first step, and the energy needs it to be; without roll-back that is
        not checked. If no preset has that name, or the time limit is negative or no number.
    OperatorError
        If a function given as the operator returns no Laplacian of the mesh, or one with the wrong sign.

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
    if isinstance(settings, str):
        settings = choose(PRESETS, settings, "preset")
    mesh = _contractible(mesh, settings)
    center, scale = mesh.centroid, mesh.diameter_bound
    if not (scale > 0 and mesh.area > 0):
        raise MeshError("the mesh has no area: every face is degenerate, so there is nothing to contract")
    start = mesh.with_vertices((mesh.vertices - center) / scale)
    if time_limit is not None and not (is_number(time_limit) and time_limit >= 0):
        raise UnknownChoice(f"time_limit must be a number of seconds, not {time_limit!r}")
    deadline = NEVER if time_limit is None else Deadline(time.perf_counter() + time_limit)
    try:
        if _can_coarsen(start, settings):  # its steps take the local radii of the start, which need no new rays
            set_local_radii(start, local_radii(mesh, deadline=deadline) / scale)
        steps, treated, now, status = _run_steps(start, settings, on_step, deadline)
    except OutOfTime:  # before the first step
        return Contraction(mesh, mesh, VertexMap.identity(len(mesh.vertices)), (), Status.TIME_LIMIT)
    coarse = now.mesh.with_vertices(now.mesh.vertices * scale + center)
    return Contraction(mesh, coarse, now.vertex_map, steps, status, treated)


def _contractible(given: Any, settings: ContractionSettings) -> Mesh:
    """Return the mesh, or the stars of a cloud."""
    if isinstance(given, PointCloud):
        return stars_in_order(given)
    mesh = as_mesh(given)
    needs_stars = isinstance(settings.operator, str) and settings.operator in STAR_OPERATORS
    return stars_in_order(PointCloud(mesh.vertices)) if needs_stars and not isinstance(mesh, PointStars) else mesh


def _choose_operator(mesh: Mesh, settings: ContractionSettings) -> str | Operator:
    """Return the operator of the settings, or the one that is stable under contraction and defined on the mesh."""
    if settings.operator is not None:
        return settings.operator
    return "intrinsic_delaunay" if mesh.is_closed and oriented_faces(mesh.faces) is not None else "robust"


def _run_steps(
    start: Mesh, settings: ContractionSettings, on_step: Callable[[Step, Mesh], None] | None, deadline: Deadline
) -> tuple[tuple[Step, ...], tuple[NDArray[np.int64], ...], Coarsened, Status]:
    """Contract a mesh of diameter bound 1 until there is a reason to stop.

    Returns the steps, the vertices treated in each, the mesh after the last, and the reason.
    """
    operator = _choose_operator(start, settings)
    has_volume = _is_consistently_oriented(start) and start.volume != 0
    rings = ring_areas(start)
    now, factorization = Coarsened.unmerged(start, rings), None
    max_lengths = None
    if _can_coarsen(start, settings):
        radii = local_radii(start, deadline=deadline)
        max_lengths = np.maximum(settings.collapse_length * np.sqrt(rings), MIN_EDGE_LENGTH * radii)
    weights, max_weight = _contraction_weights(start, settings)
    max_cotangent = 1 / np.tan(settings.degenerate_angle) if settings.degenerate_angle > 0 else np.inf
    steps: list[Step] = []
    treated: list[NDArray[np.int64]] = []

    def result(status: Status) -> tuple[tuple[Step, ...], tuple[NDArray[np.int64], ...], Coarsened, Status]:
        return tuple(steps), tuple(treated), now, status

    while len(steps) < settings.max_steps:
        began = time.perf_counter()
        if deadline.seconds_left < (steps[-1].seconds if steps else 0.0):
            return result(Status.TIME_LIMIT)
        if steps and max_lengths is not None:
            now = coarsen(now, max_lengths)
        mesh = now.mesh
        cotangents = _max_face_cotangents(mesh)
        degenerate = distinct(mesh.faces[cotangents > max_cotangent].ravel())
        try:
            laplacian = apply_operator(operator, mesh)
        except MeshError:
            if not steps:
                raise
            return result(Status.NOT_FINITE)
        weight = np.minimum(weights[now.kept] if isinstance(weights, np.ndarray) else weights, max_weight)
        system = _step_system(start, now, laplacian, weight, degenerate, settings)
        may_be_asymmetric = not steps or len(laplacian.treated_vertices)  # the operator may have replaced rows
        needs_symmetry = settings.rollback and settings.energy == "curvature_flow"
        if needs_symmetry and may_be_asymmetric and not _is_symmetric(system):
            if steps:
                return result(Status.NOT_SYMMETRIC)
            raise UnknownChoice(
                f"the operator {settings.operator!r} is not symmetric, which the energy {settings.energy!r} needs; "
                "use the energy 'least_squares', whose equations are symmetric for any operator, or another operator"
            )
        if deadline.seconds_left < 0:
            return result(Status.TIME_LIMIT)
        try:
            if settings.rollback:
                is_same_size = factorization is not None and len(factorization.ordering) == len(mesh.vertices)
                like = factorization if is_same_size else None
                factorization = factorize(system.A, settings.solver, like=like)
                # the first-order system is well conditioned: without refinement, skeletons of 25 meshes moved by 1e-13
                D, residual = factorization.solve_with_residual(system.B, refined=settings.energy != "curvature_flow")
            else:
                D = solve_once(system.A, system.positions) - mesh.vertices
                residual = relative_residual(system.A, D, system.B)
        except SolveError:
            return result(Status.NOT_SOLVED)
        moved = mesh.vertices + D
        if not np.isfinite(moved).all():
            return result(Status.NOT_FINITE)
        following = mesh.with_vertices(moved)
        touched = distinct(np.append(laplacian.treated_vertices, system.replaced_rows))
        step = Step(
            area_ratio=following.area / start.area,
            volume_ratio=abs(following.volume / start.volume) if has_volume else float("nan"),
            box_ratio=following.diagonal / start.diagonal,
            weight=float(np.mean(weight)),
            attraction=(float(system.attraction.min()), float(system.attraction.max())),
            min_angle_deg=float(np.degrees(np.arctan2(1.0, cotangents.max()))),
            n_vertices=len(mesh.vertices),
            n_clamped_angles=laplacian.n_clamped_angles,
            n_fallback_rows=len(touched),
            n_replaced_rows=len(system.replaced_rows),
            max_displacement=float(vector_lengths(D[touched]).max(initial=0.0)),
            residual=residual,
            seconds=time.perf_counter() - began,
        )
        previous = steps[-1] if steps else None
        fault = RULES[settings.stop_rule].fault(step, previous, start, mesh, following)
        if fault and settings.rollback:
            return result(fault)
        now = replace(now, mesh=following)
        steps.append(replace(step, fault=fault))
        treated.append(now.kept[touched])
        if on_step is not None:
            on_step(steps[-1], start.with_vertices(following.vertices[now.vertex_map.indices]))
        if not fault and (completed := RULES[settings.stop_rule].completion(step, previous, settings)):
            return result(completed)
        growth = settings.contraction_growth
        weights = weights * (growth if settings.energy == "curvature_flow" else growth**2)
    return result(Status.STEPS)


def _is_consistently_oriented(mesh: Mesh) -> bool:
    """Whether every edge has as many faces on one side as on the other, without which no volume is enclosed."""
    signs = np.sign(mesh.half_edges[:, 1] - mesh.half_edges[:, 0])
    return not np.bincount(mesh.edge_of_half_edge, signs).any()


def _max_face_cotangents(mesh: Mesh) -> NDArray[np.float64]:
    """(m,) cotangent of the smallest angle of each face; infinite where an edge has no length."""
    a, b, c = corner_cotangents(mesh).T
    largest: NDArray[np.float64] = np.nan_to_num(np.maximum(np.maximum(a, b), c), nan=np.inf, posinf=np.inf)
    return largest


def _can_coarsen(start: Mesh, settings: ContractionSettings) -> bool:
    """Whether vertices may be merged: energy and attraction must account for merged areas."""
    accounts_for_areas = (
        settings.energy == "curvature_flow" and settings.attraction == "ring_areas" and settings.rollback
    )
    accounts_for_areas &= not isinstance(start, PointStars)
    return settings.collapse_length > 0 and accounts_for_areas and len(start.used_vertices) == len(start.vertices)


def _contraction_weights(start: Mesh, settings: ContractionSettings) -> tuple[float | NDArray[np.float64], float]:
    """Contraction weights of the first step, and their upper bound: tau or W_L^2, on a mesh of diameter bound 1."""
    rule = INITIAL_WEIGHT_RULES[settings.initial_weight_rule]
    tau, mean_ring = rule(start, settings.initial_weight), mean_ring_area(start)
    largest = float("inf") if settings.max_contraction_weight is None else settings.max_contraction_weight**2
    return (tau, largest * mean_ring) if settings.energy == "curvature_flow" else (tau / mean_ring, largest)


def _step_system(
    start: Mesh,
    now: Coarsened,
    laplacian: Laplacian,
    weight: float | NDArray[np.float64],
    degenerate: NDArray[np.int64],
    settings: ContractionSettings,
) -> LinearSystem:
    """Build the linear system of a step from the present mesh and the weights."""
    initial_mass = np.where(now.weights > 0, now.weights / 3, mean_ring_area(start) / 3)
    is_unmerged = len(now.kept) == len(start.vertices)
    shrinkage = (
        ATTRACTIONS[settings.attraction](start, now.mesh) if is_unmerged else ring_shrinkage(now.weights, now.mesh)
    )
    if settings.max_attraction is not None:
        shrinkage = np.minimum(shrinkage, settings.max_attraction**2)
    treatment = ROW_TREATMENTS[settings.degenerate_rows]
    step = ContractionStepInput(
        laplacian, now.mesh.vertices, weight, shrinkage, initial_mass, lambda L: treatment(L, degenerate)
    )
    return ENERGIES[settings.energy](step)


def _is_symmetric(system: LinearSystem) -> bool:
    """Whether the system is symmetric up to rounding, as it is if its operator is."""
    largest, difference = (np.abs(each.data).max(initial=0.0) for each in (system.A, system.A - system.A.T))
    return bool(difference <= MAX_ASYMMETRY * largest)
