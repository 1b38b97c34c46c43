"""A curve skeleton: a graph in space, a radius for every node, and a map from the vertices of the mesh to the nodes.

It is a graph and not a tree: every handle of the shape is a cycle of the skeleton.
"""

from __future__ import annotations

__all__ = ["Skeleton"]

import itertools
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel._kernels.connectivity import component_roots
from lbskel._kernels.traversal import walk_branches
from lbskel.errors import MeshError, counted, first_few
from lbskel.geometry.arrays import read_only, refuse_masked
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.sorting import distinct, group_medians, stable_order
from lbskel.skeleton.exchange import SkeletonExchange


def _numbers(values: ArrayLike, name: str, dtype: type) -> NDArray[Any]:
    """Copy the values unless they are constant; a MeshError if they are not numbers, or not whole for an int dtype."""
    if isinstance(values, np.ndarray) and values.dtype == dtype and _is_constant(values):
        return values
    refuse_masked(values, f"{name} of a skeleton")
    try:
        given = np.asarray(values)
        if given.dtype.kind == "c":
            raise TypeError("not of complex ones")
        with np.errstate(invalid="ignore"):  # of NaN as an index, which is no whole number
            numbers: NDArray[Any] = np.array(given, dtype=dtype, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise MeshError(f"{name} of a skeleton must be an array of numbers: {error}") from None
    if dtype is np.int64 and (numbers != given).any():
        raise MeshError(f"{name} of a skeleton must be whole numbers")
    return numbers


def _is_constant(values: NDArray[Any]) -> bool:
    """Whether an array is read-only and owns its data, as those of a skeleton do, so that it need not be copied."""
    return not values.flags.writeable and values.base is None and values.flags.c_contiguous


def _rows(values: ArrayLike, name: str, width: int, dtype: type) -> NDArray[Any]:
    """Copy the values to shape (k, width), also an empty sequence; a MeshError if they have another shape."""
    rows = _numbers(values, name, dtype)
    if rows.size == 0:
        return rows.reshape(0, width)
    if rows.ndim != 2 or rows.shape[1] != width:
        raise MeshError(f"{name} of a skeleton must have shape (k, {width}), not {rows.shape}")
    return rows


@dataclass(frozen=True, eq=False)
class Skeleton(SkeletonExchange):
    """Nodes connected by straight edges, in the coordinates of the mesh that the skeleton was made from.

    Parameters
    ----------
    nodes : (k, 3) array of float
        Positions.
    edges : (e, 2) array of int
        Pairs of nodes; they are stored with the smaller index first, each pair once, sorted, without self-loops.
    radii : (k,) array of float
        Thickness of the shape at each node, of the kind that ``radius_kind`` names; NaN where it is not known.
    node_of_vertex : (n,) array of int
        For each vertex of the mesh, the node that it is mapped to. Empty where no mesh is known.
    radius_kind : str
        ``inscribed``: distance to the surface; ``mean``: mean distance of the vertices that are mapped to the node from
        the axis of its branch there, which noise hardly changes.
    mean_radii : (k,) array of float
        Radii of the kind ``mean``, in addition to ``radii`` of another kind. Empty where they are not known.
    anchors : (a,) array of int
        Nodes that the caller asked for; no function that simplifies the graph removes or moves them.
    report : dict
        How the skeleton was made and checked, ready for JSON.

    Raises
    ------
    MeshError
        If an array does not hold numbers or has the wrong shape, a node is not finite, the lengths do not agree, or an
        edge, the map or an anchor refers to a node that does not exist.

    Examples
    --------
    >>> import lbskel
    >>> fork = lbskel.Skeleton([[0, 0, 0], [1, 0, 0], [2, 1, 0], [2, -1, 0]], [[0, 1], [1, 2], [1, 3]], [1, 1, 1, 1])
    >>> fork.tips.tolist(), fork.junctions.tolist(), len(fork.branches)
    ([0, 2, 3], [1], 3)
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
        if not np.isfinite(nodes).all():
            bad = first_few(np.flatnonzero(~np.isfinite(nodes).all(axis=1)))
            raise MeshError(f"nodes {bad} of the skeleton have NaN or infinite coordinates")
        edges = _rows(self.edges, "edges", 2, np.int64)
        if not (is_ascending := (edges[:, 0] < edges[:, 1]).all()):
            edges = np.sort(edges, axis=1)
        radii = _numbers(self.radii, "radii", np.float64).reshape(-1)
        mean_radii = _numbers(self.mean_radii, "mean_radii", np.float64).reshape(-1)
        node_of_vertex = _numbers(self.node_of_vertex, "node_of_vertex", np.int64).reshape(-1)
        anchors = np.unique(_numbers(self.anchors, "anchors", np.int64))
        if len(radii) != len(nodes):
            raise MeshError(f"a skeleton of {len(nodes)} nodes needs as many radii, not {len(radii)}")
        if len(mean_radii) not in (0, len(nodes)):
            raise MeshError(
                f"a skeleton of {len(nodes)} nodes needs as many mean radii, or none, not {len(mean_radii)}"
            )
        for field_name, indices in (("edges", edges), ("node_of_vertex", node_of_vertex), ("anchors", anchors)):
            if indices.size and (indices.min() < 0 or indices.max() >= len(nodes)):
                raise MeshError(f"{field_name} of the skeleton name a node outside 0..{len(nodes) - 1}")
        key = edges[:, 0] * len(nodes) + edges[:, 1]
        if not is_ascending or (key[1:] <= key[:-1]).any():
            key = distinct(key[edges[:, 0] != edges[:, 1]])
            edges = np.stack(np.divmod(key, max(len(nodes), 1)), axis=1)
        for name, value in {
            "nodes": nodes,
            "edges": edges,
            "radii": radii,
            "node_of_vertex": node_of_vertex,
            "mean_radii": mean_radii,
            "anchors": anchors,
        }.items():
            object.__setattr__(self, name, read_only(value))

    def __repr__(self) -> str:
        numbers = {"node": self.nodes, "edge": self.edges, "tip": self.tips, "junction": self.junctions}
        counts = [counted(len(each), noun) for noun, each in numbers.items()]
        return f"Skeleton({', '.join([*counts, counted(self.cycle_rank, 'cycle')])})"

    @cached_property
    def degrees(self) -> NDArray[np.int64]:
        """(k,) number of edges at each node."""
        return read_only(np.bincount(self.edges.ravel(), minlength=len(self.nodes)))

    @property
    def tips(self) -> NDArray[np.int64]:
        """(t,) nodes with one edge, at the ends of the shape."""
        return np.flatnonzero(self.degrees == 1)

    @property
    def junctions(self) -> NDArray[np.int64]:
        """(j,) nodes with three or more edges."""
        return np.flatnonzero(self.degrees >= 3)

    @cached_property
    def edge_lengths(self) -> NDArray[np.float64]:
        """(e,) length of each edge."""
        start, end = self.nodes[self.edges].transpose(1, 0, 2)
        return read_only(vector_lengths(end - start))

    @property
    def length(self) -> float:
        """Total length of the edges."""
        return float(self.edge_lengths.sum())

    @cached_property
    def component_of_node(self) -> NDArray[np.int64]:
        """(k,) index of the connected component of each node."""
        first = component_roots(self.edges, np.zeros(len(self.nodes), dtype=np.int64))
        return read_only((np.cumsum(first == np.arange(len(first))) - 1)[first])

    @property
    def n_components(self) -> int:
        """Number of connected components."""
        return int(self.component_of_node.max()) + 1 if len(self.nodes) else 0

    @property
    def cycle_rank(self) -> int:
        """Number of independent cycles: edges minus nodes plus components."""
        return len(self.edges) - len(self.nodes) + self.n_components

    @cached_property
    def adjacency(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Neighbors in compressed form: (k + 1,) where those of each node begin, and (2 e,) all, in ascending order."""
        k = max(len(self.nodes), 1)
        keys = np.concatenate([self.edges @ [k, 1], self.edges @ [1, k]])
        return read_only(np.append(0, np.cumsum(self.degrees))), read_only(keys[stable_order(keys)] % k)

    @cached_property
    def neighbors(self) -> tuple[NDArray[np.int64], ...]:
        """For each node, the nodes that share an edge with it, in ascending order."""
        first, adjacent = self.adjacency
        return tuple(adjacent[begin:end] for begin, end in itertools.pairwise(first.tolist()))

    @cached_property
    def flat_branches(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Nodes of all :attr:`branches`, one after the other, and (b + 1,) where each begins and the last ends."""
        nodes, begins = walk_branches(*self.adjacency)
        return read_only(nodes), read_only(begins)

    @cached_property
    def branch_ends(self) -> NDArray[np.int64]:
        """(b, 2) first and last node of each of the :attr:`branches`."""
        nodes, begins = self.flat_branches
        return read_only(np.stack([nodes[begins[:-1]], nodes[begins[1:] - 1]], axis=1))

    @cached_property
    def branches(self) -> tuple[NDArray[np.int64], ...]:
        """Polylines of node indices, from one tip or junction to the next; a loop without any repeats its first node.

        Together they contain every edge exactly once. They are ordered by their first nodes, with loops without a
        junction last.
        """
        nodes, begins = self.flat_branches
        return tuple(nodes[begin:end] for begin, end in itertools.pairwise(begins.tolist()))

    @cached_property
    def branch_of_node(self) -> NDArray[np.int64]:
        """(k,) index of the branch of each node; -1 at junctions, and at nodes without an edge."""
        branch_of = np.full(len(self.nodes), -1)
        nodes, begins = self.flat_branches
        branch_of[nodes] = np.repeat(np.arange(len(begins) - 1), np.diff(begins))
        branch_of[self.degrees >= 3] = -1
        return read_only(branch_of)

    @property
    def triples(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """All r runs of three nodes along the branches, as three (r,) arrays; around a loop without a junction too."""
        nodes, begins = self.flat_branches
        is_inner = np.ones(len(nodes), dtype=bool)
        is_inner[np.concatenate([begins[:-1], begins[1:] - 1])] = False
        inner = np.flatnonzero(is_inner)
        starts, stops = self.branch_ends.T
        is_loop = (starts == stops) & (self.degrees[starts] == 2)
        first, last = begins[:-1][is_loop], begins[1:][is_loop] - 1
        runs = ((inner - 1, last - 1), (inner, first), (inner + 1, first + 1))
        previous, middle, following = (nodes[np.concatenate(run)] for run in runs)
        return previous, middle, following

    def branch_medians(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) median over the branch of each node, the largest where branches meet; 0 at nodes without an edge.

        Parameters
        ----------
        values : (k,) array of float
            At the nodes.
        """
        nodes, begins = self.flat_branches
        medians = np.zeros(len(self.nodes))
        np.maximum.at(medians, nodes, np.repeat(group_medians(values[nodes], begins), np.diff(begins)))
        return medians

    @property
    def end_branches(self) -> list[NDArray[np.int64]]:
        """The branches between a junction and a tip, the junction first."""
        to_tip = [branch if self.degrees[branch[-1]] == 1 else branch[::-1] for branch in self.branches]
        return [branch for branch in to_tip if self.degrees[branch[-1]] == 1 and self.degrees[branch[0]] >= 3]
