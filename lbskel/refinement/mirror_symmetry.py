"""A mirror-symmetric skeleton for a mirror-symmetric mesh: the better half of it, and the mirror image of that half.

Decisions at thresholds, such as whether the branch of a foot ends at the heel or at the toes, may fall differently on
the two sides of a body. Nodes on the plane of symmetry are shared by both sides; branches that cross it get a node
there. A half and its mirror image take the place of both: the half that misses fewer ends of limbs, or else leaves less
of the surface uncovered by its balls inside, of those that change neither the number of components nor that of cycles,
and leave no more uncovered than before. An end branch whose mirror image would leave the surface stays as it is: a tail
may be bent aside.
"""

from __future__ import annotations

__all__ = ["Symmetry", "find_symmetries", "keep_mirror_symmetry", "make_mirror_symmetric"]

from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.mirrors import Mirror, mirror_between, mirrors_at_centroid, principal_axes
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap
from lbskel.refinement.extrema import find_extrema, is_missed
from lbskel.refinement.radii import inscribed_radii, mean_radii
from lbskel.refinement.region_map import nearest_balls
from lbskel.skeleton.editing import contract_new_tips
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO
from lbskel.skeleton.skeleton import Skeleton

# Distance of the mirror image of 95 % of the area from the surface, and of those of nodes inside it from its inside, in
# mean radii of their branches. Rows "deviations of" in benchmarks/results/refinement.md
TYPICAL_DEVIATION = 0.1
# Height of a node above the plane, in inscribed radii, up to which it counts as on the plane. Rows "on the plane below"
# in benchmarks/results/refinement.md
ON_PLANE = 0.5
# Vertices of a small and a large sample, which bound the time: the small one rules out nearly every plane that is none
# of symmetry; guesses
N_SAMPLES = (100, 2_000)


@dataclass(frozen=True, eq=False)
class Symmetry:
    """A plane of symmetry of a surface.

    Parameters
    ----------
    plane : Mirror
    is_one_sided : (k,) array of bool
        The nodes of end branches whose mirror images would leave the surface, but for their junctions.
    """

    plane: Mirror
    is_one_sided: NDArray[np.bool_]


