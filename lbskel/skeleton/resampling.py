"""Resampling a skeleton: nodes evenly spaced along every branch, at a given distance or of a given number.

New nodes lie on cubic Hermite curves through the present nodes, since straight pieces would cut the bends. The tangent
at a node is that of the chord between its neighbors.
"""

from __future__ import annotations

__all__ = ["require_number_of_nodes", "resample", "space_evenly"]

import heapq
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.traversal import sums_along_paths
from lbskel.errors import UnknownChoice, checked_count, is_number
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import group_medians, split_at
from lbskel.skeleton.editing import replace_paths
from lbskel.skeleton.joining import without_joining_edges
from lbskel.skeleton.skeleton import Skeleton

Polylines: TypeAlias = list[NDArray[np.float64]]
Mask: TypeAlias = NDArray[np.bool_]

# Local radii per piece above which a resampling that removes every inner node is taken for one whose spacing was meant
# as a length; a guess, with no effect from 7 to 14 in benchmarks/results/constants.md
MAX_SPACING = 10.0
# Upper bound on the new pieces per present edge in `space_evenly`, for flat parts whose radii are near zero; a guess
MAX_REFINEMENT = 3
# Upper bound on a number of nodes, or on that of a spacing. It bounds the memory: a node and its edge take 56 bytes in
# the arrays of a skeleton, so that it has at most half a gigabyte
MAX_NODES = 10_000_000


@dataclass(frozen=True, eq=False)
class _Paths:
    """Polylines of nodes between two that are kept, laid end to end.

    Path k has ``nodes[begins[k] : begins[k + 1]]``. ``arc_lengths`` is the distance along it to each of its nodes,
    ``lengths`` that of each whole path, and ``min_pieces`` the number of pieces that keeps the topology.
    """

    nodes: NDArray[np.int64]
    begins: NDArray[np.int64]
    arc_lengths: NDArray[np.float64]
    lengths: NDArray[np.float64]
    min_pieces: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.lengths)

    @property
    def sizes(self) -> NDArray[np.int64]:
        """(p,) number of nodes of each path."""
        return np.diff(self.begins)

    @property
    def path_of_node(self) -> NDArray[np.int64]:
        """(n,) number of the path of each row of ``nodes``."""
        return np.repeat(np.arange(len(self)), self.sizes)


def resample(skeleton: Skeleton, *, spacing: float | None = None, n_nodes: int | None = None) -> Skeleton:
    """Space the nodes evenly along each branch; junctions, tips, loops and what joins bodies are kept.

    So are anchors and the first node, which is the root of a tree and may be within a branch, as a soma.

    Parameters
    ----------
    skeleton : Skeleton
    spacing : float, optional
        Distance between nodes to aim at, as a multiple of the median radius of each branch. It is not a length: give
        0.5 for two nodes per local radius. A branch without thickness keeps its number of nodes.
    n_nodes : int, optional
        Number of nodes to have instead, at about the same distance everywhere.

    Raises
    ------
    UnknownChoice
        If not exactly one of the two is given; if the spacing is not positive, so small that there would be more than
        ten million nodes, or above 10 and so large that no inner node of a branch would be left; if ``n_nodes`` is not
        a whole number, so small that these nodes and loops cannot be kept, or another than that of a skeleton without
        branches.

    Examples
    --------
    >>> from lbskel import Skeleton, resample
    >>> path = Skeleton([[0, 0, 0], [1, 0, 0], [4, 0, 0]], [[0, 1], [1, 2]], [1.0, 1.0, 1.0])
    >>> resample(path, n_nodes=5).nodes[:, 0]
    array([0., 4., 1., 2., 3.])
    >>> resample(path, spacing=2.0).nodes[:, 0]
    array([0., 4., 2.])
    """
    if (spacing is None) == (n_nodes is None):
        raise UnknownChoice("give either spacing or n_nodes")
    return without_joining_edges(partial(_resampled, spacing=spacing, n_nodes=n_nodes), skeleton)


