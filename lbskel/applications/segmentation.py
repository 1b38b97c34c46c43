"""Segmentation of a mesh into its parts, by the branches of its skeleton and their thickness.

The nodes of the skeleton are divided into parts (:mod:`lbskel.applications.skeleton_parts`). A vertex belongs to the
node that it contracted to, or to a node of another part nearby that is nearer in radii, since where limbs join at their
roots, as fingers do, the surface between them contracts to either. A face costs, for each part, its area times the
distance from its nodes to the part along the skeleton. An edge between two parts costs its length over 1 + c, where the
surface turns inwards by c radians per local radius, since people see the boundaries of parts in concave places:
Hoffman, Richards 1984, "Parts of recognition", https://doi.org/10.1016/0010-0277(84)90022-2. Lengths are in local
radii, so the boundary around a limb moves by about its radius to find a crease. The least sum is sought by graph cuts
(:mod:`lbskel.applications.boundary_cut`), and diffusion of the labels makes the boundaries smooth
(:mod:`lbskel.applications.boundary_smoothing`). Last, every part is made connected, and patches without an end
of the skeleton go to the parts beside them (:mod:`lbskel.applications.flat_parts`).
"""

from __future__ import annotations

__all__ = ["Segmentation", "segment"]

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from lbskel.applications.boundary_cut import expand_labels
from lbskel.applications.boundary_smoothing import concavity, smooth_labels
from lbskel.applications.face_graph import FaceGraph, connect_parts, face_graph
from lbskel.applications.flat_parts import merge_flat_parts
from lbskel.applications.part_volumes import part_volumes
from lbskel.applications.skeleton_parts import parts_of_nodes
from lbskel.errors import choose
from lbskel.geometry.arrays import read_only
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.shape_diameter import local_thickness
from lbskel.preprocess import oriented_surface
from lbskel.skeleton.skeleton import Skeleton
from lbskel.skeleton.source import require_map

# Local radii by which a boundary may move; 2.8 to 5.6 do as well (benchmarks/results/parts.md, "Constants")
MAX_SHIFT = 4.0
# Distance along the skeleton, in MAX_SHIFT local radii, within which a vertex may belong to a nearer node of another
# part; 2.1 to 4.2 do as well (same table)
REACH = 3.0
PARTS_AT_ONCE = 64  # whose distances are computed together, no unit: it bounds the memory (same table: alike)
MAX_SIZE = 100.0  # size of a face or an edge in local radii up to which it counts, so that sums stay finite
MIN_RADIUS = 1e-6  # lower bound on radii, relative to the diameter bound: less is the rounding error of a surface
THICKNESS = ("inscribed", "shape_diameter")


