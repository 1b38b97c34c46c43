"""Surgery: from the contracted mesh to a graph, by collapsing edges until no face is left.

The cost of collapsing i into j is the squared distance of v_j to the lines of the edges accumulated at i and j, plus a
tenth of |v_i v_j| times the summed lengths of the edges at i: Au, Tai, Chu, Cohen-Or, Lee 2008,
https://doi.org/10.1145/1399504.1360643, section 5. In place of one priority queue there are rounds: every edge that is
the cheapest at both of its ends collapses at once.

A collapse must not close a tunnel. The cochain of :mod:`lbskel.contraction.homology` decides: two edges may be merged
only if their values are equal, so that every handle of the surface stays a cycle of the graph. The graph of a sphere
becomes a tree whatever is collapsed.
"""

from __future__ import annotations

__all__ = ["CollapsedGraph", "collapse", "collapse_mesh"]

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.connectivity import component_roots
from lbskel.contraction.collapsed_graph import CollapsedGraph
from lbskel.contraction.homology import Tunnels, find_tunnels, transfer_cochain
from lbskel.contraction.point_graph import collapse_stars
from lbskel.contraction.quadrics import line_quadrics
from lbskel.contraction.result import Contraction
from lbskel.contraction.spurious_loops import PRIME, spurious_loop_edges
from lbskel.geometry.deadline import NEVER, Deadline, OutOfTime
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.point_stars import PointStars
from lbskel.geometry.vertex_map import VertexMap

COST_DIGITS = 11  # decimals of a cost, in squared diameter bounds, that order edges, so that rounding decides no ties
TUNNELS_SHARE = 0.5  # of the time left that certificates may take under a deadline; a guess
SAMPLING_WEIGHT = 0.1  # weight of the sampling cost relative to the shape cost; Au et al. 2008


@dataclass(frozen=True, eq=False)
class _Complex:
    """The faces and edges not yet collapsed.

    Parameters
    ----------
    faces : (m, 3) array of int
        With ascending corners.
    edges : (k, 2) array of int
        With ascending ends.
    cochain : (k, 1) array of int
        Of each edge from its lower to its higher end, modulo 2^64.
    """

    faces: NDArray[np.int64]
    edges: NDArray[np.int64]
    cochain: NDArray[np.int64]


def collapse(contraction: Contraction, *, deadline: Deadline = NEVER) -> CollapsedGraph:
    """Collapse a contracted mesh to the graph of its curve skeleton, a contracted cloud as Cao et al. 2010 do.

    Parameters
    ----------
    contraction : Contraction
        Of one connected component.
    deadline : Deadline
        After it, OutOfTime is raised.

    Returns
    -------
    CollapsedGraph
        Its ``node_of_vertex`` has a node for each vertex of ``contraction.source``.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> graph = lbskel.collapse(lbskel.contract(torus(1.0, 0.2)))
    >>> graph.handles_certified, len(graph.edges) - len(graph.nodes) + 1
    (True, 1)
    """
    if isinstance(contraction.source, PointStars):
        return collapse_stars(contraction.mesh, contraction.source, deadline=deadline)
    return collapse_mesh(contraction.coarse, contraction.source, vertex_map=contraction.vertex_map, deadline=deadline)


