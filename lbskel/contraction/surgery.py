"""Surgery: from the contracted mesh to a graph, by collapsing edges until no face is left.

The cost of a collapse i -> j is the squared distance of v_j to the lines of the edges gathered at i and j, plus a tenth
of |v_i v_j| times the summed lengths of the edges at i: Au, Tai, Chu, Cohen-Or, Lee 2008,
https://doi.org/10.1145/1399504.1360643, section 5. Instead of one heap, rounds: every edge that is the cheapest at both
of its ends collapses at once.

What a collapse may not do is close a tunnel. The cochain of :mod:`lbskel.contraction.homology` decides it: two edges may become one
only where their vectors agree, so that every tunnel of the surface stays a cycle of the graph. A sphere's graph is a
tree whatever collapses.
"""

from __future__ import annotations

__all__ = ["CollapsedGraph", "collapse", "collapse_mesh"]

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from lbskel.contraction.homology import transfer_cochain, tunnel_cochain
from lbskel.contraction.result import Contraction
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import as_mesh
from lbskel.geometry.vertex_map import VertexMap

DIGITS = 11  # of a cost that count, on a mesh of extent 1: of equal ones the order does not depend on rounding
SAMPLING = 0.1  # weight of the sampling cost beside the shape cost; Au et al. 2008


@dataclass(frozen=True, eq=False)
class CollapsedGraph:
    """The graph that remains of a contracted mesh when all its faces have collapsed.

    Parameters
    ----------
    nodes : (k, 3) array of float
        Positions of the nodes, in the units of the contracted mesh.
    kept : (k,) array of int
        Vertices of the contracted mesh that became nodes.
    edges : (e, 2) array of int
        Pairs of nodes.
    node_of_vertex : (n,) array of int
        For each vertex of the source, the node it was merged into.
    handles_certified : bool
        Whether the tunnels were known, so that none could be lost.
    n_spurious_loops_removed : int
        Loops that went round no tunnel and were opened at their longest edge.
    """

    nodes: NDArray[np.float64]
    kept: NDArray[np.int64]
    edges: NDArray[np.int64]
    node_of_vertex: NDArray[np.int64]
    handles_certified: bool
    n_spurious_loops_removed: int


@dataclass(frozen=True, eq=False)
class _Complex:
    """What is left of the mesh: faces with ascending corners, edges, and their cochain from lower to higher end."""

    faces: NDArray[np.int64]
    edges: NDArray[np.int64]
    cochain: NDArray[np.int64]


def collapse(contraction: Contraction) -> CollapsedGraph:
    """Collapse a contracted mesh to the graph of its curve skeleton.

    Parameters
    ----------
    contraction : Contraction
        Of one connected component.

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
    return collapse_mesh(contraction.coarse, contraction.source, vertex_map=contraction.vertex_map)


def collapse_mesh(contracted: Any, source: Any, *, vertex_map: VertexMap | None = None) -> CollapsedGraph:
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

    Returns
    -------
    CollapsedGraph
        Deterministic: of equal costs the edge with the lower index is collapsed first.
    """
    contracted, source = as_mesh(contracted), as_mesh(source)
    n = len(contracted.vertices)
    cochain = tunnel_cochain(source) if source.is_closed_manifold else None
    handles_certified = cochain is not None
    if cochain is None:
        cochain = np.zeros((len(contracted.edges), 0), dtype=np.int64)
    elif vertex_map is not None:
        cochain = transfer_cochain(cochain, source, contracted, vertex_map.indices)
    used = contracted.used_vertices
    P = (contracted.vertices - contracted.vertices[used].mean(axis=0)) / source.diameter_bound
    left = _Complex(np.sort(contracted.faces, axis=1), contracted.edges, cochain)
    Q = _quadrics(P, left.edges)
    merged_into = np.arange(n)
    blocked, has_progressed = np.empty(0, dtype=np.int64), False
    while len(left.faces):
        candidates = np.flatnonzero(_has_face(left, n) & ~np.isin(_keys(left.edges, n), blocked))
        if len(candidates):
            left, gone, target, refused = _round(left, candidates, P, Q, n)
            np.add.at(Q, target, Q[gone])
            step = np.arange(n)
            step[gone] = target
            merged_into = step[merged_into]
            blocked = np.union1d(blocked, refused)
            has_progressed |= len(gone) > 0
        elif has_progressed:
            blocked, has_progressed = blocked[:0], False
        elif len(free := _free_edges(left, n)):
            left, has_progressed = _open_at(left, int(free[0]), n), True
        else:  # a closed surface of few vertices: a hole in it loses no tunnel, and loops too many are cut in the end
            left, has_progressed = _Complex(left.faces[1:], left.edges, left.cochain), True
    kept, node_of_vertex = np.unique(merged_into[used], return_inverse=True)
    node_of = np.full(n, -1)
    node_of[used] = node_of_vertex
    edges = np.searchsorted(kept, left.edges)
    needless = _loops_round_no_tunnel(P[kept], edges, left.cochain) if handles_certified else []
    node_of = node_of if vertex_map is None else node_of[vertex_map.indices]
    return CollapsedGraph(
        contracted.vertices[kept],
        kept,
        np.delete(edges, needless, axis=0),
        node_of,
        handles_certified,
        len(needless),
    )