def _resampled(skeleton: Skeleton, *, spacing: float | None, n_nodes: int | None) -> Skeleton:
    """Space the nodes evenly, by the one that is given."""
    paths = _paths(skeleton)
    if spacing is not None:
        counts = _counts_for_spacing(skeleton, paths, spacing, shortest=0.0)
    else:
        counts = _counts_for_number(skeleton, paths, n_nodes)
    return _divided(skeleton, paths, counts)


def space_evenly(skeleton: Skeleton, spacing: float, stays: Callable[[Polylines, Polylines], Mask]) -> Skeleton:
    """Resample branches; those that may not change only get nodes on their chords, where their own are far apart.

    A branch gets at most three pieces per present edge: just as many where its radii are zero, and those that it has
    where it has no length.

    Parameters
    ----------
    skeleton : Skeleton
    spacing : float
        As for :func:`resample`.
    stays : callable
        From the present polylines and the new inner nodes of p paths, to a (p,) array of bool: which paths may not
        change.
    """
    paths = _paths(skeleton)
    shortest = paths.lengths / (MAX_REFINEMENT * (paths.sizes - 1))
    return _divided(skeleton, paths, _counts_for_spacing(skeleton, paths, spacing, shortest), stays)


def require_number_of_nodes(n_nodes: Any) -> int:
    """Return a number of nodes; raise UnknownChoice if it is not a whole number from 1 to MAX_NODES."""
    return checked_count(n_nodes, "n_nodes", 1, MAX_NODES)


def _paths(skeleton: Skeleton) -> _Paths:
    """Split the branches at anchors; a loop needs three pieces, and of two paths with the same ends one needs two."""
    nodes, begins = skeleton.flat_branches
    is_anchor = np.zeros(len(skeleton.nodes), dtype=bool)
    is_anchor[skeleton.anchors] = True
    is_split = is_anchor[nodes]
    is_split[np.concatenate([begins[:-1], begins[1:] - 1])] = False
    rows = np.repeat(np.arange(len(nodes)), 1 + is_split)  # an anchor ends a path and begins the next
    again = np.flatnonzero(is_split) + np.arange(1, 1 + np.count_nonzero(is_split))
    begins = np.sort(np.concatenate([begins + np.searchsorted(np.flatnonzero(is_split), begins), again]))
    nodes = nodes[rows]
    steps = vector_lengths(np.diff(skeleton.nodes[nodes], axis=0, prepend=skeleton.nodes[nodes[:1]]))
    arc_lengths, last = sums_along_paths(steps, begins), begins[1:] - 1
    ends = np.sort(np.stack([nodes[begins[:-1]], nodes[last]], axis=1), axis=1)
    is_first = np.zeros(len(ends), dtype=bool)
    is_first[np.unique(ends @ [len(skeleton.nodes), 1], return_index=True)[1]] = True
    min_pieces = np.where(ends[:, 0] == ends[:, 1], 3, np.where(is_first, 1, 2))
    return _Paths(nodes, begins, arc_lengths, arc_lengths[last], min_pieces)


def _counts_for_spacing(
    skeleton: Skeleton, paths: _Paths, spacing: float, shortest: NDArray[np.float64] | float
) -> NDArray[np.int64]:
    """(p,) number of pieces of each path for a spacing in median radii of the path, none below a shortest length."""
    if not (is_number(spacing) and spacing > 0):
        raise UnknownChoice(f"spacing must be positive, in local radii, not {spacing!r}")
    if np.isnan(skeleton.radii[paths.nodes]).any():
        raise UnknownChoice("spacing is in local radii, which the skeleton does not have at all nodes; give n_nodes")
    pieces = np.maximum(spacing * group_medians(skeleton.radii[paths.nodes], paths.begins), shortest)
    present = paths.sizes - 1.0  # what a path without thickness keeps, as that of a sheet
    numbers = np.rint(np.divide(paths.lengths, pieces, out=present, where=pieces > 0))
    if not numbers.sum() <= MAX_NODES:
        raise UnknownChoice(
            f"spacing is in local radii, and {spacing} of them give more than {MAX_NODES:,} nodes; give n_nodes"
        )
    counts = np.asarray(np.maximum(numbers.astype(np.int64), paths.min_pieces))
    removes_all = (counts == paths.min_pieces).all()
    if spacing > MAX_SPACING and removes_all and (paths.sizes - 1 > paths.min_pieces).any():
        raise UnknownChoice(
            f"spacing is in local radii, and {spacing} of them are longer than every branch; for a distance d in the "
            f"skeleton's units give d / {float(np.median(skeleton.radii)):.3g}, which is its median radius"
        )
    return counts


