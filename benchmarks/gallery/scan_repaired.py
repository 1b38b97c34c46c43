"""A scan with noise, holes and crumbs: its defects in sentences, and the skeleton of what it was."""

import numpy as np

import lbskel
from lbskel.shapes import make
from lbskel.visualization import Panel, render

shape = make("tripod", n_vertices=3000).mesh
random = np.random.default_rng(0)
center = shape.vertices[shape.faces].mean(axis=1)
holes = center[random.choice(len(center), 12)]
near = np.linalg.norm(center[:, None] - holes, axis=2).min(axis=1)
edge = np.linalg.norm(np.diff(shape.vertices[shape.edges], axis=1), axis=2).mean()
noisy = shape.vertices + random.normal(scale=0.2 * edge, size=shape.vertices.shape)
scan = lbskel.Mesh(noisy, shape.faces[near > 1.5 * edge])

print(lbskel.check(scan))
skeleton, clean = lbskel.skeletonize(scan, preprocess="scan"), lbskel.skeletonize(shape)
render(
    [Panel(scan, title="scan"), Panel(scan, skeleton, "its skeleton"), Panel(shape, clean, "clean")],
    "scan_repaired.png",
)

assert len(skeleton.tips) == len(clean.tips) == 3
assert lbskel.ground_truth_distances(skeleton, clean).accuracy < 0.1
