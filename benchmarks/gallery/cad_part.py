"""A part of a machine: branches as long as the part, with the preset for CAD."""

import lbskel
from lbskel.shapes import make
from lbskel.visualization import Panel, render

mesh = make("cube_frame", n_vertices=2000).mesh
skeleton = lbskel.skeletonize(mesh, preset="cad")
rods = lbskel.simplify_branches(skeleton, tolerance=0.3)  # the fewest straight pieces
render([Panel(mesh, skeleton, "skeleton"), Panel(mesh, rods, "as rods")], "cad_part.png")

print(f"{len(skeleton.nodes)} nodes, {len(rods.nodes)} as rods")
assert skeleton.cycle_rank == mesh.genus == 5
assert len(rods.nodes) < len(skeleton.nodes) / 2
