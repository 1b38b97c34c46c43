"""Resampling a skeleton: nodes evenly spaced along every branch, at a given distance or of a given number.

New nodes lie on cubic Hermite curves through the present nodes, since straight pieces would cut the bends. The tangent
at a node is that of the chord between its neighbors.
"""

from __future__ import annotations

__all__ = ["resample"]

import heapq
import itertools
import operator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice
from lbskel.skeleton.editing import replace_paths
from lbskel.skeleton.skeleton import Skeleton

MAX_SPACING = (
    10.0  # local radii per piece above which a resampling that removes every inner node is taken for one whose
)
# spacing was meant as a length; a guess
MAX_REFINEMENT = 3  # upper bound on the new pieces per present edge, for flat parts whose radii are near zero; a guess


@dataclass(frozen=True, eq=False)
class _Path:
    """A polyline of nodes between two that are kept.

    ``arc_length`` is the distance along it to each of its nodes, and ``min_pieces`` the number of pieces that keeps the
    topology.
    """

    nodes: NDArray[np.int64]
    arc_length: NDArray[np.float64]
    min_pieces: int

    @property
    def length(self) -> float:
        return float(self.arc_length[-1])


def resample(skeleton: Skeleton, *, spacing: float | None = None, n_nodes: int | None = None) -> Skeleton:
    """Space the nodes evenly along each branch; junctions, tips, anchors and loops are kept.

    Parameters
    ----------
    skeleton : Skeleton
    spacing : float, optional
        Distance between nodes to aim at, as a multiple of the median radius of each branch. It is not a length: give
        0.5 for two nodes per local radius.
    n_nodes : int, optional
        Number of nodes to have instead, at about the same distance everywhere.

    Raises
    ------
    UnknownChoice
        If not exactly one of the two is given; if the spacing is not positive, or above 10 and so large that no inner
        node of a branch would be left; or if so few nodes cannot keep the junctions, tips, anchors and loops.

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
    paths = _paths(skeleton)
    if spacing is not None:
        counts = _counts_for_spacing(skeleton, paths, spacing)
    else:
        counts = _counts_for_number(skeleton, paths, n_nodes)
    return _divided(skeleton, paths, counts)


def _paths(skeleton: Skeleton) -> list[_Path]:
    """Split the branches at anchors; a loop needs three pieces, and of two paths with the same ends one needs two."""
    is_anchor = np.zeros(len(skeleton.nodes), dtype=bool)
    is_anchor[skeleton.anchors] = True
    paths, seen = [], set()
    for branch in skeleton.branches:
        stops = np.unique([0, *np.flatnonzero(is_anchor[branch]), len(branch) - 1])
        for first, last in itertools.pairwise(stops.tolist()):
            nodes = branch[first : last + 1]
            lengths = np.linalg.norm(np.diff(skeleton.nodes[nodes], axis=0), axis=1)
            ends = frozenset((int(nodes[0]), int(nodes[-1])))
            min_pieces = 3 if len(ends) == 1 else 2 if ends in seen else 1
            seen.add(ends)
            paths.append(_Path(nodes, np.concatenate([[0.0], np.cumsum(lengths)]), min_pieces))
    return paths


def _counts_for_spacing(skeleton: Skeleton, paths: list[_Path], spacing: float) -> list[int]:
    """Count the pieces of each path for a spacing in median radii of the path."""
    if not spacing > 0:
        raise UnknownChoice(f"spacing must be positive, in local radii, not {spacing}")
    counts = []
    for path in paths:
        radius = float(np.median(skeleton.radii[path.nodes]))
        piece = max(spacing * radius, path.length / (MAX_REFINEMENT * (len(path.nodes) - 1)))
        counts.append(max(path.min_pieces, round(path.length / piece)) if piece > 0 else path.min_pieces)
    removes_all = all(count == path.min_pieces for path, count in zip(paths, counts, strict=True))
    if spacing > MAX_SPACING and removes_all and any(len(path.nodes) - 1 > path.min_pieces for path in paths):
        raise UnknownChoice(
            f"spacing is in local radii, and {spacing} of them are longer than every branch; for a distance d in the "
            f"skeleton's units give d / {float(np.median(skeleton.radii)):.3g}, which is its median radius"
        )
    return counts


def _counts_for_number(skeleton: Skeleton, paths: list[_Path], n_nodes: Any) -> list[int]:
    """Count the pieces of each path for a total number of nodes; the longest piece is divided first."""
    try:
        n_asked = operator.index(n_nodes)
    except TypeError:
        raise UnknownChoice(f"n_nodes must be a whole number, not {n_nodes!r}") from None
    counts = [path.min_pieces for path in paths]
    n_min = len(_kept_nodes(skeleton, paths)) + sum(counts) - len(counts)
    if n_asked < n_min:
        raise UnknownChoice(
            f"n_nodes must be at least {n_min} to keep every junction, tip, anchor and loop; prune the skeleton first"
        )
    queue = [(-path.length / count, index) for index, (path, count) in enumerate(zip(paths, counts, strict=True))]
    heapq.heapify(queue)
    for _ in range(n_asked - n_min if queue else 0):
        _, index = queue[0]
        counts[index] += 1
        heapq.heapreplace(queue, (-paths[index].length / counts[index], index))
    return counts


def _kept_nodes(skeleton: Skeleton, paths: list[_Path]) -> NDArray[np.int64]:
    """Find the nodes that stay: junctions, tips, isolated nodes, anchors, ends of all paths; in ascending order."""
    ends = [path.nodes[[0, -1]] for path in paths]
    return np.unique(np.concatenate([np.flatnonzero(skeleton.degrees != 2), skeleton.anchors, *ends]))


def _divided(skeleton: Skeleton, paths: list[_Path], counts: list[int]) -> Skeleton:
    """Divide every path evenly; vertices go to the new node nearest to theirs along the path."""
    has_mean_radii = len(skeleton.mean_radii) > 0
    values = np.column_stack([skeleton.nodes, skeleton.radii, *([skeleton.mean_radii] if has_mean_radii else [])])
    kept = _kept_nodes(skeleton, paths)
    new_index = np.full(len(skeleton.nodes), -1)
    new_index[kept] = np.arange(len(kept))
    n_nodes = len(kept)
    for path, count in zip(paths, counts, strict=True):
        chain = np.concatenate([new_index[path.nodes[:1]], n_nodes + np.arange(count - 1), new_index[path.nodes[-1:]]])
        n_nodes += count - 1
        share = path.arc_length[1:-1] / path.length if path.length > 0 else np.zeros(len(path.nodes) - 2)
        new_index[path.nodes[1:-1]] = chain[np.rint(share * count).astype(np.int64)]
    inner = _interpolated(values, paths, counts)
    ends = np.cumsum([count - 1 for count in counts])
    positions = np.split(inner[:, :3], ends[:-1]) if paths else []
    resampled = replace_paths(skeleton, [path.nodes for path in paths], positions, inner[:, 3])
    return replace(
        resampled,
        mean_radii=np.concatenate([values[kept], inner])[:, 4] if has_mean_radii else np.empty(0),
        node_of_vertex=new_index[skeleton.node_of_vertex],
    )


def _interpolated(values: NDArray[np.float64], paths: list[_Path], counts: list[int]) -> NDArray[np.float64]:
    """(k, d) values at the inner points that divide each path: positions on a cubic curve, the rest linear.

    All paths are laid end to end, so that one search finds the piece of each point. The tangent at a node is that of
    the chord between its neighbors, so that short pieces beside long ones do not make the curve overshoot. A path with
    a piece of no length is divided on its chords.
    """
    if not paths:
        return np.empty((0, values.shape[1]))
    rows = np.concatenate([path.nodes for path in paths])
    sizes, lengths = np.array([len(path.nodes) for path in paths]), np.array([path.length for path in paths])
    begin = np.cumsum(sizes) - sizes
    arc = np.concatenate([path.arc_length for path in paths])
    number = np.repeat(np.arange(len(paths)), sizes)
    of_point = np.repeat(np.arange(len(paths)), np.array(counts) - 1)
    step = np.arange(len(of_point)) - np.repeat(np.cumsum(np.array(counts) - 1) - counts + 1, np.array(counts) - 1) + 1
    at = lengths[of_point] * step / np.array(counts)[of_point]
    shares = np.divide(arc, lengths[number], out=np.zeros_like(arc), where=lengths[number] > 0) + number * 2.0
    share_at = np.divide(at, lengths[of_point], out=np.zeros_like(at), where=lengths[of_point] > 0) + of_point * 2.0
    left = np.clip(np.searchsorted(shares, share_at, side="right") - 1, begin[of_point], (begin + sizes - 2)[of_point])
    width = arc[left + 1] - arc[left]
    t = np.divide(at - arc[left], width, out=np.zeros_like(at), where=width > 0)[:, None]
    start, end = values[rows[left]], values[rows[left + 1]]
    result: NDArray[np.float64] = (1 - t) * start + t * end
    tangents, is_smooth = _tangents(values[rows, :3], arc, begin, sizes)
    cubic = is_smooth[of_point]
    t, h = t[cubic], width[cubic, None]
    offset = (t - 1) * tangents[left[cubic]] * h + t * tangents[left[cubic] + 1] * h
    chord = (end - start)[cubic, :3]
    result[cubic, :3] += t * (1 - t) * ((2 * t - 1) * chord - offset)
    return result


def _tangents(
    P: NDArray[np.float64], arc: NDArray[np.float64], begin: NDArray[np.int64], sizes: NDArray[np.int64]
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
    return tangents, is_smooth
