"""Labels of faces of least energy: graph cuts that move the boundaries of parts to short, concave paths of edges.

The energy of a labeling is the sum of the costs of the faces' labels, plus the sum of the costs of the edges between
faces of different labels. A move gives one label to any set of faces. The best move of each label is made in turn until
none lowers the energy: Boykov, Veksler, Zabih 2001, "Fast approximate energy minimization via graph cuts",
https://doi.org/10.1109/34.969114. The best move is a minimum cut of the graph of Kolmogorov, Zabih 2004, "What energy
functions can be minimized via graph cuts?", https://doi.org/10.1109/TPAMI.2004.1262177.
"""

from __future__ import annotations

__all__ = ["expand_labels"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

MAX_ROUNDS = 4  # rounds of one move for each label; a guess, the third seldom changes anything
LARGEST = 2**30  # bound on the sum of all capacities, which are whole numbers of 32 bits


def expand_labels(
    labels: NDArray[np.int64], costs: csr_array, pairs: NDArray[np.int64], weights: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Lower the energy of labels by moves of one label at a time.

    Parameters
    ----------
    labels : (m,) array of int
        Initial label of each face, from 0 to c - 1, with a cost.
    costs : (m, c) csr_array
        Cost of each label at each face, not negative; a face cannot have a label whose cost is not stored.
    pairs : (p, 2) array of int
        Neighboring faces.
    weights : (p,) array of float
        Cost of different labels at a pair, not negative.

    Returns
    -------
    (m,) array of int
        Labels, after at most MAX_ROUNDS rounds.
    """
    total = 4 * weights.sum() + costs.max(axis=1).toarray().sum()
    if costs.shape[1] < 2 or not total > 0:
        return labels
    moves = _Moves(labels, costs, pairs, weights, LARGEST / total)
    for _ in range(MAX_ROUNDS):
        before = moves.labels.copy()
        for label in range(costs.shape[1]):
            moves.expand(label)
        if np.array_equal(before, moves.labels):
            break
    return moves.labels


class _Moves:
    """Labels that are changed by moves, with costs in whole numbers; each takes time for the faces of its label."""

    def __init__(
        self,
        labels: NDArray[np.int64],
        costs: csr_array,
        pairs: NDArray[np.int64],
        weights: NDArray[np.float64],
        scale: float,
    ):
        self.labels, m = labels.copy(), len(labels)
        by_label = costs.tocsc()
        self._faces, self._begins = by_label.indices, by_label.indptr
        self._prices = np.rint(by_label.data * scale).astype(np.int64)
        self._present = np.zeros(m, dtype=np.int64)  # price of the label that each face has
        for label in range(costs.shape[1]):
            faces, prices = self._priced(label)
            has_label = labels[faces] == label
            self._present[faces[has_label]] = prices[has_label]
        capacities = np.rint(weights * scale).astype(np.int64)
        self._pairs, self._capacities = pairs[capacities > 0], capacities[capacities > 0]
        ends = self._pairs.ravel()
        self._edges = np.argsort(ends, kind="stable") // 2  # at each face
        self._first = np.append(0, np.cumsum(np.bincount(ends, minlength=m)))
        self._number = np.full(m, -1)

    def _priced(self, label: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Faces that can have a label, and its price there."""
        own = slice(self._begins[label], self._begins[label + 1])
        return self._faces[own], self._prices[own]

    def _edges_at(self, faces: NDArray[np.int64]) -> NDArray[np.int64]:
        """Edges of faces, in ascending order."""
        counts = self._first[faces + 1] - self._first[faces]
        places = np.repeat(self._first[faces] - (np.cumsum(counts) - counts), counts) + np.arange(counts.sum())
        return np.unique(self._edges[places])

    def expand(self, label: int) -> None:
        """Give one label to the faces for which that lowers the energy most."""
        faces, take = self._priced(label)
        is_free = self.labels[faces] != label
        free, take = faces[is_free], take[is_free]
        if not len(free):
            return
        here = self._edges_at(free)
        number = self._number
        number[free] = np.arange(len(free))
        moved = free[self._is_moved(label, free, take.copy(), self._pairs[here], self._capacities[here])]
        self._present[moved] = take[number[moved]]
        self.labels[moved] = label
        number[free] = -1

    def _is_moved(
        self,
        label: int,
        free: NDArray[np.int64],
        take: NDArray[np.int64],
        pairs: NDArray[np.int64],
        w: NDArray[np.int64],
    ) -> NDArray[np.bool_]:
        """Whether each free face takes the label, x = 1, whose price is ``take``, or keeps its own, x = 0."""
        labels, number = self.labels, self._number
        keep = self._present[free]
        f, g = pairs.T
        f, g = np.where(number[f] >= 0, f, g), np.where(number[f] >= 0, g, f)  # f is free
        is_fixed = number[g] < 0
        f0, g0, w0 = number[f[is_fixed]], labels[g[is_fixed]], w[is_fixed]
        np.add.at(keep, f0, w0 * (labels[f[is_fixed]] != g0))
        np.add.at(take, f0, w0 * (g0 != label))
        i, j, w = number[f[~is_fixed]], number[g[~is_fixed]], w[~is_fixed]
        both_keep = w * (labels[free[i]] != labels[free[j]])
        # A + (C - A) x_i + (D - C) x_j + (B + C - A - D) (1 - x_i) x_j with A = both_keep, B = C = w, D = 0
        np.add.at(take, i, w)
        np.add.at(keep, i, both_keep)
        np.add.at(keep, j, w)
        least = np.minimum(keep, take)
        source, sink, every = len(free), len(free) + 1, np.arange(len(free))
        # indices of 32 bits are all that maximum_flow takes
        rows = np.concatenate([np.full(len(free), source), every, i]).astype(np.int32)
        columns = np.concatenate([every, np.full(len(free), sink), j]).astype(np.int32)
        # a face on the source's side keeps its label: cutting source -> f costs take, cutting f -> sink costs keep
        values = np.concatenate([take - least, keep - least, 2 * w - both_keep])
        n = len(free) + 2
        graph = coo_array((values, (rows, columns)), shape=(n, n)).tocsr()
        graph.eliminate_zeros()
        graph = graph.astype(np.int32)
        residual = graph - maximum_flow(graph, source, sink).flow
        residual.eliminate_zeros()
        reaching_sink = breadth_first_order(residual.T.tocsr(), sink, return_predecessors=False)  # of two equal cuts,
        is_moved = np.zeros(n, dtype=bool)  # the one that changes fewer labels
        is_moved[reaching_sink] = True
        return is_moved[: len(free)]
