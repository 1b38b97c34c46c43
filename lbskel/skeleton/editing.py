"""Edits of a skeleton's graph: contract nodes or branches, append or replace paths, split an edge, reroot, concatenate.

Every function returns a new skeleton whose ``anchors`` and ``node_of_vertex`` refer to its nodes. Added nodes come
after the present ones, and their radii are given by the caller; only :func:`replace_paths` maps vertices to them.
``mean_radii`` are dropped where nodes are added, since those of the new nodes are not known.
"""

from __future__ import annotations

__all__ = [
    "append_paths",
    "concatenate",
    "contract_branches",
    "contract_new_tips",
    "contract_nodes",
    "replace_paths",
    "reroot",
    "split_edge",
]

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.traversal import sums_along_paths
from lbskel.errors import MeshError
from lbskel.geometry.normals import vector_lengths
from lbskel.skeleton.skeleton import Skeleton


def contract_nodes(skeleton: Skeleton, target: NDArray[np.int64]) -> Skeleton:
    """Contract every node into its target, which keeps its position and radius.

    Parameters
    ----------
    skeleton : Skeleton
    target : (k,) array of int
        For each node the node that it becomes part of; a node that stays is its own target.
    """
    is_kept = np.zeros(len(target), dtype=bool)
    is_kept[target] = True
    return _renumbered(skeleton, np.flatnonzero(is_kept), (np.cumsum(is_kept) - 1)[target])


def contract_branches(skeleton: Skeleton, branches: Sequence[NDArray[np.int64]]) -> Skeleton:
    """Contract branches into their first nodes, which get their vertices.

    Parameters
    ----------
    skeleton : Skeleton
    branches : sequence of (k,) arrays of int
        The nodes of each; no two branches share a node other than their first.
    """
    target = np.arange(len(skeleton.nodes))
    for branch in branches:
        target[branch] = branch[0]
    return contract_nodes(skeleton, target)


def contract_new_tips(skeleton: Skeleton, was_tip: NDArray[np.bool_]) -> Skeleton:
    """Contract end branches until no tip of a branch from a junction is left that was none before an edit.

    Parameters
    ----------
    skeleton : Skeleton
    was_tip : (k,) array of bool
        For each of its nodes.
    """
    while new := [end for end in skeleton.end_branches if not was_tip[end[-1]]]:
        was_tip = np.delete(was_tip, np.concatenate([end[1:] for end in new]))
        skeleton = contract_branches(skeleton, new)
    return skeleton


def reroot(skeleton: Skeleton, node: int) -> Skeleton:
    """Reorder the nodes so that one comes first, where formats of rooted trees begin.

    Parameters
    ----------
    skeleton : Skeleton
    node : int

    Raises
    ------
    MeshError
        If there is no such node.
    """
    n_nodes = len(skeleton.nodes)
    if not 0 <= node < n_nodes:
        raise MeshError(f"there is no node {node} to be the root: the skeleton has nodes 0..{n_nodes - 1}")
    order = np.concatenate([[node], np.delete(np.arange(n_nodes), node)])
    return _renumbered(skeleton, order, np.argsort(order))


def _renumbered(skeleton: Skeleton, kept: NDArray[np.int64], new_index: NDArray[np.int64]) -> Skeleton:
    """Keep the nodes ``kept``, in this order; ``new_index`` has the new number of every node."""
    return replace(
        skeleton,
        nodes=skeleton.nodes[kept],
        edges=new_index[skeleton.edges],
        radii=skeleton.radii[kept],
        mean_radii=skeleton.mean_radii[kept] if len(skeleton.mean_radii) else skeleton.mean_radii,
        anchors=new_index[skeleton.anchors],
        node_of_vertex=new_index[skeleton.node_of_vertex],
    )


def append_paths(
    skeleton: Skeleton, starts: Sequence[int], paths: Sequence[NDArray[np.float64]], radii: NDArray[np.float64]
) -> Skeleton:
    """Append a path of new nodes at each of some nodes.

    Parameters
    ----------
    skeleton : Skeleton
    starts : sequence of int
        The node that each path begins at.
    paths : sequence of (k, 3) arrays of float
        Positions of the new nodes of each path, in order; an empty path adds nothing.
    radii : (sum of k,) array of float
        Radii of all new nodes.
    """
    sizes = np.array([len(path) for path in paths], dtype=np.int64)
    positions = np.concatenate([np.empty((0, 3)), *(path.reshape(-1, 3) for path in paths)])
    new, first = len(skeleton.nodes) + np.arange(len(positions)), (np.cumsum(sizes) - sizes)[sizes > 0]
    before = new - 1
    before[first] = np.asarray(starts, dtype=np.int64)[sizes > 0]
    edges = np.concatenate([skeleton.edges, np.stack([before, new], axis=1)])
    return _extended(skeleton, edges, positions, radii)


