"""The graph that is left of a contracted mesh: the result of :mod:`lbskel.contraction.surgery`."""

from __future__ import annotations

__all__ = ["CollapsedGraph"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class CollapsedGraph:
    """The graph that remains of a contracted mesh when all its faces have collapsed.

    Parameters
    ----------
    nodes : (k, 3) array of float
        Positions of the nodes, in the units of the contracted mesh.
    kept : (k,) array of int
        Vertices of the contracted mesh that became nodes.
    edges : (e, 2) array of int
        Pairs of nodes.
    node_of_vertex : (n,) array of int
        For each vertex of the source, the node that it was merged into; -1 for a vertex without a face.
    handles_certified : bool
        Whether the tunnel loops of the source were known, so that its handles and the cycles of the graph correspond.
    n_spurious_loops_removed : int
        Cycles around no tunnel that were opened, each by removing an edge.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> graph = lbskel.collapse(lbskel.contract(torus(1.0, 0.2)))
    >>> len(graph.edges) - len(graph.nodes) + 1, graph.handles_certified
    (1, True)
    """

    nodes: NDArray[np.float64]
    kept: NDArray[np.int64]
    edges: NDArray[np.int64]
    node_of_vertex: NDArray[np.int64]
    handles_certified: bool
    n_spurious_loops_removed: int
