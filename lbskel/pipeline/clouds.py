"""The skeleton of a point cloud: that of a closed surface through the points, mapped back to them.

So clouds have the contraction, the surgery, the refinement and the settings of meshes. The graph of a soup of local
triangulations, contracted instead, has a loop at many of its holes: hundreds of loops on clouds with noise.
"""

from __future__ import annotations

__all__ = ["CloudSkeletonizer", "skeletonize_cloud"]

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from lbskel.errors import MeshError
from lbskel.evaluation.measures import NOT_SCORED, Score
from lbskel.evaluation.point_scoring import SCORED_NEIGHBORS
from lbskel.geometry.graphs import connected_labels
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.geometry.sorting import is_among
from lbskel.geometry.vertex_map import VertexMap
from lbskel.pipeline.anchoring import index_of_point, listed_anchors
from lbskel.pipeline.assembly import skipped_notes
from lbskel.pipeline.evaluation import score_cloud
from lbskel.pipeline.profiling import StageTimer
from lbskel.preprocess import Pipeline, PreprocessResult
from lbskel.preprocess.point_cleaning import CleanedPoints
from lbskel.preprocess.reconstruction import surface_and_points
from lbskel.refinement.anchors import as_place
from lbskel.refinement.radii import mean_axis_distances
from lbskel.skeleton.joining import join_pieces
from lbskel.skeleton.resampling import resample
from lbskel.skeleton.root import reroot_by_thickness
from lbskel.skeleton.skeleton import Skeleton

UNCHECKED = "no surface is given, so what of it no point has seen, and whether a loop is too many, could not be checked"
# Distance between limbs, in distances between points, below which their surfaces may grow together: by hand, tubes 1.4
# apart did, those 2.0 apart and more did not; with noise, the limbs of a knot did at 2
LEAST_GAP = 2.0


class CloudSkeletonizer(Protocol):
    """:func:`lbskel.skeletonize` of a mesh, with the options of the caller and without a score."""

    def __call__(
        self,
        mesh: Mesh,
        *,
        anchors: Sequence[Any],
        root: Any,
        preprocess: str,
        timer: StageTimer,
    ) -> Skeleton:
        """Make the skeleton of a mesh."""


def skeletonize_cloud(
    cloud: PointCloud,
    skeletonize: CloudSkeletonizer,
    *,
    anchors: Sequence[Any] = (),
    root: Any = None,
    preprocess: str | Pipeline | None = "auto",
    join: str = "pieces",
    radius_kind: str = "inscribed",
    n_nodes: int | None = None,
    timer: StageTimer,
) -> Skeleton:
    """Make the skeleton of the surface through a cloud, with a node for every point.

    Parameters
    ----------
    cloud : PointCloud
    skeletonize : callable
        Makes the skeleton of a mesh.
    anchors, root, preprocess, join, radius_kind, n_nodes
        As for :func:`lbskel.skeletonize`, where ``preprocess`` is a preparation of clouds, not a pipeline of meshes.
    timer : StageTimer

    Raises
    ------
    MeshError
        If the points enclose nothing, or an anchor is no point of the cloud.
    UnknownChoice
        If the preparation is none of those of clouds.
    """
    places = listed_anchors(anchors)
    for place in (*places, root):
        index_of_point(place, len(cloud.points))  # before anything is computed
    with timer("reconstruct"):
        surface, points = surface_and_points(cloud, "none" if preprocess is None else preprocess)  # type: ignore[arg-type]
    skeleton = skeletonize(
        surface.mesh,
        anchors=[_on_surface(anchor, cloud, surface) for anchor in places],
        root=_on_surface(root, cloud, surface),
        preprocess="none" if surface.mesh.is_closed_manifold else "auto",
        timer=timer,
    )
    n_skipped = len(timer.skipped)
    to_node = surface.vertex_map.compose(VertexMap(skeleton.node_of_vertex)).complete(cloud.points, skeleton.nodes)
    mapped = replace(skeleton, node_of_vertex=to_node.indices)
    if join == "pieces":
        mapped = _with_joined_pieces(mapped, points)
    # without outliers; 0 in a component without points
    means = mean_axis_distances(mapped, cloud.points, surface.vertex_map.is_mapped)
    means = np.where(means > 0, means, mapped.mean_radii)
    # the surface is a guess between the points, the more so where it is a tube around those of a thin limb
    mapped = replace(mapped, radii=np.minimum(mapped.radii, means), mean_radii=means)
    if root is None:
        mapped = reroot_by_thickness(mapped, radius_kind)
    if n_nodes is not None:
        mapped = resample(mapped, n_nodes=n_nodes)
    neighbors = points.source_neighbors(SCORED_NEIGHBORS)
    scored = timer.optional("score points", lambda _: score_cloud(mapped, cloud, neighbors), None, is_needed=True)
    return replace(mapped, report=_report(mapped, cloud, surface, scored, timer, timer.skipped[n_skipped:]))


