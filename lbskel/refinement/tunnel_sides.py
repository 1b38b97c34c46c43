"""The side on which a skeleton passes each tunnel: moves and new paths that would pass another side are undone.

One edge that passes a tunnel on its other side draws a cycle off the tunnel, even if no edge leaves the solid. An edge
and its new course form a loop, which must not go around a tunnel.
"""

from __future__ import annotations

__all__ = ["edges_that_pass", "keep_sides", "n_tunnels_missed", "on_their_side", "paths_that_pass"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction.cycle_classes import are_around_tunnels, tunnels_missed
from lbskel.geometry.surface_queries import Surface
from lbskel.skeleton.skeleton import Skeleton


def edges_that_pass(
    before: NDArray[np.float64], after: NDArray[np.float64], edges: NDArray[np.int64], surface: Surface
) -> NDArray[np.bool_]:
    """(e,) whether an edge passes a tunnel on another side once its ends are moved straight to their new places.

    Parameters
    ----------
    before, after : (n, 3) array of float
        Positions of the nodes.
    edges : (e, 2) array of int
    surface : Surface
    """
    quadrangles = np.concatenate([before[edges], after[edges[:, ::-1]]], axis=1)
    return are_around_tunnels(quadrangles, surface)


def keep_sides(skeleton: Skeleton, nodes: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """(n, 3) new positions of the nodes.

    If these miss more tunnels, the nodes of edges that would pass a tunnel on another side keep their old positions.

    Parameters
    ----------
    skeleton : Skeleton
    nodes : (n, 3) array of float
        The new positions.
    surface : Surface
    """
    passes = edges_that_pass(skeleton.nodes, nodes, skeleton.edges, surface)
    if not passes.any():
        return nodes
    if n_tunnels_missed(replace(skeleton, nodes=nodes), surface) <= n_tunnels_missed(skeleton, surface):
        return nodes
    kept = np.array(nodes)
    while passes.any():
        kept[skeleton.edges[passes]] = skeleton.nodes[skeleton.edges[passes]]
        passes = edges_that_pass(skeleton.nodes, kept, skeleton.edges, surface)
    return kept


def paths_that_pass(
    olds: list[NDArray[np.float64]], news: list[NDArray[np.float64]], surface: Surface
) -> NDArray[np.bool_]:
    """(p,) whether a new path passes a tunnel on another side than the old one.

    Parameters
    ----------
    olds, news : list of (n, 3) array of float
        The points of each, in the same direction; the ends of the old path may be missing in the new one.
    surface : Surface
    """
    return are_around_tunnels([np.concatenate([old, new[::-1]]) for old, new in zip(olds, news, strict=True)], surface)


def on_their_side(
    olds: list[NDArray[np.float64]], news: list[NDArray[np.float64]], surface: Surface
) -> list[NDArray[np.float64]]:
    """Choose the new paths, but the old one for each that passes a tunnel on another side.

    Parameters
    ----------
    olds, news : list of (n, 3) array of float
        The points of each, from the same start to the same end.
    surface : Surface
    """
    passes = paths_that_pass(olds, news, surface)
    return [old if stays else new for old, new, stays in zip(olds, news, passes, strict=True)]


def n_tunnels_missed(skeleton: Skeleton, surface: Surface) -> int:
    """Count the tunnels of a solid that no cycle of its skeleton goes around; 0 where this is not known.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    """
    mesh = surface.proxy.mesh
    if not mesh.genus or skeleton.n_components > 1:
        return 0
    nodes, edges = skeleton.nodes, skeleton.edges
    return surface.proxy.recall(
        "tunnels missed", lambda: tunnels_missed(nodes, edges, mesh, deadline=surface.deadline) or 0, nodes, edges
    )
