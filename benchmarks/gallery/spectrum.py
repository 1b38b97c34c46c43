"""Eigenfunctions of a surface, and a mesh from few of them."""

import numpy as np

import lbskel
from lbskel.visualization import Panel, render

mesh = lbskel.read_mesh("meshes/hand.ply")
basis = lbskel.spectral_basis(mesh, 60)
panels = [Panel(mesh, title=f"function {k}", field=basis.functions[:, k], field_name=f"phi_{k}") for k in (1, 2, 5, 12)]
packed = lbskel.compress(mesh, 60)
panels.append(Panel(packed.mesh, title=f"60 coefficients, {packed.bits_per_vertex:.1f} bits a vertex"))
render(panels, "spectrum.png", size=(1500, 500))

print(basis.values[:6].round(4))
assert abs(basis.values[0]) < 1e-8  # the constant function
assert np.allclose(basis.gram(), np.eye(60), atol=1e-8)
