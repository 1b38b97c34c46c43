"""The result of a contraction: the contracted mesh, a record of every step, and why it ended."""

from __future__ import annotations

__all__ = ["Contraction", "Status", "Step", "completion_status", "step_fault"]

from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.settings import ContractionSettings
from lbskel.display import Displayed
from lbskel.errors import counted
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.vertex_map import VertexMap

MAX_AREA_GROWTH = 1 + 1e-9  # factor on the area over one step, above which it has grown; allows for rounding
MAX_BOX_GROWTH = 1.01  # factor on the box diagonal over one step, harmless where vertices are held; a guess
MAX_FINAL_AREA = 0.1  # area ratio that a complete or stalled contraction must have reached; a guess
STALLED_AREA = 0.999  # factor on the area over one step, above which the contraction has stalled; a guess


class Status(str, Enum):
    """Why a contraction ended, as a sentence.

    Examples
    --------
    >>> import lbskel
    >>> lbskel.Status.STEPS.value
    'the number of steps allowed was reached'
    """

    VOLUME = "the volume fell below its target"
    AREA = "the area fell below its target"
    STALLED = "the area no longer falls"
    RINGS = "the rings of the points no longer shrink, the last good step was kept"
    STEPS = "the number of steps allowed was reached"
    AREA_GREW = "the area began to grow, the last good step was kept"
    BOX_GREW = "the bounding box began to grow, the last good step was kept"
    NOT_FINITE = "a coordinate was no longer finite, the last good step was kept"
    NOT_SOLVED = "the system could no longer be solved, the last good step was kept"
    NOT_SYMMETRIC = "the operator became asymmetric, which least_squares allows, the last good step was kept"
    TIME_LIMIT = "the time limit was reached, the last good step was kept"


FAILURES = (Status.AREA_GREW, Status.BOX_GREW, Status.NOT_FINITE, Status.NOT_SOLVED, Status.NOT_SYMMETRIC)


