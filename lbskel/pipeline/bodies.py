"""The skeleton of one body: contract, collapse, refine; again on the full surface where the proxy loses a handle."""

from __future__ import annotations

__all__ = ["skeletonize_body", "to_skeleton"]

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from lbskel.contraction.collapsed_graph import CollapsedGraph
from lbskel.contraction.flow import contract
from lbskel.contraction.result import Contraction, Status
from lbskel.contraction.settings import ContractionSettings
from lbskel.contraction.surgery import collapse
from lbskel.errors import MeshError, counted
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.vertex_map import VertexMap
from lbskel.pipeline.assembly import body_report
from lbskel.pipeline.preparation import Body
from lbskel.pipeline.profiling import StageTimer
from lbskel.preprocess.proxy import MAX_FACES
from lbskel.preprocess.result import identity_result
from lbskel.skeleton.skeleton import Skeleton

CONTRACTION_SHARE = 0.5  # of the time left that contraction may take under a time limit; a guess


def skeletonize_body(
    body: Body, settings: ContractionSettings, refine: Callable[[Skeleton, Body], Skeleton], timer: StageTimer
) -> tuple[Skeleton, dict[str, Any]]:
    """Make the skeleton of a body, and its report.

    If the skeleton of a closed surface does not have one cycle for each handle, and a proxy was contracted, the full
    surface is contracted in its place. Where no time is left to collapse the body to a graph, the skeleton is a single
    node.

    Parameters
    ----------
    body : Body
    settings : ContractionSettings
    refine : callable
        Takes the skeleton of the body's proxy and the body, returns that of the body: :func:`lbskel.refine`.
    timer : StageTimer
    """
    skeleton, report = _skeletonize_proxy(body, settings, refine, timer)
    has_lost_handles = body.mesh.genus is not None and skeleton.cycle_rank != body.mesh.genus
    is_simplified = len(body.proxy.mesh.faces) < len(body.mesh.faces)
    if not (has_lost_handles and is_simplified and timer.has_time_for("contract the full surface")):
        return skeleton, report
    full = replace(body, proxy=identity_result(body.mesh))
    again, report_again = _skeletonize_proxy(full, settings, refine, timer)
    note = f"contracted in full, since the proxy kept {counted(skeleton.cycle_rank, 'cycle')} of {body.mesh.genus}"
    return again, {**report_again, "notes": [*report_again["notes"], note]}


def _skeletonize_proxy(
    body: Body, settings: ContractionSettings, refine: Callable[[Skeleton, Body], Skeleton], timer: StageTimer
) -> tuple[Skeleton, dict[str, Any]]:
    mesh = body.proxy.mesh
    contraction = Contraction(mesh, mesh, VertexMap.identity(len(mesh.vertices)), (), Status.TIME_LIMIT)
    if timer.has_time_for("contract"):
        with timer("contract"):
            seconds = None if timer.time_limit is None else CONTRACTION_SHARE * max(timer.seconds_left, 0.0)
            contraction = contract(mesh, settings, time_limit=seconds)
    graph = None
    is_out_of_time = contraction.status is Status.TIME_LIMIT and not contraction.steps
    if len(mesh.faces) <= MAX_FACES or not is_out_of_time:  # else its rounds take longer than what is left
        graph = timer.optional("collapse", lambda end: collapse(contraction, deadline=end), None, is_needed=True)
    else:
        timer.skip("collapse")
    if graph is None:
        skeleton = _single_node(body)
        return skeleton, body_report(body, contraction, None, skeleton)
    skeleton = refine(to_skeleton(graph), body)
    return skeleton, body_report(body, contraction, graph, skeleton)


def _single_node(body: Body) -> Skeleton:
    """Make a skeleton of one node, at the centroid of a body for which no time was left."""
    center, n = body.mesh.centroid[None], len(body.mesh.vertices)
    distances = vector_lengths(body.mesh.vertices - center)
    no_edges, of_vertex = np.empty((0, 2), dtype=np.int64), np.zeros(n, dtype=np.int64)
    single = Skeleton(center, no_edges, distances.min(keepdims=True), of_vertex)
    return replace(single, mean_radii=distances.mean(keepdims=True))


def to_skeleton(graph: CollapsedGraph) -> Skeleton:
    """Convert a collapsed graph to a skeleton with radii of zero, the input of :func:`lbskel.refine`.

    Parameters
    ----------
    graph : CollapsedGraph

    Raises
    ------
    MeshError
        If the graph's mesh has vertices in no face, which have no node.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> lbskel.to_skeleton(lbskel.collapse(lbskel.contract(torus(1.0, 0.2)))).cycle_rank
    1
    """
    if (n_without := int((graph.node_of_vertex < 0).sum())) > 0:
        raise MeshError(
            f"the mesh has {counted(n_without, 'vertex')} in no face, which no node is made from: contract the mesh of "
            "a body from lbskel.prepare, which leaves them out"
        )
    return Skeleton(graph.nodes, graph.edges, np.zeros(len(graph.nodes)), graph.node_of_vertex)
