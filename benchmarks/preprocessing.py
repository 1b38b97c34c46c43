"""Effects of preprocessing on meshes, skeletons of simulated scans, and robustness of the filters.

Distances are of the Hausdorff kind, between samples of both surfaces, as fractions of the diameter
bound.
"""

from __future__ import annotations

__all__ = ["LIMITS", "from_clean", "run", "scanned"]

import resource
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

import lbskel
from benchmarks.damage import DAMAGE, damaged
from benchmarks.harness import interleaved, markdown_table, save_json, save_markdown
from lbskel.errors import LbskelError, MeshError
from lbskel.geometry.mesh import Mesh
from lbskel.io import MESH_READERS
from lbskel.preprocess import PIPELINES, Pipeline, preprocess_mesh, simplify
from lbskel.preprocess.subprocess_filter import run_in_subprocess
from lbskel.shapes import SHAPES, make, torus
from lbskel.skeleton.edge_sampling import sample_edges

MESHES = Path(__file__).parent.parent / "meshes"
# Distances allowed between the skeletons of a scan and of the clean mesh: noise of a tenth of an edge length moves
# cross-sections by hundredths of a radius, holes move tips and junctions by up to a quarter, along a thick body by more
LIMITS = {"mean, in radii": 0.1, "worst twentieth, in radii": 0.25, "worst, of the diagonal": 0.04}
SAMPLED = Pipeline.parse("remesh_isotropic:edge_length=0.011")  # sampling of a simulated scanner
RUNS, QUICK_RUNS = 1000, 20
LIMIT = 10.0  # seconds for one run of a filter, half a second of which starts the process
ENDS = {
    "signal": "child crashes",
    "took more": "over its time",
    "leaves nothing": "leaves nothing",
}  # outcomes by parts of error messages


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write preprocessing.json and preprocessing.md."""
    paths = [path for path in (*sorted(MESHES.iterdir()), *meshes) if path.suffix[1:] in MESH_READERS]
    read = {}
    for path in paths[: 1 if quick else None]:
        with suppress(MeshError):  # a file of points without faces
            read[path.name] = lbskel.read_mesh(path)
    presets = [_preset_row(name, preset, mesh) for name, mesh in read.items() for preset in PIPELINES]
    skeletons = [_skeleton_row(name, mesh) for name, mesh in read.items()]
    scans = [_scan_row(name, make(name).mesh) for name in (["tripod"] if quick else SHAPES)]
    sampled = {name: SAMPLED(mesh).mesh for name, mesh in read.items() if mesh.is_closed_manifold and not quick}
    scans += [_scan_row(name, mesh) for name, mesh in sampled.items()]
    coarse = [] if quick else [_coarse_row(name, faces) for name in SHAPES for faces in (300, 600)]
    cost = [_cost_row(name, mesh) for name, mesh in read.items() if mesh.is_closed_manifold]
    hostile = _hostile(QUICK_RUNS if quick else RUNS)
    measured = {
        "presets": presets,
        "skeletons": skeletons,
        "scans": scans,
        "coarse": coarse,
        "cost": cost,
        "hostile": hostile,
    }
    save_json(results / "preprocessing.json", measured, packages=("pymeshlab", "fast-simplification"), meshes=paths)
    save_markdown(
        results / "preprocessing.md",
        "Preprocessing",
        {
            "Each preset on each mesh": markdown_table(presets),
            "Skeletons with automatic preprocessing": markdown_table(skeletons),
            "Simulated scans: noise, holes, debris; distance to the skeleton of the clean mesh": _limits()
            + markdown_table(scans),
            "Low-poly shapes, means": markdown_table(_coarse_summary(coarse)),
            "Time of the checks of automatic preprocessing, on closed meshes": markdown_table(cost),
            "pymeshlab on damaged meshes, in child processes": markdown_table([hostile]),
        },
    )


def _preset_row(name: str, preset: str, mesh: Mesh) -> dict[str, Any]:
    """Measure sizes, topology and distance after a preset."""
    began = time.perf_counter()
    try:
        result = PIPELINES[preset](mesh)
    except LbskelError as error:
        return {"mesh": name, "preset": preset, "faces": len(mesh.faces), "error": str(error)}
    return {
        "mesh": name,
        "preset": preset,
        "faces": len(mesh.faces),
        "faces after": len(result.mesh.faces),
        "genus": mesh.genus,
        "genus after": result.mesh.genus,
        "components": mesh.n_components,
        "components after": result.mesh.n_components,
        "open edges": int((mesh.faces_per_edge == 1).sum()),
        "open edges after": int((result.mesh.faces_per_edge == 1).sum()),
        "distance": result.report["distance"],
        "seconds": time.perf_counter() - began,
        "unmapped": int((~result.vertex_map.is_mapped).sum()),
    }


def _skeleton_row(name: str, mesh: Mesh) -> dict[str, Any]:
    """Summarize the skeleton of a mesh with automatic preprocessing."""
    try:
        skeleton = lbskel.skeletonize(mesh)
    except LbskelError as error:
        return {"mesh": name, "error": str(error)}
    return {
        "mesh": name,
        "done": ", ".join(step["step"] for step in skeleton.report["preprocess"]["steps"]) or "nothing",
        "components": skeleton.n_components,
        "cycles": skeleton.cycle_rank,
        "tips": len(skeleton.tips),
        "passed": skeleton.report["passed"],
        "score": skeleton.report["score"]["verdict"],
        "seconds": sum(skeleton.report["seconds"].values()),
    }


def scanned(mesh: Mesh, seed: int = 0) -> Mesh:
    """Simulate a scan: noise of a tenth of an edge length, twelve holes, small debris, no shared vertices."""
    rng = np.random.default_rng(seed)
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    length = np.linalg.norm(end - start, axis=1).mean()
    V = mesh.vertices + 0.1 * length * rng.standard_normal(mesh.vertices.shape)
    centers = V[mesh.faces].mean(axis=1)
    seeds = centers[rng.choice(len(centers), 12, replace=False)]
    near = np.linalg.norm(centers[:, None] - seeds, axis=2).min(axis=1)
    F = mesh.faces[near > 1.2 * length]
    debris = torus(length, 0.4 * length, 5, 4)
    positions = V[rng.choice(len(V), 8, replace=False)] + 5 * length * rng.standard_normal((8, 3))
    corners = [V[F], *(debris.vertices[debris.faces] + position for position in positions)]
    soup = np.concatenate(corners).reshape(-1, 3)
    return Mesh(soup, np.arange(len(soup)).reshape(-1, 3))


def _scan_row(name: str, mesh: Mesh) -> dict[str, Any]:
    """Measure the distance between the skeletons of a simulated scan and of the clean mesh."""
    clean = lbskel.skeletonize(mesh)
    began = time.perf_counter()
    skeleton = lbskel.skeletonize(scanned(mesh), preprocess="scan")
    return {
        "shape": name,
        **from_clean(skeleton, clean, mesh.diagonal),
        "cycles": f"{skeleton.cycle_rank} of {clean.cycle_rank}",
        "tips": f"{len(skeleton.tips)} of {len(clean.tips)}",
        "components": skeleton.n_components,
        "seconds": time.perf_counter() - began,
    }


def from_clean(skeleton: lbskel.Skeleton, clean: lbskel.Skeleton, diagonal: float) -> dict[str, Any]:
    """Measure distances between the skeletons of a scan and of the clean mesh, and whether they are within LIMITS."""
    found = lbskel.ground_truth_distances(skeleton, clean)
    curves = [sample_edges(each, diagonal / 2000)[0] for each in (skeleton, clean)]
    apart = [cKDTree(curves[1 - k]).query(curves[k])[0].max() for k in (0, 1)]
    measured = {
        "mean, in radii": max(found.accuracy, found.coverage),
        "worst twentieth, in radii": max(found.accuracy_95, found.coverage_95),
        "worst, of the diagonal": float(max(apart)) / diagonal,
    }
    is_near = all(measured[name] <= limit for name, limit in LIMITS.items())
    is_same = is_near and found.is_topology_right and found.n_tips == found.n_true_tips
    return {**measured, "the same within the limits": is_same}


def _limits() -> str:
    """Describe LIMITS in a line."""
    limits = ", ".join(f"{name}: {limit:g}" for name, limit in LIMITS.items())
    return f"Limits: {limits}; and the same components, cycles and tips. Meshes of files are sampled evenly first.\n\n"


def _coarse_row(name: str, faces: int) -> dict[str, Any]:
    """Measure the skeleton of a coarse shape with and without automatic preprocessing."""
    shape = make(name, n_vertices=2000)
    mesh = simplify(shape.mesh, target_faces=faces).mesh
    row: dict[str, Any] = {"shape": name, "faces": len(mesh.faces)}
    for how in ("none", "auto"):
        comparison = lbskel.ground_truth_distances(lbskel.skeletonize(mesh, preprocess=how), shape.truth)
        row |= {f"accuracy, {how}": comparison.accuracy, f"coverage 95, {how}": comparison.coverage_95}
        row[f"topology right, {how}"] = comparison.is_topology_right
        row[f"tips right, {how}"] = comparison.n_tips == comparison.n_true_tips
    return row


def _coarse_summary(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Compute means and counts with and without automatic preprocessing."""
    return [
        {
            "preprocess": how,
            "shapes": len(rows),
            "accuracy": float(np.mean([row[f"accuracy, {how}"] for row in rows])) if rows else None,
            "coverage 95": float(np.mean([row[f"coverage 95, {how}"] for row in rows])) if rows else None,
            "topology right": sum(row[f"topology right, {how}"] for row in rows),
            "tips right": sum(row[f"tips right, {how}"] for row in rows),
        }
        for how in ("none", "auto")
    ]


