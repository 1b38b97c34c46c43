"""Wrong normals of points sampled from meshes: by the rounds in which normals are turned, and the width of dipoles.

Each mesh is sampled evenly by area. A normal is wrong if it points to the other side than that of its face. Points with
a negative winding number around them are counted too, which the reconstructed surface would miss. Rounds are changed
with the width as it is, and the width with the rounds as they are.
"""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.geometry.normals import normalized, triangle_normals
from lbskel.preprocess import point_normals
from lbskel.preprocess.point_cleaning import clean_points
from lbskel.preprocess.point_normals import N_NEIGHBORS, oriented

ROOT = Path(__file__).parent.parent
N_POINTS = 15_000
SEED = 3
ROUNDS = (0, 2, 4, 8, 16, 32)
WIDTHS = (1.0, 1.5, 2.0, 3.0)  # of dipoles, in spacings


def run(quick: bool, results: Path, meshes: list[Path] | None = None) -> None:
    """Measure the meshes of the repository and those given; write point_orientation.json and point_orientation.md."""
    files = [ROOT / "meshes" / "dinosaur.ply"] if quick else sorted((ROOT / "meshes").glob("*.[pos]*")) + (meshes or [])
    rows = [row for file in files for row in _rows(file, 2_000 if quick else N_POINTS)]
    save_json(results / "point_orientation.json", {"rows": rows}, meshes=files)
    settings = dict.fromkeys((row["rounds"], row["width"]) for row in rows)
    means = [
        {"rounds": rounds, "width": width}
        | {
            what: float(np.mean([row[what] for row in rows if (row["rounds"], row["width"]) == (rounds, width)]))
            for what in ("wrong", "inside out")
        }
        for rounds, width in settings
    ]
    save_markdown(
        results / "point_orientation.md",
        "Wrong normals of points",
        {f"Means over {len(files)} meshes, in percent": markdown_table(means), "Each mesh": markdown_table(rows)},
    )


@contextmanager
def _with_settings(rounds: int, width: float) -> Iterator[None]:
    """Turn normals in so many rounds, with dipoles of that width."""
    usual = point_normals.MAX_TURNS, point_normals.SURFACE_SMOOTHING
    point_normals.MAX_TURNS, point_normals.SURFACE_SMOOTHING = rounds, width
    try:
        yield
    finally:
        point_normals.MAX_TURNS, point_normals.SURFACE_SMOOTHING = usual


def _rows(file: Path, n_points: int) -> list[dict[str, Any]]:
    """One mesh: percent of wrong normals, and of points with a negative winding number around them."""
    mesh, rng = lbskel.read_mesh(file), np.random.default_rng(SEED)
    face = rng.choice(len(mesh.faces), n_points, p=mesh.face_areas / mesh.area)
    corners = mesh.vertices[mesh.faces[face]]
    points = np.einsum("nk,nki->ni", rng.dirichlet(np.ones(3), n_points), corners)
    outward = normalized(triangle_normals(*corners.transpose(1, 0, 2)))
    cloud = clean_points(points, "auto").cloud
    same = cKDTree(points).query(cloud.points)[1]
    width = point_normals.SURFACE_SMOOTHING
    rows = []
    for setting in dict.fromkeys(
        [(rounds, width) for rounds in ROUNDS] + [(point_normals.MAX_TURNS, other) for other in WIDTHS]
    ):
        with _with_settings(*setting):
            found = oriented(cloud)
        around = found.field(width).values()[cloud.nearest(N_NEIGHBORS)[1]].mean(axis=1)
        rows.append(
            {
                "mesh": file.name,
                "rounds": setting[0],
                "width": setting[1],
                "wrong": 100 * float(((found.normals * outward[same]).sum(axis=1) < 0).mean()),
                "inside out": 100 * float((around < 0).mean()),
            }
        )
    return rows
