"""What a contraction tells of itself: its steps, and why it ended."""

from __future__ import annotations

__all__ = ["Contraction", "Status", "Step", "fault_of", "success_of"]

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.settings import ContractionSettings
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.vertex_map import VertexMap

AREA_GROWTH = 1 + 1e-9  # over a step that is no more than rounding
BOX_GROWTH = 1.01  # over a step that held vertices may cause and that does no harm


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
    TIME_LIMIT = "the time allowed was over, the last good step was kept"


FAILURES = (Status.AREA_GREW, Status.BOX_GREW, Status.NOT_FINITE, Status.NOT_SOLVED)


@dataclass(frozen=True)
class Step:
    """What one step did; ratios are to the start of the contraction.

    ``weight`` is tau or W_L^2, ``attraction`` the smallest and largest entry of H or W_H^2, ``min_angle_deg`` the smallest
    angle in degrees before the step. ``n_vertices`` is how many it moved. ``n_fallback_rows`` counts the vertices that the
    operator's guard or the treatment of degenerate triangles has touched, ``n_replaced_rows`` those of the treatment
    alone; ``max_displacement`` is how far the farthest of them went in this step, as a fraction of the extent. ``fault`` is why a
    guarded contraction would have undone the step.
    """

    area_ratio: float
    volume_ratio: float
    box_ratio: float
    weight: float
    attraction: tuple[float, float]
    min_angle_deg: float
    n_vertices: int
    n_clamped_angles: int
    n_fallback_rows: int
    n_replaced_rows: int
    max_displacement: float
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
    coarse : Mesh
        The contracted mesh, in the coordinates of the source; where vertices were merged on the way it has fewer.
    vertex_map : VertexMap
        From the vertices of the source to those of ``coarse``.
    steps : tuple of Step
        The steps that were kept.
    status : Status
        Why it ended.
    treated_vertices : tuple of (t,) arrays of int
        Of each step, the vertices that ``n_fallback_rows`` counts.
    """

    source: Mesh
    coarse: Mesh
    vertex_map: VertexMap
    steps: tuple[Step, ...]
    status: Status
    treated_vertices: tuple[NDArray[np.int64], ...] = ()

    @cached_property
    def mesh(self) -> Mesh:
        """The faces of the source on the contracted vertices."""
        return self.source.with_vertices(self.coarse.vertices[self.vertex_map.indices])

    @property
    def broke_at(self) -> int | None:
        """Number of the first step, from 1, that failed or was no step at all; None if there was none."""
        faults = [number for number, step in enumerate(self.steps, 1) if step.fault]
        if faults:
            return faults[0]
        return len(self.steps) + 1 if self.status in FAILURES else None


def fault_of(step: Step, before: Step | None) -> Status | None:
    """Why a step must be undone, if it must."""
    if step.area_ratio > AREA_GROWTH * (before.area_ratio if before else 1.0):
        return Status.AREA_GREW
    if step.box_ratio > BOX_GROWTH * (before.box_ratio if before else 1.0):
        return Status.BOX_GREW
    return None


def success_of(step: Step, before: Step | None, settings: ContractionSettings) -> Status | None:
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
