"""The same mesh contracted by several Laplacians, and how far each skeleton is from the default's."""

import lbskel
from lbskel.visualization import Panel, render

mesh = lbskel.read_mesh("meshes/hand.ply")
default = lbskel.skeletonize(mesh)
panels = [Panel(mesh, default, "intrinsic Delaunay (default)")]
for operator in ("robust", "mollified", "graph"):
    skeleton = lbskel.skeletonize(mesh, operator=operator)
    distance = lbskel.ground_truth_distances(skeleton, default).accuracy
    panels.append(Panel(mesh, skeleton, f"{operator}: {distance:.2f} radii"))
    assert distance < 0.3
render(panels, "comparing_operators.png", size=(1200, 420))
