"""Meshes, point clouds and skeletons: from files and into files.

=============  =====  ======  =======================================================
meshes         read   write   remarks
=============  =====  ======  =======================================================
obj            yes    yes     vertices in the order of the ``v`` lines, seams ignored
off            yes    yes     also COFF, NOFF and STOFF
ply            yes    yes     text and binary
stl            yes    yes     a soup, merged on reading; written in single precision
glb, gltf      yes    no      needs no compression; meshes of the scene are joined
=============  =====  ======  =======================================================

Point clouds are read from xyz, ply and off.

Skeletons are written and read as below. Positions, edges and cycles always come back exactly, the rest where it says
so. What is lost is empty when read, or NaN for radii.

=========  =======  =======  ==============  ===========  =======  =======  ===================================
skeletons  radii    order    node_of_vertex  radius_kind  extras   report   remarks
=========  =======  =======  ==============  ===========  =======  =======  ===================================
swc        kept     lost     lost            kept         lost     lost     a tree: cycles cut, the cuts noted
json       kept     kept     kept            kept         kept     kept
npz        kept     kept     kept            kept         kept     kept
ply        kept     kept     kept            kept         lost     lost     elements vertex, edge, mesh_vertex
vtp        kept     kept     kept            kept         lost     lost     a polyline per branch
graphml    kept     kept     lost            kept         lost     lost     through networkx
csv        kept     kept     lost            lost         lost     lost     two files, nodes and edges
obj        lost     kept     lost            lost         lost     lost     a polyline per branch
=========  =======  =======  ==============  ===========  =======  =======  ===================================

``order`` is the order of the nodes, ``extras`` are the mean radii and the anchors.
JSON has no NaN and no infinity: in the report they become null.
"""

__all__ = [
    "FORMATS",
    "MESH_READERS",
    "MESH_WRITERS",
    "POINT_READERS",
    "Format",
    "as_mesh",
    "read_mesh",
    "read_points",
    "read_skeleton",
    "write_mesh",
    "write_safely",
    "write_skeleton",
]

from lbskel.geometry.mesh import as_mesh
from lbskel.io.atomic_write import write_safely
from lbskel.io.mesh_io import (
    MESH_READERS,
    MESH_WRITERS,
    POINT_READERS,
    read_mesh,
    read_points,
    write_mesh,
)
from lbskel.io.skeleton_io import FORMATS, Format, read_skeleton, write_skeleton
