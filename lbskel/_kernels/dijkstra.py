"""Shortest paths in a graph, and between two vertices of a mesh that is offset inwards.

Dijkstra 1959, "A note on two problems in connexion with graphs", https://doi.org/10.1007/BF01386390; with a lower bound
on the rest of the path, Hart, Nilsson, Raphael 1968, "A formal basis for the heuristic determination of minimum cost
paths", https://doi.org/10.1109/TSSC.1968.300136.
"""

from __future__ import annotations

__all__ = ["OffsetPaths", "ShortestPaths"]

from threading import RLock
from typing import Any

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython

if cython.compiled:
    from cython.cimports.libc.math import sqrt
else:
    from math import sqrt

INFINITY = cython.declare(cython.double, float("inf"))
# Share of a bound that is left out, so that rounding does not make a longer path look shorter: sums of up to 4,000
# edges are off by less
ROUNDING = cython.declare(cython.double, 1e-12)


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
@cython.locals(slot=cython.Py_ssize_t, parent=cython.Py_ssize_t)
def _push(
    heap: cython.longlong[::1],
    keys: cython.double[::1],
    size: cython.Py_ssize_t,
    node: cython.longlong,
    key: cython.double,
) -> cython.void:
    """Insert a node into a heap of some size."""
    slot = size
    while slot > 0:
        parent = (slot - 1) // 2
        if keys[parent] <= key:
            break
        heap[slot], keys[slot] = heap[parent], keys[parent]
        slot = parent
    heap[slot], keys[slot] = node, key


@cython.cfunc
@cython.nogil
@cython.inline
@cython.exceptval(check=False)
@cython.locals(slot=cython.Py_ssize_t, child=cython.Py_ssize_t, last=cython.longlong, key=cython.double)
def _pop(heap: cython.longlong[::1], keys: cython.double[::1], size: cython.Py_ssize_t) -> cython.longlong:
    """Remove the nearest node from a heap, of which ``size`` nodes are left."""
    nearest: cython.longlong = heap[0]
    last, key = heap[size], keys[size]
    slot, child = 0, 1
    while child < size:
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if key <= keys[child]:
            break
        heap[slot], keys[slot] = heap[child], keys[child]
        slot, child = child, 2 * child + 1
    heap[slot], keys[slot] = last, key
    return nearest


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
@cython.locals(node=cython.longlong, other=cython.longlong, slot=cython.Py_ssize_t, nearest=cython.double)
def _spread(
    first: cython.const[cython.longlong][::1],
    neighbors: cython.const[cython.longlong][::1],
    lengths: cython.const[cython.double][::1],
    distance: cython.double[::1],
    heap: cython.longlong[::1],
    keys: cython.double[::1],
    size: cython.Py_ssize_t,
) -> cython.void:
    """Lower the distances of all nodes that paths from the nodes in the heap reach, as Dijkstra's algorithm does."""
    while size > 0:
        size -= 1
        nearest = keys[0]
        node = _pop(heap, keys, size)
        if nearest > distance[node]:  # pushed before a shorter path was found
            continue
        for slot in range(first[node], first[node + 1]):
            other = neighbors[slot]
            if nearest + lengths[slot] < distance[other]:
                distance[other] = nearest + lengths[slot]
                _push(heap, keys, size, other, distance[other])
                size += 1


