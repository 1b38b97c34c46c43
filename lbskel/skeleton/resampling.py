"""Resampling a skeleton: nodes evenly spaced along every branch, by a distance or to a number.

New nodes lie on cubic curves through the old ones, with directions there by differences: chords would cut its bends.
"""

from __future__ import annotations

__all__ = ["resample"]

import heapq
import itertools
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from lbskel.errors import UnknownChoice
from lbskel.skeleton.skeleton import Skeleton

FINER = 4  # pieces at most for each that a branch had: what is flat has no radius to go by


@dataclass(frozen=True, eq=False)
class _Path:
    """A polyline of nodes between two that stay, how far along each of them lies, and its fewest pieces."""

    nodes: NDArray[np.int64]
    along: NDArray[np.float64]
    fewest: int

    @property
    def length(self) -> float:
        return float(self.along[-1])


def resample(skeleton: Skeleton, *, spacing: float | None = None, n_nodes: int | None = None) -> Skeleton:
    """Space the nodes evenly along each branch; junctions, tips, anchors and loops stay.

    Parameters
    ----------
    skeleton : Skeleton
    spacing : float, optional
        Distance between nodes aimed at, in median radii of each branch.
    n_nodes : int, optional
        Number of nodes to have instead, at about one distance everywhere.

    Raises
    ------
    UnknownChoice
        If not just one of the two is given, the spacing is not positive, or so few nodes cannot keep the junctions,
        tips, anchors and loops.

    Examples
    --------
    >>> from lbskel import Skeleton, resample
    >>> path = Skeleton([[0, 0, 0], [1, 0, 0], [4, 0, 0]], [[0, 1], [1, 2]], [1.0, 1.0, 1.0])
    >>> resample(path, n_nodes=5).nodes[:, 0]
    array([0., 4., 1., 2., 3.])
    """
    if (spacing is None) == (n_nodes is None):
        raise UnknownChoice("give either spacing or n_nodes")
    paths = _paths(skeleton)
    fixed = np.flatnonzero(skeleton.degrees != 2)
    ends = [path.nodes[[0, -1]] for path in paths]
    fixed = np.unique(np.concatenate([fixed, skeleton.anchors, *ends]))
    if spacing is not None:
        counts = _counts_for_spacing(skeleton, paths, spacing)
    else:
        counts = _counts_for_number(paths, int(n_nodes or 0) - len(fixed), len(fixed))
    return _divided(skeleton, fixed, paths, counts)


def _paths(skeleton: Skeleton) -> list[_Path]:
    """The branches, cut at anchors; a loop needs three pieces, and of two paths with the same ends one needs two."""
    is_anchor = np.zeros(len(skeleton.nodes), dtype=bool)
    is_anchor[skeleton.anchors] = True
    paths, seen = [], set()
    for branch in skeleton.branches:
        stops = np.unique([0, *np.flatnonzero(is_anchor[branch]), len(branch) - 1])
        for first, last in itertools.pairwise(stops.tolist()):
            nodes = branch[first : last + 1]
            steps = np.linalg.norm(np.diff(skeleton.nodes[nodes], axis=0), axis=1)
            ends = frozenset((int(nodes[0]), int(nodes[-1])))
            fewest = 3 if len(ends) == 1 else 2 if ends in seen else 1
            seen.add(ends)
            paths.append(_Path(nodes, np.concatenate([[0.0], np.cumsum(steps)]), fewest))
    return paths


def _counts_for_spacing(skeleton: Skeleton, paths: list[_Path], spacing: float) -> list[int]:
    """How many pieces each path is divided into, by the radii along it."""
    if not spacing > 0:
        raise UnknownChoice(f"spacing must be positive, not {spacing}")
    counts = []
    for path in paths:
        radius = float(np.median(skeleton.radii[path.nodes]))
        apart = max(spacing * radius, path.length / (FINER * (len(path.nodes) - 1)))
        counts.append(max(path.fewest, round(path.length / apart)) if apart > 0 else path.fewest)
    return counts


def _counts_for_number(paths: list[_Path], n_free: int, n_fixed: int) -> list[int]:
    """How many pieces each path is divided into for so many nodes beside the fixed ones, the longest piece first."""
    counts = [path.fewest for path in paths]
    n_free -= sum(counts) - len(counts)
    if n_free < 0:
        fewest = n_fixed + sum(counts) - len(counts)
        raise UnknownChoice(
            f"n_nodes must be at least {fewest} to keep every junction, tip, anchor and loop; prune the skeleton first"
        )
    queue = [(-path.length / count, index) for index, (path, count) in enumerate(zip(paths, counts, strict=True))]
    heapq.heapify(queue)
    for _ in range(n_free if queue else 0):
        _, index = queue[0]
        counts[index] += 1
        heapq.heapreplace(queue, (-paths[index].length / counts[index], index))
    return counts


def _divided(skeleton: Skeleton, fixed: NDArray[np.int64], paths: list[_Path], counts: list[int]) -> Skeleton:
    """The skeleton with every path divided evenly; a vertex stays with what is nearest to its node along the path."""
    new_of = np.full(len(skeleton.nodes), -1)
    new_of[fixed] = np.arange(len(fixed))
    values = np.column_stack(
        [skeleton.nodes, skeleton.radii, *([skeleton.mean_radii] if len(skeleton.mean_radii) else [])]
    )
    rows, edges, n_nodes = [values[fixed]], [np.empty((0, 2), dtype=np.int64)], len(fixed)
    for path, count in zip(paths, counts, strict=True):
        inner = np.linspace(0, path.length, count + 1)[1:-1]
        rows.append(_between(path.along, values[path.nodes], inner))
        chain = np.concatenate([new_of[path.nodes[:1]], n_nodes + np.arange(count - 1), new_of[path.nodes[-1:]]])
        n_nodes += count - 1
        edges.append(np.stack([chain[:-1], chain[1:]], axis=1))
        share = path.along[1:-1] / path.length if path.length > 0 else np.zeros(len(path.nodes) - 2)
        new_of[path.nodes[1:-1]] = chain[np.rint(share * count).astype(np.int64)]
    values = np.concatenate(rows)
    return replace(
        skeleton,
        nodes=values[:, :3],
        edges=np.concatenate(edges),
        radii=values[:, 3],
        mean_radii=values[:, 4] if values.shape[1] > 4 else skeleton.mean_radii,
        anchors=new_of[skeleton.anchors],
        node_of_vertex=new_of[skeleton.node_of_vertex],
    )


def _between(along: NDArray[np.float64], values: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, d) values at some places of a path, and positions on a curve through its nodes."""
    linear = np.stack([np.interp(at, along, column) for column in values.T], axis=1)
    if len(along) > 2 and (np.diff(along) > 0).all():
        P = values[:, :3]
        linear[:, :3] = CubicHermiteSpline(along, P, np.gradient(P, along, axis=0))(at)
    return linear
