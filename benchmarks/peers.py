"""Other tools for curve skeletons, each called as its documentation shows; a missing tool gives an error row."""

from __future__ import annotations

__all__ = ["OURS", "PEERS", "SKELETOR", "Graph"]

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.cgal import Graph, cgal_medial


def lbskel_flow(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    import lbskel

    skeleton = lbskel.skeletonize((vertices, faces))
    return skeleton.nodes, skeleton.edges


def lbskel_least_squares(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    import lbskel

    skeleton = lbskel.skeletonize((vertices, faces), preset="least_squares")
    return skeleton.nodes, skeleton.edges


def lbskel_au2008(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    """Contract with the weights printed by Au et al. 2008, plain cotangents and no clamp."""
    import lbskel

    skeleton = lbskel.skeletonize((vertices, faces), preset="au2008")
    return skeleton.nodes, skeleton.edges


def skeletor_edge_collapse(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    """Contract by skeletor to its default area ratio 0.1, then collapse edges."""
    import skeletor
    import trimesh

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    contracted = skeletor.pre.contract(mesh, progress=False)
    skeleton = skeletor.skeletonize.by_edge_collapse(contracted, progress=False)
    return np.asarray(skeleton.vertices), np.asarray(skeleton.edges, dtype=np.int64)


def skeletor_tangent_ball(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    """Fix the mesh as skeletor's documentation shows, and make a skeleton by tangent balls with its defaults."""
    import skeletor
    import trimesh

    mesh = skeletor.pre.fix_mesh(trimesh.Trimesh(vertices, faces, process=False), remove_disconnected=5, inplace=False)
    return swc_graph(skeletor.skeletonize.by_tangent_ball(mesh).swc)


def swc_graph(table: Any) -> Graph:
    """Convert skeletor's table of nodes and parents."""
    ids, parents = table["node_id"].to_numpy(), table["parent_id"].to_numpy()
    order = np.argsort(ids)
    child = np.flatnonzero(parents >= 0)
    parent = order[np.searchsorted(ids[order], parents[child])]
    return table[["x", "y", "z"]].to_numpy(float), np.stack([child, parent], axis=1)


def pygel_separators(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    """Compute multi-scale local separators by PyGEL3D on the graph of the mesh."""
    from pygel3d import graph, hmesh

    mesh = hmesh.Manifold.from_triangles(np.asarray(vertices), np.asarray(faces))
    skeleton = graph.MSLS_skeleton(graph.from_mesh(mesh))
    positions = np.array(skeleton.positions()).reshape(-1, 3)
    used = np.array(list(skeleton.nodes()), dtype=np.int64)
    pairs = [(i, j) for i in used for j in skeleton.neighbors(int(i)) if i < j]
    new_of = np.full(len(positions), -1)
    new_of[used] = np.arange(len(used))
    return positions[used], new_of[np.array(pairs, dtype=np.int64).reshape(-1, 2)]


SKELETOR = "skeletor, contract + edge collapse"  # the method of Au et al., as lbskel's

PEERS: dict[str, Callable[[NDArray[np.float64], NDArray[np.int64]], Graph]] = {
    "lbskel": lbskel_flow,
    "lbskel least_squares": lbskel_least_squares,
    "lbskel au2008": lbskel_au2008,
    SKELETOR: skeletor_edge_collapse,
    "skeletor, tangent ball": skeletor_tangent_ball,  # its best other on these shapes, of waves, TEASAR and this
    "PyGEL3D": pygel_separators,
    "CGAL": cgal_medial,
}

OURS = ("lbskel", "lbskel least_squares", "lbskel au2008")
