"""SWC, the format of neuron tracings: a line per node with id, type, position, radius and the id of its parent.

Ids count from 1, every parent stands before its children, a root's parent is -1, one root per component. Types: 5 at
a fork, 6 at an end, 0 elsewhere. SWC holds trees; the edges that were cut to make one are noted as comments
``# cut edge 7 12``, which other programs pass over and reading restores. A radius that is not known is written as 0.
Format: Cannon et al. 1998, https://doi.org/10.1016/S0165-0270(98)00091-0
"""

from __future__ import annotations

__all__ = ["read_swc", "skeleton_swc"]

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import depth_first_order, minimum_spanning_tree

from lbskel.errors import FormatError
from lbskel.geometry.graphs import weighted_graph
from lbskel.io.text import as_integers, lines_of, read_text, table
from lbskel.skeleton.skeleton import Skeleton

FORK, END, OTHER = 5, 6, 0
NO_PARENT = -1
CUT_EDGE = re.compile(r"#\s*cut edge (\d{1,15}) (\d{1,15})\s*")
RADIUS_KIND = re.compile(r"#\s*radius_kind (.+)")


def skeleton_swc(
    skeleton: Skeleton, path: Path, *, cut_cycles: bool = False, root: int | None = None
) -> dict[Path, str]:
    """A skeleton as SWC text.

    Parameters
    ----------
    skeleton : Skeleton
    path : Path
        Where it shall be written.
    cut_cycles : bool
        Whether each cycle may be cut at its longest edge; the cut edges are noted as comments.
    root : int, optional
        The node that is the root of its component. Else, and in other components, the first node is.

    Raises
    ------
    FormatError
        If the skeleton has cycles and ``cut_cycles`` is not set, or there is no such root.
    """
    if skeleton.cycle_rank and not cut_cycles:
        raise FormatError(
            f"the skeleton has {skeleton.cycle_rank} cycles and SWC holds trees only; cut_cycles=True (--cut-cycles on "
            "the command line) cuts each at its longest edge and notes the cuts as comments; other formats keep them"
        )
    k = len(skeleton.nodes)
    if root is not None and not 0 <= root < k:
        raise FormatError(f"there is no node {root} to be the root; the nodes are 0 to {k - 1}")
    kept = _spanning_edges(skeleton)
    order, parents = _parents_first(skeleton, skeleton.edges[kept], root)
    ids = np.empty(k, dtype=np.int64)
    ids[order] = np.arange(1, k + 1)
    kinds = np.select([skeleton.degrees >= 3, skeleton.degrees == 1], [FORK, END], OTHER)
    radii = np.where(np.isnan(skeleton.radii), 0.0, skeleton.radii)
    lines = [f"# radius_kind {' '.join(skeleton.radius_kind.split())}", "# id type x y z radius parent"]
    for node in order.tolist():
        x, y, z = skeleton.nodes[node].tolist()
        parent = NO_PARENT if parents[node] < 0 else ids[parents[node]]
        lines.append(f"{ids[node]} {kinds[node]} {x!r} {y!r} {z!r} {radii[node].item()!r} {parent}")
    lines += [f"# cut edge {start} {end}" for start, end in np.sort(ids[skeleton.edges[~kept]], axis=1)]
    return {path: "\n".join(lines) + "\n"}


def _spanning_edges(skeleton: Skeleton) -> NDArray[np.bool_]:
    """Which edges to keep so that no cycle is left: of each cycle the longest goes, the later one of equals.

    This is the minimum spanning forest; ranks in place of lengths make it unique and give every edge a weight > 0.
    """
    k, rank = len(skeleton.nodes), np.empty(len(skeleton.edges), dtype=np.int64)
    rank[np.argsort(skeleton.edge_lengths, kind="stable")] = np.arange(1, len(rank) + 1)
    forest = minimum_spanning_tree(weighted_graph(skeleton.edges, rank, k))
    return np.isin(rank, forest.data)


def _parents_first(
    skeleton: Skeleton, edges: NDArray[np.int64], root: int | None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """An order of the nodes in which each follows its parent, and the parent of each node, -1 for roots."""
    k, label = len(skeleton.nodes), skeleton.component_of_node
    roots = np.unique(label, return_index=True)[1]
    if root is not None:
        roots[label[root]] = root
    # A node above all roots makes one tree of the forest, so that a single walk orders it.
    downward = np.stack([np.full(len(roots), k), roots], axis=1)
    pairs = np.concatenate([edges, edges[:, ::-1], downward])
    order, parents = depth_first_order(weighted_graph(pairs, np.ones(len(pairs)), k + 1), k)
    return order[1:], np.where(parents[:k] == k, NO_PARENT, parents[:k])


def read_swc(path: Path) -> Skeleton:
    """The skeleton in an SWC file, nodes in the order of the lines, noted cuts undone."""
    text = read_text(path)
    lines = lines_of(text)
    rows = table(lines, range(7), "id, type, x, y, z, radius and parent")
    ids, parents = (as_integers(rows[:, column], what, lines.numbers) for column, what in ((0, "ids"), (6, "parents")))
    unique, first = np.unique(ids, return_index=True)
    for row in np.setdiff1d(np.arange(len(ids)), first)[:1]:
        raise FormatError(f"line {lines.numbers[row]}: the id {ids[row]} was given before")
    children = np.flatnonzero(parents != NO_PARENT)
    pairs = np.stack([ids[children], parents[children]], axis=1)
    comments = [line.strip() for line in text.splitlines() if line.lstrip().startswith("#")]
    cuts = [[int(end) for end in match.groups()] for match in map(CUT_EDGE.fullmatch, comments) if match]
    places = [f"line {lines.numbers[child]}: its parent" for child in children] + ["a cut edge: its node"] * len(cuts)
    pairs = np.concatenate([pairs, np.array(cuts, dtype=np.int64).reshape(-1, 2)])
    for row in np.flatnonzero(~np.isin(pairs, ids).all(axis=1))[:1]:
        raise FormatError(f"{places[row]} {np.setdiff1d(pairs[row], ids)[0]} does not exist")
    kinds = [match.group(1) for match in map(RADIUS_KIND.fullmatch, comments) if match]
    return Skeleton(
        rows[:, 2:5],
        first[np.searchsorted(unique, pairs)],
        rows[:, 5],
        radius_kind=next(iter(kinds), Skeleton.radius_kind),
    )
