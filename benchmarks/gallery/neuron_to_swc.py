"""A neuron from a mesh in nanometers to SWC in micrometers; it has no soma, so that its thickest tip is the root."""

from pathlib import Path

import lbskel
from lbskel.shapes import vessel_tree
from lbskel.visualization import picture

tree = vessel_tree(7, min_radius=0.2, seed=4)
mesh = tree.mesh.with_vertices(tree.mesh.vertices * 500)  # half a micrometer is the radius of the trunk
skeleton = lbskel.skeletonize(mesh, preset="neuron")
lbskel.write_skeleton("neuron.swc", skeleton, scale=0.001, units="um")
picture(mesh, skeleton, "neuron_to_swc.png")

back = lbskel.read_skeleton("neuron.swc")
print(*Path("neuron.swc").read_text().splitlines()[:6], sep="\n")
assert abs(back.length / skeleton.length - 1) < 1e-9  # the scale is stored, and undone on reading
assert (skeleton.n_components, skeleton.cycle_rank) == (1, 0)
assert len(skeleton.tips) == tree.truth.n_tips
