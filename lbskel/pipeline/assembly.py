"""The skeletons of the bodies as one skeleton of the caller's mesh, and the report on it."""

from __future__ import annotations

__all__ = ["assemble", "body_report", "contraction_report", "full_report", "skipped_notes"]

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.connectivity import descend_to_nearest_node
from lbskel.contraction.collapsed_graph import CollapsedGraph
from lbskel.contraction.result import Contraction
from lbskel.contraction.settings import ContractionSettings
from lbskel.errors import MeshError
from lbskel.evaluation.measures import NOT_SCORED, Score
from lbskel.geometry.arrays import to_builtin
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap
from lbskel.pipeline.environment import are_kernels_compiled, versions
from lbskel.pipeline.preparation import Body, PreparedMesh
from lbskel.pipeline.profiling import StageTimer
from lbskel.skeleton.editing import concatenate
from lbskel.skeleton.root import reroot_by_thickness
from lbskel.skeleton.skeleton import Skeleton

# What a skeleton lacks, or may lack, where no time was left for a stage
MISSING = {
    "canonical order": "a result that depends on the order of vertices",
    "prepare bodies": "components without a skeleton, whose vertices are mapped to the nearest node of the others",
    "simplify": "bodies were contracted in full",
    "contract": "bodies that are a single node, or whose graph has many short branches",
    "collapse": "bodies that are a single node, without their handles, open ends and anchors",
    "contract the full surface": "handles that were lost in the proxy",
    "prune spurs": "spurs, and junctions near each other",
    "merge junctions": "junctions where branches do not meet, nodes beside the axes of branches",
    "recenter": "nodes beside the middle of their section",
    "extend tips": "ends short of the last ball of their limb",
    "grow limbs": "limbs without a branch",
    "prune blunt ends": "branches in the corners of ends",
    "mirror": "sides of a symmetric mesh that may differ",
    "reroute inside": "branches that leave the surface",
    "fit tubes": "branches that follow noise, junctions a share of a radius off",
    "tips at surface": "ends inside the surface",
    "map vertices": "regions in several parts",
    "score": "no measures",
    "score points": "no measures",
}


def assemble(skeletons: Sequence[Skeleton], prepared: PreparedMesh) -> Skeleton:
    """Join the skeletons of all bodies in the caller's coordinates, with a node for each of the caller's vertices.

    The first node is the root of trees: the soma of a neuron, else the thickest tip, as
    :func:`~lbskel.skeleton.root.reroot_by_thickness` finds them. Radii of bodies with open ends are distances to the
    caller's surface, where what closed the cuts is nearer.

    Parameters
    ----------
    skeletons : sequence of Skeleton
        Of the bodies of the prepared mesh, in their order.
    prepared : PreparedMesh

    Raises
    ------
    MeshError
        If there is not one skeleton for each body.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> prepared = lbskel.prepare(torus(5.0, 1.0))
    >>> (body,) = prepared.bodies
    >>> graph = lbskel.collapse(lbskel.contract(body.proxy.mesh))
    >>> skeleton = lbskel.assemble([lbskel.refine(lbskel.to_skeleton(graph), body)], prepared)
    >>> skeleton.cycle_rank, round(float(skeleton.radii.mean()), 1)
    (1, 1.0)
    """
    if len(skeletons) != len(prepared.bodies):
        raise MeshError(f"give one skeleton for each of {len(prepared.bodies)} bodies, not {len(skeletons)}")
    whole = concatenate(skeletons)
    node_of_vertex = np.full(len(prepared.mesh.vertices), -1)
    first = 0
    for body, skeleton in zip(prepared.bodies, skeletons, strict=True):
        node_of_vertex[body.vertices] = skeleton.node_of_vertex + first
        first += len(skeleton.nodes)
    to_node = VertexMap(node_of_vertex).complete(prepared.mesh.vertices, whole.nodes)
    vertices = prepared.frame.to_unit(prepared.source.vertices)
    from_source = prepared.vertex_map.compose(to_node).complete(vertices, whole.nodes)
    nodes, radii = prepared.frame.from_unit(whole.nodes), whole.radii * prepared.frame.scale
    is_open = np.repeat([len(body.open_ends) > 0 for body in prepared.bodies], [len(each.nodes) for each in skeletons])
    if is_open.any():  # neither what closes a cut is surface, nor what preprocessing removed
        radii[is_open] = np.maximum(radii[is_open], Surface(prepared.source).distance(nodes[is_open]))
    joined = replace(
        whole,
        nodes=nodes,
        radii=radii,
        mean_radii=whole.mean_radii * prepared.frame.scale,
        node_of_vertex=_with_near_nodes(from_source.indices, vertices, whole, prepared),
    )
    return reroot_by_thickness(joined)


