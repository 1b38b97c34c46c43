"""The skeleton of a cloud by contraction of its points, without a surface: the method of Cao et al. 2010.

The points go through the loop that contracts meshes, with the operator of their stars. The graph of
:mod:`lbskel.contraction.point_graph` is the skeleton; nothing refines it, so that it is the skeleton of the paper.
"""

from __future__ import annotations

__all__ = ["is_of_points", "skeletonize_points"]

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.contraction.flow import contract
from lbskel.contraction.result import Status
from lbskel.contraction.settings import ContractionSettings
from lbskel.contraction.surgery import collapse
from lbskel.errors import MeshError, UnknownChoice, were
from lbskel.evaluation.measures import NOT_SCORED
from lbskel.evaluation.point_scoring import score_points
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.geometry.point_stars import distinct_points
from lbskel.geometry.vertex_map import VertexMap
from lbskel.operators import STAR_OPERATORS
from lbskel.pipeline.anchoring import index_of_point, listed_anchors
from lbskel.pipeline.assembly import contraction_report, no_edits, skipped_notes
from lbskel.pipeline.environment import are_kernels_compiled, versions
from lbskel.pipeline.profiling import StageTimer
from lbskel.preprocess.point_cleaning import CleanedPoints, clean_points
from lbskel.preprocess.point_neighborhoods import Neighborhoods
from lbskel.refinement.anchors import as_point
from lbskel.refinement.radii import mean_axis_distances
from lbskel.skeleton.editing import reroot
from lbskel.skeleton.joining import join_components
from lbskel.skeleton.resampling import resample
from lbskel.skeleton.root import reroot_by_thickness
from lbskel.skeleton.short_loops import open_short_loops
from lbskel.skeleton.skeleton import Skeleton

UNCHECKED = "no surface is given, so whether a loop is too many, and how near it the skeleton is, could not be checked"
OF_VERTICES = "the preset contracts points: the faces of the mesh were not used"
NEEDS_SURFACE = ("min_branch_ratio", "tip_position")  # options of refinement, which takes a surface


def is_of_points(settings: ContractionSettings) -> bool:
    """Whether the operator of some settings is one of the stars of points."""
    return isinstance(settings.operator, str) and settings.operator in STAR_OPERATORS


