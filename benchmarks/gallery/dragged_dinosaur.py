"""A dinosaur dragged to the origin: identity rows with a right-hand side of zero pull degenerate vertices there.

The literature replaces the rows of degenerate triangles by identity rows. With a right-hand side of zero this moves
their vertices to the origin; held at their place, they stay.
"""

import numpy as np

import lbskel
from lbskel.visualization import Panel, render

mesh = lbskel.read_mesh("meshes/dinosaur.ply")
mesh = mesh.with_vertices(mesh.vertices - mesh.vertices.min(axis=0) - [0, 0, 3])  # the origin is outside
panels, dragged = [], {}
for name in ("identity row, right-hand side zero", "identity row, held"):
    changes = lbskel.DEGENERACY_STRATEGIES[name]
    states = []
    settings = lbskel.ContractionSettings(energy="least_squares", rollback=False, max_steps=9, **changes)
    contraction = lbskel.contract(mesh, settings, on_step=lambda step, now, states=states: states.append(now))
    dragged[name] = max(step.max_displacement for step in contraction.steps)
    panels.append(Panel(states[-1], title=name))
    print(f"{name}: treated vertices move by {dragged[name]:.3f} of the diameter")
render(panels, "dragged_dinosaur.png")
assert dragged["identity row, right-hand side zero"] > dragged["identity row, held"]
assert np.isfinite(contraction.mesh.vertices).all()
