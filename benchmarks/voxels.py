"""Bodies of voxels, as the segmentation of an image volume has them: whether they have one skeleton in any unit.

The edges of such a mesh are alike, so that rounding errors may choose among them when it is simplified. Trees of
vessels as voxels are measured in four units and places: small ones, which are simplified by quadric errors, with other
values of ``ROUNDING``; and large ones, of which the short edges collapse.
"""

from __future__ import annotations

__all__ = ["run", "voxel_body"]

from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.preprocess import simplification
from lbskel.shapes import Shape, solid_of, vessel_tree
from lbskel.shapes.isosurface import GRID_OFFSET, marching_cubes

EXPONENTS = (-60, -40, -34, -30, -24)  # swept: of two, in ROUNDING; the first rounds nothing
DEFAULT = -30
N_TREES = 4
SMALL, LARGE = (3, 0.2), (12, 0.4)  # forks of a tree, and the size of voxels in median radii
PLACES = ((1.0, 0.0), (1.7, 0.0), (1 / 3.3, 0.0), (1.0, 100.1))  # scales and offsets

BLEND = 1e-3  # of the tubes where they meet, in their radii: nearly none


def voxel_body(shape: Shape, size: float) -> Shape:
    """Mesh the voxels whose centers are in the round cones around the axes of a shape, by marching cubes.

    The vertices lie in the middle between the centers of two voxels, so that the surface has steps. Parts thinner than
    a voxel are lost, and parts nearer to each other than that touch.

    Parameters
    ----------
    shape : Shape
    size : float
        Of a voxel, in median radii.
    """
    truth = shape.truth
    branches = lbskel.Skeleton(truth.nodes, truth.edges, truth.radii).branches
    solid = solid_of([(truth.nodes[branch], truth.radii[branch]) for branch in branches], blend=BLEND)
    step = size * float(np.median(truth.radii))
    mesh = marching_cubes(solid, step)
    origin = solid.centers.min(axis=0) - 2 * solid.radii.max() - GRID_OFFSET * step
    places = (mesh.vertices - origin) / step  # two of the three coordinates of each are integers
    rows, between = np.arange(len(places)), np.abs(places - np.rint(places)).argmax(axis=1)
    middles = np.rint(places)
    middles[rows, between] = np.floor(places[rows, between]) + 0.5
    return Shape(mesh.with_vertices(origin + step * middles), truth, shape.name)


def run(quick: bool, results: Path) -> None:
    """Measure, and write voxels.json and voxels.md."""
    small, large = (
        [voxel_body(vessel_tree(n_forks, seed=seed), size) for seed in range(1 if quick else N_TREES)]
        for n_forks, size in (SMALL, LARGE)
    )
    tables = {"rounding": [_row(small, exponent) for exponent in EXPONENTS], "short edges": [_row(large, DEFAULT)]}
    save_json(results / "voxels.json", tables)
    save_markdown(
        results / "voxels.md",
        "Voxels",
        {
            "Rounding of coordinates, in four places": markdown_table(tables["rounding"]),
            "Short edges collapse, in four places": markdown_table(tables["short edges"]),
        },
    )


def _row(bodies: list[Shape], exponent: int) -> dict[str, Any]:
    """Count the proxies and graphs that bodies have in all places, with coordinates rounded to a power of two."""
    proxies, graphs, accuracies = [], [], []
    with mock.patch.object(simplification, "ROUNDING", 2.0**exponent):
        for body in bodies:
            placed = [lbskel.Mesh(scale * body.mesh.vertices + at, body.mesh.faces) for scale, at in PLACES]
            prepared = [lbskel.prepare(mesh) for mesh in placed]
            proxies.append(len({each.bodies[0].proxy.mesh.faces.tobytes() for each in prepared}))
            skeletons = [lbskel.skeletonize(mesh) for mesh in placed]
            graphs.append(len({(len(each.nodes), each.edges.tobytes()) for each in skeletons}))
            accuracies.append(lbskel.ground_truth_distances(skeletons[0], body.truth).accuracy)
    return {
        "ROUNDING": f"2^{exponent}",
        "bodies": len(bodies),
        "faces": int(np.mean([len(body.mesh.faces) for body in bodies])),
        "proxies": sum(proxies),
        "graphs": sum(graphs),
        "accuracy": float(np.mean(accuracies)),
    }
