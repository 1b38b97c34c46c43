"""Bones and weights for a character, a pose, and a GLB for Blender."""

import numpy as np

import lbskel
from lbskel.visualization import Panel, render

mesh = lbskel.read_mesh("meshes/dinosaur.ply")
rigged = lbskel.rig(mesh, lbskel.skeletonize(mesh, preset="character"))
lbskel.write_rig("character.glb", rigged, up="z")

angle = np.radians(35)
turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
posed = rigged.posed({name: turn for name in rigged.names if name.startswith("spine")})
bones = rigged.weights.argmax(axis=1).astype(float)
panels = [Panel(mesh, title="rest", field=bones, field_name="strongest bone"), Panel(posed, title="posed")]
render(panels, "character_to_glb.png")

print(*rigged.names)
assert np.allclose(rigged.weights.sum(axis=1), 1)
assert np.allclose(rigged.posed({}).vertices, mesh.vertices)
