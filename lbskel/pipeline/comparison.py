"""Comparison of contraction settings on one mesh.

Each setting runs twice: with roll-back, as :func:`lbskel.skeletonize` runs it, which shows the result for a user; and
without, as published, down to a millionth of the volume, which shows whether and where the step itself breaks.
"""

from __future__ import annotations

__all__ = ["CASES", "AreaNormalized", "ComparisonResult", "record", "representative", "run_case"]

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.flow import Contraction, Status, Step, contract
from lbskel.contraction.settings import DEGENERACY_STRATEGIES, PRESETS, ContractionSettings
from lbskel.errors import LbskelError, MeshError
from lbskel.evaluation.ground_truth import ground_truth_distances
from lbskel.geometry.components import components
from lbskel.geometry.mesh import Mesh
from lbskel.operators import Laplacian, operator_named
from lbskel.pipeline.stages import skeletonize
from lbskel.preprocess import MAX_FACES, preprocess_mesh, simplify, why_no_inside
from lbskel.skeleton.skeleton import Skeleton

FINISHED = (Status.VOLUME, Status.AREA, Status.STALLED)  # reasons to stop because nothing is left to contract
FREE_VOLUME_RATIO = 1e-6  # volume at which runs without roll-back stop; Au et al. 2008


@dataclass(frozen=True)
class AreaNormalized:
    """An operator multiplied by the area over its total mass; the factor is 1 where the mass is the area.

    Mean value weights have a unit and grow as the mesh gets finer; the multiplied weights do not.

    Parameters
    ----------
    operator : str
        A name in OPERATORS.
    """

    operator: str

    def __call__(self, mesh: Mesh) -> Laplacian:
        """Return the Laplacian of a mesh."""
        laplacian = operator_named(self.operator)(mesh)
        total = float(laplacian.mass.sum())
        factor = mesh.area / total if total > 0 else 1.0
        return replace(laplacian, stiffness=(laplacian.stiffness * factor).tocsc())

    def __repr__(self) -> str:
        return f"area-normalized {self.operator}"


def _cases() -> dict[str, ContractionSettings]:
    """List the presets, then each strategy against degenerate triangles with each of its energies."""
    cases = dict(PRESETS)
    scaled = {
        "mean value, to scale": {"operator": AreaNormalized("mean_value")},
        "mean value, symmetric, to scale": {"operator": AreaNormalized("mean_value_symmetric")},
    }
    for energy in ENERGIES:
        for name, changes in {**DEGENERACY_STRATEGIES, **scaled}.items():
            if energy == "least_squares" or "degenerate_rows" not in changes:
                cases[f"{name}; {energy.replace('_', ' ')}"] = ContractionSettings(energy=energy, **changes)
    return cases


CASES: Mapping[str, ContractionSettings] = _cases()


@dataclass(frozen=True, eq=False)
class ComparisonResult:
    """The result of one choice of settings on a mesh.

    Parameters
    ----------
    settings : ContractionSettings
    skeleton : Skeleton or None
        None if there is none, for the reason in ``error``.
    free : Contraction or None
        The contraction without roll-back; None if the operator is not defined on the mesh.
    meshes : tuple of Mesh
        After each step of ``free``, at a diameter bound of 1.
    error : str
    seconds : float
        Time of the skeleton.
    """

    settings: ContractionSettings
    skeleton: Skeleton | None
    free: Contraction | None
    meshes: tuple[Mesh, ...]
    error: str
    seconds: float


def representative(mesh: Mesh, *, most_faces: int = MAX_FACES) -> Mesh:
    """Prepare the largest component of a mesh as :func:`lbskel.skeletonize` does, and simplify it.

    Parameters
    ----------
    mesh : Mesh
    most_faces : int
        The component is simplified to this number of faces if it has more.

    Raises
    ------
    MeshError
        If no component has an area, or the largest has no inside.
    """
    prepared = preprocess_mesh(mesh).mesh
    number, largest = max(enumerate(components(prepared)), key=lambda part: part[1].mesh.area)
    if not largest.mesh.area > 0:
        raise MeshError("the mesh has no area: every face is degenerate, so there is nothing to compare")
    if fault := why_no_inside(number, largest, prepared):
        raise MeshError(f"there is nothing to compare: {fault}")
    return simplify(largest.mesh, target_faces=most_faces).mesh


