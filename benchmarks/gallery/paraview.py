"""A skeleton for ParaView: polylines with radii as VTP, read back, and as tubes."""

import lbskel
from lbskel.shapes import tube_mesh
from lbskel.visualization import Panel, render

mesh = lbskel.read_mesh("meshes/knot.off")
skeleton = lbskel.skeletonize(mesh)
lbskel.write_skeleton("knot.vtp", skeleton)
back = lbskel.read_skeleton("knot.vtp")
render([Panel(mesh, skeleton, "mesh"), Panel(tube_mesh(back).mesh, title="tubes of knot.vtp")], "paraview.png")

assert (back.nodes == skeleton.nodes).all()
assert (back.radii == skeleton.radii).all()
assert back.cycle_rank == 1
