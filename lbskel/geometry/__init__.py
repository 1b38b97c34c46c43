"""Triangle meshes and point clouds, and the queries on them: search trees, cross-sections, distances, components."""

from lbskel.geometry.mesh import Mesh, PointCloud, as_mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap

__all__ = ["Mesh", "PointCloud", "Surface", "VertexMap", "as_mesh"]
