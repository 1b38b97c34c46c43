"""Skeletons of real meshes from two sides, beside those of CGAL and PyGEL3D: pictures, and counts in a table.

``--meshes FOLDER`` gives the meshes; only pictures and numbers of them are kept. ``--peers`` adds the other tools.
Radii are distances to the surface. An end is crooked if it turns near its tip and its limb does not: if the chord of
its last piece, of END_SHARE of the mesh's diagonal, is at over CROOKED degrees to that of the piece of the same length
before it. It is curled if its limb turns by over CROOKED degrees, too, by the surface alone: between the centroids of
three bands of geodesic distance from the vertex ahead of the tip, as far apart as the ends of the pieces, each within
one piece of its centroid. Ends shorter than both pieces do not count.
"""

from __future__ import annotations

__all__ = ["run"]

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

import lbskel
from benchmarks.harness import markdown_table, run_in_subprocess, save_json, save_markdown
from benchmarks.peers import PEERS
from lbskel.geometry.graphs import edge_length_graph
from lbskel.geometry.normals import normalized
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import inside_fraction
from lbskel.visualization import Panel, draw

TOOLS = ("lbskel", "CGAL", "PyGEL3D")
# Meshes with limbs, none of them twice; further ones of the folder are left out.
NAMES = (
    *("armadillo", "cat", "dino", "elephant", "fertility", "fish"),
    *("hand", "human_neutral", "koala", "penguin", "scorpion", "spot"),
)
SIDES = (0.0, 90.0)  # degrees about the vertical axis
PATIENCE = 300  # seconds for one skeleton
END_SHARE, CROOKED = 0.015, 30.0
SIZE, N_COLORS = (1320, 500), 128  # of the row of each side; the pictures are to be small


def run(quick: bool, results: Path, meshes: list[Path] | None = None, peers: bool = False) -> None:
    """Write gallery_meshes.md, gallery_meshes.json and a picture for each mesh."""
    paths = {path.stem: path for path in meshes or () if path.stem in NAMES}
    tools = TOOLS if peers else TOOLS[:1]
    rows, sections = [], {}
    for name, path in list(paths.items())[: 1 if quick else None]:
        mesh = lbskel.read_mesh(path)
        measured = [_row(tool, path.name, mesh) for tool in tools]
        rows += [row for row, _ in measured]
        (results / f"gallery_meshes_{name}.png").write_bytes(_from_two_sides(mesh, measured))
        sections[name.replace("_", " ").capitalize()] = f"{path.name}\n\n![{name}](gallery_meshes_{name}.png)\n"
    save_json(
        results / "gallery_meshes.json", {"skeletons": rows}, packages=("PyGEL3D", "CGAL"), meshes=[*paths.values()]
    )
    save_markdown(results / "gallery_meshes.md", "Real meshes", {"Counts": markdown_table(rows), **sections})


def _row(tool: str, name: str, mesh: lbskel.Mesh) -> tuple[dict[str, Any], lbskel.Skeleton | None]:
    """Count what a tool finds on a mesh."""
    row: dict[str, Any] = {"mesh": name, "faces": len(mesh.faces), "tool": tool}
    answer = run_in_subprocess(PEERS[tool], np.array(mesh.vertices), np.array(mesh.faces), timeout=PATIENCE)
    if "error" in answer:
        return {**row, "error": answer["error"].removeprefix("RuntimeError: ")}, None
    nodes, edges = answer["value"]
    surface = Surface(mesh)
    skeleton = lbskel.Skeleton(nodes, edges, surface.distance(nodes))
    counts = {"tips": len(skeleton.tips), "junctions": len(skeleton.junctions), "cycles": skeleton.cycle_rank}
    length = END_SHARE * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    ends = _last_pieces(skeleton, length)
    turning = [end for end in ends if _turn(end) > CROOKED]
    n_curled = sum(_turn_of_limb(end, mesh, length) > CROOKED for end in turning)
    counts |= {"ends": len(ends), "crooked": len(turning) - n_curled, "curled": n_curled}
    return {**row, **counts, "length inside": inside_fraction(skeleton, surface)}, skeleton


def _last_pieces(skeleton: lbskel.Skeleton, length: float) -> list[NDArray[np.float64]]:
    """(3, 3) tip, end of the last piece and of the piece before, for each end branch that is long enough for both."""
    ends = []
    for branch in skeleton.end_branches:
        path = skeleton.nodes[branch[::-1]]
        along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
        if along[-1] >= 2 * length:
            ends.append(np.stack([np.interp([0, length, 2 * length], along, x) for x in path.T], axis=1))
    return ends


def _turn(points: NDArray[np.float64]) -> float:
    """Angle, in degrees, between the chords of three points."""
    first, second = normalized(np.diff(points, axis=0))
    return float(np.degrees(np.arccos(np.clip(first @ second, -1, 1))))


def _turn_of_limb(end: NDArray[np.float64], mesh: lbskel.Mesh, length: float) -> float:
    """Turn of the surface around the last pieces of an end; 0 where its bands are no rings thinner than a piece."""
    [direction] = normalized(end[:1] - end[1])
    [ahead] = Surface(mesh).ray_distance(end[:1], direction[None])
    if not np.isfinite(ahead):
        return 0.0
    vertex = Surface(mesh).vertex_tree.query(end[0] + ahead * direction)[1]
    distances = dijkstra(edge_length_graph(mesh), indices=vertex, limit=ahead + 2.5 * length)
    areas = np.bincount(mesh.faces.ravel(), np.repeat(mesh.face_areas, 3), len(mesh.vertices))
    centroids = []
    for k in range(3):
        band = np.flatnonzero(np.abs(distances - ahead - k * length) < length / 4)
        if not areas[band].any():
            return 0.0
        centroids.append(np.average(mesh.vertices[band], axis=0, weights=areas[band]))
        if np.linalg.norm(mesh.vertices[band] - centroids[-1], axis=1).max() > length:
            return 0.0
    return _turn(np.array(centroids))


def _from_two_sides(mesh: lbskel.Mesh, measured: list[tuple[dict[str, Any], lbskel.Skeleton | None]]) -> bytes:
    """Draw the skeletons of all tools in a row, seen from each side."""
    from PIL import Image

    panels = [
        Panel(
            mesh,
            skeleton,
            f"{row['tool']}: " + (row.get("error") or f"{row['tips']} tips, {row['junctions']} junctions"),
        )
        for row, skeleton in measured
    ]
    rows = [Image.open(io.BytesIO(draw(panels, size=SIZE, turn=turn))).convert("RGB") for turn in SIDES]
    whole = Image.new("RGB", (SIZE[0], len(SIDES) * SIZE[1]))
    for number, row in enumerate(rows):
        whole.paste(row, (0, number * SIZE[1]))
    content = io.BytesIO()
    whole.quantize(N_COLORS).save(content, "png", optimize=True)
    return content.getvalue()
