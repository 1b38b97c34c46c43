"""The quality of a skeleton, measured on its mesh, where no true skeleton is known.

The measures follow the properties of Cornea, Silver, Min 2007, https://doi.org/10.1109/TVCG.2007.1002: homotopic to the
shape, inside it, centered, reliable, smooth, and decomposing the shape into its parts. Lengths are in units of the
local radius, the distance from a node to the surface of its body; the radii of the skeleton itself are not used.
"""

from __future__ import annotations

__all__ = ["centeredness_errors", "require_scorable", "score_on"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.spatial import cKDTree

from lbskel.contraction.cycle_classes import tunnels_missed
from lbskel.errors import MeshError, counted
from lbskel.evaluation.handles import count_handles
from lbskel.evaluation.measures import Score
from lbskel.evaluation.medial_points import medial_distances
from lbskel.evaluation.skeleton_shape import mean_and_worst_branch, n_spurs, negative_fraction, rms_curvature
from lbskel.geometry.components import find_crumbs, set_local_radii_of_components
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.sorting import stable_order
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import is_in_largest_piece
from lbskel.refinement.centerlines import find_section_centers
from lbskel.refinement.containment import inside_fraction
from lbskel.refinement.extrema import find_extrema, is_missed
from lbskel.refinement.open_ends import NO_CUTS, are_at_rims, cuts_with_tips
from lbskel.refinement.radii import inscribed_radii, mean_radii, own_radii
from lbskel.refinement.region_map import edges_with_disjoint_regions, nearest_balls
from lbskel.skeleton.skeleton import Skeleton

# benchmarks/results/constants.md has how scores change with each of these constants moved by -30 and +40 %
MAX_COVERED_DISTANCE = 2.0  # in local radii: a vertex no farther from its node is covered; a guess
# Length of a limb, in its radii, up to which its extremity may have no tip; a guess, which was 6 with distances along
# edges: on a sphere these are 7 % longer, and the length in radii grows with their square. That of 6 had no effect from
# 4.2 to 8.4
MIN_LIMB_LENGTH = 5.3
OPEN_TOLERANCE = 0.5  # in mean radii: as far outside a surface that is not closed counts as inside, since the surface
# that is missing there has no exact place; a guess
NEAR_SURFACE_RATIO = 0.2  # distance to the surface over the local radius, or over the mean distance to own vertices if
# that is less, below which a node is near the surface; a guess below 0.3, which nodes on the axis of a flat limb have
SURFACE_TOLERANCE = 1e-6  # in diameter bounds: a node this near is on the surface; rays put tips within 1e-8 of it


def score_on(
    skeleton: Skeleton, surface: Surface, *, open_ends: NDArray[np.float64] = NO_CUTS, n_loops_opened: int = 0
) -> Score:
    """Measure a skeleton on the surface of a mesh at unit size.

    Parameters
    ----------
    skeleton : Skeleton
        In the coordinates of the surface. Without a vertex map, each vertex is mapped to the nearest ball, and the
        measures of the map are None.
    surface : Surface
        Of a mesh with a diameter bound of 1, with its centroid at the origin.
    open_ends : (e, 7) array of float
        Center (3), mean radius (1) and vector area (3) of each cut. Within the radius of a cut that has a tip, what
        closes it does not count: a node there counts as inside, and as that radius away from the surface.
    n_loops_opened : int
        Cycles that were opened on purpose, and count as if they were there.

    Raises
    ------
    OutOfTime
        If the deadline of the surface passes.
    """
    skeleton, surface = _on_used_vertices(skeleton, surface)
    unit, has_map = surface.mesh, len(skeleton.node_of_vertex) > 0
    skeleton = _on_surface(skeleton, surface)
    open_ends = cuts_with_tips(skeleton, surface, open_ends)
    node = skeleton.node_of_vertex
    distances = vector_lengths(unit.vertices - skeleton.nodes[node])
    areas = unit.vertex_areas
    set_local_radii_of_components(surface.proxy.mesh, deadline=surface.deadline)
    extrema = find_extrema(surface.proxy.mesh, deadline=surface.deadline)
    # the ball of a node outside a closed surface would be the larger, the farther the node is
    is_ball = surface.contains(skeleton.nodes) if unit.is_closed else np.ones(len(skeleton.nodes), dtype=bool)
    balls = np.where(is_ball, skeleton.radii, 0.0)
    missed = is_missed(extrema, surface.proxy.mesh, replace(skeleton, radii=balls))
    missed &= ~are_at_rims(surface.proxy.mesh.vertices[extrema.vertices], open_ends)
    widths = mean_radii(skeleton, unit).radii
    mean_error, worst_branch_error = mean_and_worst_branch(skeleton, _section_errors(skeleton, widths, surface))
    longest = _longest_edges(skeleton, unit)
    disjoint = _edges_with_distant_regions(skeleton, unit, longest)
    thickness = surface.from_proxy(local_radii(surface.proxy.mesh, deadline=surface.deadline))
    count = np.bincount(node, minlength=len(skeleton.nodes))
    own_thickness = np.bincount(node, thickness, len(skeleton.nodes)) / np.maximum(count, 1)
    expected = np.where(count > 0, np.minimum(widths, own_thickness), widths)
    region_widths = _region_widths(skeleton, unit)
    reach = np.maximum(np.maximum(balls, region_widths)[node], thickness)
    own = surface.on_proxy(node)
    medial = medial_distances(
        skeleton, surface.proxy.mesh, region_widths[own], own_thickness[own], deadline=surface.deadline
    )
    is_limb = extrema.lengths > MIN_LIMB_LENGTH * extrema.radii
    cuts = _radii_of_cuts(skeleton.nodes, open_ends)
    tolerance = np.maximum(SURFACE_TOLERANCE, 0.0 if unit.is_closed_manifold else OPEN_TOLERANCE * widths)
    is_inside = surface.contains(skeleton.nodes) | (skeleton.radii <= np.maximum(tolerance, cuts))
    return Score(
        nodes_inside_fraction=float(is_inside.mean()),
        inside_fraction=inside_fraction(skeleton, surface, tolerance, open_ends=open_ends),
        centeredness_error=mean_error,
        centeredness_error_worst_branch=worst_branch_error,
        medial_accuracy_95=medial.accuracy_95,
        medial_coverage_98=medial.coverage_98,
        uncovered_parts=medial.uncovered_parts,
        near_surface_fraction=negative_fraction(
            skeleton, np.maximum(skeleton.radii, cuts) - NEAR_SURFACE_RATIO * expected
        ),
        coverage=float(areas[distances <= MAX_COVERED_DISTANCE * reach].sum() / areas.sum()),
        extremities=len(missed),
        extremities_missed=int(missed.sum()),
        missed_limb_fraction=float(missed[is_limb].mean()) if is_limb.any() else 0.0,
        rms_curvature=rms_curvature(skeleton),
        extra_components=skeleton.n_components - int((~find_crumbs(unit)).sum()),
        extra_cycles=_extra_cycles(skeleton, unit, n_loops_opened),
        tunnels_missed=_tunnels_missed(skeleton, surface, n_loops_opened),
        connected_regions=float(is_in_largest_piece(node, unit).mean()) if has_map else None,
        adjacent_regions=1 - len(disjoint) / max(1, len(skeleton.edges)) if has_map else None,
        shortcut_edges=_n_shortcut_edges(skeleton, unit, np.maximum(widths, longest), disjoint),
        spurs=n_spurs(skeleton),
    )


def centeredness_errors(skeleton: Skeleton, surface: Surface) -> NDArray[np.float64]:
    """(k,) distance of each node from the centroid of its section, in local radii; NaN where the section is not known.

    Parameters
    ----------
    skeleton, surface
        As for :func:`score_on`.
    """
    skeleton = _on_surface(skeleton, surface)
    return _section_errors(skeleton, mean_radii(skeleton, surface.mesh).radii, surface)


def _on_used_vertices(skeleton: Skeleton, surface: Surface) -> tuple[Skeleton, Surface]:
    """Leave out the vertices without a face, which would count in the regions of nodes."""
    mesh = surface.mesh
    used, n = mesh.used_vertices, len(mesh.vertices)
    if len(used) == n:
        return skeleton, surface
    number = np.zeros(n, dtype=np.int64)
    number[used] = np.arange(len(used))
    own = skeleton.node_of_vertex[used] if len(skeleton.node_of_vertex) else skeleton.node_of_vertex
    used_mesh = Mesh(mesh.vertices[used], number[mesh.faces])
    return replace(skeleton, node_of_vertex=own), Surface(used_mesh, deadline=surface.deadline)


def _on_surface(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Return the skeleton with inscribed radii in its own bodies, and with a map if it has none."""
    if len(skeleton.node_of_vertex) == 0:
        balls = inscribed_radii(skeleton, surface)
        skeleton = replace(skeleton, node_of_vertex=nearest_balls(balls, surface.mesh.vertices))
    return own_radii(skeleton, surface.mesh) if surface.mesh.n_components > 1 else inscribed_radii(skeleton, surface)


def require_scorable(skeleton: Skeleton, n_vertices: int) -> None:
    """Raise MeshError for a skeleton that has no score on a mesh or a cloud.

    Parameters
    ----------
    skeleton : Skeleton
    n_vertices : int
        Of the mesh, or points of the cloud, that it was made from.

    Raises
    ------
    MeshError
        If it has no nodes, or a map of another number of vertices.
    """
    if len(skeleton.nodes) == 0:
        raise MeshError("the skeleton has no nodes, so there is nothing to score")
    n_mapped = len(skeleton.node_of_vertex)
    if n_mapped not in (0, n_vertices):
        raise MeshError(
            f"the skeleton's map is for {counted(n_mapped, 'vertex')}, but the mesh has {n_vertices:,}: give the "
            "mesh that it was made from, or a skeleton without a map"
        )


def _radii_of_cuts(nodes: NDArray[np.float64], open_ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) radius of the cut that each node is in, within that radius of its center; 0 for none."""
    radii, within = np.zeros(len(nodes)), cKDTree(nodes).query_ball_point(open_ends[:, :3], open_ends[:, 3])
    for radius, rows in zip(open_ends[:, 3].tolist(), within, strict=True):
        radii[rows] = np.maximum(radii[rows], radius)
    return radii


def _section_errors(skeleton: Skeleton, widths: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """(k,) distance from each node inside a branch to the centroid of its section, NaN elsewhere.

    It is not known where the section is not that of the node's branch alone. The unit is the mean distance of the
    node's vertices, or the distance from the centroid to the surface if that is larger.
    """
    nodes = np.flatnonzero(skeleton.degrees == 2)
    sections = find_section_centers(skeleton, surface)
    known = nodes[sections.is_known[nodes]]
    errors = np.full(len(skeleton.nodes), np.nan)
    if len(known):
        centers = sections.positions[known]
        radii = np.maximum(surface.distance(centers), widths[known])
        errors[known] = vector_lengths(centers - skeleton.nodes[known]) / radii
    return errors


def _extra_cycles(skeleton: Skeleton, mesh: Mesh, n_loops_opened: int) -> int | None:
    """Count cycles minus handles, with the holes of the mesh closed; None if more than two faces meet at an edge.

    Each component of the skeleton is compared with the components of the mesh that it represents, so that an extra
    cycle in one does not compensate for a lost cycle in another. If both occur, the result is the sum of their numbers.
    """
    if not mesh.is_edge_manifold:
        return None
    vertices, component, handles = mesh.used_vertices, mesh.component_of_vertex, count_handles(mesh)
    part = skeleton.component_of_node
    votes = part[skeleton.node_of_vertex[vertices]], component[vertices]
    shape = (skeleton.n_components, mesh.n_components)
    represents = coo_array((np.ones(len(vertices), dtype=np.int64), votes), shape=shape).tocsc().argmax(axis=0)
    expected = np.bincount(np.asarray(represents).ravel(), handles, minlength=skeleton.n_components)
    n_edges, n_nodes = (np.bincount(of, minlength=skeleton.n_components) for of in (part[skeleton.edges[:, 0]], part))
    cycles = n_edges - n_nodes + 1
    surplus = cycles - expected
    total = int(surplus.sum())
    if abs(total) != np.abs(surplus).sum():
        return int(np.abs(surplus).sum())
    return min(total + n_loops_opened, 0) if total < 0 else total


def _tunnels_missed(skeleton: Skeleton, surface: Surface, n_loops_opened: int) -> int | None:
    """Count the tunnels that no cycle goes around, less the loops that were opened on purpose; None if not certain."""
    mesh = surface.proxy.mesh
    if not mesh.is_closed_manifold or mesh.n_components > 1 or skeleton.n_components > 1:
        return None
    n_missed = tunnels_missed(skeleton.nodes, skeleton.edges, mesh, deadline=surface.deadline)
    return None if n_missed is None else max(0, n_missed - n_loops_opened)


def _region_widths(skeleton: Skeleton, mesh: Mesh) -> NDArray[np.float64]:
    """(k,) mean distance of a region from its own center, the median over the branch of each node.

    In a flat part this is about a quarter of its width, and the inscribed radius half its thickness. A limb without a
    branch widens one region but not the median. The positions of the nodes do not matter.
    """
    node, count = skeleton.node_of_vertex, np.bincount(skeleton.node_of_vertex, minlength=len(skeleton.nodes))
    sums = np.stack([np.bincount(node, x, len(count)) for x in mesh.vertices.T], axis=1)
    widths = mean_radii(replace(skeleton, nodes=sums / np.maximum(count, 1)[:, None]), mesh).radii
    return skeleton.branch_medians(widths)


def _longest_edges(skeleton: Skeleton, mesh: Mesh) -> NDArray[np.float64]:
    """(k,) longest edge of the mesh at the vertices of each node; 0 for a node without vertices."""
    longest = np.zeros(len(skeleton.nodes))
    np.maximum.at(longest, skeleton.node_of_vertex[mesh.edges.ravel()], np.repeat(mesh.edge_lengths, 2))
    return longest


def _edges_with_distant_regions(skeleton: Skeleton, mesh: Mesh, longest: NDArray[np.float64]) -> NDArray[np.int64]:
    """(p, 2) edges whose regions are not adjacent, and farther apart than the longest edge of the mesh at either.

    Where there are about as many nodes as vertices, regions of single vertices need not be adjacent.
    """
    disjoint, node = edges_with_disjoint_regions(skeleton, mesh), skeleton.node_of_vertex
    if len(disjoint) == 0:
        return disjoint
    by_node = stable_order(node)
    begins = np.searchsorted(node[by_node], np.stack([disjoint, disjoint + 1], axis=2)).tolist()
    regions = ([mesh.vertices[by_node[i:j]] for i, j in pair] for pair in begins)
    gaps = [cKDTree(first).query(second)[0].min() for first, second in regions]
    return np.asarray(disjoint[np.array(gaps) > longest[disjoint].max(axis=1)])


def _n_shortcut_edges(skeleton: Skeleton, mesh: Mesh, reach: NDArray[np.float64], disjoint: NDArray[np.int64]) -> int:
    """Count the edges that join regions which do not touch, and that are longer than both regions together reach.

    A region reaches as far as its mean radius, or as the longest edge of the mesh at its vertices: regions of single
    vertices of a coarse mesh need not touch. Nor need those of a branch and its junction in the palm of a hand, where
    the region of another finger lies between them: two regions that both touch that of a neighbor of their nodes are
    no shortcut.
    """
    node = skeleton.node_of_vertex
    lengths = vector_lengths(skeleton.nodes[disjoint[:, 0]] - skeleton.nodes[disjoint[:, 1]])
    long = disjoint[lengths > reach[disjoint].sum(axis=1)]
    pairs = np.unique(np.concatenate([node[mesh.edges], node[mesh.edges[:, ::-1]]]), axis=0) if len(long) else long
    touching = {each: pairs[pairs[:, 0] == each, 1] for each in np.unique(long).tolist()}
    beside = [np.concatenate([skeleton.neighbors[i], skeleton.neighbors[j]]) for i, j in long]
    return sum(
        len(np.intersect1d(near, np.intersect1d(touching[i], touching[j]))) == 0
        for near, (i, j) in zip(beside, long.tolist(), strict=True)
    )
