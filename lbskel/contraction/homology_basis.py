"""A basis of the loops of a closed surface, by a tree of its vertices and a tree of its faces.

A spanning tree of the vertices, and one of the faces that crosses none of its edges, leave 2g edges, the generators.
Each closes a loop gamma_i along edges with the first tree, and a loop delta_i across edges with the second (Erickson,
Whittlesey 2005, "Greedy optimal homotopy and homology generators", SODA). gamma_i meets delta_i once and no other
delta_j.

No loop is written down: sums along the trees give, for all loops at once, the flow of a combination of loops through
each edge, and the sums of values of edges over each loop. All numbers are modulo 2^64.
"""

from __future__ import annotations

__all__ = ["HomologyBasis", "Integers", "homology_basis"]

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order

from lbskel._kernels.linking import sums_around_vertices, sums_from_root, sums_to_root
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.sorting import stable_order

Integers: TypeAlias = NDArray[np.uint64]  # modulo 2^64


@dataclass(frozen=True, eq=False)
class _Tree:
    """A spanning tree.

    Parameters
    ----------
    order : (n,) array of int
        The nodes, every parent before its children.
    parent : (n,) array of int
    edge : (n,) array of int
        Edge of the mesh to the parent; -1 for the root.
    sign : (n,) array of uint64
        1 where that edge leads to the parent, -1 where it comes from there; 0 for the root.
    """

    order: NDArray[np.int64]
    parent: NDArray[np.int64]
    edge: NDArray[np.int64]
    sign: Integers

    def flow(self, supply: Integers, n_edges: int) -> Integers:
        """(k,) flow along each edge if an (n,) supply at the nodes flows to the root."""
        flow = np.zeros(n_edges, dtype=np.uint64)
        below = self.order[1:]
        flow[self.edge[below]] = (self.sign * sums_to_root(self.order, self.parent, supply))[below]
        return flow

    def potential(self, values: Integers) -> Integers:
        """(n,) sum of values of edges along the path from each node to the root."""
        potential: Integers = sums_from_root(self.order, self.parent, self.sign * values[self.edge])
        return potential


@dataclass(frozen=True, eq=False)
class HomologyBasis:
    """2g loops along edges and 2g loops across edges of a closed surface.

    In the methods ``x`` has (2g,) coefficients of the loops, and ``values`` are (k,), one for each edge.

    Parameters
    ----------
    mesh : Mesh
        One closed manifold component, oriented outwards.
    generators : (2g,) array of int
        The edges in neither tree.
    sides : (k, 2) array of int
        The half-edges of each edge; the first, in the face on its left, leads to its larger vertex.
    twins : (3m,) array of int
        The opposite of each half-edge.
    sign : (3m,) array of uint64
        1 for half-edges from their smaller to their larger vertex, else -1.
    """

    mesh: Mesh
    generators: NDArray[np.int64]
    sides: NDArray[np.int64]
    twins: NDArray[np.int64]
    sign: Integers
    _vertices: _Tree
    _faces: _Tree

    def flow_along(self, x: Integers) -> Integers:
        """(k,) flow along each edge, from its smaller to its larger vertex, of sum x_i gamma_i."""
        supply = np.zeros(len(self.mesh.vertices), dtype=np.uint64)
        low, high = self.mesh.edges[self.generators].T
        np.add.at(supply, high, x)
        np.subtract.at(supply, low, x)
        flow = self._vertices.flow(supply, len(self.mesh.edges))
        flow[self.generators] = x
        return flow

    def sums_along(self, values: Integers) -> Integers:
        """(2g,) sum of values of edges along each gamma_i."""
        low, high = self.mesh.edges[self.generators].T
        potential = self._vertices.potential(values)
        sums: Integers = values[self.generators] + potential[high] - potential[low]
        return sums

    def flow_across(self, x: Integers) -> Integers:
        """(k,) flow from the left to the right of each edge of sum x_i delta_i; it is zero out of each face.

        As a cochain, it is zero on the edges of the first tree, x on the generators, and sums to zero around each face.
        """
        k, m = len(self.mesh.edges), len(self.mesh.faces)
        on_generators = np.zeros(k, dtype=np.uint64)
        on_generators[self.generators] = x
        out_of_side = self.sign * on_generators[self.mesh.edge_of_half_edge]
        return self._faces.flow(-out_of_side.reshape(3, m).sum(axis=0, dtype=np.uint64), k) + on_generators

    def sums_across(self, values: Integers) -> Integers:
        """(2g,) sum of values of edges across each delta_i."""
        left, right = self.sides[self.generators].T % len(self.mesh.faces)
        potential = self._faces.potential(values)
        sums: Integers = values[self.generators] + potential[right] - potential[left]
        return sums

    def intersections(self, x: Integers) -> Integers:
        """(2g,) signed number of times that each gamma_i crosses sum x_i gamma_i, shifted to its left.

        The shifted loops run in the faces left of their edges, and turn around each vertex to the next of these.
        """
        m = len(self.mesh.faces)
        along = np.where(self.sign == 1, self.flow_along(x)[self.mesh.edge_of_half_edge], np.uint64(0))
        arriving = np.roll(along, m) - along  # at the corner that each half-edge leaves
        around: Integers = sums_around_vertices(self.twins, arriving)
        crossed = np.zeros(len(self.mesh.edges), dtype=np.uint64)
        np.add.at(crossed, self.mesh.edge_of_half_edge, self.sign * around)
        return self.sums_along(crossed)


