"""From one connected surface to its skeleton: the stages in their order, each timed.

Two of them may take more than a quarter of the whole. Contraction does up to some hundred thousand faces: its steps
cannot be fewer without loss, nor be run side by side. Simplification does beyond: it has to visit every face, in an
order that depends on what it did before.
"""

from __future__ import annotations

__all__ = ["RESOLUTIONS", "TIPS", "Options", "enough_faces", "skeleton_of_component"]

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.contraction.flow import ContractionSettings, Status, Step, contract
from lbskel.contraction.surgery import collapse
from lbskel.errors import UnknownChoice, choose
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import straight_thickness
from lbskel.geometry.surface_queries import Proxy, Surface
from lbskel.pipeline.profiling import StageTimer
from lbskel.preprocess import PreprocessResult, simplify
from lbskel.preprocess.result import identity_result
from lbskel.refinement.anchors import attach_anchors
from lbskel.refinement.centering import (
    fit_to_centerlines,
    inscribed_radii,
    mean_radii,
    reassign_to_nearest_node,
    recenter,
)
from lbskel.refinement.centerlines import find_section_centers
from lbskel.refinement.containment import inside_fraction, reroute_inside
from lbskel.refinement.junctions import merge_junctions_by_axes
from lbskel.refinement.missing_branches import grow_missing_branches
from lbskel.refinement.tips import extend_tips, tips_at_surface
from lbskel.refinement.vertex_map import make_regions_connected
from lbskel.skeleton.pruning import merge_junctions, prune, prune_contained_branches
from lbskel.skeleton.resampling import resample
from lbskel.skeleton.skeleton import Skeleton

MERGE = 0.7  # junctions nearer than this many radii are one
SPACING = 0.5  # of the nodes along a branch, in radii
INSIDE = 0.995  # share of the length that must lie inside for the check to pass

SURE = 2.0  # times the measured distance of the simplified surface, beyond which it tells inside from outside
CONTRACTING = 0.5  # share of the time left that contraction may take where time is limited

MOST_FACES = 16_000  # of a component that is contracted as it is, unless in full
FEWEST_FACES = 12_000  # of one that is simplified: with 8,000 our shapes came out a tenth less accurate
EDGE = 0.4  # of the local radius, as which edges need not be shorter; with 0.5 armadillo lost claws
SAMPLES = 1_000  # faces that tell the local radius
TINY = 0.001  # of the extent, as which no radius counts for less: what is that thin is a crease, or lost anyway
EQUILATERAL = 0.433  # the area of a triangle with edges of one
SLENDER = 2.0  # times area^3 / volume^2: so many faces have edges of half the mean radius 2 volume / area
MOST_SLENDER = 128_000  # of them, however thin

RESOLUTIONS = ("auto", "full")
TIPS = ("inside", "surface")


@dataclass(frozen=True)
class Options:
    """What the caller may choose; see :func:`lbskel.skeletonize`."""

    settings: ContractionSettings
    resolution: str = "auto"
    prune: float = 1.5
    tips: str = "inside"

    def __post_init__(self) -> None:
        choose(dict.fromkeys(RESOLUTIONS), self.resolution, "resolution")
        choose(dict.fromkeys(TIPS), self.tips, "place of the tips")
        if not self.prune >= 0:
            raise UnknownChoice(f"prune must be a number of radii, 0 or more, not {self.prune}")


def skeleton_of_component(
    mesh: Mesh, options: Options, anchors: tuple[NDArray[np.int64], NDArray[np.float64]], clock: StageTimer
) -> tuple[Skeleton, Surface, dict[str, Any]]:
    """Contract, collapse, prune, refine and check one connected surface.

    Parameters
    ----------
    mesh : Mesh
        Of about unit extent.
    options : Options
    anchors : pair of (a,) array of int and (a, 3) array of float
        The vertices at or near the anchors, and their places.
    clock : StageTimer

    Returns
    -------
    skeleton : Skeleton
    surface : Surface
        The mesh, with what it was simplified to.
    report : dict
        What was done and checked, ready for JSON.
    """
    proxy = identity_result(mesh)
    if options.resolution == "auto":
        proxy = clock("simplify", _simple, mesh)
    limit = None if clock.time_limit is None else CONTRACTING * max(clock.seconds_left, 0.0)
    contraction = clock("contract", contract, proxy.mesh, options.settings, time_limit=limit)
    graph = clock("collapse", collapse, contraction)
    skeleton = Skeleton(graph.nodes, graph.edges, np.zeros(len(graph.nodes)), graph.node_of_vertex)
    surface = Surface(mesh, _simplified(mesh, proxy))
    skeleton = clock("prune", _pruned, skeleton, surface.proxy, options.prune)
    skeleton = clock.if_time("gather", _gathered, skeleton, surface.proxy)
    skeleton = replace(skeleton, node_of_vertex=proxy.vertex_map.pull_back(skeleton.node_of_vertex))
    skeleton = clock.if_time("recenter", recenter, skeleton, surface)
    skeleton = clock.if_time("extend", extend_tips, skeleton, surface)
    skeleton = clock("prune", prune_contained_branches, inscribed_radii(skeleton, surface.proxy), mesh)
    skeleton = clock.if_time("extend", grow_missing_branches, skeleton, surface, ratio=options.prune)
    skeleton = clock.if_time("lead inside", _led_inside, skeleton, surface)
    if options.tips == "surface":
        skeleton = clock.if_time("extend", tips_at_surface, skeleton, surface)
    skeleton = clock("anchor", attach_anchors, inscribed_radii(skeleton, surface), surface, *anchors)
    skeleton = clock("map", reassign_to_nearest_node, skeleton, mesh)
    skeleton = clock("map", make_regions_connected, skeleton, mesh)
    skeleton = replace(skeleton, mean_radii=mean_radii(skeleton, mesh).radii)
    inside = clock("check", inside_fraction, skeleton, surface)
    genus = mesh.genus
    checks = {
        "is_topology_right": None if genus is None else (skeleton.n_components, skeleton.cycle_rank) == (1, genus),
        "is_inside": inside >= INSIDE if mesh.is_closed else None,
        "is_contracted": contraction.status in (Status.VOLUME, Status.AREA, Status.STALLED),
    }
    return (
        skeleton,
        surface,
        {
            "vertices": len(mesh.vertices),
            "faces": len(mesh.faces),
            "notes": list(proxy.notes),
            "is_closed_manifold": mesh.is_closed_manifold,
            "genus": genus,
            "status": contraction.status.value,
            "steps": [_record(step) for step in contraction.steps],
            "handles_certified": graph.handles_certified,
            "spurious_loops_removed": graph.n_spurious_loops_removed,
            "cycle_rank": skeleton.cycle_rank,
            "tips": len(skeleton.tips),
            "junctions": len(skeleton.junctions),
            "inside_fraction": inside,
            "checks": checks,
        },
    )


