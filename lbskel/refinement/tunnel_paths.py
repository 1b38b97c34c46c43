"""Shortest paths below a surface that pass every tunnel on the side of another path.

Each edge has a number, so that the sum around a closed polygon is zero if and only if it goes around no tunnel
(:func:`lbskel.contraction.cycle_classes.tunnel_cochain`). A search over pairs of a vertex and the sum so far, the
covering of the graph in which paths on different sides of a tunnel end at different places, finds the shortest path
with the sum of the given one.
"""

from __future__ import annotations

__all__ = ["paths_on_side_of"]

import heapq

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.cycle_classes import tunnel_cochain
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.offset_paths import moved_inwards

MAX_STATES = 5_000  # pairs of a vertex and a sum that a search visits at most, which bounds the time; a guess: by hand,
# searches on a surface of genus 2 and on a porous block of genus 133 visit up to 2,500 pairs, or end only at the limit
MAX_PATHS = 4  # that are searched at most; each takes a tenth of a second on a mesh of 10,000 vertices; a guess
WRAP = 2**64  # sums are modulo this number


def paths_on_side_of(paths: list[NDArray[np.float64]], surface: Surface) -> list[NDArray[np.float64]]:
    """For each path, the shortest one along edges of the mesh, moved inwards, that passes each tunnel on the same side.

    Parameters
    ----------
    paths : list of (n, 3) array of float
        Of at least two points, whose ends are inside. Vertices are moved inwards by half the thickness of the shape,
        but no deeper than the deeper end.
    surface : Surface
        Of a closed mesh.

    Returns
    -------
    list of (m, 3) array of float
        With the same ends; the path itself where none is found, or after ``MAX_PATHS``.
    """
    mesh, depths = surface.mesh, [float(surface.distance(path[[0, -1]]).max()) for path in paths[:MAX_PATHS]]
    both = np.concatenate([mesh.edges, mesh.edges[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    begins = np.searchsorted(both[:, 0], np.arange(len(mesh.vertices) + 1)).tolist()
    found = []
    for path, depth in surface.deadline.until(zip(paths[:MAX_PATHS], depths, strict=True)):
        V = moved_inwards(np.arange(len(mesh.vertices)), depth, surface)
        first, last = (int(vector_lengths(V - end).argmin()) for end in (path[0], path[-1]))
        own = np.stack([path[:-1], path[1:]], axis=1)
        joins = np.stack([[path[0], V[first]], [V[last], path[-1]]])
        values = tunnel_cochain(np.concatenate([V[both], own, joins]), surface)
        if values is None:
            return paths
        n_edges, n_own = len(both), len(own)
        target = int(values[n_edges : n_edges + n_own].sum()) - int(values[n_edges + n_own :].sum())
        lengths = vector_lengths(V[both[:, 0]] - V[both[:, 1]])
        graph = (begins, both[:, 1].tolist(), lengths.tolist(), values[:n_edges].tolist())
        vertices = _search(graph, vector_lengths(V - V[last]).tolist(), first, last, target % WRAP)
        found.append(np.concatenate([path[:1], V[vertices], path[-1:]]) if vertices else path)
    return [*found, *paths[MAX_PATHS:]]


def _search(
    graph: tuple[list[int], list[int], list[float], list[int]],
    to_last: list[float],
    first: int,
    last: int,
    target: int,
) -> list[int]:
    """Vertices of the shortest path whose edges have the target for their sum; empty if too many states are visited.

    The graph is where the edges of each vertex begin, and their ends, lengths and values. The search is led by the
    straight distances to the last vertex (A*).
    """
    begins, ends, lengths, values = graph
    start = (first, 0)
    parents: dict[tuple[int, int], tuple[int, int]] = {}
    queue = [(to_last[first], 0.0, start, start)]
    while queue and len(parents) < MAX_STATES:
        _, length, state, parent = heapq.heappop(queue)
        if state in parents:
            continue
        parents[state] = parent
        vertex, total = state
        if state == (last, target):
            path = [vertex]
            while state != start:
                state = parents[state]
                path.append(state[0])
            return path[::-1]
        for row in range(begins[vertex], begins[vertex + 1]):
            following = (ends[row], (total + values[row]) % WRAP)
            if following not in parents:
                far = length + lengths[row]
                heapq.heappush(queue, (far + to_last[ends[row]], far, following, state))
    return []
