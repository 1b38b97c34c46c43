# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Shortest ways in a graph: Dijkstra 1959, "A note on two problems in connexion with graphs"."""

from __future__ import annotations

__all__ = ["ShortestPaths"]

import cython
import numpy as np
from numpy.typing import NDArray

NEVER = cython.declare(cython.double, float("inf"))


@cython.cclass
class ShortestPaths:
    """A graph to look for ways in: beside node i are those from ``beside[first[i]]`` on, before ``first[i + 1]``.

    Lengths are none of them negative, and of several starts no two are the same.
    """

    first: cython.const[cython.longlong][::1]
    beside: cython.const[cython.longlong][::1]
    lengths: cython.const[cython.double][::1]
    far: cython.double[::1]
    before: cython.longlong[::1]
    is_done: cython.schar[::1]
    reached: cython.longlong[::1]
    n_reached: cython.Py_ssize_t
    heap: cython.longlong[::1]
    keys: cython.double[::1]
    n_waiting: cython.Py_ssize_t

    def __init__(self, first: NDArray[np.int64], beside: NDArray[np.int64], lengths: NDArray[np.float64]) -> None:
        n = len(first) - 1
        self.first, self.beside, self.lengths = first, beside, lengths
        self.far, self.before = np.full(n, NEVER), np.empty(n, dtype=np.int64)
        self.is_done, self.reached = np.zeros(n, dtype=np.int8), np.empty(n, dtype=np.int64)
        self.heap, self.keys = np.empty(len(beside) + n, dtype=np.int64), np.empty(len(beside) + n)
        self.n_reached = self.n_waiting = 0

    @cython.locals(source=cython.Py_ssize_t, node=cython.Py_ssize_t, everywhere=cython.schar[::1])
    def distances(self, sources: cython.const[cython.longlong][::1]) -> NDArray[np.float64]:
        """(s, n) how far it is from each source to each node; infinite where no way leads."""
        array = np.full((sources.shape[0], self.far.shape[0]), NEVER)
        result: cython.double[:, ::1] = array
        everywhere = np.ones(self.far.shape[0], dtype=np.int8)
        for source in range(sources.shape[0]):
            self._spread(sources[source : source + 1], everywhere)
            for node in range(self.n_reached):
                result[source, self.reached[node]] = self.far[self.reached[node]]
            self._forget()
        return array

    @cython.locals(node=cython.longlong)
    def first_of(
        self, starts: cython.const[cython.longlong][::1], kinds: cython.const[cython.schar][::1]
    ) -> tuple[float, NDArray[np.int64]]:
        """How far it is to the nearest goal, and the nodes on the way, the goal first; infinite, none if there is none.

        Kinds are 0 for nodes that no way may use, 1 for those that one may, 2 for goals.
        """
        if kinds.shape[0] != self.far.shape[0]:
            raise ValueError("there must be a kind for each node")
        node = self._spread(starts, kinds)
        far, way = NEVER, []
        if node >= 0:
            far = self.far[node]
        while node >= 0:
            way.append(node)
            node = self.before[node]
        self._forget()
        return far, np.array(way, dtype=np.int64)

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(node=cython.longlong, other=cython.longlong, at=cython.Py_ssize_t, far=cython.double)
    def _spread(
        self, starts: cython.const[cython.longlong][::1], kinds: cython.const[cython.schar][::1]
    ) -> cython.longlong:
        """The first goal reached, or -1; what is reached on the way is known then."""
        for at in range(starts.shape[0]):
            self._reach(starts[at], -1, 0.0)
        while self.n_waiting > 0:
            node = self._next()
            if self.is_done[node]:
                continue
            self.is_done[node] = 1
            if kinds[node] == 2:
                return node
            for at in range(self.first[node], self.first[node + 1]):
                other = self.beside[at]
                far = self.far[node] + self.lengths[at]
                if kinds[other] > 0 and far < self.far[other]:
                    self._reach(other, node, far)
        return -1

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(at=cython.Py_ssize_t)
    def _forget(self) -> cython.void:
        """Be ready for the next search."""
        for at in range(self.n_reached):
            self.far[self.reached[at]], self.is_done[self.reached[at]] = NEVER, 0
        self.n_reached = self.n_waiting = 0

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(at=cython.Py_ssize_t, above=cython.Py_ssize_t)
    def _reach(self, node: cython.longlong, before: cython.longlong, far: cython.double) -> cython.void:
        """A node by a shorter way, which waits in the heap."""
        if self.far[node] == NEVER:
            self.reached[self.n_reached] = node
            self.n_reached += 1
        self.far[node], self.before[node] = far, before
        at = self.n_waiting
        self.n_waiting += 1
        while at > 0:
            above = (at - 1) // 2
            if self.keys[above] <= far:
                break
            self.heap[at], self.keys[at] = self.heap[above], self.keys[above]
            at = above
        self.heap[at], self.keys[at] = node, far

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(at=cython.Py_ssize_t, under=cython.Py_ssize_t, last=cython.longlong, key=cython.double)
    def _next(self) -> cython.longlong:
        """The nearest node that waits."""
        nearest: cython.longlong = self.heap[0]
        self.n_waiting -= 1
        last, key = self.heap[self.n_waiting], self.keys[self.n_waiting]
        at, under = 0, 1
        while under < self.n_waiting:
            if under + 1 < self.n_waiting and self.keys[under + 1] < self.keys[under]:
                under += 1
            if key <= self.keys[under]:
                break
            self.heap[at], self.keys[at] = self.heap[under], self.keys[under]
            at, under = under, 2 * under + 1
        self.heap[at], self.keys[at] = last, key
        return nearest
