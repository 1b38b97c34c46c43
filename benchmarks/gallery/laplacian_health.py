"""The health of a Laplacian: which properties hold on a mesh, and where the weights of an edge are negative."""

import numpy as np

import lbskel
from lbskel.visualization import Panel, render

mesh = lbskel.read_mesh("meshes/octopus.ply")
mesh = mesh.with_vertices(mesh.vertices * [1, 1, 3])  # stretched, so that many triangles are obtuse
panels = []
for name in ("cotangent", "mollified", "robust"):
    laplacian = lbskel.laplacian(mesh, operator=name)
    print(name, lbskel.laplacian_diagnostics(laplacian, mesh), sep="\n")
    entries = laplacian.stiffness.tocoo()
    is_edge = entries.row != entries.col
    negative = np.zeros(len(mesh.vertices))
    np.maximum.at(negative, entries.row[is_edge], entries.data[is_edge])  # S has -w of each edge
    panels.append(Panel(mesh, title=name, field=negative, field_name="most negative weight"))
    assert abs(laplacian.stiffness.sum(axis=1)).max() < 1e-9
    if name == "robust":
        assert negative.max() < 1e-9
render(panels, "laplacian_health.png", size=(1200, 460))