def _keys(edges: NDArray[np.int64], n: int) -> NDArray[np.int64]:
    """A number for each pair of vertices."""
    return edges[:, 0] * n + edges[:, 1]


def _has_face(left: _Complex, n: int) -> NDArray[np.bool_]:
    """Which edges lie in a face."""
    return np.isin(_keys(left.edges, n), _keys_of_sides(left, n))


def _keys_of_sides(left: _Complex, n: int) -> NDArray[np.int64]:
    """(3m,) number of the pair of vertices at each side of each face."""
    return np.concatenate([_keys(left.faces[:, pair], n) for pair in ([0, 1], [0, 2], [1, 2])])


def _quadrics(P: NDArray[np.float64], edges: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n, 4, 4) sum over the edges at each vertex of the squared distance to the edge's line."""
    start, end = P[edges].transpose(1, 0, 2)
    along = end - start
    length = np.linalg.norm(along, axis=1, keepdims=True)
    direction = np.divide(along, length, out=np.zeros_like(along), where=length > 0)
    A = np.eye(3) - direction[:, :, None] * direction[:, None, :]
    A[length[:, 0] == 0] = 0  # a point has no line
    shifted = np.einsum("kij,kj->ki", A, start)
    line = np.empty((len(edges), 4, 4))
    line[:, :3, :3], line[:, :3, 3], line[:, 3, :3] = A, -shifted, -shifted
    line[:, 3, 3] = np.einsum("ki,ki->k", start, shifted)
    ends = coo_array((np.ones(2 * len(edges)), (edges.T.ravel(), np.tile(np.arange(len(edges)), 2))))
    ends.resize(len(P), len(edges))
    return (ends.tocsr() @ line.reshape(-1, 16)).reshape(-1, 4, 4)


