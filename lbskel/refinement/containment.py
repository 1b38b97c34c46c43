"""Keeping a skeleton inside its surface: parts of branches that leave it are rerouted below the surface."""

from __future__ import annotations

__all__ = [
    "inside_fraction",
    "interior_paths",
    "moved_inside",
    "paths_outside",
    "reroute_inside",
    "segments_outside",
]

import itertools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.normals import normalized, vector_lengths
from lbskel.geometry.surface_queries import VERTEX_OFFSET, Surface
from lbskel.refinement.offset_paths import paths_below_surface
from lbskel.refinement.open_ends import NO_CUTS, are_within_cuts
from lbskel.refinement.relaxation import relax_inside
from lbskel.refinement.tunnel_paths import paths_on_side_of
from lbskel.refinement.tunnel_sides import keep_sides, n_tunnels_missed, on_their_side, paths_that_pass
from lbskel.skeleton.editing import replace_paths
from lbskel.skeleton.skeleton import Skeleton

N_SAMPLES = 12  # parts of a segment, of which each that is not in a ball is tested; a guess,
# benchmarks/results/constants.md


def inside_fraction(
    skeleton: Skeleton,
    surface: Surface,
    tolerance: NDArray[np.float64] | float = 0.0,
    *,
    open_ends: NDArray[np.float64] = NO_CUTS,
) -> float:
    """Fraction of the skeleton's length that lies inside, sampled along the edges that leave the surface somewhere.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    tolerance : float or (k,) array of float
        Distance from the surface, at each node, up to which a point outside counts as inside.
    open_ends : (e, 7) array of float
        Center (3), mean radius (1) and vector area (3) of each cut. A point within the radius of the center counts as
        inside.
    """
    allowed = np.broadcast_to(tolerance, len(skeleton.nodes))
    if len(skeleton.edges) == 0 or not skeleton.length > 0:
        return float((surface.contains(skeleton.nodes) | (surface.distance(skeleton.nodes) < allowed)).mean())
    leaving = skeleton.edges[segments_outside(skeleton.nodes, skeleton.edges, surface)]
    P, Q = skeleton.nodes[leaving].transpose(1, 0, 2)
    share = ((np.arange(N_SAMPLES) + 0.5) / N_SAMPLES)[:, None]
    points = (P[:, None] + share * (Q - P)[:, None]).reshape(-1, 3)
    limits = np.repeat(allowed[leaving].min(axis=1), N_SAMPLES)
    lengths, (first, last) = vector_lengths(Q - P), surface.distance(skeleton.nodes)[leaving].T
    bounds = np.minimum(first + share * lengths, last + (1 - share) * lengths).T.ravel()  # on the distances of points
    is_outside = bounds >= limits
    is_outside[is_outside] = ~surface.contains(points[is_outside])
    is_outside[is_outside] = surface.distance(points[is_outside]) >= limits[is_outside]
    is_outside[is_outside] = ~are_within_cuts(points[is_outside], open_ends)
    outside = is_outside.reshape(-1, N_SAMPLES).mean(axis=1) * lengths
    return float(1 - outside.sum() / skeleton.length)


