"""Shortest paths in a graph.

Dijkstra 1959, "A note on two problems in connexion with graphs", https://doi.org/10.1007/BF01386390.
"""

from __future__ import annotations

__all__ = ["ShortestPaths"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython

INFINITY = cython.declare(cython.double, float("inf"))


@cython.cclass
class ShortestPaths:
    """Shortest path searches in one graph, which share their working arrays.

    Parameters
    ----------
    first : (n + 1,) array of int
    neighbors : (e,) array of int
        Adjacency: the neighbors of node i are ``neighbors[first[i]:first[i + 1]]``.
    lengths : (e,) array of float
        Lengths of these edges; none is negative.
    """

    first: cython.const[cython.longlong][::1]
    neighbors: cython.const[cython.longlong][::1]
    lengths: cython.const[cython.double][::1]
    distance: cython.double[::1]
    predecessor: cython.longlong[::1]
    is_done: cython.schar[::1]
    reached: cython.longlong[::1]
    n_reached: cython.Py_ssize_t
    heap: cython.longlong[::1]
    keys: cython.double[::1]
    heap_size: cython.Py_ssize_t

    def __init__(self, first: NDArray[np.int64], neighbors: NDArray[np.int64], lengths: NDArray[np.float64]) -> None:
        n = len(first) - 1
        self.first, self.neighbors, self.lengths = first, neighbors, lengths
        self.distance, self.predecessor = np.full(n, INFINITY), np.empty(n, dtype=np.int64)
        self.is_done, self.reached = np.zeros(n, dtype=np.int8), np.empty(n, dtype=np.int64)
        self.heap, self.keys = np.empty(len(neighbors) + n, dtype=np.int64), np.empty(len(neighbors) + n)
        self.n_reached = self.heap_size = 0

    @cython.locals(source=cython.Py_ssize_t, node=cython.Py_ssize_t, all_allowed=cython.schar[::1])
    def distances(self, sources: cython.const[cython.longlong][::1]) -> NDArray[np.float64]:
        """(s, n) distance from each source to each node; infinite if there is no path."""
        array = np.full((sources.shape[0], self.distance.shape[0]), INFINITY)
        result: cython.double[:, ::1] = array
        all_allowed = np.ones(self.distance.shape[0], dtype=np.int8)
        for source in range(sources.shape[0]):
            self._search(sources[source : source + 1], all_allowed)
            for node in range(self.n_reached):
                result[source, self.reached[node]] = self.distance[self.reached[node]]
            self._reset()
        return array

    @cython.locals(node=cython.longlong)
    def nearest_goal(
        self, starts: cython.const[cython.longlong][::1], kinds: cython.const[cython.schar][::1]
    ) -> tuple[float, NDArray[np.int64]]:
        """Distance to the nearest goal, or infinity, and the nodes of the path from it back to a start.

        Parameters
        ----------
        starts : (s,) array of int
            Distinct nodes.
        kinds : (n,) array of int8
            0 for nodes that no path may enter, 1 for nodes that one may, 2 for goals.
        """
        if kinds.shape[0] != self.distance.shape[0]:
            raise ValueError("there must be a kind for each node")
        node = self._search(starts, kinds)
        distance, path = INFINITY, []
        if node >= 0:
            distance = self.distance[node]
        while node >= 0:
            path.append(node)
            node = self.predecessor[node]
        self._reset()
        return distance, np.array(path, dtype=np.int64)

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(node=cython.longlong, other=cython.longlong, slot=cython.Py_ssize_t, distance=cython.double)
    def _search(
        self, starts: cython.const[cython.longlong][::1], kinds: cython.const[cython.schar][::1]
    ) -> cython.longlong:
        """Nearest goal, or -1; distances and predecessors of all nodes reached before it are set."""
        for slot in range(starts.shape[0]):
            self._update(starts[slot], -1, 0.0)
        while self.heap_size > 0:
            node = self._pop()
            if self.is_done[node]:
                continue
            self.is_done[node] = 1
            if kinds[node] == 2:
                return node
            for slot in range(self.first[node], self.first[node + 1]):
                other = self.neighbors[slot]
                distance = self.distance[node] + self.lengths[slot]
                if kinds[other] > 0 and distance < self.distance[other]:
                    self._update(other, node, distance)
        return -1

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(slot=cython.Py_ssize_t)
    def _reset(self) -> cython.void:
        """Clear what the search has set, for the next one."""
        for slot in range(self.n_reached):
            self.distance[self.reached[slot]], self.is_done[self.reached[slot]] = INFINITY, 0
        self.n_reached = self.heap_size = 0

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(slot=cython.Py_ssize_t, parent=cython.Py_ssize_t)
    def _update(self, node: cython.longlong, predecessor: cython.longlong, distance: cython.double) -> cython.void:
        """Set a smaller distance and the predecessor of a node, and push it on the heap."""
        if self.distance[node] == INFINITY:
            self.reached[self.n_reached] = node
            self.n_reached += 1
        self.distance[node], self.predecessor[node] = distance, predecessor
        slot = self.heap_size
        self.heap_size += 1
        while slot > 0:
            parent = (slot - 1) // 2
            if self.keys[parent] <= distance:
                break
            self.heap[slot], self.keys[slot] = self.heap[parent], self.keys[parent]
            slot = parent
        self.heap[slot], self.keys[slot] = node, distance

    @cython.cfunc
    @cython.exceptval(check=False)
    @cython.locals(slot=cython.Py_ssize_t, child=cython.Py_ssize_t, last=cython.longlong, key=cython.double)
    def _pop(self) -> cython.longlong:
        """Remove the nearest node from the heap."""
        nearest: cython.longlong = self.heap[0]
        self.heap_size -= 1
        last, key = self.heap[self.heap_size], self.keys[self.heap_size]
        slot, child = 0, 1
        while child < self.heap_size:
            if child + 1 < self.heap_size and self.keys[child + 1] < self.keys[child]:
                child += 1
            if key <= self.keys[child]:
                break
            self.heap[slot], self.keys[slot] = self.heap[child], self.keys[child]
            slot, child = child, 2 * child + 1
        self.heap[slot], self.keys[slot] = last, key
        return nearest
