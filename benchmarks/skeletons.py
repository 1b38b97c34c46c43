"""Skeletons of shapes with a known axis, by lbskel and by other tools, and of the meshes of the repository.

Distances are in units of the true local radius. A tool that fails has a row with its error, and counts as wrong. Tools
whose results differ from run to run are run several times on the clean shapes.
"""

from __future__ import annotations

__all__ = ["run"]

import json
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

import lbskel
from benchmarks.harness import interleaved, markdown_table, median_ratio, run_in_subprocess, save_json, save_markdown
from benchmarks.peers import OURS, PEERS, SKELETOR
from benchmarks.provenance import commit
from benchmarks.summaries import counts_of_right, means
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import inside_fraction
from lbskel.shapes import SHAPES, VARIANTS, Shape, make
from lbskel.visualization import Panel, picture, render

MESHES = Path(__file__).parent.parent / "meshes"
MESH_FILES = [path for path in sorted(MESHES.iterdir()) if path.suffix in (".ply", ".off", ".obj", ".stl")]
QUICK = ("limbs", "knot", "cube_frame")
RANDOM, RUNS = ("PyGEL3D",), 3  # tools that draw random numbers, and how often they run on each clean shape

SKELETOR_PROCESS = """
import sys, trimesh, skeletor
mesh = trimesh.load(sys.argv[1], process=False)
contracted = skeletor.pre.contract(mesh, progress=False)
skeletor.skeletonize.by_edge_collapse(contracted, progress=False).save_swc(sys.argv[2])
"""


def run(quick: bool, results: Path, peers: bool = False, package: str | None = None) -> None:
    """Measure, and write skeletons.json, skeletons.md and pictures.

    With the name of a tool as ``package``, it alone is measured, and its rows replace those in skeletons.json.
    """
    shapes = {(name, variant): make(name, **VARIANTS[variant]) for variant in VARIANTS for name in SHAPES}
    if quick:
        shapes = {key: shape for key, shape in shapes.items() if key[0] in QUICK}
    before = {} if package is None else json.loads((results / "skeletons.json").read_text(encoding="utf-8"))
    measured = [tool for tool in PEERS if peers or tool in OURS] if package is None else [package]
    rows = [_row(tool, name, variant, shape) for (name, variant), shape in shapes.items() for tool in measured]
    rows += [row for row in before.get("shapes", []) if row["tool"] != package]
    tools = [tool for tool in PEERS if tool in {row["tool"] for row in rows}]
    repeated = [
        {"run": number, **_row(tool, name, variant, shape)}
        for tool in measured
        if tool in RANDOM
        for number in range(1, 1 + RUNS)
        for (name, variant), shape in shapes.items()
        if variant == "clean"
    ] or before.get("repeated", [])
    is_ours = package in (None, OURS[0])
    meshes = [_mesh_row(path) for path in MESH_FILES] if is_ours else before["meshes"]
    timed = peers and package is None
    process = [_process_row(n) for n in ((3500,) if quick else (3500, 26000))] if timed else before.get("process", [])
    save_json(
        results / "skeletons.json",
        {"shapes": rows, "repeated": repeated, "meshes": meshes, "process": process},
        packages=("skeletor", "PyGEL3D", "CGAL"),
        meshes=MESH_FILES,
    )
    summary = [_summary(rows, tool, variant) for variant in VARIANTS for tool in tools]
    save_markdown(
        results / "skeletons.md",
        "Skeletons",
        {
            "Shapes with a known axis, means": markdown_table(summary),
            **({"Spread over runs, clean shapes": markdown_table(_runs(repeated))} if repeated else {}),
            "Each shape, lbskel": markdown_table([_brief(row) for row in rows if row["tool"] == "lbskel"]),
            "Meshes of the repository": markdown_table(meshes),
            **({f"Whole processes, {SKELETOR} over lbskel": markdown_table(process)} if process else {}),
        },
    )
    if not is_ours:
        return
    dinosaur = lbskel.read_mesh(MESHES / "dinosaur.ply")
    picture(dinosaur, lbskel.skeletonize(dinosaur), results / "dinosaur.png", size=(900, 660), force=True)
    clean = [
        Panel(shape.mesh, lbskel.skeletonize(shape.mesh), name)
        for (name, variant), shape in shapes.items()
        if variant == "clean"
    ]
    render(clean, results / "skeletons.png", force=True)


