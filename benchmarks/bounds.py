"""Bounds: what is right with some values of bounds that no other benchmark moves.

Edges between pieces of cropped trees, which are false, and across gaps of bent tubes, which are true; and local radii
of closed tubes with fans and of noisy ones.
"""

from __future__ import annotations

__all__ = ["run"]

from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from scipy.spatial import cKDTree

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.geometry.shape_diameter import local_radii
from lbskel.preprocess.holes import close_holes
from lbskel.shapes import cylinder, marching_cubes, solid_of, tube, vessel_tree

COSINES = (-1.0, 0.0, 0.1, 0.2, 0.4, 0.7)
N_TREES, SIDE = 12, 0.5  # cropped trees, and the side of the box in extents of the tree
GAPS, BENDS = (1.0, 2.0, 4.0), (0.0, 30.0, 60.0)  # in radii of the tube, and degrees by which it turns
NEIGHBORS = (4, 8, 16, 32, 64, 10_000)
SIDES, STEP, NOISE = 2000, 0.05, 0.1  # of the closed tube; of the grid of the noisy one; and its noise, in steps


def run(quick: bool, results: Path) -> None:
    """Measure, and write bounds.json and bounds.md."""
    few = 2 if quick else None
    trees, gaps = [_cropped(seed) for seed in range(2 if quick else N_TREES)], _with_gaps()[:few]
    tables: dict[str, list[dict[str, Any]]] = {
        "Edges that join pieces": [_row_of_join(trees, gaps, value) for value in COSINES[:few]],
        "Local radii around vertices, of tubes of radius 1": [_row_of_fan(value) for value in NEIGHBORS[:few]],
    }
    save_json(results / "bounds.json", tables)
    save_markdown(results / "bounds.md", "Bounds", {title: markdown_table(rows) for title, rows in tables.items()})


def _cropped(seed: int) -> lbskel.Mesh:
    """Crop a tree of vessels by a box around a place on its axis."""
    shape, generator = vessel_tree(12, seed=seed), np.random.default_rng(seed)
    center = shape.truth.nodes[generator.integers(len(shape.truth.nodes))]
    half = SIDE / 2 * np.ptp(shape.mesh.vertices, axis=0)
    is_kept = (np.abs(shape.mesh.vertices[shape.mesh.faces].mean(axis=1) - center) < half).all(axis=1)
    return lbskel.Mesh(shape.mesh.vertices, shape.mesh.faces[is_kept])


def _with_gaps() -> list[lbskel.Mesh]:
    """Make tubes of radius 1 that turn along 12 radii, without the faces along a gap in the middle."""
    meshes = []
    for bend in np.radians(BENDS):
        angles = np.linspace(-0.5, 0.5, 121) * bend
        steps = 0.1 * np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1)
        whole, along = tube(np.cumsum(steps, axis=0), 1.0, sides=24, rounded=True), np.cumsum(steps, axis=0)
        station = cKDTree(along).query(whole.vertices[whole.faces].mean(axis=1))[1] * 0.1
        meshes += [lbskel.Mesh(whole.vertices, whole.faces[np.abs(station - 6) > gap / 2]) for gap in GAPS]
    return meshes


def _row_of_join(trees: list[lbskel.Mesh], gaps: list[lbskel.Mesh], value: float) -> dict[str, Any]:
    with mock.patch("lbskel.skeleton.joining.MIN_OUTWARDS", value):
        false, true = (
            sum(lbskel.skeletonize(mesh).report["pieces_joined"] for mesh in meshes) for meshes in (trees, gaps)
        )
    return {"MIN_OUTWARDS": value, "false edges": false, "gaps joined": f"{true}/{len(gaps)}"}


def _row_of_fan(value: int) -> dict[str, Any]:
    """Measure a tube of length 10 that is closed by fans, and a noisy one of length 6 by marching cubes."""
    closed = close_holes(cylinder(1.0, 10.0, SIDES, 2), max_perimeter=10.0).mesh
    smooth = marching_cubes(solid_of([([[-3.0, 0.0, 0.0], [3.0, 0.0, 0.0]], 1.0)]), STEP)
    offsets = np.random.default_rng(0).normal(size=smooth.vertices.shape)
    noisy = smooth.with_vertices(smooth.vertices + NOISE * STEP * offsets)
    rays = mock.patch("lbskel.geometry.shape_diameter.ALL_RAYS", len(closed.faces) // 10)  # as of larger meshes
    with rays, mock.patch("lbskel.geometry.shape_diameter.MAX_AROUND", value):
        radii = [float(np.median(local_radii(mesh))) for mesh in (closed, noisy)]
    return {"MAX_AROUND": value, "with fans": radii[0], "noisy": radii[1]}
