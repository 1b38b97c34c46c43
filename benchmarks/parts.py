"""Parts and branches: Rand index of segmentations of shapes with known limbs, beside CGAL's; the table of branches.

Further measures are how smooth the boundaries are, and whether they follow concave edges. ``--peers`` adds CGAL's
segmentation by shape diameters, where its headers are installed, and kimimaro's areas of cross-sections of the same
tubes, as voxels. ``--meshes FOLDER`` adds meshes, whose parts are drawn.
"""

from __future__ import annotations

__all__ = ["rand_index", "run"]

import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.application_constants import FACTORS, swept
from benchmarks.cgal import cgal_parts
from benchmarks.damage import DAMAGE, damaged
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.part_boundaries import boundary_measures
from lbskel.applications.face_graph import connect_parts, face_graph
from lbskel.applications.segmentation import THICKNESS
from lbskel.errors import LbskelError
from lbskel.geometry.surface_queries import Surface
from lbskel.shapes import SHAPES, capsule, mesh_solid, solid_of, torus, tube, tube_mesh
from lbskel.visualization import Panel, render

# Shapes whose branches are their limbs; the spine of the dinosaur is neck, body and tail in one, and so is not here.
LIMBED = ("limbs", "octopus", "hand", "spiked_ring", "tripod", "tree", "ladder", "cube_frame")
N_VERTICES = 3000
CONSTANTS = tuple(
    f"applications/{name}.py" for name in ("skeleton_parts", "segmentation", "boundary_cut", "boundary_smoothing")
)
SECTION_FACTORS = (0.025, 0.25, 0.5, 0.7, 1.0, 1.4, 2.0)  # wide, since they mostly bound the time
N_VOXELS = 24  # per radius, of the tube for kimimaro
SMOOTHING = 25  # nodes, of which kimimaro averages the tangents of its sections: one radius


def rand_index(a: NDArray[np.int64], b: NDArray[np.int64]) -> float:
    """Share of the pairs of faces that two segmentations both join or both part: Rand 1971."""
    table = np.zeros((int(a.max()) + 1, int(b.max()) + 1))
    np.add.at(table, (a, b), 1)
    total = len(a) * (len(a) - 1) / 2
    rows, columns, cells = ((x * (x - 1) / 2).sum() for x in (table.sum(axis=1), table.sum(axis=0), table))
    return float(1 - (rows + columns - 2 * cells) / total)


def run(quick: bool, results: Path, peers: bool = False, meshes: list[Path] | None = None) -> None:
    """Measure, and write parts.json and parts.md, and parts.png if there are meshes."""
    parts = [_segmented(name, peers) for name in (LIMBED[:2] if quick else LIMBED)]
    solids = {name: mesh_solid(SHAPES[name](), n_vertices=N_VERTICES) for name in (LIMBED[:2] if quick else LIMBED)}
    others = {each.stem: lbskel.read_mesh(each) for each in meshes or ()}
    found = {name: _parts(mesh) for name, mesh in {**solids, **others}.items()}
    boundaries = [_bounded(name, *each, peers=peers) for name, each in found.items()]
    lengths = _branches()
    sections = _sections(peers and not quick)
    hostile = _hostile(list(DAMAGE)[:4] if quick else list(DAMAGE))
    constants, of_sections = _constants(quick), _constants_of_sections()
    save_json(
        results / "parts.json",
        {
            "parts": parts,
            "boundaries": boundaries,
            "branches": lengths,
            "sections": sections,
            "damaged": hostile,
            "constants": constants,
            "constants_of_sections": of_sections,
        },
        packages=("kimimaro", "CGAL"),
        meshes=meshes or (),
    )
    if meshes:
        _draw({name: found[name] for name in others}, results / "parts.png")
    save_markdown(
        results / "parts.md",
        "Parts and branches",
        {
            "Rand index with the known limbs": markdown_table(parts),
            "Boundaries": "Raggedness: the length of the boundaries along edges over that of the curves where the "
            "labels, diffused over an edge, are one half; along the edges of equilateral triangles a straight line "
            "has 1 to 1.155, 1.10 on average. Turn: by how many degrees the surface turns at the boundaries, inwards "
            "positive; over all edges it is negative, since shapes are convex on the whole.\n\n"
            + markdown_table(boundaries),
            "Lengths and radii of known shapes": markdown_table(lengths),
            "Area of cross-sections of a tube": markdown_table(sections),
            "Damaged meshes": markdown_table(hostile),
            "Constants": "Rand index by the constants of segmentation, each times a factor: the mean and the least of "
            "the shapes above with 1,500 and 3,000 vertices, and a dumbbell, whose thickness jumps.\n\n"
            + markdown_table(constants),
            "Constants of sections": "The largest relative error of the mean area of the cross-sections of a branch, "
            "of three cylinders that meet in a point, by the constants of the measures of branches.\n\n"
            + markdown_table(of_sections),
        },
    )


