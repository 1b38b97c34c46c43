"""Tubes around the branches, fitted to the surface.

The tubes are round cones along the edges of the skeleton, with a radius at every node. Positions and radii are fitted
to all vertices of the mesh at once, by Gauss-Newton steps on the distance of each vertex from the cone that is nearest
to it. So the vertices of a limb also count where it has no cross-section of its own: next to a junction, where only a
part of its surface is visible. Branches bend as little as the vertices allow, in their course and in their radii.

With the axes held, the same fit gives the mean radii of a finished skeleton (:func:`tube_radii`).

A tube is the wrong model of a flat part. The less round a branch is where it has sections of its own, the less its
vertices count, and the more its nodes keep their places.
"""

from __future__ import annotations

__all__ = ["fit_tubes", "tube_radii"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, diags_array, kron

from lbskel.geometry.normals import row_dots, vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centering import BENDING_WEIGHT, POSITION_WEIGHT, second_differences
from lbskel.refinement.centerlines import find_section_centers
from lbskel.refinement.containment import segments_outside
from lbskel.refinement.open_ends import NO_CUTS, are_within_cuts
from lbskel.refinement.radii import axis_directions, mean_axis_distances
from lbskel.refinement.tubes import Feet, Tubes, feet_on_tubes, nearest_balls_by_power, tubes_around
from lbskel.refinement.tunnel_sides import keep_sides
from lbskel.skeleton.skeleton import Skeleton
from lbskel.solvers import factorize

# Distance from a round tube, in its radii, at which a vertex counts half, and at which all vertices of a branch do if
# that is their mean distance. Rows "deviation of" in benchmarks/results/refinement.md
MAX_DEVIATION = 0.2
# Weight of a tube's squared second differences where its course is fitted, against a weight of 1 on the vertices of a
# ring half a radius long: less follows noise, more cuts bends. Rows "bending weight of tubes" there; by hand, noisy
# tubes are 0.0228 off with 0.5, 0.0233 with 0.25, 0.0244 with 0.125. Where only radii are fitted, which cut no bend, it
# is BENDING_WEIGHT
COURSE_WEIGHT = 0.25
# Lower bound on the ball at the new place of a node inside, as a share of that at its old one. Rows "ball share of
# tubes" in benchmarks/results/limbs.md: with 0.9, branches have kinks, since only some of their nodes are moved; with
# less than 0.8 tubes and creatures are alike, and by hand tips and nodes beside other branches are drawn aside
MIN_BALL_SHARE = 0.8
# Lower bound on the mean distance of a flat cap from the tip a radius before it, in radii of the N_BEFORE nodes before
# that: it is 1 for a round cap, 1.22 for a disk and 1.41 for its rim
MIN_CAP_RATIO, N_BEFORE = 1.1, 3
# Gauss-Newton steps, which bound the time. Rows "tube steps of" in refinement.md: more are alike
N_STEPS = 3


def fit_tubes(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Move the nodes to the axes of round tubes that are fitted to the surface.

    Tips move across their branches only, since a cone around the last edge fits the surface as well if it is shorter.
    No node inside leaves the surface, no edge inside leaves a closed one, and none passes a tunnel on another side. No
    node inside goes to a ball of less than MIN_BALL_SHARE of its own, as a tip would that a tube draws aside. No branch
    turns back: along a straight tube that narrows and widens, the places of the cones are hardly determined.

    Parameters
    ----------
    skeleton : Skeleton
        With evenly spaced branches near their places, and a node for each vertex of the mesh.
    surface : Surface
        The vertices of its proxy count.

    Returns
    -------
    Skeleton
        The same if there are fewer vertices than unknowns, so that bending would decide, or if no branch has a section
        of its own, so that nothing tells whether it is round.
    """
    points, areas = surface.proxy.mesh.vertices, surface.proxy.mesh.vertex_areas
    if len(points) < 4 * len(skeleton.nodes):
        return skeleton
    is_known = find_section_centers(skeleton, surface).is_known
    if not is_known.any():
        return skeleton
    radii = _along_gaps(skeleton, mean_axis_distances(skeleton, surface.mesh.vertices), is_known)
    start = tubes_around(skeleton, radii, surface.mesh.diameter_bound)
    balls = nearest_balls_by_power(start, points)
    shares = _roundness(skeleton, feet_on_tubes(start, points, balls), areas, is_known)
    (hessian, gradient), tubes = _prior(skeleton, start, shares), start
    for _ in range(N_STEPS):
        surface.deadline.check()
        pull = -(hessian @ (tubes.unknowns - start.unknowns) + gradient)
        tubes = _step(tubes, feet_on_tubes(tubes, points, balls), areas, shares, hessian, pull)
    moves, tips = tubes.positions - skeleton.nodes, skeleton.tips
    along = axis_directions(skeleton)[tips]
    moves[tips] -= np.einsum("ki,ki->k", moves[tips], along)[:, None] * along
    nodes = keep_sides(skeleton, skeleton.nodes + moves, surface)
    while True:  # nodes go back to their old places only
        inside = _kept_inside(skeleton, nodes, surface)
        nodes = _kept_in_order(skeleton, inside)
        if np.array_equal(nodes, inside):
            return replace(skeleton, nodes=nodes)


def tube_radii(skeleton: Skeleton, surface: Surface, *, cuts: NDArray[np.float64] = NO_CUTS) -> NDArray[np.float64]:
    """Compute the radii of the round tubes around a skeleton that fit the surface best.

    The mean distance of a node's vertices from the axis is the start, and what a node without vertices keeps. It is too
    large where the radius changes from node to node, and where vertices of other branches are among those of the node.

    Parameters
    ----------
    skeleton : Skeleton
        With a node for each vertex of the mesh.
    surface : Surface
        The vertices of its proxy count, but for those within half the radius of a cut from its center, which close it,
        and those of flat caps, whose rims are farther from the tip than the tube is wide.
    cuts : (c, 7) array of float
        Those with a tip, as from :func:`lbskel.refinement.open_ends.cuts_with_tips`.
    """
    start = mean_axis_distances(skeleton, surface.mesh.vertices)
    if len(skeleton.edges) == 0:
        return start
    points, areas = surface.proxy.mesh.vertices, surface.proxy.mesh.vertex_areas
    first = tubes_around(skeleton, start, surface.mesh.diameter_bound)
    balls, rows = nearest_balls_by_power(first, points), np.arange(len(points))
    # the surface of a tube is at a radius from the center of its cut; half that far, only what closes the cut can be
    is_counted = ~are_within_cuts(points, cuts, share=0.5)
    is_counted &= ~_are_on_flat_caps(skeleton, points, feet_on_tubes(first, points, balls), start)
    areas = np.where(is_counted, areas, 0.0)
    bending = BENDING_WEIGHT * _bending(skeleton, first.radii)
    fixed = bending + diags_array(POSITION_WEIGHT / first.radii**2)
    radii = first.radii
    for _ in range(N_STEPS):
        feet = feet_on_tubes(replace(first, radii=radii), points, balls)
        weights = _weights(feet, areas)
        near, far = first.edges[feet.edges].T
        at = np.concatenate([rows, rows]), np.concatenate([near, far])
        shares = csr_array((np.concatenate([1 - feet.shares, feet.shares]), at), shape=(len(rows), len(radii)))
        b = shares.T @ (weights * feet.distances) - fixed @ (radii - first.radii) - bending @ first.radii
        step = factorize((shares.T @ diags_array(weights) @ shares + fixed).tocsc()).solve(b, refined=False)
        radii = np.maximum(radii + step, radii / 2)
    return radii


def _are_on_flat_caps(
    skeleton: Skeleton, points: NDArray[np.float64], feet: Feet, radii: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """(n,) whether vertices are beyond a tip whose cap is farther from it, on average, than its branch is wide."""
    node = skeleton.edges[feet.edges, (feet.shares >= 0.5).astype(np.int64)]
    offsets, k = points - skeleton.nodes[node], len(skeleton.nodes)
    is_beyond = (skeleton.degrees[node] == 1) & (row_dots(offsets, axis_directions(skeleton)[node]) > 0)
    at = node[is_beyond]
    distances = np.bincount(at, vector_lengths(offsets[is_beyond]), k) / np.maximum(np.bincount(at, minlength=k), 1)
    is_flat = np.zeros(k, dtype=bool)
    for way in (way for branch in skeleton.branches for way in (branch, branch[::-1])):
        if len(way) <= 2 or distances[way[-1]] == 0:
            continue
        is_flat[way[-1]] = distances[way[-1]] > MIN_CAP_RATIO * np.median(radii[way[1:-1][-N_BEFORE:]])
    return np.asarray(is_beyond & is_flat[node])


def _along_gaps(skeleton: Skeleton, values: NDArray[np.float64], is_known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(k,) values of the nodes, interpolated along each branch where they are not known; the largest where some meet.

    A branch without known values keeps its own.
    """
    interpolated = np.where(skeleton.degrees == 0, values, -np.inf)
    for branch in skeleton.branches:
        known = np.flatnonzero(is_known[branch])
        filled = np.interp(np.arange(len(branch)), known, values[branch[known]]) if len(known) else values[branch]
        np.maximum.at(interpolated, branch, filled)  # a loop has its first node twice
    return interpolated


def _roundness(
    skeleton: Skeleton, feet: Feet, areas: NDArray[np.float64], is_known: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """(k,) shares by which vertices count at each node: 1 where the surface is round, 0 where it is flat.

    Measured at the nodes that have sections of their own: elsewhere, distances also tell that nodes are misplaced. A
    node with a section but without a vertex, as on a long face, keeps its place.
    """
    node = skeleton.edges[feet.edges, (feet.shares >= 0.5).astype(np.int64)]
    count = np.bincount(node, areas, len(skeleton.nodes))
    total = np.bincount(node, areas * np.abs(feet.distances) / feet.radii, len(skeleton.nodes))
    deviations = np.divide(total, count, out=np.ones(len(count)), where=count > 0)
    deviations = _along_gaps(skeleton, deviations, is_known)
    shares: NDArray[np.float64] = 1 / (1 + (deviations / MAX_DEVIATION) ** 4)
    return shares


def _prior(skeleton: Skeleton, start: Tubes, shares: NDArray[np.float64]) -> tuple[coo_array, NDArray[np.float64]]:
    """(4 k, 4 k) Hessian and (4 k,) gradient, at the start, of what is expected of the unknowns without the surface.

    Branches bend little, and nodes keep their places and radii, relative to the radii at the start.
    """
    bending = COURSE_WEIGHT * _bending(skeleton, start.radii)
    held = np.tile(((1 - shares) ** 2 + POSITION_WEIGHT)[:, None], 4)
    held[:, 3] = POSITION_WEIGHT
    held /= start.radii[:, None] ** 2
    hessian = (kron(bending, np.eye(4)) + diags_array(held.ravel())).tocoo()
    hessian.coords = tuple(each.astype(np.int32) for each in hessian.coords)
    return hessian, (bending @ start.unknowns.reshape(-1, 4)).ravel()


def _bending(skeleton: Skeleton, radii: NDArray[np.float64]) -> csr_array:
    """(k, k) the square of the second differences of values along the branches, relative to the radii there."""
    relative = diags_array(1 / radii[skeleton.triples[1]]) @ second_differences(skeleton)
    return relative.T @ relative


def _weights(feet: Feet, areas: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) weights of vertices, for squared distances relative to the radii there.

    A vertex counts by its area relative to a ring of the tube half a radius long, and at most as that, so that each
    node counts about as much as one section.
    """
    weights: NDArray[np.float64] = np.minimum(areas / (np.pi * feet.radii**2), 1.0) / feet.radii**2
    return weights


def _step(
    tubes: Tubes,
    feet: Feet,
    areas: NDArray[np.float64],
    shares: NDArray[np.float64],
    hessian: coo_array,
    pull: NDArray[np.float64],
) -> Tubes:
    """Make one Gauss-Newton step; radii stay positive, since none falls by more than half.

    The Hessian and the pull, the negative gradient at these tubes, are those of the prior. A vertex counts less where
    it is far from all tubes.
    """
    r, edges = tubes.radii, tubes.edges
    near, far = edges[feet.edges].T
    weights = _weights(feet, areas)
    weights *= (1 - feet.shares) * shares[near] + feet.shares * shares[far]
    weights /= 1 + (feet.distances / (MAX_DEVIATION * feet.radii)) ** 2
    change = np.column_stack([feet.normals, np.ones(len(near))])
    gradients = np.concatenate([(1 - feet.shares)[:, None] * change, feet.shares[:, None] * change], axis=1)
    of_edge = csr_array((weights, (feet.edges, np.arange(len(near)))), shape=(len(edges), len(near)))
    blocks = of_edge @ (gradients[:, :, None] * gradients[:, None, :]).reshape(-1, 64)
    places = (4 * edges[:, :, None] + np.arange(4)).reshape(-1, 8).astype(np.int32)  # int64 takes three times as long
    rows, columns = np.repeat(places, 8, axis=1).ravel(), np.tile(places, 8).ravel()
    entries = np.concatenate([blocks.ravel(), hessian.data])
    at = np.concatenate([rows, hessian.coords[0]]), np.concatenate([columns, hessian.coords[1]])
    b = np.array(pull)
    np.add.at(b, places, of_edge @ (feet.distances[:, None] * gradients))
    step = factorize(coo_array((entries, at), shape=hessian.shape).tocsc()).solve(b, refined=False).reshape(-1, 4)
    return replace(tubes, positions=tubes.positions + step[:, :3], radii=np.maximum(r + step[:, 3], r / 2))


def _kept_in_order(skeleton: Skeleton, nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3) new positions; the old ones of each three successive nodes of a branch at which it would turn back."""
    kept, triples = np.array(nodes), np.stack(skeleton.triples)
    olds = np.diff(skeleton.nodes[triples], axis=0)
    while True:
        news = np.diff(kept[triples], axis=0)
        passes = ((olds * news).sum(axis=2) <= 0).any(axis=0) & (news.prod(axis=0).sum(axis=1) <= 0)
        passes &= (news != olds).any(axis=(0, 2))
        if not passes.any():
            return kept
        kept[triples[:, passes]] = skeleton.nodes[triples[:, passes]]


def _kept_inside(skeleton: Skeleton, nodes: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """(k, 3) new positions, or the old ones of nodes, and of edges of a closed surface, that would leave it.

    Nodes inside whose balls would shrink keep their places, too.
    """
    is_shallow = surface.distance(nodes) < MIN_BALL_SHARE * surface.distance(skeleton.nodes)
    is_kept = surface.contains(skeleton.nodes) & (~surface.contains(nodes) | is_shallow)
    kept = np.where(is_kept[:, None], skeleton.nodes, nodes)
    if surface.mesh.is_closed:
        may_leave = segments_outside(skeleton.nodes, skeleton.edges, surface)
        while (is_outside := segments_outside(kept, skeleton.edges, surface) & ~may_leave).any():
            kept[skeleton.edges[is_outside]] = skeleton.nodes[skeleton.edges[is_outside]]
    return kept
