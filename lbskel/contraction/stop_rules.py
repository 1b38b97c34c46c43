"""When a contraction ends: by areas and volumes, or by the rings of points.

A rule says why a step must be undone, and why a step completes the contraction. That of rings is of Cao, Tagliasacchi,
Olson, Zhang, Su 2010, https://doi.org/10.1109/SMI.2010.25, with the constants of their program.
"""

from __future__ import annotations

__all__ = ["RULES", "StopRule"]

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lbskel.contraction.result import Status, Step, completion_status, step_fault
from lbskel.contraction.settings import ContractionSettings
from lbskel.contraction.weights import shortest_ring_edges
from lbskel.geometry.mesh import Mesh

# A step is undone if the sum of the shortest edges of all rings decreases by less than this share of the first sum, or
# if a side of the bounding box is longer than this many times the first; Cao et al. 2010
MIN_RING_DECREASE, MAX_SIDE_GROWTH = 0.01, 1.2


class StopRule(NamedTuple):
    """When a contraction ends.

    Parameters
    ----------
    fault : callable
        From a step, the one before it or None, and the meshes at the start, before and after the step, to the reason
        why the step must be undone; None if it is good.
    completion : callable
        From a step, the one before it or None, and the settings to the reason why it is the last.
    """

    fault: Callable[[Step, Step | None, Mesh, Mesh, Mesh], Status | None]
    completion: Callable[[Step, Step | None, ContractionSettings], Status | None]


def _area_fault(step: Step, previous: Step | None, start: Mesh, before: Mesh, after: Mesh) -> Status | None:
    """Why a step must be undone by its areas and boxes."""
    return step_fault(step, previous)


def _ring_fault(step: Step, previous: Step | None, start: Mesh, before: Mesh, after: Mesh) -> Status | None:
    """Why a step must be undone by the sides of its box and its rings."""
    first, now = (np.ptp(mesh.vertices, axis=0) for mesh in (start, after))
    if (now > MAX_SIDE_GROWTH * first).any():
        return Status.BOX_GREW
    initial = _sum_of_rings(start)
    is_less = _sum_of_rings(before) - _sum_of_rings(after) < MIN_RING_DECREASE * initial
    return Status.RINGS if is_less else None


def _sum_of_rings(mesh: Mesh) -> float:
    """Sum of the shortest edges of all rings."""
    shortest = shortest_ring_edges(mesh)
    return float(shortest[np.isfinite(shortest)].sum())


def _never(step: Step, previous: Step | None, settings: ContractionSettings) -> Status | None:
    """Never complete the contraction: it ends with a step that is undone, or at the limit on the steps."""
    return None


RULES: dict[str, StopRule] = {
    "areas": StopRule(_area_fault, completion_status),
    "rings": StopRule(_ring_fault, _never),
}
"""Rules by their names in STOP_RULES of :mod:`lbskel.contraction.settings`."""