def moved_inside(points: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """Move each point outside as far inside as it was outside, but not past half the thickness.

    Parameters
    ----------
    points : (n, 3) array of float
        Those inside stay.
    surface : Surface
    """
    outside = np.flatnonzero(~surface.contains(points))
    _, nearest = surface.closest(points[outside])
    way = nearest - points[outside]
    inward = normalized(way)
    entry = nearest + VERTEX_OFFSET * surface.mesh.diameter_bound * inward
    thickness = surface.ray_distance(entry, inward)
    thickness = np.where(np.isfinite(thickness), thickness, 0.0)
    depth = np.minimum(0.5 * thickness, vector_lengths(way))
    moved: NDArray[np.float64] = np.array(points)
    moved[outside] = entry + depth[:, None] * inward
    return moved


def reroute_inside(skeleton: Skeleton, surface: Surface) -> Skeleton:
    """Reroute every part of a branch that leaves the surface.

    Junctions and tips outside are moved inside. A part of a branch between two nodes inside is then replaced by a
    straight segment where that stays inside, or else by the shortest path below the surface, relaxed.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
        Closed.
    """
    nodes = np.array(skeleton.nodes)
    ends = np.flatnonzero(skeleton.degrees != 2)
    nodes[ends] = moved_inside(nodes[ends], surface)
    nodes = keep_sides(skeleton, nodes, surface)
    skeleton = replace(skeleton, nodes=nodes)
    is_leaving = segments_outside(skeleton.nodes, skeleton.edges, surface)
    if not is_leaving.any():
        return skeleton
    leaving = {tuple(edge) for edge in skeleton.edges[is_leaving].tolist()}
    parts = _parts_to_reroute(skeleton, leaving, surface)
    paths = interior_paths(nodes, np.array([(part[0], part[-1]) for part in parts]), surface)
    rerouted = _with_paths(skeleton, parts, paths, surface)
    if n_tunnels_missed(rerouted, surface) > n_tunnels_missed(skeleton, surface):
        paths = _on_their_side([nodes[part] for part in parts], paths, surface)
        rerouted = _with_paths(skeleton, parts, paths, surface)
    nodes, radii = keep_sides(rerouted, moved_inside(rerouted.nodes, surface), surface), np.array(rerouted.radii)
    moved = np.flatnonzero((nodes != rerouted.nodes).any(axis=1))
    radii[moved] = surface.distance(nodes[moved])
    return replace(rerouted, nodes=nodes, radii=radii)


def _with_paths(
    skeleton: Skeleton, parts: list[NDArray[np.int64]], paths: list[NDArray[np.float64]], surface: Surface
) -> Skeleton:
    """Replace the inner nodes of parts of branches by the points of paths."""
    positions = np.concatenate(paths)
    begins, new_begins = (np.cumsum([0, *map(len, each)]) for each in (parts, paths))
    return replace_paths(skeleton, np.concatenate(parts), begins, positions, new_begins, surface.distance(positions))


def _on_their_side(
    olds: list[NDArray[np.float64]], paths: list[NDArray[np.float64]], surface: Surface
) -> list[NDArray[np.float64]]:
    """Inner points that pass each tunnel on the side of old paths: those of the new paths, or of others."""
    news = [np.concatenate([old[:1], path, old[-1:]]) for old, path in zip(olds, paths, strict=True)]
    passes = np.flatnonzero(paths_that_pass(olds, news, surface)).tolist()
    if passes:
        others = paths_on_side_of([olds[row] for row in passes], surface.proxy)
        for row, path in zip(passes, on_their_side(others, relax_inside(others, surface), surface), strict=True):
            news[row] = path
    return [path[1:-1] for path in news]


def segments_outside(nodes: NDArray[np.float64], edges: NDArray[np.int64], surface: Surface) -> NDArray[np.bool_]:
    """(m,) whether an edge, of (m, 2) pairs of (n, 3) nodes, is outside the surface somewhere.

    An edge is inside if balls inside the surface cover it from one end to the ball at the other end. Where a ball is
    smaller than one of ``N_SAMPLES`` parts of the edge, the next ball is one part further, and its center is tested.
    """
    used, rows_of_used = np.unique(edges, return_inverse=True)
    nodes, edges = nodes[used], rows_of_used.reshape(-1, 2)
    P, Q = nodes.take(edges.T, axis=0)
    is_inside = surface.contains(nodes)
    is_outside = ~(is_inside[edges[:, 0]] & is_inside[edges[:, 1]])
    lengths, open_edges = vector_lengths(Q - P), np.flatnonzero(~is_outside)
    reach, measured = np.zeros(len(nodes)), np.arange(len(nodes))
    for distance in (surface.clearance, surface.distance)[surface.simplified is None :]:
        reach[measured] = distance(nodes[measured])
        open_edges = open_edges[lengths[open_edges] >= reach[edges[open_edges]].sum(axis=1)]
        measured = np.unique(edges[open_edges])
    if len(open_edges) == 0:
        return is_outside
    directions = (Q - P)[open_edges] / np.where(lengths > 0, lengths, 1.0)[open_edges, None]
    parts, (radii, last_radii) = lengths[open_edges] / N_SAMPLES, reach[edges[open_edges]].T
    at, ends = np.zeros(len(open_edges)), lengths[open_edges] - last_radii
    rows = np.arange(len(open_edges))
    while len(rows):
        at[rows] += np.maximum(radii, parts[rows])
        is_small, is_open = radii < parts[rows], at[rows] < ends[rows]
        rows, is_small = rows[is_open], is_small[is_open]
        points = P[open_edges[rows]] + at[rows, None] * directions[rows]
        is_in = np.ones(len(rows), dtype=bool)
        is_in[is_small] = surface.contains(points[is_small])
        is_outside[open_edges[rows[~is_in]]] = True
        rows, radii = rows[is_in], surface.distance(points[is_in])
    return is_outside


def paths_outside(paths: list[NDArray[np.float64]], surface: Surface) -> NDArray[np.bool_]:
    """(p,) whether a path is outside the surface somewhere.

    Parameters
    ----------
    paths : list of (n, 3) array of float
    surface : Surface
    """
    if len(paths) == 0:
        return np.zeros(0, dtype=bool)
    path_of = np.repeat(np.arange(len(paths)), [len(path) for path in paths])
    first = np.flatnonzero(path_of[1:] == path_of[:-1])
    outside = segments_outside(np.concatenate(paths), np.stack([first, first + 1], axis=1), surface)
    found: NDArray[np.bool_] = np.bincount(path_of[first], outside, minlength=len(paths)) > 0
    return found


def _parts_to_reroute(skeleton: Skeleton, leaving: set[tuple[int, ...]], surface: Surface) -> list[NDArray[np.int64]]:
    """Find the parts of branches from a node inside to the next where the edges between leave the surface.

    Where the straight line between the two leaves it too, the part goes on to nodes in the middle of the solid.
    """
    radii = surface.distance(skeleton.nodes)
    runs = [(branch, *run) for branch in skeleton.branches for run in _leaving_runs(branch, leaving)]
    ends = np.array([(branch[first], branch[last]) for branch, first, last in runs])
    is_blocked = segments_outside(skeleton.nodes, ends, surface)
    parts: list[tuple[NDArray[np.int64], int, int]] = []
    for (branch, first, last), is_long in zip(runs, is_blocked, strict=True):
        if is_long:
            first -= _n_to_middle(radii[branch[first::-1]])
            last += _n_to_middle(radii[branch[last:]])
        if parts and parts[-1][0] is branch and first < parts[-1][2]:
            _, first, end = parts.pop()
            last = max(last, end)
        parts.append((branch, first, last))
    return [piece for branch, first, last in parts for piece in _pieces(branch[first : last + 1])]


def _pieces(part: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Cut a part in three if it is a whole loop, so that it stays a loop."""
    third = len(part) // 3 if part[0] == part[-1] else len(part)
    return [part[: third + 1], part[third : 2 * third + 1], part[2 * third :]] if third < len(part) else [part]


def _n_to_middle(radii: NDArray[np.float64]) -> int:
    """Count the steps along a path as long as its inscribed radii grow."""
    grows = np.diff(radii) > 0
    return len(grows) if grows.all() else int(grows.argmin())


def _leaving_runs(branch: NDArray[np.int64], leaving: set[tuple[int, ...]]) -> list[tuple[int, int]]:
    """Find the first and the last node of each run of edges that leave the surface, as places in the branch."""
    is_leaving = [False, *((min(a, b), max(a, b)) in leaving for a, b in itertools.pairwise(branch.tolist())), False]
    runs = np.flatnonzero(np.diff(is_leaving)).reshape(-1, 2).tolist()
    return [(first, last) for first, last in runs]


def interior_paths(P: NDArray[np.float64], pairs: NDArray[np.int64], surface: Surface) -> list[NDArray[np.float64]]:
    """For each pair of points, the points between them on a path that stays inside.

    Where the straight segment is inside, this is its midpoint. Otherwise the path follows the edges of the proxy mesh,
    with vertices moved inwards by half the thickness of the shape, but no deeper than the deeper of the two points, and
    is relaxed (:mod:`lbskel.refinement.relaxation`).

    Parameters
    ----------
    P : (n, 3) array of float
    pairs : (p, 2) array of int
        Rows of P.
    surface : Surface
    """
    paths = list(P[pairs].mean(axis=1, keepdims=True))
    outside = np.flatnonzero(segments_outside(P, pairs, surface))
    if len(outside) == 0:
        return paths
    starts, ends = P[pairs[outside]].transpose(1, 0, 2)
    depths = np.maximum(surface.distance(starts), surface.distance(ends))
    below = paths_below_surface(starts, ends, depths, surface.proxy)
    whole = [np.concatenate([[p], path, [q]]) for p, path, q in zip(starts, below, ends, strict=True)]
    for row, path in zip(outside.tolist(), relax_inside(whole, surface), strict=True):
        paths[row] = path[1:-1]
    return paths
