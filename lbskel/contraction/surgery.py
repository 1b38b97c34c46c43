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

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.collapsed_graph import CollapsedGraph
from lbskel.contraction.complexes import (
    Complex,
    closing_edges,
    free_edges,
    has_face,
    keys_of,
    open_surfaces,
    remove_free_edges,
    unique_rows,
)
from lbskel.contraction.homology import Tunnels, find_tunnels, transfer_cochain
from lbskel.contraction.point_graph import collapse_stars
from lbskel.contraction.quadrics import line_quadrics
from lbskel.contraction.result import Contraction
from lbskel.contraction.spurious_loops import PRIME, null_loop_edges, spurious_loop_edges
from lbskel.errors import MeshError
from lbskel.geometry.deadline import NEVER, Deadline, OutOfTime
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.point_stars import PointStars
from lbskel.geometry.sorting import is_among, unique_inverse
from lbskel.geometry.vertex_map import VertexMap

COST_DIGITS = 11  # decimals of a cost, in squared diameter bounds, that order edges, so that rounding decides no ties
TUNNELS_SHARE = 0.5  # of the time left that certificates may take under a deadline; a guess
SAMPLING_WEIGHT = 0.1  # weight of the sampling cost relative to the shape cost; Au et al. 2008


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

    Raises
    ------
    MeshError
        If one is no mesh, or the two have different faces, or the vertex map is none between them.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> mesh = torus(1.0, 0.2)
    >>> graph = lbskel.collapse_mesh(lbskel.contract(mesh).mesh, mesh)
    >>> len(graph.edges) - len(graph.nodes) + 1
    1
    """
    contracted, source = as_mesh(contracted), as_mesh(source)
    n = len(contracted.vertices)
    _require_same_surface(contracted, source, vertex_map)
    tunnels = _tunnels_in_time(source, deadline) if source.is_closed_manifold else None
    cochain = np.zeros((len(contracted.edges), 1), dtype=np.int64)
    if tunnels is not None and tunnels.genus:
        cochain = tunnels.cochain()
        if vertex_map is not None:
            cochain = transfer_cochain(cochain, source, contracted.edges, vertex_map)
    used = contracted.used_vertices
    P = (contracted.vertices - contracted.vertices[used].mean(axis=0)) / source.diameter_bound
    is_removed = np.zeros(len(cochain), dtype=bool)
    remaining = Complex(np.sort(contracted.faces, axis=1), contracted.edges, cochain, is_removed)
    Q = line_quadrics(P, remaining.edges)
    merged_into = np.arange(n)
    blocked, has_progressed = np.empty(0, dtype=np.int64), False
    while len(remaining.faces):
        deadline.check()
        candidates = np.flatnonzero(has_face(remaining, n) & ~is_among(keys_of(remaining.edges, n), blocked))
        if len(candidates):
            remaining, removed, target, refused = _collapse_round(remaining, candidates, P, Q, n)
            Q[target] += Q[removed]  # an edge is the cheapest at both ends, so targets are distinct
            step = np.arange(n)
            step[removed] = target
            merged_into = step[merged_into]
            if len(refused):
                blocked = np.concatenate([blocked, refused, closing_edges(remaining, n)])
            has_progressed |= len(removed) > 0
        elif has_progressed:
            blocked, has_progressed = closing_edges(remaining, n), False
        elif len(free := free_edges(remaining, n)):
            remaining, has_progressed = remove_free_edges(remaining, free, P, n), True
        else:  # closed surfaces of few vertices: opening them loses no tunnel; spurious loops are removed at the end
            remaining, has_progressed = open_surfaces(remaining, n), True
    kept, node_of_used = np.unique(merged_into[used], return_inverse=True)
    node_of_vertex = np.full(n, -1)
    node_of_vertex[used] = node_of_used
    if vertex_map is not None:
        node_of_vertex = vertex_map.pull_back(node_of_vertex)
    is_left = ~remaining.is_removed
    edges, spurious, is_certified = np.searchsorted(kept, remaining.edges[is_left]), [], tunnels is not None
    n_spurious = 0 if tunnels is None else len(edges) - len(kept) + 1 - tunnels.genus
    if tunnels is not None and n_spurious > 0:
        spurious = null_loop_edges(P[kept], edges, remaining.cochain[is_left])
        try:
            if len(spurious) != n_spurious:
                blocks = tunnels.independent_cochains(PRIME, deadline=deadline)
                to_node = VertexMap(node_of_vertex)
                values = np.concatenate([transfer_cochain(x, source, edges, to_node) for x in blocks], axis=1)
                spurious = spurious_loop_edges(P[kept], edges, values, deadline=deadline)
        except OutOfTime:
            is_certified = False
    return CollapsedGraph(
        contracted.vertices[kept],
        kept,
        np.delete(edges, spurious, axis=0),
        node_of_vertex,
        is_certified,
        len(spurious),
    )


def _require_same_surface(contracted: Mesh, source: Mesh, vertex_map: VertexMap | None) -> None:
    """Raise MeshError if the contracted mesh is not that of the source."""
    if vertex_map is None and not (
        len(contracted.vertices) == len(source.vertices) and np.array_equal(contracted.faces, source.faces)
    ):
        raise MeshError(
            f"the contracted mesh ({contracted!r}) must have the faces of its source ({source!r}); where vertices were "
            "merged, give the vertex_map of the contraction"
        )
    if vertex_map is not None and not (
        len(vertex_map) == len(source.vertices) and vertex_map.indices.max(initial=-1) < len(contracted.vertices)
    ):
        raise MeshError(
            f"the vertex map of {len(vertex_map)} vertices does not lead from the source ({source!r}) to the "
            f"contracted mesh ({contracted!r}); give that of the contraction"
        )


def _tunnels_in_time(source: Mesh, deadline: Deadline) -> Tunnels | None:
    """Find the tunnels in half of the time that is left; None if that is not enough, or if they are not certain."""
    if deadline == NEVER:
        return find_tunnels(source)
    try:
        return find_tunnels(source, deadline=Deadline(deadline.end - (1 - TUNNELS_SHARE) * deadline.seconds_left))
    except OutOfTime:
        return None


def _collapse_round(
    remaining: Complex, candidates: NDArray[np.int64], P: NDArray[np.float64], Q: NDArray[np.float64], n: int
) -> tuple[Complex, NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Collapse every candidate that is the cheapest at both ends and closes no tunnel.

    Returns the complex afterwards, the vertices removed, those they were merged into, and the keys of refused edges.
    """
    removed, target, chosen = _cheapest(remaining, candidates, P, Q, n)
    keys = keys_of(remaining.edges[chosen], n)
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
    remaining: Complex, candidates: NDArray[np.int64], P: NDArray[np.float64], Q: NDArray[np.float64], n: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Select the candidates that are the cheapest at both ends: the vertex to remove, the one to keep, and the edge."""
    length = vector_lengths(P[remaining.edges[:, 0]] - P[remaining.edges[:, 1]]) * ~remaining.is_removed
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
    remaining: Complex, removed: NDArray[np.int64], target: NDArray[np.int64], chosen: NDArray[np.int64], n: int
) -> tuple[Complex, NDArray[np.bool_]]:
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
    distinct_keys, group = unique_inverse(keys_of(edges, n))
    first = np.empty(len(distinct_keys), dtype=np.int64)
    first[group[::-1]] = np.arange(len(group))[::-1]
    differs = is_edge & (cochain != cochain[first][group]).any(axis=1)
    in_conflict = np.zeros(n, dtype=bool)
    if differs.any():
        in_conflict[remaining.edges[np.isin(group, group[differs])]] = True
    is_removed = np.ones(len(first), dtype=bool)
    is_removed[group[~remaining.is_removed]] = False
    is_removed, first = is_removed[is_edge[first]], first[is_edge[first]]
    faces = np.sort(new_vertex[remaining.faces], axis=1)
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])]
    return Complex(unique_rows(faces), edges[first], cochain[first], is_removed), in_conflict
