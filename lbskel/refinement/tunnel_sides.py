"""Which side of each tunnel a skeleton passes: moves and paths that would pass another side are taken back.

A cycle around a tunnel can be drawn off it by one edge that passes the tunnel on its other side, without any edge that
leaves the solid. An edge and its new course are a loop, which must not go around a tunnel.
"""

from __future__ import annotations

__all__ = ["are_around_tunnels", "edges_that_pass", "keep_sides", "n_tunnels_missed", "paths_that_pass"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lbskel.contraction import cycle_classes
from lbskel.geometry.surface_queries import Surface
from lbskel.skeleton.skeleton import Skeleton


def are_around_tunnels(loops: list[NDArray[np.float64]], surface: Surface) -> NDArray[np.bool_]:
    """(p,) whether each closed polygon goes around a tunnel of a solid; False where that is not known.

    Parameters
    ----------
    loops : list of (n, 3) array of float
        Corners; an edge leads from the last back to the first.
    surface : Surface
    """
    nowhere = np.zeros(len(loops), dtype=bool)
    if len(loops) == 0 or not surface.proxy.mesh.genus:
        return nowhere
    found = cycle_classes.are_around_tunnels(loops, surface.proxy.mesh, deadline=surface.deadline)
    return nowhere if found is None else found


def edges_that_pass(
    before: NDArray[np.float64], after: NDArray[np.float64], edges: NDArray[np.int64], surface: Surface
) -> NDArray[np.bool_]:
    """(e,) whether an edge passes another side of a tunnel when its ends are moved straight to their new places.

    Parameters
    ----------
    before, after : (n, 3) array of float
        Positions of the nodes.
    edges : (e, 2) array of int
    surface : Surface
    """
    quadrangles = np.concatenate([before[edges], after[edges[:, ::-1]]], axis=1)
    return are_around_tunnels([*quadrangles], surface)


def keep_sides(skeleton: Skeleton, nodes: NDArray[np.float64], surface: Surface) -> NDArray[np.float64]:
    """(n, 3) new positions of the nodes; if more tunnels are missed with them, the present ones where an edge passes.

    Parameters
    ----------
    skeleton : Skeleton
    nodes : (n, 3) array of float
    surface : Surface
    """
    if n_tunnels_missed(replace(skeleton, nodes=nodes), surface) <= n_tunnels_missed(skeleton, surface):
        return nodes
    kept = np.array(nodes)
    while (passes := edges_that_pass(skeleton.nodes, kept, skeleton.edges, surface)).any():
        kept[skeleton.edges[passes]] = skeleton.nodes[skeleton.edges[passes]]
    return kept


def paths_that_pass(
    olds: list[NDArray[np.float64]], news: list[NDArray[np.float64]], surface: Surface
) -> NDArray[np.bool_]:
    """(p,) whether a new path passes another side of a tunnel than the old one.

    Parameters
    ----------
    olds, news : list of (n, 3) array of float
        The points of each, in the same direction; the ends of the old path may be missing in the new one.
    surface : Surface
    """
    return are_around_tunnels([np.concatenate([old, new[::-1]]) for old, new in zip(olds, news, strict=True)], surface)


def n_tunnels_missed(skeleton: Skeleton, surface: Surface) -> int:
    """Count the tunnels of a solid that no cycle of its skeleton goes around; 0 where that is not known.

    Parameters
    ----------
    skeleton : Skeleton
    surface : Surface
    """
    mesh = surface.proxy.mesh
    if not mesh.genus or skeleton.n_components > 1:
        return 0
    return cycle_classes.tunnels_missed(skeleton.nodes, skeleton.edges, mesh, deadline=surface.deadline) or 0
