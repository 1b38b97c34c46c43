"""Smooth boundaries between labels of faces: the labels diffuse over the surface, and the largest share is taken.

A few times, (M + t L) U = M P is solved, with the areas M of the faces, the indicators P of the labels and a Laplacian
L of the faces, and each face then takes the label of its largest U, of those that it can have. Labels that no face can
both have are far from each other, and share a column of P, so that many parts need few columns. The weights of L are
the lengths of the edges over the distances of the faces' centers, less where the surface is concave. That moves
boundaries like mean curvature flow, and keeps them in creases: Merriman, Bence, Osher 1992, "Diffusion generated motion
by mean curvature". The time t is the square of a share of the local radius. Last, a face with more of its edges' length
at another label takes that one.
"""

from __future__ import annotations

__all__ = ["concavity", "smooth_labels"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, csr_array

from lbskel.applications.face_graph import FaceGraph
from lbskel.solvers import factorize

# Local radii over which labels diffuse, and how often they do. Both, and those below, are swept in
# benchmarks/results/parts.md, "Constants".
DIFFUSION = 0.85
TURNS = 3
COLUMNS = 32  # labels solved for together, no unit: it bounds the memory (same table: alike)
MAX_CONDUCTANCE = 1e3  # bound on the length of an edge over the distance of its faces, which is tiny at slivers
MIN_MASS = 1e-12  # lower bound on the mass of a face, relative to the conductance of its edges; keeps A definite
EPSILON = 1e-9  # part of the longest edge by which a boundary must get shorter: less is rounding


def concavity(graph: FaceGraph, scale: NDArray[np.float64]) -> NDArray[np.float64]:
    """(p,) angle by which the surface turns inwards at each edge, in radians per local radius; 0 where it is convex.

    Parameters
    ----------
    graph : FaceGraph
    scale : (m,) array of float
        Local radius at each face, positive, in units of the mesh.
    """
    local = scale[graph.pairs].mean(axis=1)
    spans = np.maximum(graph.spans, np.finfo(np.float64).eps * local)
    inward: NDArray[np.float64] = np.maximum(graph.turns, 0.0) * local / spans
    return inward


def smooth_labels(
    labels: NDArray[np.int64],
    graph: FaceGraph,
    areas: NDArray[np.float64],
    scale: NDArray[np.float64],
    choices: csr_array,
) -> NDArray[np.int64]:
    """Smooth the boundaries of labels; a label of few faces may vanish.

    Parameters
    ----------
    labels : (m,) array of int
        Of the faces, not negative.
    graph : FaceGraph
    areas : (m,) array of float
        Of the faces, in squared units of the mesh.
    scale : (m,) array of float
        Local radius at each face, positive, in units of the mesh.
    choices : (m, p) csr_array
        Has an entry, of any value, for each label that a face can have; its first one is among them.

    Raises
    ------
    SolveError
        If the system cannot be solved.
    """
    m, n_labels = len(labels), int(labels.max(initial=0)) + 1
    if n_labels < 2 or not len(graph.pairs):
        return labels
    i, j = graph.pairs.T
    spans = np.maximum(graph.spans, graph.lengths / MAX_CONDUCTANCE)
    ratio = np.divide(graph.lengths, spans, out=np.zeros(len(spans)), where=spans > 0)
    conductance = ratio / (1 + concavity(graph, scale))
    total = np.bincount(i, conductance, minlength=m) + np.bincount(j, conductance, minlength=m)
    mass = np.maximum(areas / (DIFFUSION * scale) ** 2, MIN_MASS * np.where(total > 0, total, 1.0))
    every = np.arange(m)
    values = np.concatenate([-conductance, -conductance, total + mass])
    rows, columns = np.concatenate([i, j, every]), np.concatenate([j, i, every])
    solver = factorize(csc_array(coo_array((values, (rows, columns)), shape=(m, m))))
    face, label, column_of_label = np.repeat(every, np.diff(choices.indptr)), choices.indices, _columns(choices)
    column, n_columns, share = column_of_label[label], int(column_of_label.max()) + 1, np.empty(len(label))
    current = labels
    for _ in range(TURNS):
        own = column_of_label[current]
        for begin in range(0, n_columns, COLUMNS):
            end = min(begin + COLUMNS, n_columns)
            solved = solver.solve(mass[:, None] * (own[:, None] == np.arange(begin, end)))
            here = np.flatnonzero((column >= begin) & (column < end))
            share[here] = solved[face[here], column[here] - begin]
        is_largest = share == np.maximum.reduceat(share, choices.indptr[:-1])[face]
        current = label[is_largest][np.unique(face[is_largest], return_index=True)[1]].astype(np.int64)
    return _without_teeth(current, graph)


def _columns(choices: csr_array) -> NDArray[np.int64]:
    """(p,) column of each label: labels that one face can have are in different ones, others may share one."""
    pattern = csr_array((np.ones(choices.nnz), choices.indices, choices.indptr), shape=choices.shape)
    together = (pattern.T @ pattern).tocsr()
    found = np.full(choices.shape[1], -1)
    for label in range(len(found)):
        beside = together.indices[together.indptr[label] : together.indptr[label + 1]]
        is_free = np.ones(len(beside) + 1, dtype=bool)
        taken = found[beside]
        is_free[taken[(taken >= 0) & (taken < len(is_free))]] = False
        found[label] = is_free.argmax()
    return found


def _without_teeth(labels: NDArray[np.int64], graph: FaceGraph) -> NDArray[np.int64]:
    """Give faces the label at the largest length of their edges, as long as the boundary gets shorter."""
    own, beside = graph.pairs.T.ravel(), graph.pairs[:, ::-1].T.ravel()
    lengths = np.tile(graph.lengths, 2)
    shape = (len(labels), int(labels.max()) + 1)
    current = labels.copy()
    while True:
        is_near = np.zeros(len(labels), dtype=bool)
        is_near[own[current[own] != current[beside]]] = True
        edges = is_near[own]
        border = csr_array((lengths[edges], (own[edges], current[beside[edges]])), shape=shape)
        faces = np.flatnonzero(is_near)
        best = np.asarray(border[faces].argmax(axis=1)).ravel()
        gain = np.zeros(len(labels))
        gain[faces] = np.asarray(border[faces, best] - border[faces, current[faces]]).ravel()
        is_first = gain > EPSILON * lengths.max()
        # of two neighbors only the one with more gain changes, or the first of equal ones
        np.logical_and.at(is_first, own, (gain[own] > gain[beside]) | ((gain[own] == gain[beside]) & (own < beside)))
        changed = is_first[faces]
        if not changed.any():
            return current
        current[faces[changed]] = best[changed]