def _counts_for_number(skeleton: Skeleton, paths: _Paths, n_nodes: Any) -> NDArray[np.int64]:
    """(p,) number of pieces of each path for a total number of nodes; the longest piece is divided first."""
    n_asked = require_number_of_nodes(n_nodes)
    counts, lengths = paths.min_pieces.tolist(), paths.lengths.tolist()
    n_min = len(_kept_nodes(skeleton, paths)) + sum(counts) - len(counts)
    if n_asked < n_min:
        raise UnknownChoice(
            f"n_nodes must be at least {n_min} to keep every junction, tip, anchor, loop and the first node; "
            "a larger min_branch_ratio leaves fewer branches"
        )
    if n_asked > n_min and not counts:
        raise UnknownChoice(f"n_nodes must be {n_min} for a skeleton without branches, which has nothing to divide")
    queue = [(-length / count, index) for index, (length, count) in enumerate(zip(lengths, counts, strict=True))]
    heapq.heapify(queue)
    for _ in range(n_asked - n_min):
        _, index = queue[0]
        counts[index] += 1
        heapq.heapreplace(queue, (-lengths[index] / counts[index], index))
    return np.array(counts, dtype=np.int64)


def _kept_nodes(skeleton: Skeleton, paths: _Paths) -> NDArray[np.int64]:
    """Find the nodes that stay: junctions, tips, isolated nodes, anchors, ends of all paths; in ascending order."""
    is_kept = skeleton.degrees != 2
    is_kept[skeleton.anchors] = True
    is_kept[paths.nodes[np.concatenate([paths.begins[:-1], paths.begins[1:] - 1])]] = True
    return np.flatnonzero(is_kept)


def _divided(
    skeleton: Skeleton,
    paths: _Paths,
    counts: NDArray[np.int64],
    stays: Callable[[Polylines, Polylines], Mask] | None = None,
) -> Skeleton:
    """Divide every path evenly, on its chords if it may not leave them; vertices stay at their share of its length."""
    has_mean_radii = len(skeleton.mean_radii) > 0
    values = np.column_stack([skeleton.nodes, skeleton.radii, *([skeleton.mean_radii] if has_mean_radii else [])])
    inner, new_begins = _interpolated(values, paths, counts), np.concatenate([[0], np.cumsum(counts - 1)])
    if stays is not None and len(paths):
        present, parts = split_at(values[paths.nodes], paths.begins[1:-1]), split_at(inner, new_begins[1:-1])
        must_stay = stays([path[:, :3] for path in present], [part[:, :3] for part in parts])
        for row in np.flatnonzero(must_stay).tolist():
            parts[row] = _on_chords(present[row], paths.lengths[row] / counts[row])
        inner, new_begins = np.concatenate(parts), np.concatenate([[0], np.cumsum([len(part) for part in parts])])
    resampled = replace_paths(skeleton, paths.nodes, paths.begins, inner[:, :3], new_begins, inner[:, 3])
    if not has_mean_radii:
        return resampled
    return replace(resampled, mean_radii=np.concatenate([values[_kept_nodes(skeleton, paths)], inner])[:, 4])