@dataclass(frozen=True, eq=False)
class Segmentation:
    """The parts of a mesh, and a table with one row for each.

    Parameters
    ----------
    part_of_face : (m,) array of int
        From 0 to p - 1.
    part_of_node : (k,) array of int
        The part of each node of the skeleton.
    n_faces : (p,) array of int
    area, volume : (p,) array of float
        Of the part of the surface, and of what it encloses with cones over its boundary; the volumes of all parts sum
        to that of the mesh.
    length : (p,) array of float
        Length of the skeleton in the part.
    mean_radius : (p,) array of float
        Mean of the known radii of the nodes; NaN if none is known.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import capsule
    >>> rod = capsule(3.0, 0.4, 10)
    >>> parts = lbskel.segment(rod, lbskel.skeletonize(rod))
    >>> len(parts), int(parts.n_faces[0]) == len(rod.faces)
    (1, True)
    """

    part_of_face: NDArray[np.int64]
    part_of_node: NDArray[np.int64]
    n_faces: NDArray[np.int64]
    area: NDArray[np.float64]
    volume: NDArray[np.float64]
    length: NDArray[np.float64]
    mean_radius: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.n_faces)

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return the columns of the table by name."""
        names = [field.name for field in fields(self) if not field.name.startswith("part_of")]
        return {"part": np.arange(len(self)), **{name: getattr(self, name) for name in names}}

    def to_csv(self) -> str:
        """Return the table as CSV, one line for each part; NaN is an empty field."""
        columns = self.columns()
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        lines = [",".join("" if value != value else repr(value) for value in row) for row in rows]
        return "\n".join([",".join(columns), *lines, ""])


def segment(mesh: Any, skeleton: Skeleton, *, thickness: str = "inscribed") -> Segmentation:
    """Divide a mesh into its limbs and trunk, and where their thickness jumps, as from a leg to a thicker foot.

    Parameters
    ----------
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
        The mesh that the skeleton was made from; it may be inside out or of mixed orientation.
    skeleton : Skeleton
        With ``node_of_vertex``.
    thickness : str
        ``inscribed``: the skeleton's radii, of its ``radius_kind``, tell where the thickness jumps;
        ``shape_diameter``: half the median shape diameter of the faces of each node.

    Raises
    ------
    MeshError
        If the skeleton has no map from the vertices of this mesh.
    UnknownChoice
        If ``thickness`` is another word.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import make
    >>> mesh = make("octopus", n_vertices=1500).mesh
    >>> parts = lbskel.segment(mesh, lbskel.skeletonize(mesh))
    >>> len(parts)  # eight arms and the head
    9
    """
    choose(dict.fromkeys(THICKNESS), thickness, "thickness")
    surface = oriented_surface(as_mesh(mesh))[0]
    require_map(skeleton, surface.vertices)
    radii = _node_radii(skeleton, surface, thickness)
    of_node = parts_of_nodes(skeleton, radii)
    graph = face_graph(surface)
    distances = _distances(skeleton, radii, of_node)
    nodes = _nodes_of_vertices(skeleton, radii, surface, of_node, distances)
    corners = nodes[surface.faces]
    scale = radii[corners].mean(axis=1)
    sizes = np.minimum(np.sqrt(surface.face_areas) / scale, MAX_SIZE) ** 2
    near = _near(distances, corners)
    labels, cost = _costs(distances, near, corners, sizes)
    labels = expand_labels(labels, cost, graph.pairs, _edge_costs(graph, scale))
    # the region of a thin branch at its root, as of a tail, is wider than the branch
    widths = np.maximum(radii[nodes], np.linalg.norm(surface.vertices - skeleton.nodes[nodes], axis=1))
    labels = smooth_labels(labels, graph, surface.face_areas, widths[surface.faces].mean(axis=1), near)
    labels = connect_parts(labels, graph, surface.face_areas)
    has_end = np.bincount(of_node, skeleton.degrees < 2) > 0
    labels = merge_flat_parts(labels, has_end, graph, surface)
    return _measured(skeleton, surface, labels, of_node)


def _node_radii(skeleton: Skeleton, mesh: Mesh, thickness: str) -> NDArray[np.float64]:
    """(k,) radius at each node; where it is not known, the mean of those known."""
    radii = np.array(skeleton.radii)
    if thickness == "shape_diameter":
        diameter = local_thickness(mesh, np.arange(len(mesh.faces)))
        node = skeleton.node_of_vertex[mesh.faces].ravel()
        value = np.repeat(diameter / 2, 3)
        is_known = np.isfinite(value)
        order = np.lexsort((value[is_known], node[is_known]))
        found, first, count = np.unique(node[is_known][order], return_index=True, return_counts=True)
        radii[found] = value[is_known][order][first + count // 2]
    is_known = np.isfinite(radii) & (radii > 0)
    default = float(radii[is_known].mean()) if is_known.any() else mesh.diameter_bound
    known: NDArray[np.float64] = np.where(is_known, radii, default)
    bounded: NDArray[np.float64] = np.maximum(known, MIN_RADIUS * mesh.diameter_bound)
    return bounded


def _distances(skeleton: Skeleton, radii: NDArray[np.float64], of_node: NDArray[np.int64]) -> csr_array:
    """(k, p) distance of each node from each part along the skeleton, in local radii, up to REACH * MAX_SHIFT.

    Each node has that of its own part, which is not zero; larger ones are not stored.
    """
    k, n_parts = len(skeleton.nodes), int(of_node.max()) + 1
    lengths = skeleton.edge_lengths / radii[skeleton.edges].mean(axis=1) + np.finfo(np.float64).tiny
    to_part = np.stack([k + of_node, np.arange(k)], axis=1)
    graph = weighted_graph(
        np.concatenate([skeleton.edges, skeleton.edges[:, ::-1], to_part]),
        np.concatenate([lengths, lengths, np.full(k, np.finfo(np.float64).tiny)]),
        k + n_parts,
    )
    blocks = []
    for first in range(0, n_parts, PARTS_AT_ONCE):
        starts = k + np.arange(first, min(first + PARTS_AT_ONCE, n_parts))
        found = dijkstra(graph, indices=starts, limit=REACH * MAX_SHIFT)[:, :k]
        blocks.append(csr_array(np.where(np.isfinite(found), found, 0.0)))
    return vstack(blocks).T.tocsr()


def _distances_at(distances: csr_array, nodes: NDArray[np.int64], parts: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n,) distances of n nodes from n parts, at most REACH * MAX_SHIFT."""
    found = np.asarray(distances[nodes, parts]).ravel()
    return np.where(found > 0, found, REACH * MAX_SHIFT)


def _near(distances: csr_array, corners: NDArray[np.int64]) -> csr_array:
    """(m, p) array with an entry for each part within reach of a corner of each face."""
    near: csr_array = sum((distances[each] for each in corners.T[1:]), distances[corners[:, 0]]).sorted_indices()
    return near