def run_case(mesh: Mesh, settings: ContractionSettings) -> ComparisonResult:
    """Contract with roll-back and without, and make a skeleton.

    Parameters
    ----------
    mesh : Mesh
        One connected surface, as :func:`representative` returns it, contracted without preprocessing.
    settings : ContractionSettings
    """
    skeleton, free, error = None, None, ""
    meshes: list[Mesh] = []
    began = time.perf_counter()
    try:
        skeleton = skeletonize(mesh, preset=settings, preprocess=None)
    except LbskelError as problem:
        error = str(problem)
    seconds = time.perf_counter() - began
    unguarded = replace(settings, rollback=False, volume_ratio=min(FREE_VOLUME_RATIO, settings.volume_ratio))
    try:
        free = contract(mesh, unguarded, on_step=lambda step, now: meshes.append(now))
    except LbskelError as problem:
        error = error or str(problem)
    return ComparisonResult(settings, skeleton, free, tuple(meshes), error, seconds)


def record(
    result: ComparisonResult, *, truth: Skeleton | None = None, reference: Skeleton | None = None
) -> dict[str, Any]:
    """Collect the numbers of a result, ready for JSON.

    Parameters
    ----------
    result : ComparisonResult
    truth : Skeleton, optional
        The known skeleton, for accuracy and coverage.
    reference : Skeleton, optional
        Another skeleton, to which the distance is given in its radii.
    """
    row: dict[str, Any] = {"error": result.error} if result.error else {}
    if result.skeleton is not None:
        row |= _skeleton_record(result.skeleton, truth, reference) | {"seconds": result.seconds}
    if result.free is not None:
        row |= _free_record(result.free)
    return row


def _skeleton_record(skeleton: Skeleton, truth: Skeleton | None, reference: Skeleton | None) -> dict[str, Any]:
    """Collect the numbers of the skeleton, made with roll-back."""
    (part,) = skeleton.report["components"]
    genus = part["genus"]
    last = part["steps"][-1] if part["steps"] else {}
    row = {
        "steps": len(part["steps"]),
        "status": part["status"],
        "area": last.get("area_ratio", 1.0),
        "volume": last.get("volume_ratio"),
        "box": last.get("box_ratio", 1.0),
        "topology right": None if genus is None else (skeleton.n_components, skeleton.cycle_rank) == (1, genus),
        "contracted": Status(part["status"]) in FINISHED,
        "tips": part["tips"],
        "inside": skeleton.report["score"]["measures"]["inside_fraction"],
    }
    if truth is not None:
        measured = ground_truth_distances(skeleton, truth)
        row |= {
            "accuracy": measured.accuracy,
            "coverage": measured.coverage,
            "tips right": measured.n_tips == measured.n_true_tips,
        }
    if reference is not None and len(reference.edges) and _has_radii(reference):
        row["from default"] = ground_truth_distances(skeleton, reference).accuracy
    return row


def _has_radii(skeleton: Skeleton) -> bool:
    """Whether no radius is zero up to rounding, as those in a sheet are."""
    rounding = np.finfo(np.float64).eps * np.abs(skeleton.nodes).max()
    return bool(skeleton.radii.min() > rounding)


def _free_record(free: Contraction) -> dict[str, Any]:
    """Collect the numbers of the steps without roll-back."""
    steps = free.steps
    return {
        "broke at": free.first_failed_step,
        "how": _fault(free),
        "free steps": len(steps),
        "free status": free.status.value,
        "largest box": _plain(max((step.box_ratio for step in steps), default=1.0)),
        "areas": [_plain(step.area_ratio) for step in steps],
        "volumes": [_plain(step.volume_ratio) for step in steps],
        "boxes": [_plain(step.box_ratio) for step in steps],
        "treated": [step.n_fallback_rows for step in steps],
        "max_displacement": [_plain(step.max_displacement) for step in steps],
        "worst angle": [step.min_angle_deg for step in steps],
    }


def _plain(value: float) -> float | None:
    """Replace numbers that are not finite by None: open meshes have no volume, and exploding steps overflow."""
    return value if np.isfinite(value) else None


def _fault(free: Contraction) -> str | None:
    """Name the first fault in a word or two."""
    if free.first_failed_step is None:
        return None
    broken: Step | None = free.steps[free.first_failed_step - 1] if free.first_failed_step <= len(free.steps) else None
    fault = broken.fault if broken is not None and broken.fault else free.status
    return fault.name.lower().replace("_", " ")