def _segmented(name: str, peers: bool) -> dict[str, Any]:
    solid = SHAPES[name]()
    mesh = mesh_solid(solid, n_vertices=N_VERTICES)
    truth = solid.nearest_branches(mesh.vertices[mesh.faces].mean(axis=1))
    row: dict[str, Any] = {"shape": name, "faces": len(mesh.faces), "limbs": int(truth.max()) + 1}
    began = time.process_time()
    skeleton = lbskel.skeletonize(mesh)
    row["skeleton, seconds"] = time.process_time() - began
    for thickness in ("inscribed", "shape_diameter"):
        began = time.process_time()
        found = lbskel.segment(mesh, skeleton, thickness=thickness)
        row[f"{thickness}, seconds"] = time.process_time() - began
        row[f"{thickness}, parts"] = len(found)
        row[f"{thickness}, Rand index"] = rand_index(found.part_of_face, truth)
    if peers:
        try:
            theirs, seconds = cgal_parts(mesh.vertices, mesh.faces)
        except RuntimeError as error:
            row["CGAL"] = str(error)
        else:
            row["CGAL, seconds"] = seconds
            row["CGAL, parts"] = int(theirs.max()) + 1
            row["CGAL, Rand index"] = rand_index(theirs, truth)
    return row


def _constants(quick: bool) -> list[dict[str, Any]]:
    """Rand index by the constants of segmentation."""
    ball = np.array([[-0.1, 0, 0], [0.1, 0, 0]])
    dumbbell = solid_of([([[-1, 0, 0], [1, 0, 0]], 0.15), (ball - [1.2, 0, 0], 0.5), (ball + [1.2, 0, 0], 0.5)])
    solids = {name: SHAPES[name]() for name in (LIMBED[:1] if quick else LIMBED)}
    cases = []
    for name, solid, n_vertices in [
        *((name, solid, n) for n in (N_VERTICES // 2, N_VERTICES) for name, solid in solids.items()),
        ("dumbbell", dumbbell, N_VERTICES // 2),
    ]:
        mesh = mesh_solid(solid, n_vertices=n_vertices)
        truth = solid.nearest_branches(mesh.vertices[mesh.faces].mean(axis=1))
        cases.append((f"{name} {n_vertices}", mesh, lbskel.skeletonize(mesh), truth))

    def measure() -> dict[str, Any]:
        found = {
            f"{name}, {thickness}": rand_index(lbskel.segment(mesh, skeleton, thickness=thickness).part_of_face, truth)
            for name, mesh, skeleton, truth in cases
            for thickness in THICKNESS
        }
        least = min(found, key=found.__getitem__)
        return {
            "mean": float(np.mean(list(found.values()))),
            "least": found[least],
            "of": least,
            "dumbbell": found[f"{cases[-1][0]}, {THICKNESS[0]}"],
        }

    return swept(CONSTANTS, measure, (0.7, 1.4) if quick else FACTORS)


def _constants_of_sections() -> list[dict[str, Any]]:
    """Error of the areas of cross-sections by the constants of the measures of branches."""
    tripod = SHAPES["tripod"]()
    mesh = mesh_solid(tripod, n_vertices=N_VERTICES)
    skeleton = lbskel.skeletonize(mesh)
    exact = np.pi * 0.14**2

    def measure() -> dict[str, Any]:
        return {"error": float(np.abs(lbskel.branch_table(skeleton, mesh).section_area / exact - 1).max())}

    rows = swept(("applications/branch_measures.py",), measure, SECTION_FACTORS)
    return [row for row in rows if row["constant"] != "`N_PROFILE`"]  # columns of the table


def _branches() -> list[dict[str, Any]]:
    """Largest relative errors of the lengths, radii and sections of branches."""
    fork = lbskel.Skeleton(
        np.array([[0.0, 0, 0], [0, 0, 9], [5, 0, 15], [-5, 0, 15]]),
        np.array([[0, 1], [1, 2], [1, 3]]),
        np.array([1.0, 0.9, 0.6, 0.7]),
    )
    tripod = SHAPES["tripod"]()
    cases: dict[str, tuple[lbskel.Mesh, Any, Any]] = {
        "capsule": (capsule(4.0, 0.5), [4.0], [0.5]),
        "torus": (torus(1.0, 0.25, 96, 48), [2 * np.pi], [0.25]),
        "tripod": (mesh_solid(tripod, n_vertices=N_VERTICES), lbskel.branch_table(tripod.truth).length, [0.14] * 3),
        "fork, by tube_mesh": (
            tube_mesh(fork).mesh,
            lbskel.branch_table(fork).length,
            lbskel.branch_table(fork).mean_radius,
        ),
    }
    rows = []
    for name, (mesh, lengths, radii) in cases.items():
        table = lbskel.branch_table(lbskel.skeletonize(mesh), mesh)
        errors = [
            np.abs(np.sort(ours) / np.sort(true) - 1).max()
            for ours, true in ((table.length, lengths), (table.mean_radius, radii))
        ]
        rows.append(
            {
                "shape": name,
                "branches": len(table),
                "length, error": errors[0],
                "mean radius, error": errors[1],
                "volume over the mesh's": table.volume.sum() / mesh.volume,
            }
        )
    return rows


def _sections(peers: bool) -> list[dict[str, Any]]:
    """Areas along a bent tube of radius 1, exact pi, by lbskel and by kimimaro."""
    t = np.linspace(0, np.pi / 2, 61)
    mesh = tube(np.stack([10 * np.cos(t), 10 * np.sin(t), 0 * t], axis=1), 1.0, sides=48, rounded=True)
    table = lbskel.branch_table(lbskel.skeletonize(mesh), mesh)
    rows = [{"tool": "exact", "area": np.pi}, {"tool": "lbskel", "area": float(table.section_area[0])}]
    if peers:
        rows.append({"tool": "kimimaro", **_kimimaro(mesh)})
    return rows


def _kimimaro(mesh: lbskel.Mesh) -> dict[str, Any]:
    """Mean area of the sections that kimimaro measures on voxels, more than two radii from the ends."""
    try:
        import kimimaro
    except ImportError:
        return {"note": "not installed"}
    low, step = mesh.vertices.min(axis=0) - 0.5, 1 / N_VOXELS
    shape = np.ceil((np.ptp(mesh.vertices, axis=0) + 1) / step).astype(int)
    labels = np.zeros(shape, dtype=np.uint32)
    x, y = (low[a] + step * (np.arange(shape[a]) + 0.5) for a in (0, 1))
    for k in range(shape[2]):
        grid = np.stack(np.meshgrid(x, y, [low[2] + step * (k + 0.5)], indexing="ij"), axis=-1).reshape(-1, 3)
        labels[:, :, k] = Surface(mesh).contains(grid).reshape(shape[:2])
    found = kimimaro.skeletonize(labels, anisotropy=(step,) * 3, dust_threshold=0, progress=False, parallel=1)
    found = kimimaro.cross_sectional_area(
        labels, found, anisotropy=(step,) * 3, smoothing_window=SMOOTHING, progress=False
    )
    skeleton = found[1]
    points = skeleton.vertices + low
    ends = np.array([[10, 0, 0], [0, 10, 0]])
    inner = np.linalg.norm(points[:, None] - ends, axis=2).min(axis=1) > 2
    areas = skeleton.cross_sectional_area[inner]
    return {"area": float(areas[areas > 0].mean())}


def _hostile(kinds: list[str]) -> list[dict[str, Any]]:
    """What segment and branch_table do with each kind of damage: a result or a typed error."""
    rows, shape = [], torus(1.0, 0.3, 32, 16)
    for kind in kinds:
        broken = damaged(kind, shape)
        if broken.vertices is None:
            continue
        row: dict[str, Any] = {"damage": kind}
        try:
            mesh = lbskel.as_mesh((broken.vertices, broken.faces))
            skeleton = lbskel.skeletonize(mesh)
            row["branches"] = len(lbskel.branch_table(skeleton, mesh))
            row["parts"] = len(lbskel.segment(mesh, skeleton))
        except LbskelError as error:
            row["error"] = type(error).__name__
        rows.append(row)
    return rows


def _parts(mesh: lbskel.Mesh) -> tuple[lbskel.Mesh, NDArray[np.int64]]:
    return mesh, lbskel.segment(mesh, lbskel.skeletonize(mesh, preset="character")).part_of_face


def _bounded(name: str, mesh: lbskel.Mesh, part: NDArray[np.int64], *, peers: bool) -> dict[str, Any]:
    """Number of parts, those in several pieces, the faces of the least, and the measures of the boundaries."""
    graph = face_graph(mesh)
    row = {"mesh": name, "faces": len(part), "parts": int(part.max()) + 1, "least part, faces": np.bincount(part).min()}
    row["parts in pieces"] = int((connect_parts(part, graph, mesh.face_areas) != part).any())
    row |= boundary_measures(mesh, part)
    if peers:
        try:
            theirs = boundary_measures(mesh, cgal_parts(mesh.vertices, mesh.faces)[0])
        except RuntimeError as error:
            row["CGAL"] = str(error).splitlines()[0][:60]
        else:
            row |= {f"CGAL: {what}": value for what, value in theirs.items() if what != "of all edges"}
    return row


def _draw(found: dict[str, tuple[lbskel.Mesh, NDArray[np.int64]]], path: Path) -> None:
    """Draw the parts of each mesh in a color of its own."""
    panels = []
    for name, (mesh, part) in found.items():
        own = lbskel.Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))
        own = own.with_vertices((own.vertices - own.centroid) / own.diameter_bound)
        field = np.repeat(part * 0.618034 % 1, 3)
        panels.append(Panel(own, title=name, field=field, field_name="parts"))
    render(panels, path, force=True)
