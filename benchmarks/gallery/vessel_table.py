"""The branches of a tree of vessels as a table: lengths, radii, sections, Strahler orders."""

import numpy as np

import lbskel
from lbskel.shapes import vessel_tree
from lbskel.visualization import Panel, render

shape = vessel_tree(6, min_radius=0.2, seed=1)
skeleton = lbskel.skeletonize(shape.mesh, preset="vessel")
table = lbskel.branch_table(skeleton, shape.mesh)
with open("vessels.csv", "w") as file:
    file.write(table.to_csv())

order = np.zeros(len(skeleton.nodes))
for branch, number in zip(skeleton.branches, table.strahler, strict=True):
    order[branch] = np.maximum(order[branch], number)
field = order[skeleton.node_of_vertex]
render(
    [Panel(shape.mesh, skeleton, "radii"), Panel(shape.mesh, title="order", field=field, field_name="Strahler order")],
    "vessel_table.png",
)

for row in range(3):
    print(
        f"branch {row}: {table.length[row]:.2f} long, radius {table.mean_radius[row]:.2f}, order {table.strahler[row]}"
    )
assert len(table) == len(skeleton.branches)
assert abs(table.volume.sum() / shape.mesh.volume - 1) < 0.01