def _cost_row(name: str, mesh: Mesh) -> dict[str, Any]:
    """Time the checks of automatic preprocessing, and a whole skeleton for comparison."""
    seconds = interleaved({"look": lambda: preprocess_mesh(Mesh(mesh.vertices, mesh.faces))}, repeats=3)["look"]
    began = time.perf_counter()
    lbskel.skeletonize(Mesh(mesh.vertices, mesh.faces))
    return {
        "mesh": name,
        "faces": len(mesh.faces),
        "look": float(np.median(seconds)),
        "skeletonize": time.perf_counter() - began,
    }


def _hostile(runs: int) -> dict[str, Any]:
    """Count outcomes of remeshing damaged meshes in child processes, and measure the memory of this process."""
    ring, rng = torus(1.0, 0.3, 16, 8), np.random.default_rng(0)
    inputs = []
    for kind in DAMAGE:
        broken = damaged(kind, ring)
        try:
            inputs.append(Mesh(broken.vertices, broken.faces))
        except (LbskelError, TypeError, ValueError):
            continue
    outcomes: Counter[str] = Counter()
    before = _resident() / 1e6
    began = time.perf_counter()
    for number in range(runs):
        if number % 2:
            mesh = inputs[number // 2 % len(inputs)]
        else:
            mesh = Mesh(rng.normal(size=(30, 3)), rng.integers(0, 30, size=(80, 3)))
        length = max(mesh.diagonal, 1e-30) * 10.0 ** rng.uniform(-2, 0)
        try:
            run_in_subprocess("remesh_isotropic", mesh, seconds=LIMIT, target_length=length)
            outcomes["a mesh"] += 1
        except LbskelError as error:
            outcomes[next((name for sign, name in ENDS.items() if sign in str(error)), "child refuses")] += 1
    return {
        "runs": runs,
        **{name: outcomes[name] for name in ("a mesh", "child refuses", *ENDS.values())},
        "caller alive": True,
        "megabytes before": before,
        "megabytes after": _resident() / 1e6,
        "peak of a child, megabytes": resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 / 1e6,
        "seconds": time.perf_counter() - began,
    }


def _resident() -> float:
    """Return the resident memory of this process in bytes; NaN without /proc."""
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[1]) * resource.getpagesize() if statm.exists() else float("nan")
