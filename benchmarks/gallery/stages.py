"""The stages: the contraction step by step, the graph that is left of it, and the finished skeleton."""

import lbskel
from lbskel.visualization import Panel, render

prepared = lbskel.prepare("meshes/hand.ply")
(body,) = prepared.bodies
states = []
contraction = lbskel.contract(body.proxy.mesh, on_step=lambda step, mesh: states.append(mesh))
graph = lbskel.collapse(contraction)
raw = lbskel.to_skeleton(graph)
skeleton = lbskel.refine(raw, body)

panels = [Panel(body.mesh, title="prepared")]
panels += [Panel(states[number], title=f"step {number + 1}") for number in (0, 2, len(states) - 1)]
panels += [Panel(body.mesh, raw, title="collapsed"), Panel(body.mesh, skeleton, title="refined")]
render(panels, "stages.png", size=(1500, 420))

print(contraction)
assert contraction.steps[-1].volume_ratio < 1e-4
assert len(skeleton.tips) == 6  # five fingers and the wrist
