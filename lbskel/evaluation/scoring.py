"""How good a skeleton is where no truth is known: measured on its mesh, with a verdict for each measure.

The measures follow the properties of Cornea, Silver, Min 2007, https://doi.org/10.1109/TVCG.2007.1002: homotopic to the
shape, inside, centered, reaching every part, smooth, and standing part by part for the shape. Lengths are in units of
the local radius, the distance from a node to the surface of its body, whatever radii the skeleton came with.
"""

from __future__ import annotations

__all__ = ["require_scorable", "score_on"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lbskel.errors import MeshError, first_few
from lbskel.evaluation.measures import Score
from lbskel.geometry.components import MIN_FACES
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centerlines import find_section_centers
from lbskel.refinement.containment import inside_fraction
from lbskel.refinement.extrema import find_extrema, is_missed
from lbskel.refinement.radii import inscribed_radii, mean_radii, own_radii
from lbskel.refinement.region_map import edges_with_disjoint_regions, is_in_largest_piece, nearest_balls
from lbskel.skeleton.skeleton import Skeleton

COVERED = 2.0  # radii of its node within which a vertex is covered
LIMB = 0.05  # of the extent: shorter ends may be too small for the skeleton of the whole shape
PRESSED = 0.2  # of the mean distance of its vertices: nearer, a node is at the wall; in a flat limb it has 0.3
ON = 1e-6  # of the extent: so near a node is on the surface, where tips may be asked for and rays put them within 1e-8
SPUR = 1.2  # radii of its junction that all balls of a spur stay within
MOST_SECTIONS = 60  # cutting takes long: of more nodes than that as many are taken, evenly
FEWEST_SECTIONS = 5  # that tell whether a branch is off its axis


def score_on(skeleton: Skeleton, surface: Surface) -> Score:
    """Measure a skeleton on a surface of extent 1 about the origin, in whose coordinates it is."""
    unit, has_map = surface.mesh, len(skeleton.node_of_vertex) > 0
    skeleton = inscribed_radii(skeleton, surface)
    if not has_map:
        skeleton = replace(skeleton, node_of_vertex=nearest_balls(skeleton, unit))
    if unit.n_components > 1:
        skeleton = own_radii(skeleton, unit)
    node = skeleton.node_of_vertex
    far = np.linalg.norm(unit.vertices - skeleton.nodes[node], axis=1)
    area = np.bincount(unit.faces.ravel(), weights=np.repeat(unit.face_areas, 3), minlength=len(unit.vertices))
    ends = find_extrema(surface.proxy.mesh)
    missed = is_missed(ends, surface.proxy.mesh, skeleton)
    widths = mean_radii(skeleton, unit).radii
    centeredness_error, centeredness_error_worst_branch = _off_center(skeleton, widths, surface)
    parted = edges_with_disjoint_regions(skeleton, unit)
    return Score(
        nodes_inside_fraction=float((surface.contains(skeleton.nodes) | (skeleton.radii <= ON)).mean()),
        inside_fraction=inside_fraction(skeleton, surface),
        centeredness_error=centeredness_error,
        centeredness_error_worst_branch=centeredness_error_worst_branch,
        near_surface_fraction=_share_of_length(skeleton, skeleton.radii < PRESSED * widths),
        coverage=float(area[far <= COVERED * skeleton.radii[node]].sum() / area.sum()),
        extremities=len(missed),
        extremities_missed=int(missed.sum()),
        limb_extremities_missed=int((missed & (ends.lengths > LIMB)).sum()),
        rms_curvature=_bending(skeleton),
        extra_components=skeleton.n_components - _n_bodies(unit),
        extra_cycles=_extra_cycles(skeleton, unit),
        connected_regions=float(is_in_largest_piece(node, unit)[unit.used_vertices].mean()) if has_map else None,
        adjacent_regions=1 - len(parted) / max(1, len(skeleton.edges)) if has_map else None,
        shortcut_edges=_bridges(skeleton, widths, parted),
        spurs=_spurs(skeleton),
    )


def require_scorable(skeleton: Skeleton, mesh: Mesh) -> None:
    """Refuse a skeleton that cannot be measured, or has a map for another mesh."""
    if len(skeleton.nodes) == 0:
        raise MeshError("the skeleton has no nodes, so there is nothing to score")
    bad = np.flatnonzero(~np.isfinite(skeleton.nodes).all(axis=1))
    if len(bad):
        raise MeshError(f"nodes {first_few(bad)} of the skeleton have NaN or infinite coordinates")
    n_mapped = len(skeleton.node_of_vertex)
    if n_mapped not in (0, len(mesh.vertices)):
        raise MeshError(
            f"the skeleton's map is for {n_mapped} vertices, but the mesh has {len(mesh.vertices)}: give the mesh that "
            "it was made from, or a skeleton without a map"
        )


def _share_of_length(skeleton: Skeleton, is_chosen: NDArray[np.bool_]) -> float:
    """How much of the length of all edges belongs to some nodes, half an edge to each end; of nodes without any."""
    length = np.bincount(skeleton.edges.ravel(), weights=np.repeat(skeleton.edge_lengths, 2), minlength=len(is_chosen))
    return float(np.average(is_chosen, weights=length if length.any() else None))


def _off_center(skeleton: Skeleton, widths: NDArray[np.float64], surface: Surface) -> tuple[float | None, float | None]:
    """Distances of nodes from the centroids of their own sections, in radii: the mean, and the worst branch's median.

    The radius is the mean distance of the node's vertices, or that from the centroid to the surface if it is larger.
    """
    inner = np.flatnonzero(skeleton.degrees == 2)
    if len(inner) > MOST_SECTIONS:
        inner = inner[np.linspace(0, len(inner) - 1, MOST_SECTIONS).astype(np.int64)]
    axes = find_section_centers(skeleton, surface, inner)
    at = inner[axes.is_known[inner]]
    if len(at) == 0:
        return None, None
    radii = np.maximum(surface.distance(axes.positions[at]), widths[at])
    off = np.full(len(skeleton.nodes), np.nan)
    off[at] = np.linalg.norm(axes.positions[at] - skeleton.nodes[at], axis=1) / radii
    known = [off[branch][~np.isnan(off[branch])] for branch in skeleton.branches]
    medians = [float(np.median(values)) for values in known if len(values) >= FEWEST_SECTIONS]
    return float(off[at].mean()), max(medians, default=None)


def _bending(skeleton: Skeleton) -> float:
    """Root of the mean square, along the length, of the turn at each node per length of one radius."""
    turns, weights = [0.0], [0.0]
    for branch in skeleton.branches:
        closed = branch[0] == branch[-1] and skeleton.degrees[branch[0]] == 2
        walk = np.concatenate([branch[-2:-1], branch]) if closed else branch
        steps = np.diff(skeleton.nodes[walk], axis=0)
        length = np.linalg.norm(steps, axis=1)
        apart = (length[1:] + length[:-1]) / 2
        cosine = np.einsum("ij,ij->i", steps[1:], steps[:-1])
        sine = np.linalg.norm(np.cross(steps[1:], steps[:-1]), axis=1)
        is_long = apart > 0
        turn = np.arctan2(sine, cosine)[is_long] * skeleton.radii[walk[1:-1]][is_long] / apart[is_long]
        turns.extend(turn)
        weights.extend(apart[is_long])
    return float(np.sqrt(np.average(np.square(turns), weights=weights))) if any(weights) else 0.0


def _n_bodies(mesh: Mesh) -> int:
    """Components that a skeleton can stand for: crumbs of a few faces or without area are none."""
    component = mesh.component_of_vertex[mesh.faces[:, 0]]
    return int(((np.bincount(component) >= MIN_FACES) & (np.bincount(component, mesh.face_areas) > 0)).sum())


def _extra_cycles(skeleton: Skeleton, mesh: Mesh) -> int | None:
    """Cycles less handles, with holes closed; None where more than two faces meet at an edge.

    Each component of the skeleton is compared with the components of the mesh that it represents: a cycle too many in
    one does not make up for a cycle lost in another.
    """
    if not mesh.is_edge_manifold:
        return None
    edges, vertices = mesh.edges, mesh.used_vertices
    component = mesh.component_of_vertex
    euler = (
        np.bincount(component[vertices], minlength=mesh.n_components)
        - np.bincount(component[edges[:, 0]], minlength=mesh.n_components)
        + np.bincount(component[mesh.faces[:, 0]], minlength=mesh.n_components)
    )
    border = edges[mesh.faces_per_edge == 1]
    if len(border):
        rim, ends = np.unique(border, return_inverse=True)
        graph = weighted_graph(ends.reshape(-1, 2), np.ones(len(border), dtype=np.int8), len(rim))
        first_of_hole = np.unique(connected_components(graph, directed=False)[1], return_index=True)[1]
        euler += np.bincount(component[rim[first_of_hole]], minlength=mesh.n_components)
    handles = 1 - euler // 2
    part = skeleton.component_of_node
    votes = part[skeleton.node_of_vertex[vertices]], component[vertices]
    shape = (skeleton.n_components, mesh.n_components)
    represents = coo_array((np.ones(len(vertices), dtype=np.int64), votes), shape=shape).tocsc().argmax(axis=0)
    expected = np.bincount(np.asarray(represents).ravel(), handles, minlength=skeleton.n_components)
    cycles = (
        np.bincount(part[skeleton.edges[:, 0]], minlength=skeleton.n_components)
        - np.bincount(part, minlength=skeleton.n_components)
        + 1
    )
    surplus = cycles - expected
    total, spread = int(surplus.sum()), int(np.abs(surplus).sum())
    return total if abs(total) == spread else spread


def _bridges(skeleton: Skeleton, widths: NDArray[np.float64], parted: NDArray[np.int64]) -> int:
    """Of the edges between regions that do not touch, those that are longer than the regions are wide."""
    length = np.linalg.norm(skeleton.nodes[parted[:, 0]] - skeleton.nodes[parted[:, 1]], axis=1)
    return int((length > widths[parted].sum(axis=1)).sum())


def _spurs(skeleton: Skeleton) -> int:
    """End branches whose balls hardly leave the ball of their junction."""
    ends = skeleton.end_branches
    reached = [np.linalg.norm(skeleton.nodes[b] - skeleton.nodes[b[0]], axis=1) + skeleton.radii[b] for b in ends]
    return sum(float(r.max()) < SPUR * float(skeleton.radii[b[0]]) for r, b in zip(reached, ends, strict=True))
