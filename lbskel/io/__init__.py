"""Reading and writing of meshes, point clouds and skeletons.

=============  =====  ======  =======================================================
meshes         read   write   remarks
=============  =====  ======  =======================================================
obj            yes    yes     vertices in the order of the ``v`` lines, seams ignored
off            yes    yes     also COFF, NOFF and STOFF
ply            yes    yes     text and binary
stl            yes    yes     equal corners merged on reading; single precision
glb, gltf      yes    no      without compression; meshes of the scene are joined; rigs
                              are written as glb
3mf            yes    no      through trimesh, lxml and networkx; objects are joined
vtp, vtk       yes    no      polygons and triangle strips of VTK's PolyData
=============  =====  ======  =======================================================

Point clouds are read from xyz, txt, csv, ply, off, obj, npy, npz, pcd and las, and from laz through laspy; a mesh file
without faces is a cloud. They are written as ply, xyz and npy.

Skeletons are written and read as below. Positions, edges and cycles are always kept exactly, but for swc with a scale;
other fields as the table says. A lost field is empty after reading, a lost radius_kind the default; lost radii are NaN.

=========  =======  =======  ==============  ===========  =======  =======  ======================================
skeletons  radii    order    node_of_vertex  radius_kind  extras   report   remarks
=========  =======  =======  ==============  ===========  =======  =======  ======================================
swc        kept     lost     lost            kept         lost     lost     a tree; edges that were cut as comments
json       kept     kept     kept            kept         kept     kept
npz        kept     kept     kept            kept         kept     kept
ply        kept     kept     kept            kept         lost     lost     elements vertex, edge, mesh_vertex
vtp        kept     kept     kept            kept         lost     lost     one polyline per branch
graphml    kept     kept     lost            kept         lost     lost     through networkx
csv        kept     kept     lost            lost         lost     lost     two files: nodes and edges
obj        lost     kept     lost            lost         lost     lost     one polyline per branch
=========  =======  =======  ==============  ===========  =======  =======  ======================================

``order`` is the order of the nodes; ``extras`` are the mean radii and the anchors.
JSON has no NaN and no infinity: in the report they become null.

``read_mesh``, ``read_points`` and ``read_skeleton`` raise FormatError for a file that is not in the format, and every
encoder for data that the format cannot hold.
"""

__all__ = [
    "FORMATS",
    "MESH_READERS",
    "MESH_WRITERS",
    "POINT_READERS",
    "POINT_WRITERS",
    "Format",
    "as_mesh",
    "as_shape",
    "read_mesh",
    "read_points",
    "read_skeleton",
    "write_mesh",
    "write_rig",
    "write_safely",
    "write_skeleton",
]

from lbskel.geometry.mesh import as_mesh
from lbskel.io.atomic_write import write_safely
from lbskel.io.gltf_skin import write_rig
from lbskel.io.mesh_io import (
    MESH_READERS,
    MESH_WRITERS,
    read_mesh,
    write_mesh,
)
from lbskel.io.point_io import POINT_READERS, POINT_WRITERS, as_shape, read_points
from lbskel.io.skeleton_io import FORMATS, Format, read_skeleton, write_skeleton