def collapse_mesh(
    contracted: Any, source: Any, *, vertex_map: VertexMap | None = None, deadline: Deadline = NEVER
) -> CollapsedGraph:
    """Collapse a mesh to a graph whose cycles are the handles of another mesh.

    Parameters
    ----------
    contracted : Mesh, (vertices, faces), path or mesh object
        One connected component after contraction.
    source : Mesh, (vertices, faces), path or mesh object
        The surface before contraction, whose handles are kept. It has the faces of ``contracted``, unless a vertex map
        is given.
    vertex_map : VertexMap, optional
        From the vertices of the source to those of the contracted mesh, where vertices were merged.
    deadline : Deadline
        After it, OutOfTime is raised.

    Returns
    -------
    CollapsedGraph
        Deterministic: of equal costs the edge with the lower index is collapsed first.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> mesh = torus(1.0, 0.2)
    >>> graph = lbskel.collapse_mesh(mesh, lbskel.contract(mesh).mesh)
    >>> len(graph.edges) - len(graph.nodes) + 1
    1
    """
    contracted, source = as_mesh(contracted), as_mesh(source)
    n = len(contracted.vertices)
    tunnels = _tunnels_in_time(source, deadline) if source.is_closed_manifold else None
    cochain = np.zeros((len(contracted.edges), 1), dtype=np.int64)
    if tunnels is not None and tunnels.genus:
        cochain = tunnels.cochain()
        if vertex_map is not None:
            cochain = transfer_cochain(cochain, source, contracted.edges, vertex_map)
    used = contracted.used_vertices
    P = (contracted.vertices - contracted.vertices[used].mean(axis=0)) / source.diameter_bound
    remaining = _Complex(np.sort(contracted.faces, axis=1), contracted.edges, cochain)
    Q = line_quadrics(P, remaining.edges)
    merged_into = np.arange(n)
    blocked, has_progressed = np.empty(0, dtype=np.int64), False
    while len(remaining.faces):
        deadline.check()
        candidates = np.flatnonzero(_has_face(remaining, n) & ~np.isin(_keys(remaining.edges, n), blocked))
        if len(candidates):
            remaining, removed, target, refused = _collapse_round(remaining, candidates, P, Q, n)
            np.add.at(Q, target, Q[removed])
            step = np.arange(n)
            step[removed] = target
            merged_into = step[merged_into]
            blocked = np.union1d(blocked, refused)
            has_progressed |= len(removed) > 0
        elif has_progressed:
            blocked, has_progressed = blocked[:0], False
        elif len(free := _free_edges(remaining, n)):
            remaining, has_progressed = _remove_free_edges(remaining, free, P, n), True
        else:  # closed surfaces of few vertices: opening them loses no tunnel; spurious loops are removed at the end
            remaining, has_progressed = _open_surfaces(remaining, n), True
    kept, node_of_used = np.unique(merged_into[used], return_inverse=True)
    node_of_vertex = np.full(n, -1)
    node_of_vertex[used] = node_of_used
    if vertex_map is not None:
        node_of_vertex = vertex_map.pull_back(node_of_vertex)
    edges, spurious = np.searchsorted(kept, remaining.edges), []
    if tunnels is not None and len(edges) - len(kept) + 1 > tunnels.genus:
        values = tunnels.independent_cochains(PRIME)
        spurious = spurious_loop_edges(
            P[kept], edges, transfer_cochain(values, source, edges, VertexMap(node_of_vertex))
        )
    return CollapsedGraph(
        contracted.vertices[kept],
        kept,
        np.delete(edges, spurious, axis=0),
        node_of_vertex,
        tunnels is not None,
        len(spurious),
    )


def _tunnels_in_time(source: Mesh, deadline: Deadline) -> Tunnels | None:
    """Find the tunnels by half of the time that is left; None, as where they are not certain, if it is over."""
    if deadline == NEVER:
        return find_tunnels(source)
    try:
        return find_tunnels(source, deadline=Deadline(deadline.end - (1 - TUNNELS_SHARE) * deadline.seconds_left))
    except OutOfTime:
        return None


def _keys(edges: NDArray[np.int64], n: int) -> NDArray[np.int64]:
    """(k,) unique number of each ordered pair of vertices."""
    keys: NDArray[np.int64] = edges[:, 0] * n + edges[:, 1]
    return keys


def _has_face(remaining: _Complex, n: int) -> NDArray[np.bool_]:
    """(k,) whether each edge belongs to a face."""
    return np.isin(_keys(remaining.edges, n), _keys_of_sides(remaining, n))


def _keys_of_sides(remaining: _Complex, n: int) -> NDArray[np.int64]:
    """(3m,) number of the pair of vertices at each side of each face."""
    return np.concatenate([_keys(remaining.faces[:, pair], n) for pair in ([0, 1], [0, 2], [1, 2])])