def _costs(
    distances: csr_array, near: csr_array, corners: NDArray[np.int64], sizes: NDArray[np.float64]
) -> tuple[NDArray[np.int64], csr_array]:
    """(m,) nearest part of each face, and (m, p) costs of the parts within MAX_SHIFT or, if none is, of the nearest.

    Parameters
    ----------
    distances : (k, p) csr_array
        As of :func:`_distances`.
    near : (m, p) csr_array
        As of :func:`_near`.
    corners : (m, 3) array of int
        Nodes of the corners of the faces.
    sizes : (m,) array of float
        Areas of the faces, in squared local radii.
    """
    face, part = near.tocoo().coords
    cost = np.stack([_distances_at(distances, each[face], part) for each in corners.T], axis=1).mean(axis=1)
    first = np.flatnonzero(np.diff(face, prepend=-1))
    least = np.minimum.reduceat(cost, first)
    nearest = np.flatnonzero(cost == least[face])
    labels = part[nearest[np.unique(face[nearest], return_index=True)[1]]]
    kept = cost <= np.maximum(least, MAX_SHIFT)[face]
    face, part = face[kept], part[kept]
    begins = np.append(0, np.cumsum(np.bincount(face, minlength=len(sizes))))
    shape = len(sizes), distances.shape[1]
    return labels.astype(np.int64), csr_array((sizes[face] * cost[kept], part, begins), shape=shape)


def _nodes_of_vertices(
    skeleton: Skeleton,
    radii: NDArray[np.float64],
    mesh: Mesh,
    of_node: NDArray[np.int64],
    distances: csr_array,
) -> NDArray[np.int64]:
    """(n,) node of each vertex: the nearest one if it is nearer in radii and its part is within reach, else its own."""
    own = skeleton.node_of_vertex
    distance, nearest = cKDTree(skeleton.nodes).query(mesh.vertices)
    own_distance = np.linalg.norm(mesh.vertices - skeleton.nodes[own], axis=1)
    is_nearer = distance / radii[nearest] < own_distance / radii[own]
    is_nearer &= _distances_at(distances, own, of_node[nearest]) < REACH * MAX_SHIFT
    nodes: NDArray[np.int64] = np.where(is_nearer, nearest, own)
    return nodes


def _edge_costs(graph: FaceGraph, scale: NDArray[np.float64]) -> NDArray[np.float64]:
    """(p,) cost of a boundary along each edge: its length in local radii, less where the surface is concave."""
    local = scale[graph.pairs].mean(axis=1)
    lengths: NDArray[np.float64] = np.minimum(graph.lengths / local, MAX_SIZE)
    costs: NDArray[np.float64] = lengths / (1 + concavity(graph, scale))
    return costs


def _measured(skeleton: Skeleton, mesh: Mesh, labels: NDArray[np.int64], of_node: NDArray[np.int64]) -> Segmentation:
    """Measure the parts that have faces; nodes of other parts take the part of most of their faces."""
    kept, part_of_face = np.unique(labels, return_inverse=True)
    new = np.full(int(of_node.max()) + 1, -1)
    new[kept] = np.arange(len(kept))
    part_of_node = new[of_node]
    lost = np.flatnonzero(part_of_node < 0)
    if len(lost):
        pairs = skeleton.node_of_vertex[mesh.faces].ravel() * len(kept) + np.repeat(part_of_face, 3)
        found, votes = np.unique(pairs, return_counts=True)
        node, part = np.divmod(found[np.argsort(-votes, kind="stable")], len(kept))
        first = np.unique(node, return_index=True)[1]
        most = np.zeros(len(skeleton.nodes), dtype=np.int64)
        most[node[first]] = part[first]
        part_of_node[lost] = most[lost]
    p = len(kept)
    share = np.repeat(skeleton.edge_lengths / 2, 2)
    is_known = np.isfinite(skeleton.radii)
    n_known = np.bincount(part_of_node, is_known, minlength=p)
    radii = np.bincount(part_of_node, np.where(is_known, skeleton.radii, 0.0), minlength=p)
    values: dict[str, NDArray[Any]] = {
        "part_of_face": part_of_face.astype(np.int64),
        "part_of_node": part_of_node,
        "n_faces": np.bincount(part_of_face, minlength=p),
        "area": np.bincount(part_of_face, mesh.face_areas, minlength=p),
        "volume": part_volumes(mesh, part_of_face.astype(np.int64), p),
        "length": np.bincount(part_of_node[skeleton.edges.ravel()], share, minlength=p),
        "mean_radius": np.divide(radii, n_known, out=np.full(p, np.nan), where=n_known > 0),
    }
    return Segmentation(**{name: read_only(value) for name, value in values.items()})