def homology_basis(mesh: Mesh) -> HomologyBasis:
    """Build both trees, breadth first, so that the loops are short.

    Parameters
    ----------
    mesh : Mesh
        One closed manifold component, oriented outwards.
    """
    n, k, m = len(mesh.vertices), len(mesh.edges), len(mesh.faces)
    is_ascending = mesh.half_edges[:, 0] < mesh.half_edges[:, 1]
    sides = stable_order(mesh.edge_of_half_edge).reshape(k, 2)
    sides = np.where(is_ascending[sides[:, :1]], sides, sides[:, ::-1])
    twins = np.empty(3 * m, dtype=np.int64)
    twins[sides] = sides[:, ::-1]
    vertices = _spanning_tree(mesh.edges, np.arange(k), n, int(mesh.faces[0, 0]))
    in_tree = np.zeros(k, dtype=bool)
    in_tree[vertices.edge[vertices.edge >= 0]] = True
    faces = _spanning_tree(sides % m, np.flatnonzero(~in_tree), m, 0)
    in_tree[faces.edge[faces.edge >= 0]] = True
    sign = np.where(is_ascending, 1, -1).astype(np.uint64)
    return HomologyBasis(mesh, np.flatnonzero(~in_tree), sides, twins, sign, vertices, faces)


def _spanning_tree(ends: NDArray[np.int64], edges: NDArray[np.int64], n: int, root: int) -> _Tree:
    """Build a breadth-first tree of the chosen edges; of two edges between the same nodes, the first is taken."""
    low, high = np.sort(ends[edges], axis=1).T
    keys, first = np.unique(low * n + high, return_index=True)
    is_edge = low[first] != high[first]
    keys, chosen = keys[is_edge], edges[first[is_edge]]
    graph = weighted_graph(np.stack([keys // n, keys % n], axis=1), np.ones(len(keys), dtype=np.int8), n)
    order, parent = (nodes.astype(np.int64) for nodes in breadth_first_order(graph, root, directed=False))
    below = order[1:]
    edge = np.full(n, -1)
    pair = np.minimum(below, parent[below]) * n + np.maximum(below, parent[below])
    edge[below] = chosen[np.searchsorted(keys, pair)]
    sign = np.zeros(n, dtype=np.int64)
    sign[below] = np.where(ends[edge[below], 0] == below, 1, -1)
    return _Tree(order, parent, edge, sign.astype(np.uint64))