def _on_chords(values: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """Values at the inner nodes of a path and at points between them, where they are farther apart than a length."""
    steps = vector_lengths(np.diff(values[:, :3], axis=0))
    n_pieces = np.maximum(np.rint(steps / length), 1).astype(np.int64) if length > 0 else np.ones(len(steps), np.int64)
    at = np.repeat(np.arange(len(steps)), n_pieces)
    share = ((np.arange(len(at)) - np.repeat(np.cumsum(n_pieces) - n_pieces, n_pieces)) / n_pieces[at])[:, None]
    divided: NDArray[np.float64] = (1 - share) * values[at] + share * values[at + 1]
    return divided[1:]


def _interpolated(values: NDArray[np.float64], paths: _Paths, counts: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k, d) values at the inner points that divide each path: positions on a cubic curve, the rest linear.

    One search finds the piece of each point on all paths. The tangent at a node is that of the chord between its
    neighbors, so that short pieces beside long ones do not make the curve overshoot. A path with a piece of no length
    is divided on its chords.
    """
    if len(paths) == 0:
        return np.empty((0, values.shape[1]))
    rows, sizes, lengths, begin = paths.nodes, paths.sizes, paths.lengths, paths.begins[:-1]
    arc, number = paths.arc_lengths, paths.path_of_node
    of_point = np.repeat(np.arange(len(paths)), counts - 1)
    step = np.arange(len(of_point)) - np.repeat(np.cumsum(counts - 1) - counts + 1, counts - 1) + 1
    at = lengths[of_point] * step / counts[of_point]
    shares = np.divide(arc, lengths[number], out=np.zeros_like(arc), where=lengths[number] > 0) + number * 2.0
    share_at = np.divide(at, lengths[of_point], out=np.zeros_like(at), where=lengths[of_point] > 0) + of_point * 2.0
    left = np.clip(np.searchsorted(shares, share_at, side="right") - 1, begin[of_point], (begin + sizes - 2)[of_point])
    width = arc[left + 1] - arc[left]
    t = np.divide(at - arc[left], width, out=np.zeros_like(at), where=width > 0)[:, None]
    start, end = values[rows[left]], values[rows[left + 1]]
    result: NDArray[np.float64] = (1 - t) * start + t * end
    is_ring = (rows[begin] == rows[begin + sizes - 1]) & (np.bincount(rows, minlength=len(values))[rows[begin]] == 2)
    tangents, is_smooth = _tangents(values[rows, :3], arc, begin, sizes, is_ring)
    cubic = is_smooth[of_point]
    t, h = t[cubic], width[cubic, None]
    offset = (t - 1) * tangents[left[cubic]] * h + t * tangents[left[cubic] + 1] * h
    chord = (end - start)[cubic, :3]
    result[cubic, :3] += t * (1 - t) * ((2 * t - 1) * chord - offset)
    return result


def _tangents(
    P: NDArray[np.float64],
    arc: NDArray[np.float64],
    begin: NDArray[np.int64],
    sizes: NDArray[np.int64],
    is_ring: NDArray[np.bool_],
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """(n, 3) derivatives by arc length on paths laid end to end, and for each path whether it has any to use."""
    h = np.diff(arc)
    last = begin + sizes - 1
    is_piece = np.ones(len(h), dtype=bool)
    is_piece[last[:-1]] = False
    is_smooth = (sizes > 2) & (np.bincount(np.repeat(np.arange(len(sizes)), sizes)[:-1], is_piece & ~(h > 0)) == 0)
    slope = np.divide(np.diff(P, axis=0), h[:, None], out=np.zeros((len(h), 3)), where=(is_piece & (h > 0))[:, None])
    tangents = np.zeros_like(P)
    total = np.where(h[:-1] + h[1:] > 0, h[:-1] + h[1:], 1.0)[:, None]
    tangents[1:-1] = (P[2:] - P[:-2]) / total
    tangents[begin], tangents[last] = slope[begin], slope[last - 1]
    first, end = begin[is_ring], last[is_ring]
    total = np.where(h[first] + h[end - 1] > 0, h[first] + h[end - 1], 1.0)[:, None]
    tangents[first] = tangents[end] = (P[first + 1] - P[end - 1]) / total
    return tangents, is_smooth
