"""Tubes around the branches, fitted to the surface.

The tubes are round cones along the edges of the skeleton, with a radius at every node. Positions and radii are fitted
to all vertices of the mesh at once, by Gauss-Newton steps on the distance of each vertex from the cone that is nearest
to it. So the vertices of a limb also count where it has no cross-section of its own: next to a junction, where only a
part of its surface is visible. Branches bend as little as the vertices allow, in their course and in their radii.

A tube is the wrong model of a flat part. The less round a branch is where it has sections of its own, the less its
vertices count, and the more its nodes keep their places.
"""

from __future__ import annotations

__all__ = ["fit_tubes"]

import itertools
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, diags_array, kron
from scipy.spatial import cKDTree

from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centering import BENDING_WEIGHT, POSITION_WEIGHT, second_differences
from lbskel.refinement.centerlines import find_section_centers
from lbskel.refinement.containment import segments_outside
from lbskel.refinement.radii import axis_directions, mean_axis_distances
from lbskel.refinement.tunnel_sides import keep_sides
from lbskel.skeleton.skeleton import Skeleton
from lbskel.solvers import factorize

# Distance from a round tube, in its radii, at which a vertex counts half, and at which all vertices of a branch do if
# that is their mean distance. Rows "deviation of" in benchmarks/results/refinement.md
MAX_DEVIATION = 0.2
# Gauss-Newton steps, which bound the time. Rows "tube steps of" there: more are alike
N_STEPS = 3
# Balls, those with the least power of a vertex, among whose edges its nearest cone is searched; they bound the time.
# Rows "nearest balls of" there
N_NEAREST = 4

# Lower bound on radii, in medians over the branch: zero, where the only vertex of a node is on the axis, makes the
# systems singular (tests/refinement/test_tube_fit.py)
MIN_RADIUS = 0.01
EPSILON, TINY = float(np.finfo(np.float64).eps), float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, eq=False)
class _Tubes:
    """Round cones along m edges, (m, 2), between k nodes: positions, (k, 3), and radii, (k,)."""

    edges: NDArray[np.int64]
    positions: NDArray[np.float64]
    radii: NDArray[np.float64]

    @property
    def unknowns(self) -> NDArray[np.float64]:
        """(4 k,) position and radius of one node after the other."""
        return np.column_stack([self.positions, self.radii]).ravel()


@dataclass(frozen=True, eq=False)
class _Feet:
    """Where the axes are nearest to n vertices, as seen from the cones.

    Parameters
    ----------
    edges : (n,) array of int
        The edge of the cone that is nearest.
    shares : (n,) array of float
        The place along it, from 0 to 1.
    radii : (n,) array of float
        Of the cone at that place.
    distances : (n,) array of float
        From the surface of the cone, negative inside it.
    normals : (n, 3) array of float
        Unit vectors from the axis to the vertices.
    """

    edges: NDArray[np.int64]
    shares: NDArray[np.float64]
    radii: NDArray[np.float64]
    distances: NDArray[np.float64]
    normals: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Prior:
    """What is expected of the 4 k unknowns without the surface, as a quadratic function.

    Parameters
    ----------
    hessian : (4 k, 4 k) coo_array
    unknowns : (4 k,) array of float
        At the start.
    gradient : (4 k,) array of float
        There.
    """

    hessian: coo_array
    unknowns: NDArray[np.float64]
    gradient: NDArray[np.float64]