@cython.cclass
class ShortestPaths:
    """Shortest path searches in one graph, which share their working arrays: one thread searches at a time.

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
    lock: Any

    def __init__(self, first: NDArray[np.int64], neighbors: NDArray[np.int64], lengths: NDArray[np.float64]) -> None:
        n = len(first) - 1
        self.first, self.neighbors, self.lengths = first, neighbors, lengths
        self.distance, self.predecessor = np.full(n, INFINITY), np.empty(n, dtype=np.int64)
        self.is_done, self.reached = np.zeros(n, dtype=np.int8), np.empty(n, dtype=np.int64)
        self.heap, self.keys = np.empty(len(neighbors) + n, dtype=np.int64), np.empty(len(neighbors) + n)
        self.n_reached = self.heap_size = 0
        self.lock = RLock()

    @cython.locals(source=cython.Py_ssize_t)
    def distances(self, sources: cython.const[cython.longlong][::1]) -> NDArray[np.float64]:
        """(s, n) distance from each source to each node; infinite if there is no path."""
        array = np.full((sources.shape[0], self.distance.shape[0]), INFINITY)
        result: cython.double[:, ::1] = array
        with self.lock, cython.nogil:
            for source in range(sources.shape[0]):
                result[source, sources[source]] = 0.0
                self.heap[0], self.keys[0] = sources[source], 0.0
                _spread(self.first, self.neighbors, self.lengths, result[source], self.heap, self.keys, 1)
        return array

    @cython.locals(node=cython.Py_ssize_t, slot=cython.Py_ssize_t, size=cython.Py_ssize_t)
    def least_sums(self, values: cython.const[cython.double][::1]) -> NDArray[np.float64]:
        """(n,) smallest sum, over all nodes, of the value of a node and its distance: at most the value itself.

        The search begins at the nodes whose value bounds that of a neighbor, so it is short where few do.
        """
        array = np.array(values)
        result: cython.double[::1] = array
        with self.lock, cython.nogil:
            size = 0
            for node in range(result.shape[0]):
                for slot in range(self.first[node], self.first[node + 1]):
                    if values[node] + self.lengths[slot] < values[self.neighbors[slot]]:
                        _push(self.heap, self.keys, size, node, values[node])
                        size += 1
                        break
            _spread(self.first, self.neighbors, self.lengths, result, self.heap, self.keys, size)
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
        distance, path = INFINITY, []
        with self.lock:
            with cython.nogil:
                node = self._search(starts, kinds)
            if node >= 0:
                distance = self.distance[node]
            while node >= 0:
                path.append(node)
                node = self.predecessor[node]
            self._reset()
        return distance, np.array(path, dtype=np.int64)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    @cython.locals(node=cython.longlong, other=cython.longlong, slot=cython.Py_ssize_t, distance=cython.double)
    def _search(
        self, starts: cython.const[cython.longlong][::1], kinds: cython.const[cython.schar][::1]
    ) -> cython.longlong:
        """Nearest goal, or -1; distances and predecessors of all nodes reached before it are set."""
        for slot in range(starts.shape[0]):
            self._update(starts[slot], -1, 0.0)
        while self.heap_size > 0:
            self.heap_size -= 1
            node = _pop(self.heap, self.keys, self.heap_size)
            if self.is_done[node]:
                continue
            self.is_done[node] = 1
            if kinds[node] == 2:
                return node
            for slot in range(self.first[node], self.first[node + 1]):
                other = self.neighbors[slot]
                distance = self.distance[node] + self._length(node, slot)
                if kinds[other] > 0 and distance < self.distance[other]:
                    self._update(other, node, distance)
        return -1

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    @cython.locals(slot=cython.Py_ssize_t)
    def _reset(self) -> cython.void:
        """Clear what the search has set, for the next one."""
        for slot in range(self.n_reached):
            self.distance[self.reached[slot]], self.is_done[self.reached[slot]] = INFINITY, 0
        self.n_reached = self.heap_size = 0

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _update(self, node: cython.longlong, predecessor: cython.longlong, distance: cython.double) -> cython.void:
        """Set a smaller distance and the predecessor of a node, and push it on the heap."""
        if self.distance[node] == INFINITY:
            self.reached[self.n_reached] = node
            self.n_reached += 1
        self.distance[node], self.predecessor[node] = distance, predecessor
        _push(self.heap, self.keys, self.heap_size, node, distance + self._bound(node))
        self.heap_size += 1

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _length(self, node: cython.longlong, slot: cython.Py_ssize_t) -> cython.double:
        """Length of an edge from a node; where it is NaN, no path takes the edge."""
        return self.lengths[slot]

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _bound(self, node: cython.longlong) -> cython.double:
        """Lower bound on the distance from a node to the goal."""
        return 0.0


@cython.cclass
class OffsetPaths(ShortestPaths):
    """Shortest paths along the edges of a mesh whose vertices are moved inwards by half the thickness of the shape.

    Vertex i is moved to ``entry[i] + min(thickness[i] / 2, depth) * inward[i]``, with a depth for each path.

    Parameters
    ----------
    first : (n + 1,) array of int
    neighbors : (e,) array of int
        Adjacency, as of ShortestPaths.
    entry, inward : (n, 3) array of float
    thickness : (n,) array of float
    min_length : float
        Added to the length of every edge.
    """

    entry: cython.const[cython.double][:, ::1]
    inward: cython.const[cython.double][:, ::1]
    thickness: cython.const[cython.double][::1]
    min_length: cython.double
    depth: cython.double
    goal: cython.longlong
    kinds: cython.schar[::1]

    def __init__(
        self,
        first: NDArray[np.int64],
        neighbors: NDArray[np.int64],
        entry: NDArray[np.float64],
        inward: NDArray[np.float64],
        thickness: NDArray[np.float64],
        min_length: float,
    ) -> None:
        ShortestPaths.__init__(self, first, neighbors, np.empty(0))
        self.entry, self.inward, self.thickness, self.min_length = entry, inward, thickness, min_length
        self.kinds = np.ones(len(first) - 1, dtype=np.int8)
        self.depth, self.goal = 0.0, 0

    def path(self, start: int, goal: int, depth: float) -> NDArray[np.int64]:
        """Find the shortest path from one vertex to another; it is empty if there is none."""
        with self.lock:
            self.goal, self.depth = goal, depth
            self.kinds[goal] = 2
            _, path = self.nearest_goal(np.array([start]), self.kinds)
            self.kinds[goal] = 1
            return path[::-1]

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _length(self, node: cython.longlong, slot: cython.Py_ssize_t) -> cython.double:
        return self._distance(node, self.neighbors[slot]) + self.min_length

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _bound(self, node: cython.longlong) -> cython.double:
        return (1.0 - ROUNDING) * self._distance(node, self.goal)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    @cython.locals(axis=cython.Py_ssize_t, step=cython.double, total=cython.double)
    def _distance(self, i: cython.longlong, j: cython.longlong) -> cython.double:
        """Distance of two vertices that are moved inwards."""
        near: cython.double = min(self.thickness[i] / 2, self.depth)
        far: cython.double = min(self.thickness[j] / 2, self.depth)
        total = 0.0
        for axis in range(3):
            step = self.entry[i, axis] + near * self.inward[i, axis]
            step = step - (self.entry[j, axis] + far * self.inward[j, axis])
            total += step * step
        return sqrt(total)