def _with_near_nodes(
    node_of_vertex: NDArray[np.int64], vertices: NDArray[np.float64], skeleton: Skeleton, prepared: PreparedMesh
) -> NDArray[np.int64]:
    """(n,) nodes nearer along the skeleton for vertices that were merged with others elsewhere.

    When a mesh is simplified, a vertex in a long triangle goes by way of one of its corners, several radii away. What
    was only moved, as by smoothing, keeps its node, so that regions stay connected.
    """
    image = prepared.vertex_map.indices
    is_merged = (image >= 0) & (np.bincount(image + 1)[image + 1] > 1)
    offsets = np.where(is_merged, vector_lengths(vertices - prepared.mesh.vertices[image]), 0.0)
    is_moved = offsets > 0
    found = np.array(node_of_vertex)
    found[is_moved] = descend_to_nearest_node(vertices[is_moved], found[is_moved], skeleton.nodes, *skeleton.adjacency)
    return found


def no_edits() -> dict[str, Any]:
    """Count the edits of a graph that has none yet, in the form in which :func:`join_components` and others count."""
    return {"pieces_joined": 0, "joining_edges": [], "loops_opened": 0}


def body_report(
    body: Body, contraction: Contraction, graph: CollapsedGraph | None, skeleton: Skeleton
) -> dict[str, Any]:
    """Report what was done to one body, ready for JSON; ``graph`` is None where no time was left to collapse it."""
    return {
        "vertices": len(body.mesh.vertices),
        "faces": len(body.mesh.faces),
        "notes": list(body.proxy.notes),
        "is_closed_manifold": body.mesh.is_closed_manifold,
        "genus": body.mesh.genus,
        **contraction_report(contraction, graph, skeleton),
    }


def contraction_report(contraction: Contraction, graph: CollapsedGraph | None, skeleton: Skeleton) -> dict[str, Any]:
    """Report a contraction and what came of it, ready for JSON."""
    return {
        "status": contraction.status.value,
        "steps": [to_builtin(asdict(step)) for step in contraction.steps],
        "handles_certified": graph is not None and graph.handles_certified,
        "spurious_loops_removed": 0 if graph is None else graph.n_spurious_loops_removed,
        "cycle_rank": skeleton.cycle_rank,
        "tips": len(skeleton.tips),
        "junctions": len(skeleton.junctions),
    }


def full_report(
    prepared: PreparedMesh,
    settings: ContractionSettings,
    bodies: list[dict[str, Any]],
    scored: Score | None,
    timer: StageTimer,
) -> dict[str, Any]:
    """Report what was done, the score, and the seconds of each stage, ready for JSON."""
    chosen = dict(vars(settings))  # asdict would copy the operator
    if callable(chosen["operator"]):
        chosen["operator"] = getattr(chosen["operator"], "__name__", repr(chosen["operator"]))
    source = prepared.source
    return {
        "input": {"vertices": len(source.vertices), "faces": len(source.faces), "components": source.n_components},
        "settings": chosen,
        "notes": [*prepared.notes, *skipped_notes(timer.skipped)],
        "components": bodies,
        "passed": scored is not None and scored.passed,
        "score": NOT_SCORED if scored is None else scored.report(),
        "seconds": dict(timer.seconds),
        "versions": dict(versions()),
        "kernels_compiled": are_kernels_compiled(),
        "preprocess": prepared.preprocessing,
    } | ({"megabytes": dict(timer.megabytes)} if timer.measures_memory else {})


def skipped_notes(stages: Sequence[str]) -> list[str]:
    """Say which stages were left out, and what the result lacks without them."""
    missing = "; ".join(f"{stage} ({MISSING[stage]})" for stage in stages)
    return [f"the time limit was reached, so these stages were left out: {missing}"] if stages else []
