"""Tools that make a skeleton of a point cloud, each called as its documentation shows; a missing tool gives an error.

pc-skeletor 1.0.0 requires mistree 1.2.0, which does not build without a Fortran compiler and numpy.distutils; it runs
with mistree 2.0.0 and open3d 0.20, installed without its other dependencies (``pip install --no-deps pc-skeletor``,
``pip install mistree open3d imageio``). Its tree variant must be told which points are trunk and which are branches:
the thicker half of the points, by the true radii, is given as trunk.
"""

from __future__ import annotations

__all__ = ["FAST", "PACKAGES", "TOOLS", "Graph"]

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from benchmarks.peers import skeletor_edge_collapse
from lbskel.shapes import Shape
from lbskel.skeleton.edge_distances import nearest_on_edges

N_NEIGHBORS = 8  # of a point in the graph of the separators
DOWN_SAMPLE = 0.008  # voxel of pc-skeletor, relative to the diagonal: the value of its documentation on unit clouds
POISSON_DEPTH = 8  # pymeshlab's default

Graph = tuple[NDArray[np.float64], NDArray[np.int64]]


def lbskel_flow(points: NDArray[np.float64], shape: Shape) -> Graph:
    """Make the default skeleton of lbskel."""
    import lbskel

    skeleton = lbskel.skeletonize(lbskel.PointCloud(points))
    return np.array(skeleton.nodes), np.array(skeleton.edges)


def lbskel_cao2010(points: NDArray[np.float64], shape: Shape) -> Graph:
    """Contract the points as Cao et al. 2010."""
    import lbskel

    skeleton = lbskel.skeletonize(lbskel.PointCloud(points), preset="cao2010")
    return np.array(skeleton.nodes), np.array(skeleton.edges)


def pygel_separators(points: NDArray[np.float64], shape: Shape) -> Graph:
    """Compute multi-scale local separators of the graph of the nearest neighbors."""
    from pygel3d import graph

    neighbors = cKDTree(points).query(points, k=N_NEIGHBORS + 1)[1]
    links = {(min(i, j), max(i, j)) for i, row in enumerate(neighbors.tolist()) for j in row[1:]}
    given = graph.Graph()
    for point in points:
        given.add_node(point)
    for i, j in sorted(links):
        given.connect_nodes(i, j)
    skeleton = graph.MSLS_skeleton(given)
    nodes = skeleton.nodes()
    number = {node: index for index, node in enumerate(nodes)}
    edges = {(number[i], number[j]) for i in nodes for j in skeleton.neighbors(i) if i < j}
    return np.array(skeleton.positions())[list(nodes)], np.array(sorted(edges), dtype=np.int64).reshape(-1, 2)


def pc_skeletor_lbc(points: NDArray[np.float64], shape: Shape) -> Graph:
    """Contract by the Laplacian of pc-skeletor, and take its graph, a tree."""
    from pc_skeletor import LBC

    return _tree(LBC(point_cloud=_open3d(points), down_sample=DOWN_SAMPLE * float(np.ptp(points, axis=0).max())))


def pc_skeletor_tree(points: NDArray[np.float64], shape: Shape) -> Graph:
    """Contract by pc-skeletor's variant for trees, with the thicker half of the points as trunk."""
    from pc_skeletor import SLBC

    radii = nearest_on_edges(shape.truth, points)[2]
    is_trunk = radii >= np.median(radii)
    if is_trunk.all():  # of one thickness
        is_trunk = np.arange(len(points)) % 2 == 0
    parts = {"trunk": _open3d(points[is_trunk]), "branches": _open3d(points[~is_trunk])}
    size = DOWN_SAMPLE * float(np.ptp(points, axis=0).max())
    return _tree(SLBC(point_cloud=parts, semantic_weighting=30, down_sample=size))


def poisson_skeletor(points: NDArray[np.float64], shape: Shape) -> Graph:
    """Reconstruct a surface by pymeshlab's normals and screened Poisson, and make skeletor's skeleton of it."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=points))
    meshes.compute_normal_for_point_clouds(k=16)
    meshes.generate_surface_reconstruction_screened_poisson(depth=POISSON_DEPTH)
    surface = meshes.current_mesh()
    return skeletor_edge_collapse(surface.vertex_matrix(), surface.face_matrix())


def _open3d(points: NDArray[np.float64]) -> Any:
    import open3d

    return open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))


def _tree(method: Any) -> Graph:
    method.extract_skeleton()
    method.extract_topology()
    graph = method.skeleton_graph  # its topology has straight lines from one end or junction to the next
    number = {node: index for index, node in enumerate(graph.nodes)}
    edges = np.array([(number[i], number[j]) for i, j in graph.edges], dtype=np.int64).reshape(-1, 2)
    return np.array([graph.nodes[node]["pos"] for node in graph.nodes]), edges


TOOLS: dict[str, Callable[[NDArray[np.float64], Shape], Graph]] = {
    "lbskel": lbskel_flow,
    "lbskel cao2010": lbskel_cao2010,
    "PyGEL3D": pygel_separators,
    "pc-skeletor": pc_skeletor_lbc,
    "pc-skeletor, tree": pc_skeletor_tree,
    "Poisson + skeletor": poisson_skeletor,
}
FAST = ("lbskel", "PyGEL3D")  # run on every cloud; the others, of ten seconds to two minutes each, on a few
PACKAGES = ("PyGEL3D", "pc-skeletor", "open3d", "mistree", "skeletor", "pymeshlab")
