"""The contraction that made a skeleton, run again, so that no intermediate mesh has to be kept.

It is run with the settings in the skeleton's report, for as many steps as the report has. It gives the same steps, but
for bodies that were contracted in a group.
"""

from __future__ import annotations

__all__ = ["replay", "what_is_told"]

import operator
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.flow import contract
from lbskel.contraction.result import Step
from lbskel.contraction.settings import ContractionSettings
from lbskel.errors import UnknownChoice
from lbskel.geometry.mesh import Mesh
from lbskel.operators import OPERATORS
from lbskel.pipeline.preparation import Body, PreparedMesh

Told = TypeVar("Told")


def what_is_told(tell: Callable[[dict[str, Any]], Told], report: dict[str, Any]) -> Told | None:
    """Return what a function takes from a report; None from one that lacks it, as one that was edited may."""
    try:
        return tell(report)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError):
        return None


def replay(
    prepared: PreparedMesh, report: dict[str, Any]
) -> tuple[Mesh | None, list[NDArray[np.float64]], list[float], list[float]]:
    """Contract all bodies again.

    Returns the surface that is contracted, its vertices after each step, and the ratios of areas and volumes; None and
    empty lists if the report does not say how, or is incomplete.
    """
    told = what_is_told(_settings_and_steps, report)
    if told is None or len(told[1]) != len(prepared.bodies):
        return None, [], [], []
    settings, steps_of_bodies = told
    replayed = [
        _replay_body(body, settings, *steps) for body, steps in zip(prepared.bodies, steps_of_bodies, strict=True)
    ]
    n_steps = max(len(states) for _, states, _ in replayed)

    def joined(number: int) -> NDArray[np.float64]:
        parts = [([mesh.vertices, *states])[min(number, len(states))] for mesh, states, _ in replayed]
        return prepared.frame.from_unit(np.concatenate(parts))

    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh, _, _ in replayed)])
    faces = np.concatenate([mesh.faces + offset for (mesh, _, _), offset in zip(replayed, offsets[:-1], strict=True)])
    areas = _total(
        [mesh.area for mesh, _, _ in replayed], [[step.area_ratio for step in steps] for *_, steps in replayed], n_steps
    )
    volumes = _total(
        [abs(mesh.volume) for mesh, _, _ in replayed],
        [[step.volume_ratio for step in steps] for *_, steps in replayed],
        n_steps,
    )
    outward = faces[:, :: round(prepared.frame.mirror.prod())]
    return Mesh(joined(0), outward), [joined(number) for number in range(1, n_steps + 1)], areas, volumes


def _settings_and_steps(report: dict[str, Any]) -> tuple[ContractionSettings, list[tuple[int, int]]]:
    """Read the settings, and for each body the number of steps and that of the vertices of the first, 0 without one."""
    if report["settings"]["operator"] not in (None, *OPERATORS):
        raise UnknownChoice("the operator is a function of the caller")
    all_steps = [body["steps"] for body in report["components"]]
    counts = [(len(steps), operator.index(steps[0]["n_vertices"]) if steps else 0) for steps in all_steps]
    return ContractionSettings(**report["settings"]), counts


def _replay_body(
    body: Body, settings: ContractionSettings, n_steps: int, n_first: int
) -> tuple[Mesh, list[NDArray[np.float64]], list[Step]]:
    """Contract a body in as many steps as its report has: the proxy, or the full surface if that was contracted."""
    mesh = body.proxy.mesh if n_first in (0, len(body.proxy.mesh.vertices)) else body.mesh
    states: list[NDArray[np.float64]] = []
    steps: list[Step] = []

    def keep(step: Step, now: Mesh) -> None:
        states.append(now.vertices * mesh.diameter_bound + mesh.centroid)
        steps.append(step)

    if n_steps:
        contract(mesh, replace(settings, max_steps=n_steps), on_step=keep)
    return mesh, states, steps


def _total(sizes: Sequence[float], ratios: Sequence[Sequence[float]], n_steps: int) -> list[float]:
    """Combine ratios of several bodies to those of all; one that ended earlier keeps its last."""
    whole = sum(sizes)
    return [
        sum(size * ([1.0, *own])[min(number, len(own))] for size, own in zip(sizes, ratios, strict=True)) / whole
        if whole > 0
        else float("nan")
        for number in range(1, n_steps + 1)
    ]
