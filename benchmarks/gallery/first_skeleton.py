"""The skeleton of a mesh, with its radii and its score."""

import lbskel
from lbskel.visualization import picture

mesh = lbskel.read_mesh("meshes/dinosaur.ply")
skeleton = lbskel.skeletonize(mesh)
picture(mesh, skeleton, "first_skeleton.png")

print(skeleton)
assert len(skeleton.tips) == 6  # head, tail, four feet
assert skeleton.report["score"]["verdict"] == "pass"
