"""The skeletons of the bodies as one skeleton of the caller's mesh, and the report on it."""

from __future__ import annotations

__all__ = ["assemble", "body_report", "full_report"]

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from lbskel.contraction.result import Contraction, Step
from lbskel.contraction.settings import ContractionSettings
from lbskel.contraction.surgery import CollapsedGraph
from lbskel.evaluation.measures import Score
from lbskel.geometry.vertex_map import VertexMap
from lbskel.pipeline.environment import are_kernels_compiled, versions
from lbskel.pipeline.preparation import Body, PreparedMesh
from lbskel.pipeline.profiling import StageTimer
from lbskel.skeleton.editing import concatenate
from lbskel.skeleton.root import reroot_by_thickness
from lbskel.skeleton.skeleton import Skeleton


def assemble(skeletons: Sequence[Skeleton], prepared: PreparedMesh) -> Skeleton:
    """Join the skeletons of all bodies in the caller's coordinates, with a node for each of the caller's vertices.

    The first node is the root of trees: the soma of a neuron, else the thickest tip, as
    :func:`~lbskel.skeleton.root.reroot_by_thickness` finds them.

    Parameters
    ----------
    skeletons : sequence of Skeleton
        Of the bodies of the prepared mesh, in their order.
    prepared : PreparedMesh
    """
    whole = concatenate(skeletons)
    node_of_vertex = np.full(len(prepared.mesh.vertices), -1)
    first = 0
    for body, skeleton in zip(prepared.bodies, skeletons, strict=True):
        node_of_vertex[body.vertices] = skeleton.node_of_vertex + first
        first += len(skeleton.nodes)
    to_node = VertexMap(node_of_vertex).complete(prepared.mesh.vertices, whole.nodes)
    from_source = prepared.vertex_map.compose(to_node)
    joined = replace(
        whole,
        nodes=whole.nodes * prepared.scale + prepared.center,
        radii=whole.radii * prepared.scale,
        mean_radii=whole.mean_radii * prepared.scale,
        node_of_vertex=from_source.complete(prepared.to_unit(prepared.source.vertices), whole.nodes).indices,
    )
    return reroot_by_thickness(joined)


def body_report(body: Body, contraction: Contraction, graph: CollapsedGraph, skeleton: Skeleton) -> dict[str, Any]:
    """Report what was done to one body, ready for JSON."""
    return {
        "vertices": len(body.mesh.vertices),
        "faces": len(body.mesh.faces),
        "notes": list(body.proxy.notes),
        "is_closed_manifold": body.mesh.is_closed_manifold,
        "genus": body.mesh.genus,
        "status": contraction.status.value,
        "steps": [_without_nan(step) for step in contraction.steps],
        "handles_certified": graph.handles_certified,
        "spurious_loops_removed": graph.n_spurious_loops_removed,
        "cycle_rank": skeleton.cycle_rank,
        "tips": len(skeleton.tips),
        "junctions": len(skeleton.junctions),
    }


def full_report(
    prepared: PreparedMesh,
    settings: ContractionSettings,
    bodies: list[dict[str, Any]],
    scored: Score,
    timer: StageTimer,
) -> dict[str, Any]:
    """Report what was done, the score, and the seconds of each stage, ready for JSON."""
    chosen = asdict(settings)
    if callable(chosen["operator"]):
        chosen["operator"] = getattr(chosen["operator"], "__name__", repr(chosen["operator"]))
    source, notes = prepared.source, list(prepared.notes)
    if timer.skipped:
        notes.append(f"the time limit was reached, so these stages were skipped: {', '.join(timer.skipped)}")
    return {
        "input": {"vertices": len(source.vertices), "faces": len(source.faces), "components": source.n_components},
        "settings": chosen,
        "notes": notes,
        "components": bodies,
        "passed": scored.passed,
        "score": scored.report(),
        "seconds": dict(timer.seconds),
        "versions": dict(versions()),
        "kernels_compiled": are_kernels_compiled(),
        "preprocess": prepared.preprocessing,
    } | ({"megabytes": dict(timer.megabytes)} if timer.measures_memory else {})


def _without_nan(step: Step) -> dict[str, Any]:
    """Replace NaN, which JSON has not: an open mesh has None for a volume."""
    return {name: None if value != value else value for name, value in asdict(step).items()}
