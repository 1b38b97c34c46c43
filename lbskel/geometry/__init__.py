"""Triangle meshes and point clouds, and queries on them: bounding volumes, cross-sections, distances, components."""

from lbskel.geometry.mesh import Mesh, PointCloud, as_mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap

__all__ = ["Mesh", "PointCloud", "Surface", "VertexMap", "as_mesh"]
