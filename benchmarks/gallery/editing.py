"""A hand bent by its regions: one end is held, the other moves rigidly, the rest follows."""

import numpy as np

import lbskel
from lbskel.visualization import Panel, render

hand = lbskel.read_mesh("meshes/hand.ply")
along, _, normal = np.linalg.svd(hand.vertices - hand.centroid, full_matrices=False)[2]
height = hand.vertices @ along
held, moved = height < np.quantile(height, 0.15), height > np.quantile(height, 0.85)
editor = lbskel.Editor(hand, [held, moved])  # factorized once
motion = lbskel.rigid_motion(axis=normal, angle_deg=50, center=hand.centroid)
bent = editor.edit([lbskel.rigid_motion(), motion])
render([Panel(hand, title="given"), Panel(bent, title="bent by 50 degrees")], "editing.png")

assert np.allclose(bent.vertices[held], hand.vertices[held])
assert abs(bent.area / hand.area - 1) < 0.1
