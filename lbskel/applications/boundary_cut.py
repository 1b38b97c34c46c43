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
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

MAX_ROUNDS = 4  # rounds of one move for each label; a guess, the third seldom changes anything
LARGEST = 2**30  # bound on the sum of all capacities, which are whole numbers of 32 bits


def expand_labels(
    labels: NDArray[np.int64], costs: NDArray[np.float64], pairs: NDArray[np.int64], weights: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Lower the energy of labels by moves of one label at a time.

    Parameters
    ----------
    labels : (m,) array of int
        Initial label of each face, from 0 to c - 1; its cost is finite.
    costs : (m, c) array of float
        Cost of each label at each face, not negative; infinite where a face cannot have the label.
    pairs : (p, 2) array of int
        Neighboring faces.
    weights : (p,) array of float
        Cost of different labels at a pair, not negative.

    Returns
    -------
    (m,) array of int
        Labels, after at most MAX_ROUNDS rounds.
    """
    finite = np.where(np.isfinite(costs), costs, 0.0)
    total = 4 * weights.sum() + finite.max(axis=1, initial=0.0).sum()
    if costs.shape[1] < 2 or not total > 0:
        return labels
    prices = np.where(np.isfinite(costs), np.rint(finite / total * LARGEST), -1).astype(np.int64)
    capacities = np.rint(weights / total * LARGEST).astype(np.int64)
    current = labels.copy()
    for _ in range(MAX_ROUNDS):
        before = current.copy()
        for label in range(costs.shape[1]):
            current = _expanded(current, label, prices, pairs, capacities)
        if np.array_equal(before, current):
            break
    return current


def _expanded(
    labels: NDArray[np.int64],
    label: int,
    prices: NDArray[np.int64],
    pairs: NDArray[np.int64],
    capacities: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Give one label to the faces for which that lowers the energy most."""
    free = np.flatnonzero((prices[:, label] >= 0) & (labels != label))
    if not len(free):
        return labels
    number = np.full(len(labels), -1)
    number[free] = np.arange(len(free))
    keep = prices[free, labels[free]].copy()  # cost of x = 0
    take = prices[free, label].copy()  # cost of x = 1
    here = (number[pairs] >= 0).any(axis=1) & (capacities > 0)
    (f, g), w = pairs[here].T, capacities[here]
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
    flow = maximum_flow(graph, source, sink).flow
    residual = graph - flow
    residual.eliminate_zeros()
    reaching_sink = breadth_first_order(residual.T.tocsr(), sink, return_predecessors=False)  # of two equal cuts, the
    is_moved = np.zeros(n, dtype=bool)  # one that changes fewer labels
    is_moved[reaching_sink] = True
    moved = labels.copy()
    moved[free[is_moved[: len(free)]]] = label
    return moved