def make_mirror_symmetric(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Make a skeleton symmetric about the planes of symmetry of its surface.

    Parameters
    ----------
    skeleton : Skeleton
        With a node for each vertex of the mesh.
    surface : Surface

    Returns
    -------
    Skeleton
        The same if the surface has no plane of symmetry, or if neither half and its image have as many components and
        cycles, and cover as much of the surface.
    """
    for plane in [symmetry.plane for symmetry in find_symmetries(skeleton, surface)]:
        surface.deadline.check()
        one_sided = _one_sided_nodes(plane, skeleton, surface)  # the plane before may have changed the nodes
        if one_sided is not None:
            skeleton = _better_half(skeleton, Symmetry(plane, one_sided), surface)
    return skeleton


def _better_half(skeleton: Skeleton, symmetry: Symmetry, surface: Surface) -> Skeleton:
    """Choose the better half with its mirror image, or the skeleton as it is if neither covers as much."""
    before, scales = inscribed_radii(skeleton, surface), _scales(skeleton, surface.mesh)
    cut, side = _cut_at(symmetry, before, _branch_radii(skeleton, surface.mesh))
    if side.any():
        halves = [sign for sign in (1, -1) if (side * sign >= 0).any()]
        vertices = surface.mesh.vertices
        twins = surface.vertex_tree.query(symmetry.plane.mirrored(vertices))[1]
        changed = [_doubled(cut, side, sign, symmetry, vertices, twins) for sign in halves]
    else:  # all nodes are on the plane: both halves are the whole, and no tie is left to rounding
        changed = [cut]
    alike = [
        inscribed_radii(one, surface)
        for one in changed
        if (one.n_components, one.cycle_rank) == (skeleton.n_components, skeleton.cycle_rank)
    ]
    # of a symmetric surface, the better half leaves no more uncovered than both, but for the deviations
    limit = _uncovered(before, surface, scales) + TYPICAL_DEVIATION
    measured = [(_n_missed(one, surface), _uncovered(one, surface, scales), one) for one in alike]
    covering = [half for half in measured if half[1] <= limit]
    return min(covering, key=itemgetter(0, 1))[2] if covering else skeleton


def keep_mirror_symmetry(before: Skeleton, after: Skeleton, surface: Surface) -> Skeleton:
    """Make moved nodes symmetric again about the planes about which they were: each goes halfway to its mirror image.

    Parameters
    ----------
    before, after : Skeleton
        The same graph, before and after its nodes were moved.
    surface : Surface
    """
    nodes, tree = after.nodes, cKDTree(before.nodes)
    limits = TYPICAL_DEVIATION * mean_radii(before, surface.mesh).radii
    for symmetry in find_symmetries(before, surface):
        distances, twins = tree.query(symmetry.plane.mirrored(before.nodes))
        has_twin = distances <= limits
        if (has_twin | symmetry.is_one_sided).all():
            halfway = (nodes + symmetry.plane.mirrored(nodes[twins])) / 2
            nodes = np.where((has_twin & ~symmetry.is_one_sided)[:, None], halfway, nodes)
    return replace(after, nodes=nodes)


def find_symmetries(skeleton: Skeleton, surface: Surface) -> list[Symmetry]:
    """Find planes, nearly at right angles to each other, about which a surface is symmetric.

    The mirror image of most of the surface is on it, and those of all nodes inside are inside, but for the nodes of
    end branches. Planes are fitted from those normal to the principal axes, which are a few degrees off on a body that
    is not quite symmetric. Where two moments are equal, as those of a cube, planes may be missed.

    Parameters
    ----------
    skeleton : Skeleton
        With a node for each vertex of the mesh; distances are relative to the mean radii of its branches.
    surface : Surface
    """
    mesh = surface.mesh
    if not mesh.area > 0:
        return []
    scales = _scales(skeleton, mesh)
    planes = [_fitted(plane, surface, scales) for plane in mirrors_at_centroid(mesh, principal_axes(mesh))]
    planes = [plane for plane in planes if _deviates_little(plane, surface, scales)]
    one_sided = [(plane, _one_sided_nodes(plane, skeleton, surface)) for plane in planes]
    return [Symmetry(plane, nodes) for plane, nodes in one_sided if nodes is not None]


def _fitted(plane: Mirror, surface: Surface, scales: NDArray[np.float64]) -> Mirror:
    """Fit a plane to the small sample and the points of the surface that are nearest to its mirror image.

    Only points that are near count, which must be most of the area. The fit is repeated as long as the sum of squared
    distances, of no more than the limit each, falls: Besl, McKay 1992, https://doi.org/10.1109/34.121791.
    """
    sample, least = _sample(surface, N_SAMPLES[0]), np.inf
    vertices, areas, limits = surface.mesh.vertices[sample], surface.mesh.vertex_areas[sample], scales[sample]
    limits = TYPICAL_DEVIATION * limits
    fitted = plane
    while True:
        distances, images = surface.closest(fitted.mirrored(vertices))
        squares, weights = areas @ np.minimum(distances, limits) ** 2, areas * (distances <= limits)
        # by hand, on eight meshes: 0.97 to 0.999 are alike; with 0.9 the fit to a pig, 4 degrees off, ends at once
        if not squares < 0.97 * least or weights.sum() < areas.sum() / 2:
            return plane
        plane, least = fitted, squares
        fitted = mirror_between(vertices, images, weights)


def _deviates_little(plane: Mirror, surface: Surface, scales: NDArray[np.float64]) -> bool:
    """Whether the mirror images of vertices with 95 % of the area are on the surface; in a small sample first."""
    for n_samples in N_SAMPLES:
        sample = _sample(surface, n_samples)
        deviations = surface.distance(plane.mirrored(surface.mesh.vertices[sample]))
        areas = surface.mesh.vertex_areas[sample]
        if areas[deviations <= TYPICAL_DEVIATION * scales[sample]].sum() < 0.95 * areas.sum():
            return False
    return True


def _sample(surface: Surface, n_samples: int) -> NDArray[np.int64]:
    """Every n-th vertex, so that there are at least as many as asked for if there are so many."""
    used = surface.mesh.used_vertices
    sample: NDArray[np.int64] = used[:: max(1, len(used) // n_samples)]
    return sample


def _one_sided_nodes(plane: Mirror, skeleton: Skeleton, surface: Surface) -> NDArray[np.bool_] | None:
    """(k,) nodes of end branches with one inside whose mirror image is not; None if other nodes are such ones."""
    is_inside, images = surface.contains(skeleton.nodes), plane.mirrored(skeleton.nodes)
    leaves = is_inside & ~surface.contains(images)
    limits = TYPICAL_DEVIATION * _branch_radii(skeleton, surface.mesh)[leaves]
    leaves[leaves] = surface.distance(images[leaves]) > limits
    is_one_sided = np.zeros(len(leaves), dtype=bool)
    for end in skeleton.end_branches:
        is_one_sided[end[1:]] = leaves[end[1:]].any()
    return is_one_sided if is_one_sided[leaves].all() else None


def _scales(skeleton: Skeleton, mesh: Mesh) -> NDArray[np.float64]:
    """(n,) mean radius of the branch of each vertex."""
    return _branch_radii(skeleton, mesh)[skeleton.node_of_vertex]


def _branch_radii(skeleton: Skeleton, mesh: Mesh) -> NDArray[np.float64]:
    """(k,) median over its branch of the mean radius of each node, or its own if it has none."""
    radii = mean_radii(skeleton, mesh).radii
    medians: NDArray[np.float64] = np.where(skeleton.degrees > 0, skeleton.branch_medians(radii), radii)
    return medians


def _cut_at(symmetry: Symmetry, skeleton: Skeleton, widths: NDArray[np.float64]) -> tuple[Skeleton, NDArray[np.int64]]:
    """Put a node wherever a branch crosses the plane; also the (k,) side of each node: 1, 0 or -1.

    One-sided nodes are shared by both sides where they are.

    Ends of branches that are near the plane are moved onto it, and so are branches without a node aside, or with most
    nodes near it and within TYPICAL_DEVIATION widths, and all within MIN_BRANCH_RATIO, but for junctions. The widths
    are those of whole branches. A rod of one branch, at 30 degrees to the plane or more, keeps its ends on their sides.
    Other nodes near the plane belong to the side of the nearest node along the branch that is not, reflected to it.
    """
    plane, shared = symmetry.plane, symmetry.is_one_sided
    heights = plane.heights(skeleton.nodes)
    near = ON_PLANE * skeleton.radii
    is_aside, is_far = (
        np.abs(heights) > bound for bound in (np.minimum(near, TYPICAL_DEVIATION * widths), MIN_BRANCH_RATIO * widths)
    )
    side = np.where(np.abs(heights) <= near, 0, np.sign(heights).astype(np.int64))
    for branch in skeleton.branches:
        first, last = heights[ends := branch[[0, -1]]]
        is_upright = abs(first - last) > np.linalg.norm(np.subtract(*skeleton.nodes[ends])) / 2
        if is_upright and first * last < 0 and skeleton.degrees[ends].max() == 1:  # a whole rod, which may be short
            side[ends] = np.sign(heights[ends])
        off = np.flatnonzero(side[branch])
        is_along = np.mean(is_aside[branch]) < 0.5 and not is_far[branch].any()
        if len(off) == 0 or is_along:
            side[branch[skeleton.degrees[branch] < 3]] = 0
        else:
            nearest = off[np.rint(np.interp(range(1, len(branch) - 1), off, np.arange(len(off)))).astype(np.int64)]
            side[branch[1:-1]] = side[branch[nearest]]
    side[shared] = 0
    on_side = np.abs(heights) * side
    nodes = skeleton.nodes + np.where(shared, 0.0, on_side - heights)[:, None] * plane.normal
    crosses = side[skeleton.edges].prod(axis=1) < 0
    i, j = skeleton.edges[crosses].T
    steps = on_side[i] - on_side[j]  # 0 where both nodes are on the plane
    share = np.divide(on_side[i], steps, out=np.full(len(i), 0.5), where=steps != 0)[:, None]
    new = len(nodes) + np.arange(len(i))
    cut = replace(
        skeleton,
        nodes=np.concatenate([nodes, (1 - share) * nodes[i] + share * nodes[j]]),
        edges=np.concatenate([skeleton.edges[~crosses], np.stack([i, new], axis=1), np.stack([new, j], axis=1)]),
        radii=np.concatenate([skeleton.radii, skeleton.radii[[i, j]].mean(axis=0)]),
        mean_radii=np.empty(0),
    )
    return cut, np.append(side, np.zeros_like(new))


def _doubled(
    skeleton: Skeleton,
    side: NDArray[np.int64],
    sign: int,
    symmetry: Symmetry,
    vertices: NDArray[np.float64],
    twins: NDArray[np.int64],
) -> Skeleton:
    """Keep the nodes on the plane and on one side, with mirror images of the latter in place of those on the other.

    ``twins`` are the vertices nearest to the images of the vertices. A branch that led to the other side is contracted.
    """
    plane = symmetry.plane
    kept, copied = np.flatnonzero(side * sign >= 0), np.flatnonzero(side * sign > 0)
    own = np.full(len(side), -1)
    own[kept] = np.arange(len(kept))
    image = np.array(own)
    image[copied] = len(kept) + np.arange(len(copied))
    nodes, given = np.concatenate([skeleton.nodes[kept], plane.mirrored(skeleton.nodes[copied])]), [*kept, *copied]
    edges = skeleton.edges[(own[skeleton.edges] >= 0).all(axis=1)]
    is_on_side = plane.heights(vertices) * sign >= 0
    is_on_side |= symmetry.is_one_sided[skeleton.node_of_vertex]
    nodes_of_vertices = own[skeleton.node_of_vertex], image[skeleton.node_of_vertex[twins]]
    node_of_vertex = VertexMap(np.where(is_on_side, *nodes_of_vertices)).complete(vertices, nodes).indices
    edges, radii = np.concatenate([own[edges], image[edges]]), skeleton.radii[given]
    doubled = replace(skeleton, nodes=nodes, edges=edges, radii=radii, node_of_vertex=node_of_vertex)
    return contract_new_tips(doubled, skeleton.degrees[given] <= 1)


def _n_missed(skeleton: Skeleton, surface: Surface) -> int:
    """Count the ends of limbs that the skeleton misses."""
    mesh = surface.proxy.mesh
    return int(is_missed(find_extrema(mesh, deadline=surface.deadline), mesh, skeleton).sum())


def _uncovered(skeleton: Skeleton, surface: Surface, scales: NDArray[np.float64]) -> float:
    """Mean distance of vertices from the nearest ball, relative to the scales; nodes outside have balls of radius 0."""
    if surface.mesh.is_closed:
        skeleton = replace(skeleton, radii=np.where(surface.contains(skeleton.nodes), skeleton.radii, 0.0))
    sample = _sample(surface, N_SAMPLES[-1])
    points = surface.mesh.vertices[sample]
    node = nearest_balls(skeleton, points)
    gaps = np.linalg.norm(points - skeleton.nodes[node], axis=1) - skeleton.radii[node]
    return float((np.maximum(gaps, 0) / scales[sample]).mean())
