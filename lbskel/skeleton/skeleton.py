"""A curve skeleton: a graph in space with a radius on every node and a node for every vertex of the mesh.

It is a graph and not a tree: a handle of the shape is a cycle of the skeleton.
"""

from __future__ import annotations

__all__ = ["Skeleton"]

import itertools
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components

from lbskel.errors import MeshError, MissingDependency
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.arrays import read_only


def _rows(values: ArrayLike, what: str, width: int, kind: type) -> NDArray[Any]:
    """A copy of shape (k, width), also of nothing at all; a MeshError if it has another shape."""
    try:
        given = np.asarray(values)
        rows: NDArray[Any] = np.array(given, dtype=kind, order="C")
    except (TypeError, ValueError) as error:
        raise MeshError(f"{what} of a skeleton must be an array of numbers: {error}") from None
    if rows.size == 0:
        return rows.reshape(0, width)
    if rows.ndim != 2 or rows.shape[1] != width:
        raise MeshError(f"{what} of a skeleton must have shape (k, {width}), not {rows.shape}")
    if kind is np.int64 and (rows != given).any():
        raise MeshError(f"{what} of a skeleton must be whole numbers")
    return rows


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Nodes joined by straight edges, in the coordinates of the mesh that it came from.

    Parameters
    ----------
    nodes : (k, 3) array of float
        Positions.
    edges : (e, 2) array of int
        Pairs of nodes, smaller index first, each pair once, sorted.
    radii : (k,) array of float
        Thickness of the shape at each node, of the kind that ``radius_kind`` names.
    node_of_vertex : (n,) array of int
        For each vertex of the mesh, the node that stands for it. Empty where no mesh is known.
    radius_kind : str
        ``inscribed``: distance to the surface; ``mean``: mean distance to the vertices that the node stands for.
    mean_radii : (k,) array of float
        Of the kind ``mean``, beside radii of another kind. Empty where they are not known.
    anchors : (a,) array of int
        Nodes that the caller asked for: nothing that simplifies the graph removes or moves them.
    report : dict
        What was done and checked on the way, ready for JSON.

    Raises
    ------
    MeshError
        If an edge or the map names a node that does not exist, or the lengths do not agree.
    """

    nodes: NDArray[np.float64]
    edges: NDArray[np.int64]
    radii: NDArray[np.float64]
    node_of_vertex: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    radius_kind: str = "inscribed"
    mean_radii: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    anchors: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    report: dict[str, Any] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        nodes = _rows(self.nodes, "nodes", 3, np.float64)
        edges = np.sort(_rows(self.edges, "edges", 2, np.int64), axis=1)
        radii = np.array(self.radii, dtype=np.float64).reshape(-1)
        mean_radii = np.array(self.mean_radii, dtype=np.float64).reshape(-1)
        mapped = np.array(self.node_of_vertex, dtype=np.int64).reshape(-1)
        anchors = np.unique(np.array(self.anchors, dtype=np.int64))
        if len(radii) != len(nodes):
            raise MeshError(f"a skeleton of {len(nodes)} nodes needs as many radii, not {len(radii)}")
        if len(mean_radii) not in (0, len(nodes)):
            raise MeshError(
                f"a skeleton of {len(nodes)} nodes needs as many mean radii, or none, not {len(mean_radii)}"
            )
        for what, indices in (("edges", edges), ("node_of_vertex", mapped), ("anchors", anchors)):
            if indices.size and (indices.min() < 0 or indices.max() >= len(nodes)):
                raise MeshError(f"{what} of the skeleton name a node outside 0..{len(nodes) - 1}")
        apart = edges[edges[:, 0] != edges[:, 1]]
        edges = np.stack(np.divmod(np.unique(apart @ [len(nodes), 1]), max(len(nodes), 1)), axis=1)
        for name, value in {
            "nodes": nodes,
            "edges": edges,
            "radii": radii,
            "node_of_vertex": mapped,
            "mean_radii": mean_radii,
            "anchors": anchors,
        }.items():
            object.__setattr__(self, name, read_only(value))

    def __repr__(self) -> str:
        return (
            f"Skeleton({len(self.nodes)} nodes, {len(self.edges)} edges, {len(self.tips)} tips, "
            f"{len(self.junctions)} junctions, {self.cycle_rank} cycles)"
        )

    @cached_property
    def degrees(self) -> NDArray[np.int64]:
        """(k,) number of edges at each node."""
        return read_only(np.bincount(self.edges.ravel(), minlength=len(self.nodes)))

    @property
    def tips(self) -> NDArray[np.int64]:
        """Nodes with one edge, the ends of the shape."""
        return np.flatnonzero(self.degrees == 1)

    @property
    def junctions(self) -> NDArray[np.int64]:
        """Nodes with three edges or more."""
        return np.flatnonzero(self.degrees >= 3)

    @cached_property
    def edge_lengths(self) -> NDArray[np.float64]:
        """(e,) length of each edge."""
        start, end = self.nodes[self.edges].transpose(1, 0, 2)
        return read_only(np.linalg.norm(end - start, axis=1))

    @property
    def length(self) -> float:
        """Total length of the edges."""
        return float(self.edge_lengths.sum())

    @cached_property
    def component_of_node(self) -> NDArray[np.int64]:
        """(k,) number of the connected component of each node."""
        k = len(self.nodes)
        graph = weighted_graph(self.edges, np.ones(len(self.edges), dtype=np.int8), k)
        return read_only(connected_components(graph, directed=False)[1].astype(np.int64))

    @property
    def n_components(self) -> int:
        """Number of connected components."""
        return int(self.component_of_node.max()) + 1 if len(self.nodes) else 0

    @property
    def cycle_rank(self) -> int:
        """Number of independent cycles: edges less nodes plus components."""
        return len(self.edges) - len(self.nodes) + self.n_components

    @cached_property
    def adjacency(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(k + 1,) where the neighbors of each node begin, and (2 e,) all of them, each node's in ascending order."""
        both = np.concatenate([self.edges, self.edges[:, ::-1]])
        both = both[np.lexsort((both[:, 1], both[:, 0]))]
        return read_only(np.append(0, np.cumsum(self.degrees))), read_only(np.ascontiguousarray(both[:, 1]))

    @cached_property
    def neighbors(self) -> tuple[NDArray[np.int64], ...]:
        """For each node, the nodes that share an edge with it, in ascending order."""
        first, beside = self.adjacency
        return tuple(beside[begin:end] for begin, end in itertools.pairwise(first.tolist()))

    @cached_property
    def branches(self) -> tuple[NDArray[np.int64], ...]:
        """Polylines of node indices, each from a tip or junction to the next; a bare loop repeats its first node.

        Together they use every edge exactly once. The order is that of their first nodes.
        """
        first, beside = (array.tolist() for array in self.adjacency)
        neighbors = [beside[begin:end] for begin, end in itertools.pairwise(first)]
        ends = np.flatnonzero((self.degrees != 2) & (self.degrees > 0))
        used: set[tuple[int, int]] = set()
        walks = [walk for end in ends.tolist() for walk in _walks_from(end, neighbors, used)]
        if len(used) < len(beside):  # what is left are loops without a junction
            for node in np.flatnonzero(self.degrees == 2).tolist():
                walks.extend(_walks_from(node, neighbors, used))
        return tuple(read_only(np.array(walk, dtype=np.int64)) for walk in walks)

    @property
    def end_branches(self) -> list[NDArray[np.int64]]:
        """The branches that lead from a junction to a tip, the junction first."""
        ways = [branch if self.degrees[branch[-1]] == 1 else branch[::-1] for branch in self.branches]
        return [way for way in ways if self.degrees[way[-1]] == 1 and self.degrees[way[0]] >= 3]

    def to_networkx(self) -> Any:
        """An undirected ``networkx.Graph`` with ``pos`` and ``radius`` on nodes and ``length`` on edges.

        Raises
        ------
        MissingDependency
            If networkx is not installed.
        """
        try:
            import networkx
        except ImportError:
            raise MissingDependency("networkx", "graph", "to_networkx()") from None
        graph = networkx.Graph()
        for index, (position, radius) in enumerate(zip(self.nodes, self.radii, strict=True)):
            graph.add_node(index, pos=tuple(position.tolist()), radius=float(radius))
        for (start, end), length in zip(self.edges.tolist(), self.edge_lengths, strict=True):
            graph.add_edge(start, end, length=float(length))
        return graph


def _walks_from(start: int, neighbors: list[list[int]], used: set[tuple[int, int]]) -> list[list[int]]:
    """The unused walks that leave a node, each up to a node of another degree than two or back to the start."""
    walks = []
    for following in neighbors[start]:
        if (start, following) in used:
            continue
        walk = [start, following]
        while len(neighbors[walk[-1]]) == 2 and walk[-1] != start:
            one, other = neighbors[walk[-1]]
            walk.append(other if one == walk[-2] else one)
        used.update(itertools.pairwise(walk))
        used.update(itertools.pairwise(reversed(walk)))
        walks.append(walk)
    return walks
