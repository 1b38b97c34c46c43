"""Noise removed by diffusion along a Laplacian, with the volume kept."""

import numpy as np

import lbskel
from lbskel.visualization import Panel, render

mesh = lbskel.read_mesh("meshes/octopus.ply")
edge = np.linalg.norm(np.diff(mesh.vertices[mesh.edges], axis=1), axis=2).mean()
noise = np.random.default_rng(0).normal(scale=0.25 * edge, size=mesh.vertices.shape)
noisy = mesh.with_vertices(mesh.vertices + noise)
panels = [Panel(noisy, title="noisy")]
for method in ("implicit", "bilaplacian", "taubin"):
    smoothed = lbskel.smooth(noisy, method=method, keep_volume=True)
    panels.append(Panel(smoothed, title=method))
    error = np.linalg.norm(smoothed.vertices - mesh.vertices, axis=1).mean() / edge
    print(f"{method}: {error:.2f} edge lengths from the clean vertices")
    assert error < np.linalg.norm(noise, axis=1).mean() / edge
    assert abs(smoothed.volume / noisy.volume - 1) < 1e-3
render(panels, "smoothing.png", size=(1400, 400))