def _round(
    left: _Complex, candidates: NDArray[np.int64], P: NDArray[np.float64], Q: NDArray[np.float64], n: int
) -> tuple[_Complex, NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Collapse every candidate that is the cheapest at both ends and closes no tunnel.

    Returns the complex after it, the vertices gone, those they went into, and the keys of the edges refused.
    """
    gone, target, chosen = _cheapest(left, candidates, P, Q, n)
    keys = _keys(left.edges[chosen], n)
    refused = []
    while True:
        after, in_conflict = _after(left, gone, target, chosen, n)
        if not in_conflict.any():
            break
        bad = in_conflict[gone]
        refused.append(keys[bad])
        gone, target, chosen, keys = gone[~bad], target[~bad], chosen[~bad], keys[~bad]
    return after, gone, target, np.concatenate(refused) if refused else keys[:0]


def _cheapest(
    left: _Complex, candidates: NDArray[np.int64], P: NDArray[np.float64], Q: NDArray[np.float64], n: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """The vertex that goes, the one that stays and the edge, for every candidate that is the cheapest at both ends."""
    length = np.linalg.norm(P[left.edges[:, 0]] - P[left.edges[:, 1]], axis=1)
    reach = np.bincount(left.edges.ravel(), weights=np.repeat(length, 2), minlength=n)
    i, j = left.edges[candidates].T
    both = Q[i] + Q[j]
    H = np.concatenate([P, np.ones((n, 1))], axis=1)
    forward = np.einsum("ki,kij,kj->k", H[j], both, H[j]) + SAMPLING * length[candidates] * reach[i]
    backward = np.einsum("ki,kij,kj->k", H[i], both, H[i]) + SAMPLING * length[candidates] * reach[j]
    forward, backward = np.round(forward, DIGITS), np.round(backward, DIGITS)
    rank = np.empty(len(candidates), dtype=np.int64)
    rank[np.argsort(np.minimum(forward, backward), kind="stable")] = np.arange(len(candidates))
    best = np.full(n, len(candidates))
    np.minimum.at(best, i, rank)
    np.minimum.at(best, j, rank)
    is_best = (best[i] == rank) & (best[j] == rank)
    goes_forward = (forward <= backward)[is_best]
    i, j = i[is_best], j[is_best]
    return np.where(goes_forward, i, j), np.where(goes_forward, j, i), candidates[is_best]


def _after(
    left: _Complex, gone: NDArray[np.int64], target: NDArray[np.int64], chosen: NDArray[np.int64], n: int
) -> tuple[_Complex, NDArray[np.bool_]]:
    """The complex after some collapses, and the vertices at edges that would become one but differ in their cochain."""
    into = np.arange(n)
    into[gone] = target
    shift = np.zeros((n, left.cochain.shape[1]), dtype=np.int64)  # of the way from the vertex that stays to it
    shift[gone] = np.where((gone > target)[:, None], left.cochain[chosen], -left.cochain[chosen])
    cochain = left.cochain + shift[left.edges[:, 0]] - shift[left.edges[:, 1]]
    edges = into[left.edges]
    flipped = edges[:, 0] > edges[:, 1]
    edges = np.where(flipped[:, None], edges[:, ::-1], edges)
    cochain = np.where(flipped[:, None], -cochain, cochain)
    is_edge = edges[:, 0] != edges[:, 1]
    _, first, group = np.unique(_keys(edges, n), return_index=True, return_inverse=True)
    differs = is_edge & (cochain != cochain[first][group]).any(axis=1)
    in_conflict = np.zeros(n, dtype=bool)
    if differs.any():
        in_conflict[left.edges[np.isin(group, group[differs])]] = True
    first = first[is_edge[first]]
    faces = np.sort(into[left.faces], axis=1)
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])]
    return _Complex(_distinct(faces), edges[first], cochain[first]), in_conflict


def _distinct(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Each of the rows once, in lexicographic order."""
    faces = faces[np.lexsort(faces.T[::-1])]
    is_new = np.ones(len(faces), dtype=bool)
    is_new[1:] = (faces[1:] != faces[:-1]).any(axis=1)
    return faces[is_new]


def _free_edges(left: _Complex, n: int) -> NDArray[np.int64]:
    """Keys of the edges that lie in exactly one face."""
    keys, count = np.unique(_keys_of_sides(left, n), return_counts=True)
    return keys[count == 1]


def _open_at(left: _Complex, free: int, n: int) -> _Complex:
    """Take away an edge and the only face it lies in: no loop is opened or closed by it."""
    is_there = (_keys_of_sides(left, n).reshape(3, -1) == free).any(axis=0)
    stays = _keys(left.edges, n) != free
    return _Complex(left.faces[~is_there], left.edges[stays], left.cochain[stays])


def _loops_round_no_tunnel(P: NDArray[np.float64], edges: NDArray[np.int64], cochain: NDArray[np.int64]) -> list[int]:
    """Edges to leave out so that as many independent loops stay as there are independent tunnels.

    Off a tree of the shortest edges, each edge closes one loop with the loop's cochain; longer ways round are asked
    first, since a loop that goes round no tunnel is small.
    """
    k = len(P)
    length = np.linalg.norm(P[edges[:, 0]] - P[edges[:, 1]], axis=1)
    tree = minimum_spanning_tree(weighted_graph(edges, length + 1e-12, k))
    order, above = breadth_first_order(tree, 0, directed=False)
    keys = _keys(edges, k)
    lookup = {int(key): row for row, key in enumerate(keys)}
    potential = np.zeros((k, cochain.shape[1]), dtype=np.int64)
    in_tree = np.zeros(len(edges), dtype=bool)
    for node in order[1:]:
        up = int(above[node])
        row = lookup[min(up, int(node)) * k + max(up, int(node))]
        in_tree[row] = True
        potential[node] = potential[up] + (cochain[row] if up < node else -cochain[row])
    around = cochain + potential[edges[:, 0]] - potential[edges[:, 1]]
    off_tree = np.flatnonzero(~in_tree)
    kept: list[NDArray[np.int64]] = []
    needless = []
    for row in off_tree[np.argsort(-length[off_tree], kind="stable")]:
        if np.linalg.matrix_rank(np.array([*kept, around[row]])) > len(kept):
            kept.append(around[row])
        else:
            needless.append(int(row))
    return needless