def enough_faces(mesh: Mesh) -> int:
    """Of how many faces a mesh is to be contracted at most.

    As many as give edges of a fraction of the local radius, within limits that are wider for what is long and thin all
    over.
    """
    squared = mesh.volume**2 if mesh.is_closed else 0.0
    if not squared > 0:
        return MOST_FACES
    most = int(np.clip(SLENDER * mesh.area**3 / squared, MOST_FACES, MOST_SLENDER))
    if len(mesh.faces) <= most:
        return most
    sample = np.flatnonzero(mesh.face_areas)[:: 1 + len(mesh.faces) // SAMPLES]
    radius = np.maximum(straight_thickness(mesh, sample) / 2, TINY * mesh.diameter_bound)
    areas = mesh.face_areas[sample]
    in_edges = (areas / radius**2).sum() * mesh.area / areas.sum() / EDGE**2
    return int(np.clip(in_edges / EQUILATERAL, FEWEST_FACES, most))


def _simple(mesh: Mesh) -> PreprocessResult:
    """The mesh in no more faces than its skeleton needs."""
    return simplify(mesh, target_faces=enough_faces(mesh))


def _simplified(mesh: Mesh, proxy: PreprocessResult) -> Proxy | None:
    """The mesh that was contracted, beside the whole one; None where it is the same."""
    deviations = [step["deviation"] for step in proxy.report.get("steps", []) if "deviation" in step]
    if not deviations:
        return None
    kept = proxy.vertex_map.one_source_per_target(len(proxy.mesh.vertices))
    if (kept < 0).any():  # where the surface was meshed anew
        kept = np.where(kept < 0, cKDTree(mesh.vertices).query(proxy.mesh.vertices)[1], kept)
    return Proxy(proxy.mesh, proxy.vertex_map, kept, SURE * deviations[0])


def _record(step: Step) -> dict[str, Any]:
    """A step as JSON can hold it, which has no NaN: an open mesh has None for a volume."""
    return {name: None if value != value else value for name, value in asdict(step).items()}


def _pruned(skeleton: Skeleton, surface: Surface, ratio: float) -> Skeleton:
    """Spurs cut, near junctions merged, nodes evenly spaced."""
    skeleton = prune(mean_radii(skeleton, surface.mesh), surface.mesh, ratio=ratio)
    return _spaced(merge_junctions(inscribed_radii(skeleton, surface), ratio=MERGE), surface)


def _gathered(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Junctions that are one made one, and every branch evenly spaced and on its axis between them."""
    axes = find_section_centers(skeleton, surface)
    gathered = merge_junctions_by_axes(inscribed_radii(skeleton, surface), axes, surface)
    if len(gathered.nodes) < len(skeleton.nodes):
        skeleton = _spaced(gathered, surface)
        axes = find_section_centers(skeleton, surface)
    return fit_to_centerlines(skeleton, axes, surface)


def _led_inside(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Every branch inside a closed surface and evenly spaced."""
    if surface.mesh.is_closed:
        skeleton = reroute_inside(skeleton, surface)
    skeleton = _spaced(skeleton, surface)
    return reroute_inside(skeleton, surface) if surface.mesh.is_closed else skeleton  # where even spacing cut a corner


def _spaced(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Nodes evenly spaced by mean radii: by inscribed ones what is flat would have a node for every thickness."""
    return resample(mean_radii(skeleton, surface.mesh), spacing=SPACING)