def _row(tool: str, name: str, variant: str, shape: Shape) -> dict[str, Any]:
    """Measure one tool on one shape."""
    row: dict[str, Any] = {"tool": tool, "shape": name, "variant": variant, "vertices": len(shape.mesh.vertices)}
    row["commit"] = commit()
    answer = run_in_subprocess(PEERS[tool], np.array(shape.mesh.vertices), np.array(shape.mesh.faces), timeout=120)
    row["seconds"] = answer["seconds"]
    if "error" in answer:
        return {**row, "error": answer["error"]}
    nodes, edges = answer["value"]
    if len(edges) == 0:
        return {**row, "error": "no edges"}
    skeleton = lbskel.Skeleton(nodes, edges, np.zeros(len(nodes)))
    comparison = lbskel.ground_truth_distances(skeleton, shape.truth)
    inside = inside_fraction(skeleton, Surface(shape.mesh))
    measured = asdict(comparison)
    del measured["radius_error"]  # other tools give no radii
    return {**row, **measured, "inside_fraction": inside}


def _brief(row: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in row.items() if key not in ("tool", "seconds", "commit")}


def _summary(rows: list[dict[str, Any]], tool: str, variant: str) -> dict[str, Any]:
    """Compute means over the shapes that gave a skeleton, and counts over all."""
    own = [row for row in rows if row["tool"] == tool and row["variant"] == variant]
    done = [row for row in own if "error" not in row]
    return {
        "variant": variant,
        "tool": tool,
        **means(own),
        **counts_of_right(own),
        "length inside": float(np.mean([row["inside_fraction"] for row in done])) if done else None,
        "median seconds, with imports": float(np.median([row["seconds"] for row in done])) if done else None,
        "measured at": ", ".join(dict.fromkeys(row.get("commit", "as above") for row in own)),
    }


def _runs(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Summarize each run of the tools that run more than once."""
    return [
        {"run": number, **_summary([row for row in rows if row["run"] == number], tool, "clean")}
        for tool, number in dict.fromkeys((row["tool"], row["run"]) for row in rows)
    ]


def _mesh_row(path: Path) -> dict[str, Any]:
    """Summarize the report on one mesh of the repository."""
    mesh = lbskel.read_mesh(path)
    skeleton = lbskel.skeletonize(mesh)
    (part,) = skeleton.report["components"]
    areas = [1.0, *(step["area_ratio"] for step in part["steps"])]
    return {
        "mesh": path.name,
        "faces": len(mesh.faces),
        "steps": len(part["steps"]),
        "status": part["status"],
        "area never rises": bool(np.all(np.diff(areas) < 0)),
        "genus": part["genus"],
        "cycles": skeleton.cycle_rank,
        "components": skeleton.n_components,
        "tips": len(skeleton.tips),
        "nodes inside": float(Surface(mesh).contains(skeleton.nodes).mean()),
        "length inside": skeleton.report["score"]["measures"]["inside_fraction"],
    }


def _process_row(n_vertices: int) -> dict[str, Any]:
    """Time whole processes in turns, with start-up, reading and writing."""
    with tempfile.TemporaryDirectory() as folder:
        mesh, swc = Path(folder) / "mesh.off", Path(folder) / "skeleton.swc"
        shape = make("dinosaur", n_vertices=n_vertices)
        lbskel.write_mesh(mesh, shape.mesh)
        commands = {
            "lbskel": [sys.executable, "-m", "lbskel", "skeletonize", str(mesh), "-o", str(swc), "--force", "--quiet"],
            "skeletor": [sys.executable, "-c", SKELETOR_PROCESS, str(mesh), str(swc)],
        }
        calls = {
            name: lambda command=command: subprocess.run(command, check=True, capture_output=True)
            for name, command in commands.items()
        }
        row: dict[str, Any] = {"mesh": "dinosaur", "faces": len(shape.mesh.faces)}
        try:
            seconds = interleaved(calls, repeats=3)
        except subprocess.CalledProcessError as error:
            return {**row, "error": error.stderr.decode()[-200:]}
    medians = {f"{name}, seconds": float(np.median(values)) for name, values in seconds.items()}
    return {**row, **medians, "ratio": median_ratio(seconds["skeletor"], seconds["lbskel"])}