def fit_tubes(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Move the nodes to the axes of round tubes that are fitted to the surface.

    Nodes move across their branches, junctions any way. No node inside leaves the surface, no edge inside leaves a
    closed one, and none passes a tunnel on another side.

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
    least = np.maximum(MIN_RADIUS * skeleton.branch_medians(radii), MIN_RADIUS**2 * surface.mesh.diameter_bound)
    start = _Tubes(skeleton.edges, skeleton.nodes, np.maximum(radii, least))
    nearby = _nearby_edges(start, points)
    shares = _roundness(skeleton, _feet(start, points, nearby), areas, is_known)
    prior, tubes = _prior(skeleton, start, shares), start
    for _ in range(N_STEPS):
        surface.deadline.check()
        tubes = _step(tubes, _feet(tubes, points, nearby), areas, shares, prior)
    moves = tubes.positions - skeleton.nodes
    along = axis_directions(skeleton)
    moves -= np.einsum("ki,ki->k", moves, along)[:, None] * along
    nodes = keep_sides(skeleton, skeleton.nodes + moves, surface)
    return replace(skeleton, nodes=_kept_inside(skeleton, nodes, surface))


def _along_gaps(skeleton: Skeleton, values: NDArray[np.float64], is_known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(k,) values of the nodes, interpolated along each branch where they are not known; the largest where some meet.

    A branch without known values keeps its own.
    """
    nodes, begins = skeleton.flat_branches
    filled = np.array(values[nodes])
    for begin, end in itertools.pairwise(begins.tolist()):
        branch = nodes[begin:end]
        known = np.flatnonzero(is_known[branch])
        if len(known):
            filled[begin:end] = np.interp(np.arange(len(branch)), known, values[branch[known]])
    interpolated = np.array(values)
    interpolated[nodes] = -np.inf
    np.maximum.at(interpolated, nodes, filled)
    return interpolated


def _feet(tubes: _Tubes, points: NDArray[np.float64], nearby: tuple[NDArray[np.int64], NDArray[np.int64]]) -> _Feet:
    """Find the nearest cone of each point, among the edges nearby: rows of points and edges, by row."""
    P, r = tubes.positions, tubes.radii
    rows, edges = nearby
    i, j = tubes.edges[edges].T
    axis, offset = P[j] - P[i], points[rows] - P[i]
    squared = np.maximum(np.einsum("ni,ni->n", axis, axis), TINY)
    share = np.einsum("ni,ni->n", offset, axis) / squared
    height = np.sqrt(np.maximum(np.einsum("ni,ni->n", offset, offset) - share**2 * squared, 0.0))
    slope = (r[i] - r[j]) / np.sqrt(squared)  # the sine of half the cone's angle; from 1 on, one ball is in the other
    share = np.clip(share - height * slope / np.sqrt(np.maximum(1 - slope**2, EPSILON) * squared), 0.0, 1.0)
    normal = offset - share[:, None] * axis
    length = np.linalg.norm(normal, axis=1)
    radius = (1 - share) * r[i] + share * r[j]
    distance = length - radius
    begins = np.searchsorted(rows, np.arange(len(points)))
    is_least = distance == np.minimum.reduceat(distance, begins)[rows]
    best = np.flatnonzero(is_least)[np.searchsorted(rows[is_least], np.arange(len(points)))]
    normals = normal[best] / np.maximum(length[best], TINY)[:, None]
    return _Feet(edges[best], share[best], radius[best], distance[best], normals)


def _nearby_edges(tubes: _Tubes, points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of points and edges that may be nearest to them, by row: those at the N_NEAREST balls by their power."""
    used = np.unique(tubes.edges)
    P, r = tubes.positions[used], tubes.radii[used]
    lifted = np.column_stack([P, np.sqrt(np.maximum(r.max() ** 2 - r**2, 0.0))])  # distances there are powers
    n_nearest = min(N_NEAREST, len(P))
    near = used[cKDTree(lifted).query(np.column_stack([points, np.zeros(len(points))]), k=n_nearest)[1]]
    near = near.reshape(len(points), n_nearest)
    ends = tubes.edges.ravel()
    order = np.argsort(ends, kind="stable")
    sizes = np.bincount(ends)
    first = np.cumsum(sizes) - sizes
    counts = sizes[near.ravel()]
    rows = np.repeat(np.repeat(np.arange(len(points)), n_nearest), counts)
    place = np.arange(counts.sum()) + np.repeat(first[near.ravel()] - np.cumsum(counts) + counts, counts)
    return rows, order[place] // 2


def _roundness(
    skeleton: Skeleton, feet: _Feet, areas: NDArray[np.float64], is_known: NDArray[np.bool_]
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


def _prior(skeleton: Skeleton, start: _Tubes, shares: NDArray[np.float64]) -> _Prior:
    """Bending along the branches, and the places and radii of the nodes at the start, relative to the radii there."""
    relative = diags_array(1 / start.radii[skeleton.triples[1]]) @ second_differences(skeleton)
    bending = BENDING_WEIGHT * (relative.T @ relative)
    held = np.tile(((1 - shares) ** 2 + POSITION_WEIGHT)[:, None], 4)
    held[:, 3] = POSITION_WEIGHT
    held /= start.radii[:, None] ** 2
    unknowns = start.unknowns
    hessian = (kron(bending, np.eye(4)) + diags_array(held.ravel())).tocoo()
    hessian.coords = tuple(each.astype(np.int32) for each in hessian.coords)
    return _Prior(hessian, unknowns, (bending @ unknowns.reshape(-1, 4)).ravel())


def _step(
    tubes: _Tubes,
    feet: _Feet,
    areas: NDArray[np.float64],
    shares: NDArray[np.float64],
    prior: _Prior,
) -> _Tubes:
    """Make one Gauss-Newton step; radii stay positive, since none falls by more than half.

    A vertex counts by its area relative to a ring of the tube half a radius long, and at most as that, so that each
    node counts about as much as one section; less where it is far from all tubes.
    """
    r, edges = tubes.radii, tubes.edges
    near, far = edges[feet.edges].T
    weights = np.minimum(areas / (np.pi * feet.radii**2), 1.0) / feet.radii**2
    weights *= (1 - feet.shares) * shares[near] + feet.shares * shares[far]
    weights /= 1 + (feet.distances / (MAX_DEVIATION * feet.radii)) ** 2
    change = np.column_stack([feet.normals, np.ones(len(near))])
    gradients = np.concatenate([(1 - feet.shares)[:, None] * change, feet.shares[:, None] * change], axis=1)
    of_edge = csr_array((weights, (feet.edges, np.arange(len(near)))), shape=(len(edges), len(near)))
    blocks = of_edge @ (gradients[:, :, None] * gradients[:, None, :]).reshape(-1, 64)
    places = (4 * edges[:, :, None] + np.arange(4)).reshape(-1, 8).astype(np.int32)  # int64 takes three times as long
    rows, columns = np.repeat(places, 8, axis=1).ravel(), np.tile(places, 8).ravel()
    fixed = prior.hessian
    entries = np.concatenate([blocks.ravel(), fixed.data])
    at = np.concatenate([rows, fixed.coords[0]]), np.concatenate([columns, fixed.coords[1]])
    b = -(fixed @ (tubes.unknowns - prior.unknowns) + prior.gradient)
    np.add.at(b, places, of_edge @ (feet.distances[:, None] * gradients))
    step = factorize(coo_array((entries, at), shape=fixed.shape).tocsc()).solve(b, refined=False).reshape(-1, 4)
    return replace(tubes, positions=tubes.positions + step[:, :3], radii=np.maximum(r + step[:, 3], r / 2))


def _kept_inside(skeleton: Skeleton, nodes: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """(k, 3) new positions; those of nodes, and of edges of a closed surface, that would leave it are the old ones."""
    leaves = ~surface.contains(nodes) & surface.contains(skeleton.nodes)
    kept = np.where(leaves[:, None], skeleton.nodes, nodes)
    if surface.mesh.is_closed:
        may_leave = segments_outside(skeleton.nodes, skeleton.edges, surface)
        while (is_outside := segments_outside(kept, skeleton.edges, surface) & ~may_leave).any():
            kept[skeleton.edges[is_outside]] = skeleton.nodes[skeleton.edges[is_outside]]
    return kept
