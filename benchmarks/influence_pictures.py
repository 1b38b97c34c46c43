"""Pictures of the influence benchmark: four stages by each strategy, failures next to their cures, curves."""

from __future__ import annotations

__all__ = ["blow_up", "curves", "stages"]

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import save_picture
from lbskel import Mesh
from lbskel.contraction.settings import DEGENERACY_STRATEGIES, ContractionSettings
from lbskel.pipeline.comparison import ComparisonResult, run_case
from lbskel.visualization import Panel, render

THIN = 0.05  # area ratio of the last stage that is pictured; a guess
REACH = 0.6  # diameter bounds from the center, beyond which vertices are drawn at that distance


def _cut(mesh: Mesh, start: Mesh) -> Mesh:
    """Bring a contracted mesh to the coordinates of its start, with far vertices pulled to ``REACH``."""
    V = mesh.vertices
    far = np.linalg.norm(V, axis=1, keepdims=True)
    return start.with_vertices(
        V * np.minimum(1.0, REACH / np.maximum(far, 1e-300)) * start.diameter_bound + start.centroid
    )


def stages(mesh: Mesh, cases: Mapping[str, ContractionSettings], results: Path) -> None:
    """Draw mesh, first step, last or broken step, and skeleton: one picture for each case."""
    for case, settings in cases.items():
        result = run_case(mesh, settings)
        name = "_".join(re.findall(r"\w+", case.lower()))
        render(_four(mesh, result, case), results / f"influence_dinosaur_{name}.png", size=(1300, 260), force=True)


def _four(mesh: Mesh, result: ComparisonResult, title: str) -> list[Panel]:
    """Make the panels: steps without roll-back up to the first that breaks or is thin; the skeleton with roll-back."""
    panels = [Panel(mesh, title=title)]
    free = result.free
    assert free is not None  # the least-squares energy admits every operator
    thin = [number for number, step in enumerate(free.steps, 1) if step.fault or step.area_ratio < THIN]
    for number in (1, thin[0] if thin else len(free.steps)):
        fault = free.steps[number - 1].fault
        broken = f": {fault.name.lower().replace('_', ' ')}" if fault else ""
        panels.append(Panel(_cut(result.meshes[number - 1], mesh), title=f"after {number}{broken}"))
    return [*panels, Panel(mesh, result.skeleton, "skeleton, guarded" if result.skeleton else result.error)]


PAIRS = (("none", "intrinsic Delaunay"), ("identity row, right-hand side zero", "identity row, held"))


def blow_up(meshes: Mapping[str, Mesh], results: Path) -> list[dict[str, Any]]:
    """Draw failing strategies at their worst step next to their cures at the same step; return their numbers."""
    rows: list[dict[str, Any]] = []
    for name, mesh in meshes.items():
        panels = [Panel(mesh, title=name)]
        for bad, good in PAIRS:
            outcomes = {
                strategy: run_case(mesh, ContractionSettings(energy="least_squares", **DEGENERACY_STRATEGIES[strategy]))
                for strategy in (bad, good)
            }
            free = outcomes[bad].free
            assert free is not None
            boxes = [step.box_ratio for step in free.steps]
            displacements = [step.max_displacement for step in free.steps]
            number = 1 + int(np.argmax(displacements if "zero" in bad else boxes))
            for strategy, result in outcomes.items():
                assert result.free is not None
                shown = min(number, len(result.meshes))
                step = result.free.steps[shown - 1]
                panels.append(Panel(_cut(result.meshes[shown - 1], mesh), title=f"{strategy}, step {shown}"))
                rows.append(
                    {
                        "mesh": name,
                        "strategy": strategy,
                        "step": shown,
                        "first broken step": result.free.first_failed_step,
                        "is chaos": (result.free.first_failed_step or shown) < shown,
                        "area": step.area_ratio,
                        "box": step.box_ratio,
                        "treated": step.n_fallback_rows,
                        "max displacement of treated": step.max_displacement,
                    }
                )
        render(panels, results / f"influence_blow_up_{Path(name).stem}.png", size=(2400, 300), force=True)
    return rows


def curves(rows: list[dict[str, Any]], mesh: str, path: Path) -> None:
    """Plot area and bounding box by step for each strategy, without roll-back."""

    names = list(dict.fromkeys(row["case"].split(";")[0] for row in rows if ";" in row["case"]))

    def draw(figure: Any) -> None:
        axes = figure.subplots(2, 2, sharex=True)
        for column, energy in enumerate(("least squares", "curvature flow")):
            own = [row for row in rows if row["mesh"] == mesh and row["case"].endswith(energy) and "areas" in row]
            for row in own:
                strategy = row["case"].split(";")[0]
                number = names.index(strategy)
                steps = np.arange(1, 1 + len(row["areas"]))
                style = {"color": f"C{number % 10}", "linestyle": "-" if number < 10 else "--", "marker": "."}
                axes[0, column].semilogy(steps, row["areas"], label=strategy, **style)
                axes[1, column].semilogy(steps, row["boxes"], **style)
            axes[0, column].set_title(f"{mesh}, {energy}, without the guard")
            axes[1, column].set_xlabel("step")
            axes[0, column].set_ylim(1e-5, 30)
            axes[1, column].set_ylim(0.2, 100)
        axes[0, 0].set_ylabel("area over that at the start")
        axes[1, 0].set_ylabel("bounding box over that at the start")
        for ax in axes.flat:
            ax.grid(alpha=0.3)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside right upper", fontsize=8)

    save_picture(path, draw, size=(14, 8))