def skeletonize_points(
    shape: Mesh | PointCloud,
    settings: ContractionSettings,
    given: Mapping[str, Any],
    *,
    anchors: Any = (),
    root: Any = None,
    n_nodes: int | None = None,
    preprocess: Any = "auto",
    timer: StageTimer,
) -> Skeleton:
    """Contract points and collapse them to a graph.

    Parameters
    ----------
    shape : Mesh or PointCloud
        Of a mesh, its vertices.
    settings : ContractionSettings
    given : mapping
        The options ``min_branch_ratio``, ``tip_position``, ``join``, ``min_loop`` and ``radius_kind`` of
        :func:`lbskel.skeletonize`, None where the caller gave none.
    anchors, root, n_nodes, preprocess
        As for :func:`lbskel.skeletonize`, except that there may be no anchors, and ``preprocess="auto"`` only merges
        duplicates, as the published method has no other preprocessing.
    timer : StageTimer

    Raises
    ------
    UnknownChoice
        If anchors or an option of refinement are given, which needs a surface.
    MeshError
        If the points are too few or on a line, or ``root`` is neither a point nor the index of one.
    """
    unused = [name for name in NEEDS_SURFACE if given.get(name) is not None]
    if listed_anchors(anchors):
        unused.append("anchors")
    if unused:
        raise UnknownChoice(
            f"{', '.join(unused)}: this preset contracts points and refines nothing; leave it out, or choose another"
        )
    cloud = shape if isinstance(shape, PointCloud) else PointCloud(shape.vertices)
    place = None if root is None else _resolve_root(root, len(cloud.points))
    with timer("clean"):
        cleaned = _distinct(cloud.points) if preprocess in (None, "auto") else clean_points(cloud.points, preprocess)
    with timer("contract"):
        limit = None if timer.time_limit is None else max(timer.seconds_left, 1e-3)
        contraction = contract(PointCloud(cleaned.points), settings, time_limit=limit)
    with timer("collapse"):
        graph = collapse(contraction)
    to_node = cleaned.vertex_map.pull_back(graph.node_of_vertex)
    to_node = VertexMap(to_node).complete(cloud.points, graph.nodes).indices
    whole = Skeleton(graph.nodes, graph.edges, np.zeros(len(graph.nodes)), to_node, report=no_edits())
    skeleton = _with_radii(whole, cloud, cleaned.vertex_map.is_mapped)
    if given.get("join") == "all":
        skeleton = join_components(skeleton)
    if given.get("min_loop"):
        skeleton = open_short_loops(skeleton, given["min_loop"])
    if place is None:
        skeleton = reroot_by_thickness(skeleton, given.get("radius_kind") or "inscribed")
    else:
        skeleton = reroot(skeleton, _node_at(place, skeleton))
    if n_nodes is not None:
        skeleton = resample(skeleton, n_nodes=n_nodes)
    if contraction.status is Status.TIME_LIMIT:
        timer.skip("contract")
    with timer("score"):
        scored = score_points(skeleton, cloud) if timer.has_time_for("score") else None
    body = {
        "vertices": len(cleaned.points),
        "faces": 0,
        "notes": [],
        "is_closed_manifold": False,
        "genus": None,
        **contraction_report(contraction, graph, skeleton),
    }
    of_vertices = [OF_VERTICES] if isinstance(shape, Mesh) else []
    report = {
        "input": {"vertices": len(cloud.points), "faces": 0, "components": 1},
        "settings": dict(vars(settings)),
        "notes": [*of_vertices, *cleaned.notes, UNCHECKED, *skipped_notes(timer.skipped)],
        "components": [body],
        "passed": scored is not None and scored.passed,
        "score": NOT_SCORED if scored is None else scored.report(),
        "seconds": dict(timer.seconds),
        "versions": dict(versions()),
        "kernels_compiled": are_kernels_compiled(),
        "preprocess": {"steps": [cleaned.report]},
        **skeleton.report,
    } | ({"megabytes": dict(timer.megabytes)} if timer.measures_memory else {})
    return replace(skeleton, report=report)


def _distinct(points: NDArray[np.float64]) -> CleanedPoints:
    """Leave out all but the first of equal points, in their order."""
    first, place = distinct_points(points)
    n_more = len(points) - len(first)
    notes = (f"{were(n_more, 'duplicate point')} merged",) if n_more else ()
    report = {"points": len(points), "duplicates": n_more, "outliers": 0, "kept": len(first)}
    return CleanedPoints(Neighborhoods(points[first]), VertexMap(place), notes, report)


def _with_radii(skeleton: Skeleton, cloud: PointCloud, is_kept: NDArray[np.bool_]) -> Skeleton:
    """Give nodes the distance to the nearest point, and the mean distance of their own points from the axis.

    Points that were left out as outliers do not count.
    """
    inscribed = cKDTree(cloud.points[is_kept]).query(skeleton.nodes)[0]
    means = mean_axis_distances(skeleton, cloud.points, is_kept)  # 0 in a component without points
    return replace(skeleton, radii=inscribed, mean_radii=np.where(means > 0, means, inscribed))


def _resolve_root(root: Any, n_points: int) -> int | NDArray[np.float64]:
    """Return the index of the point, or the position, that a root is; raise MeshError if it is neither."""
    if (index := index_of_point(root, n_points)) is not None:
        return index
    if (point := as_point(root)) is None:
        raise MeshError(f"a root must be the index of a point, or a point of three numbers, not {root!r}")
    return point


def _node_at(place: int | NDArray[np.float64], skeleton: Skeleton) -> int:
    """Return the node of a point, given by its index, or the node nearest to a position."""
    if isinstance(place, int):
        return int(skeleton.node_of_vertex[place])
    return int(cKDTree(skeleton.nodes).query(place)[1])