@dataclass(frozen=True)
class Step:
    """Measurements of one step; ratios are relative to the mesh before the contraction.

    Parameters
    ----------
    area_ratio, volume_ratio, box_ratio : float
        Area, volume and bounding box diagonal after the step; the volume ratio of a mesh that is not closed and
        consistently oriented is NaN.
    weight : float
        Contraction weight, the mean over the vertices: tau for ``curvature_flow``, W_L^2 for ``least_squares``.
    attraction : pair of float
        Smallest and largest entry of H or W_H^2.
    min_angle_deg : float
        Smallest angle of a triangle before the step, in degrees.
    n_vertices : int
        Number of vertices that the step moved, fewer than those of the input where vertices were merged.
    n_clamped_angles : int
        Angles that the operator clamped.
    n_fallback_rows : int
        Vertices where the operator fell back on other weights, or whose row was treated as degenerate.
    n_replaced_rows : int
        Rows of L treated as degenerate.
    max_displacement : float
        Largest displacement in this step of the vertices that ``n_fallback_rows`` counts, in diameter bounds.
    residual : float
        Relative residual of the linear system.
    seconds : float
        Time of the step.
    fault : Status or None
        Why a contraction with roll-back would have undone the step.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> step = lbskel.contract(torus(1.0, 0.2)).steps[0]
    >>> 0 < step.volume_ratio < step.area_ratio < 1
    True
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
class Contraction(Displayed):
    """A contracted mesh and the record of its contraction; ``print()`` shows a line for each step.

    Parameters
    ----------
    source : Mesh
        The mesh before the contraction.
    coarse : Mesh
        The contracted mesh, in the units of the source; it has fewer vertices where vertices were merged.
    vertex_map : VertexMap
        From the vertices of the source to those of ``coarse``.
    steps : tuple of Step
        The steps that were kept.
    status : Status
        Why it ended.
    treated_vertices : tuple of (t,) arrays of int
        For each step the vertices of the source that ``n_fallback_rows`` counts.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import capsule
    >>> contraction = lbskel.contract(capsule(3.0, 0.4, 10))
    >>> contraction.status.value, contraction.first_failed_step
    ('the volume fell below its target', None)
    """

    source: Mesh
    coarse: Mesh
    vertex_map: VertexMap
    steps: tuple[Step, ...]
    status: Status
    treated_vertices: tuple[NDArray[np.int64], ...] = ()

    def __repr__(self) -> str:
        left = f", {_remaining(self.steps[-1])}" if self.steps else ""
        return f"Contraction({counted(len(self.steps), 'step')}{left}: {self.status.value})"

    def __str__(self) -> str:
        """Show the steps as a table, then area and volume left and why the contraction ended."""
        lines = ["step  vertices   area    volume  bounding box  smallest angle"]
        for number, step in enumerate(self.steps, 1):
            volume = "-" if np.isnan(step.volume_ratio) else f"{step.volume_ratio:.1e}"
            fault = f"  {step.fault.value.split(',')[0]}" if step.fault else ""
            lines.append(
                f"{number:4d}  {step.n_vertices:8d}  {step.area_ratio:6.4f}  {volume:>7}  {step.box_ratio:12.4f}  "
                f"{step.min_angle_deg:10.1e} deg{fault}"
            )
        left = f"; {_remaining(self.steps[-1])} left" if self.steps else ""
        return "\n".join([*lines, f"{len(self.steps)} steps: {self.status.value}{left}"])

    def _drawings(self) -> list[tuple[str, Mesh]]:
        return [("before", self.source), (f"after {len(self.steps)} steps", self.mesh)]

    def plot(self) -> Any:
        """Show an interactive page: the mesh before and after, and the table of the steps.

        Returns
        -------
        InlinePage
            Shown by a notebook; ``save(path)`` writes it to a file.

        Raises
        ------
        MissingDependency
            If plotly is not installed.

        Examples
        --------
        >>> import lbskel
        >>> from lbskel.shapes import capsule
        >>> lbskel.contract(capsule(3.0, 0.4, 10)).plot()
        InlinePage(show it in a notebook, or save(path))
        """
        n = len(self.steps)
        return self._plot(
            mesh=self.source,
            title=repr(self),
            contracted=self.source,
            positions=[self.mesh.vertices] if n else [],
            step_numbers=[n],
            area_ratios=[step.area_ratio for step in self.steps],
            volume_ratios=[step.volume_ratio for step in self.steps],
            notes=str(self).splitlines(),
        )

    @cached_property
    def mesh(self) -> Mesh:
        """The faces of the source with the contracted positions."""
        return self.source.with_vertices(self.coarse.vertices[self.vertex_map.indices])

    @property
    def first_failed_step(self) -> int | None:
        """Number, from 1, of the first step that was faulty or could not be completed; None if there is none."""
        faults = [number for number, step in enumerate(self.steps, 1) if step.fault]
        if faults:
            return faults[0]
        return len(self.steps) + 1 if self.status in FAILURES else None


def _remaining(step: Step) -> str:
    """Area and, of a closed mesh, volume after a step, relative to the start."""
    volume = "" if np.isnan(step.volume_ratio) else f", volume {step.volume_ratio:.1e}"
    return f"area {step.area_ratio:.4f}{volume}"


def step_fault(step: Step, previous: Step | None) -> Status | None:
    """Why a step must be undone; None if it is good.

    Parameters
    ----------
    step : Step
    previous : Step or None
        None before the first step.
    """
    if step.area_ratio > MAX_AREA_GROWTH * (previous.area_ratio if previous else 1.0):
        return Status.AREA_GREW
    if step.box_ratio > MAX_BOX_GROWTH * (previous.box_ratio if previous else 1.0):
        return Status.BOX_GREW
    return None


def completion_status(step: Step, previous: Step | None, settings: ContractionSettings) -> Status | None:
    """Why a step completes the contraction; None if it does not.

    A signed volume may pass through zero early, so the area must be small too.

    Parameters
    ----------
    step : Step
    previous : Step or None
        None before the first step.
    settings : ContractionSettings
    """
    if step.volume_ratio <= settings.volume_ratio and step.area_ratio <= MAX_FINAL_AREA:
        return Status.VOLUME
    if not np.isfinite(step.volume_ratio) and step.area_ratio <= settings.area_ratio:
        return Status.AREA
    if (
        previous is not None
        and step.area_ratio > STALLED_AREA * previous.area_ratio
        and step.area_ratio <= MAX_FINAL_AREA
    ):
        return Status.STALLED
    return None