def _collapse_round(
    remaining: _Complex, candidates: NDArray[np.int64], P: NDArray[np.float64], Q: NDArray[np.float64], n: int
) -> tuple[_Complex, NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Collapse every candidate that is the cheapest at both ends and closes no tunnel.

    Returns the complex afterwards, the vertices removed, those they were merged into, and the keys of refused edges.
    """
    removed, target, chosen = _cheapest(remaining, candidates, P, Q, n)
    keys = _keys(remaining.edges[chosen], n)
    refused = []
    while True:
        following, in_conflict = _collapse_edges(remaining, removed, target, chosen, n)
        if not in_conflict.any():
            break
        bad = in_conflict[removed]
        refused.append(keys[bad])
        removed, target, chosen, keys = removed[~bad], target[~bad], chosen[~bad], keys[~bad]
    return following, removed, target, np.concatenate(refused) if refused else keys[:0]


def _cheapest(
    remaining: _Complex, candidates: NDArray[np.int64], P: NDArray[np.float64], Q: NDArray[np.float64], n: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Select the candidates that are the cheapest at both ends: the vertex to remove, the one to keep, and the edge."""
    length = np.linalg.norm(P[remaining.edges[:, 0]] - P[remaining.edges[:, 1]], axis=1)
    length_sum = np.bincount(remaining.edges.ravel(), weights=np.repeat(length, 2), minlength=n)
    i, j = remaining.edges[candidates].T
    both = Q[i] + Q[j]
    H = np.concatenate([P, np.ones((n, 1))], axis=1)
    forward = np.einsum("ki,kij,kj->k", H[j], both, H[j]) + SAMPLING_WEIGHT * length[candidates] * length_sum[i]
    backward = np.einsum("ki,kij,kj->k", H[i], both, H[i]) + SAMPLING_WEIGHT * length[candidates] * length_sum[j]
    forward, backward = np.round(forward, COST_DIGITS), np.round(backward, COST_DIGITS)
    rank = np.empty(len(candidates), dtype=np.int64)
    rank[np.argsort(np.minimum(forward, backward), kind="stable")] = np.arange(len(candidates))
    best = np.full(n, len(candidates))
    np.minimum.at(best, i, rank)
    np.minimum.at(best, j, rank)
    is_best = (best[i] == rank) & (best[j] == rank)
    removes_i = (forward <= backward)[is_best]
    i, j = i[is_best], j[is_best]
    return np.where(removes_i, i, j), np.where(removes_i, j, i), candidates[is_best]


def _collapse_edges(
    remaining: _Complex, removed: NDArray[np.int64], target: NDArray[np.int64], chosen: NDArray[np.int64], n: int
) -> tuple[_Complex, NDArray[np.bool_]]:
    """Collapse edges; also return (n,) whether each vertex is at edges that would be merged but differ in cochain."""
    new_vertex = np.arange(n)
    new_vertex[removed] = target
    shift = np.zeros((n, remaining.cochain.shape[1]), dtype=np.int64)  # cochain of the edge from target to removed
    shift[removed] = np.where((removed > target)[:, None], remaining.cochain[chosen], -remaining.cochain[chosen])
    cochain = remaining.cochain + shift[remaining.edges[:, 0]] - shift[remaining.edges[:, 1]]
    edges = new_vertex[remaining.edges]
    flipped = edges[:, 0] > edges[:, 1]
    edges = np.where(flipped[:, None], edges[:, ::-1], edges)
    cochain = np.where(flipped[:, None], -cochain, cochain)
    is_edge = edges[:, 0] != edges[:, 1]
    _, first, group = np.unique(_keys(edges, n), return_index=True, return_inverse=True)
    differs = is_edge & (cochain != cochain[first][group]).any(axis=1)
    in_conflict = np.zeros(n, dtype=bool)
    if differs.any():
        in_conflict[remaining.edges[np.isin(group, group[differs])]] = True
    first = first[is_edge[first]]
    faces = np.sort(new_vertex[remaining.faces], axis=1)
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])]
    return _Complex(_unique_rows(faces), edges[first], cochain[first]), in_conflict


def _unique_rows(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the distinct rows in lexicographic order."""
    faces = faces[np.lexsort(faces.T[::-1])]
    is_new = np.ones(len(faces), dtype=bool)
    is_new[1:] = (faces[1:] != faces[:-1]).any(axis=1)
    return faces[is_new]


def _free_edges(remaining: _Complex, n: int) -> NDArray[np.int64]:
    """Keys of the edges that belong to exactly one face."""
    keys, count = np.unique(_keys_of_sides(remaining, n), return_counts=True)
    free: NDArray[np.int64] = keys[count == 1]
    return free


def _remove_free_edges(remaining: _Complex, free: NDArray[np.int64], P: NDArray[np.float64], n: int) -> _Complex:
    """Remove the longest free edge of each face that has one, and the face, which neither opens nor closes a loop."""
    keys = _keys_of_sides(remaining, n).reshape(3, -1)
    lengths = np.linalg.norm(P[keys // n] - P[keys % n], axis=2)
    lengths[~np.isin(keys, free)] = -1
    longest = np.argmax(lengths, axis=0)
    has_free_edge = lengths.max(axis=0) >= 0
    removed = keys[longest, np.arange(keys.shape[1])][has_free_edge]
    is_kept = ~np.isin(_keys(remaining.edges, n), removed)
    return _Complex(remaining.faces[~has_free_edge], remaining.edges[is_kept], remaining.cochain[is_kept])


def _open_surfaces(remaining: _Complex, n: int) -> _Complex:
    """Remove the first face of each connected part of the faces."""
    part = component_roots(
        np.concatenate([remaining.faces[:, :2], remaining.faces[:, 1:]]), np.zeros(n, dtype=np.int64)
    )
    _, first = np.unique(part[remaining.faces[:, 0]], return_index=True)
    return _Complex(np.delete(remaining.faces, first, axis=0), remaining.edges, remaining.cochain)