def _with_joined_pieces(skeleton: Skeleton, points: CleanedPoints) -> Skeleton:
    """Join components with neighboring points: the surface of a thin limb may break where the points go on."""
    if skeleton.n_components == 1:
        return skeleton
    source = points.vertex_map.one_source_per_target(len(points.points))
    component, k = skeleton.component_of_node[skeleton.node_of_vertex[source]], skeleton.n_components
    neighbors = points.cloud.nearest(SCORED_NEIGHBORS)[1]
    links = np.stack([np.repeat(np.arange(len(neighbors)), neighbors.shape[1]), neighbors.ravel()], axis=1)
    links = links[component[links[:, 0]] != component[links[:, 1]]]
    is_mutual = is_among(links @ [len(neighbors), 1], links @ [1, len(neighbors)])
    pairs = component[links[is_mutual]]
    part = connected_labels(pairs, k)
    joined, first = skeleton, np.unique(skeleton.component_of_node, return_index=True)[1]  # a node of each component
    for number in np.flatnonzero(np.bincount(part) > 1):
        is_joinable = np.isin(np.arange(joined.n_components), joined.component_of_node[first[part == number]])
        joined = join_pieces(joined, is_joinable)
    return joined


def _on_surface(place: Any, cloud: PointCloud, surface: PreprocessResult) -> Any:
    """Return the vertex of the surface for a point of the cloud, by its index or place, and anything else unchanged.

    The surface passes beside the points, so that a place of one may be outside.
    """
    index = index_of_point(place, len(cloud.points))
    given = as_place(place)
    if index is None and given.shape == (3,):
        index = next(iter(np.flatnonzero((cloud.points == given).all(axis=1)).tolist()), None)
    if index is None:
        return place
    vertex = int(surface.vertex_map.indices[index])
    if vertex < 0:
        raise MeshError(f"point {index} is an outlier, which is on no surface; give another, or preprocess='none'")
    return vertex


def _report(
    skeleton: Skeleton,
    cloud: PointCloud,
    surface: PreprocessResult,
    scored: Score | None,
    timer: StageTimer,
    skipped: Sequence[str],
) -> dict[str, Any]:
    """Return the report of the surface's skeleton with input, notes, score and seconds of the cloud."""
    report = skeleton.report
    given = {"vertices": len(cloud.points), "faces": 0, "components": report["input"]["components"]}
    steps = surface.report["steps"][0]
    gap = f"about {LEAST_GAP * steps['spacing']:.2g}, twice the distance between points"
    grown = f"limbs nearer to each other than {gap}, may have grown together, and so may limbs that noise joins"
    return {
        **report,
        "input": given,
        "notes": [*surface.notes, *report["notes"], f"{UNCHECKED}; {grown}", *skipped_notes(skipped)],
        "passed": scored is not None and scored.passed,
        "score": NOT_SCORED if scored is None else scored.report(),
        "reconstruction": {"faces": len(surface.mesh.faces), **steps},
        "seconds": dict(timer.seconds),
    } | ({"megabytes": dict(timer.megabytes)} if timer.measures_memory else {})
