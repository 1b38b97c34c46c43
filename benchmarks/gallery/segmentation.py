"""Limbs and trunk of a mesh, and a table of them."""

import lbskel
from lbskel.visualization import Panel, render

mesh = lbskel.read_mesh("meshes/octopus.ply")
skeleton = lbskel.skeletonize(mesh)
parts = lbskel.segment(mesh, skeleton)
part_of_vertex = parts.part_of_node[skeleton.node_of_vertex].astype(float)
render([Panel(mesh, skeleton), Panel(mesh, title="parts", field=part_of_vertex, field_name="part")], "segmentation.png")

print(parts.to_csv())
assert len(parts) == 9  # eight arms and the head
assert abs(parts.area.sum() / mesh.area - 1) < 1e-9