def replace_paths(
    skeleton: Skeleton,
    paths: NDArray[np.int64],
    begins: NDArray[np.int64],
    positions: NDArray[np.float64],
    new_begins: NDArray[np.int64],
    radii: NDArray[np.float64],
) -> Skeleton:
    """Replace the inner nodes of paths of the graph by new ones; vertices stay at their share of the path's length.

    Parameters
    ----------
    skeleton : Skeleton
    paths : (n,) array of int
        Nodes of p paths, one after the other; the first and the last node of each path stay. The inner nodes are of
        degree two and on no other path.
    begins : (p + 1,) array of int
        Where each begins, and the end of the last.
    positions : (k, 3) array of float
        The new inner nodes of the paths, one after the other.
    new_begins : (p + 1,) array of int
        Where those of each path begin, and the end of the last.
    radii : (k,) array of float
        Radii of the new nodes.
    """
    n_nodes, last = len(skeleton.nodes), begins[1:] - 1
    is_inner = np.ones(len(paths), dtype=bool)
    is_inner[np.concatenate([begins[:-1], last])] = False
    target = np.arange(n_nodes + len(positions))
    target[paths[is_inner]] = _at_same_share(skeleton.nodes, paths, begins, positions, new_begins)[is_inner]
    is_step = np.ones(len(paths), dtype=bool)
    is_step[last] = False
    step = np.flatnonzero(is_step)
    removed = np.sort(np.stack([paths[step], paths[step + 1]], axis=1), axis=1)
    is_kept = ~np.isin(skeleton.edges @ [n_nodes, 1], removed @ [n_nodes, 1])
    new, sizes = n_nodes + np.arange(len(positions)), np.diff(new_begins)
    before, has_new = new - 1, sizes > 0
    before[new_begins[:-1][has_new]] = paths[begins[:-1]][has_new]
    to_last = np.where(has_new, n_nodes + new_begins[1:] - 1, paths[begins[:-1]])
    added = [np.stack([before, new], axis=1), np.stack([to_last, paths[last]], axis=1)]
    edges = np.concatenate([skeleton.edges[is_kept], *added])
    return contract_nodes(_extended(skeleton, edges, positions, radii), target)


def _at_same_share(
    nodes: NDArray[np.float64],
    paths: NDArray[np.int64],
    begins: NDArray[np.int64],
    positions: NDArray[np.float64],
    new_begins: NDArray[np.int64],
) -> NDArray[np.int64]:
    """(n,) new node or end of each node of paths: the one with the nearest share of the path's length before it."""
    last, rows = begins[1:] - 1, np.arange(len(begins) - 1)
    of_new = np.repeat(rows, np.diff(new_begins))
    path = np.concatenate([rows, of_new, rows])
    order = np.argsort(path, kind="stable")
    numbers = np.concatenate([paths[begins[:-1]], len(nodes) + np.arange(len(positions)), paths[last]])[order]
    points = np.concatenate([nodes[paths[begins[:-1]]], positions, nodes[paths[last]]])[order]
    new_places = _places(points, new_begins + 2 * np.arange(len(begins)))
    places = _places(nodes[paths], begins)
    after = np.clip(np.searchsorted(new_places, places), 1, len(new_places) - 1)
    is_before = places - new_places[after - 1] < new_places[after] - places
    nearest: NDArray[np.int64] = numbers[after - is_before]
    return nearest


def _places(points: NDArray[np.float64], begins: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n,) place of each point of paths: the share of its path's length before it, plus twice the path's number."""
    steps = vector_lengths(np.diff(points, axis=0, prepend=points[:1]))
    arc_lengths, sizes = sums_along_paths(steps, begins), np.diff(begins)
    lengths = np.repeat(arc_lengths[begins[1:] - 1], sizes)
    shares = np.divide(arc_lengths, lengths, out=np.zeros(len(points)), where=lengths > 0)
    shares[begins[1:] - 1] = 1.0
    places: NDArray[np.float64] = shares + 2.0 * np.repeat(np.arange(len(sizes)), sizes)
    return places


def split_edge(skeleton: Skeleton, edge: int, position: NDArray[np.float64], radius: float) -> Skeleton:
    """Insert a node into an edge.

    Parameters
    ----------
    skeleton : Skeleton
    edge : int
        Row in ``edges``.
    position : (3,) array of float
    radius : float
    """
    start, end = skeleton.edges[edge]
    new = len(skeleton.nodes)
    edges = np.concatenate([np.delete(skeleton.edges, edge, axis=0), [[start, new], [end, new]]])
    return _extended(skeleton, edges, position[None], np.array([radius]))


def concatenate(skeletons: Sequence[Skeleton]) -> Skeleton:
    """Combine several skeletons to one graph, with their nodes in order.

    The ``node_of_vertex`` are concatenated too, for the concatenated vertices of their meshes; the result has none if
    one of the skeletons has none. The same holds for ``mean_radii``. Reports are dropped.

    Parameters
    ----------
    skeletons : sequence of Skeleton

    Raises
    ------
    MeshError
        If there is no skeleton, or their radii are of different kinds.
    """
    kinds = {skeleton.radius_kind for skeleton in skeletons}
    if len(kinds) != 1:
        raise MeshError(
            f"only skeletons with radii of one kind can be concatenated, not of {' and '.join(sorted(kinds)) or 'none'}"
        )
    first_node = np.cumsum([0, *(len(s.nodes) for s in skeletons)])[:-1]
    numbered = list(zip(skeletons, first_node, strict=True))
    has_maps = all(len(s.node_of_vertex) for s in skeletons)
    has_mean_radii = all(len(s.mean_radii) == len(s.nodes) for s in skeletons)
    return Skeleton(
        np.concatenate([s.nodes for s in skeletons]),
        np.concatenate([s.edges + first for s, first in numbered]),
        np.concatenate([s.radii for s in skeletons]),
        np.concatenate([s.node_of_vertex + first for s, first in numbered]) if has_maps else np.empty(0, np.int64),
        radius_kind=kinds.pop(),
        mean_radii=np.concatenate([s.mean_radii for s in skeletons]) if has_mean_radii else np.empty(0),
        anchors=np.concatenate([s.anchors + first for s, first in numbered]),
    )


def _extended(
    skeleton: Skeleton, edges: NDArray[np.int64], positions: NDArray[np.float64], radii: NDArray[np.float64]
) -> Skeleton:
    """Add nodes and replace the edges."""
    return replace(
        skeleton,
        nodes=np.concatenate([skeleton.nodes, positions]),
        edges=edges,
        radii=np.concatenate([skeleton.radii, radii]),
        mean_radii=np.empty(0),
    )
