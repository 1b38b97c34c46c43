"""Distances along a surface by the heat method, and values extended from a few vertices."""

import lbskel
from lbskel.visualization import Panel, render

mesh = lbskel.read_mesh("meshes/octopus.ply")
method = lbskel.HeatMethod(mesh)  # factorized once
distance = method.distance([0])
farthest = int(distance.argmax())
values = method.extend([0, farthest], [1.0, 2.0])
panels = [
    Panel(mesh, title="from one vertex", field=distance, field_name="distance"),
    Panel(mesh, title="to two ends", field=method.distance([0, farthest]), field_name="distance to the nearer"),
    Panel(mesh, title="two values extended", field=values, field_name="value"),
]
render(panels, "geodesics.png", size=(1200, 460))

assert distance[0] < 1e-9
assert values.min() >= 1 - 1e-6
assert values.max() <= 2 + 1e-6
