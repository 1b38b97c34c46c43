"""What each stage costs with ever more handles, holes, bristles, branches, components and faces around a vertex.

Each input is run in a process of its own; seconds are processor seconds, of all threads together, except for those of
the column "wall clock". The exponent of a stage is the slope of the logarithm of its seconds over that of the count,
fitted to all inputs of up to 10,000 on which it is not too short to measure; up to 1.2 counts as linear. A second
exponent is fitted to the two largest inputs; it is larger where these need what smaller ones do not, a proxy for
example. Larger inputs are left out once one has taken over a fifth of the limit; the next has a dash. The limit is in
wall-clock seconds and includes making the input, so it is wide: other programs may run on the same processors.

Then hard inputs are run with time limits in wall-clock seconds. A limit is kept if the result comes within one and a
half times the limit, or two seconds more. Where the processor time is far less, other programs ran at the same time.
"""

from __future__ import annotations

__all__ = ["run"]

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import lbskel
from benchmarks.harness import fitted_order, markdown_table, run_in_subprocess, save_json, save_markdown, save_picture
from lbskel.contraction import cycle_classes
from lbskel.contraction.homology import find_tunnels
from lbskel.preprocess import proxy
from lbskel.shapes import brush, lattice, perforated_plate, porous_block, sphere, voxel_tree

LIMIT = 600.0  # seconds for each input
LARGEST = 11_000  # upper bound on the counts that exponents are fitted to: four inputs of each kind, 10 to 10,000
MIN_SECONDS = 0.002  # below, a stage counts as too short to measure; a fit over all sizes needs most of them


def shells(n: int) -> lbskel.Mesh:
    """Put n separate spheres of 80 faces on a grid."""
    ball, side = sphere(1), int(np.ceil(n ** (1 / 3)))
    centers = 3.0 * np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)[:n]
    V = (ball.vertices + centers[:, None]).reshape(-1, 3)
    return lbskel.Mesh(V, (ball.faces + len(ball.vertices) * np.arange(n)[:, None, None]).reshape(-1, 3))


def double_cone(n: int) -> lbskel.Mesh:
    """Close a polygon of n corners by a fan of n faces to each of two apices."""
    t, i = 2 * np.pi * np.arange(n) / n, np.arange(n)
    j, ring = (i + 1) % n, np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    faces = [np.stack([i, j, np.full(n, n)], axis=1), np.stack([j, i, np.full(n, n + 1)], axis=1)]
    return lbskel.Mesh(np.concatenate([ring, [[0, 0, 1], [0, 0, -1]]]), np.concatenate(faces))


KINDS: dict[str, tuple[Callable[[int], lbskel.Mesh], tuple[int, ...], Callable[[int], int]]] = {
    "handles of a lattice": (lattice, (2, 3, 5, 8, 14), lambda n: 3 * n**2 * (n - 1) - n**3 + 1),
    "holes of a plate": (perforated_plate, (3, 10, 32, 45), lambda n: n**2),
    "bristles of a brush": (brush, (3, 10, 32, 50), lambda n: n**2),
    "tips of a tree": (voxel_tree, (3, 10, 32, 100), lambda n: n**2 + 2),
    "components": (shells, (10, 100, 1000, 10_000), lambda n: n),
    "valence": (double_cone, (10, 100, 1000, 10_000, 50_000), lambda n: n),
}

HARD: dict[str, Callable[[], lbskel.Mesh]] = {
    "porous block": lambda: porous_block(24),
    "voxel noise": lambda: porous_block(24, grain=0.0),
    "lattice": lambda: lattice(14),
    "brush": lambda: brush(50),
    "tree": lambda: voxel_tree(32),
    "shells": lambda: shells(10_000),
}
TIME_LIMITS = (1.0, 5.0, 30.0)  # seconds
THIN = {"bristles of a brush": 50, "tips of a tree": 60}  # inputs that are simplified to various shares of their faces
REDUCTIONS = (1, 2, 4, 8)  # faces for each face of the proxy
BAR = 9  # length of the bars of a lattice, in their widths
MAX_COMPARED = 900  # tunnels that are compared with cycles, twice as many as in lbskel


def skeletonize_kind(kind: str, n: int) -> dict[str, Any]:
    """Skeletonize one input: its numbers, and the processor time of each stage."""
    mesh = KINDS[kind][0](n)
    seconds: dict[str, float] = {}
    current, since = "", time.process_time()

    def on_stage(stage: str) -> None:
        nonlocal current, since
        now = time.process_time()
        if current:
            seconds[current] = seconds.get(current, 0.0) + now - since
        current, since = stage, now

    began, began_at = time.process_time(), time.perf_counter()
    skeleton = lbskel.skeletonize(mesh, on_stage=on_stage)
    on_stage("")
    return {
        "faces": len(mesh.faces),
        "cycle rank": skeleton.cycle_rank,
        "tips": len(skeleton.tips),
        "wall clock": time.perf_counter() - began_at,
        "all": time.process_time() - began,
        **seconds,
    }


def skeletonize_within(name: str, time_limit: float) -> dict[str, Any]:
    """Skeletonize a hard input with a time limit: how long it took, and what was left out."""
    mesh = HARD[name]()
    given, began, worked = (mesh.vertices, mesh.faces), time.perf_counter(), time.process_time()
    skeleton = lbskel.skeletonize(given, time_limit=time_limit)
    seconds, processor_seconds = time.perf_counter() - began, time.process_time() - worked
    missing = next((note for note in skeleton.report["notes"] if "were left out: " in note), "")
    stages = [each.split(" (")[0] for each in missing.partition("were left out: ")[2].split("; ")]
    return {
        "faces": len(mesh.faces),
        "seconds": seconds,
        "processor seconds": processor_seconds,
        "holds": seconds <= max(1.5 * time_limit, time_limit + 2),
        "nodes": len(skeleton.nodes),
        "verdict": skeleton.report["score"]["verdict"],
        "left out": ", ".join(stages) or "nothing",
    }


def skeletonize_reduced(kind: str, reduction: int) -> dict[str, Any]:
    """Skeletonize a thin input by a proxy of a share of its faces: its tips, and the processor time of some stages."""
    proxy.MAX_REDUCTION = reduction
    row = skeletonize_kind(kind, THIN[kind])
    return {key: row[key] for key in ("faces", "tips", "all", "simplify", "contract", "reroute inside")}


def certify_lattice(n: int) -> dict[str, Any]:
    """Compute the linking form of a lattice with bars as long as nine widths: its size, and the processor time.

    Up to MAX_COMPARED tunnels, also the time in which they are compared with the cycles of its axes.
    """
    mesh = lattice(n, spacing=BAR)
    began = time.process_time()
    tunnels = find_tunnels(mesh)
    seconds = time.process_time() - began
    crossings = tunnels.form.crossings.nnz if tunnels and tunnels.form else 0
    row = {"faces": len(mesh.faces), "certified": tunnels is not None, "crossings": crossings, "seconds": seconds}
    if (mesh.genus or 0) > MAX_COMPARED:
        return {**row, "tunnels missed": None, "seconds to compare": None}
    cycle_classes.MAX_TUNNELS = MAX_COMPARED
    number = np.arange(n**3).reshape(n, n, n)
    pairs = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:]), (number[:, :, :-1], number[:, :, 1:])]
    axes = np.concatenate([np.stack([low.ravel(), high.ravel()], axis=1) for low, high in pairs])
    nodes = BAR * np.stack(np.unravel_index(number.ravel(), number.shape), axis=1).astype(float)
    for _ in range(2):  # the loops outside are projected at the first
        began = time.process_time()
        missed = cycle_classes.tunnels_missed(nodes, axes, mesh)
    return {**row, "tunnels missed": missed, "seconds to compare": time.process_time() - began}


def run(quick: bool, results: Path) -> None:
    """Run all kinds, fit exponents, and write scaling.json, scaling.md and scaling.png."""
    n_sizes = 2 if quick else None
    certificates = [_certificate(n) for n in ((2, 3) if quick else (3, 4, 6, 8, 9, 10, 11))]
    runs = {kind: _runs(kind, KINDS[kind][1][:n_sizes]) for kind in KINDS}
    limited = [
        {"input": name, "time limit": limit, **_limited(name, limit)}
        for name in list(HARD)[: 1 if quick else None]
        for limit in TIME_LIMITS[: 1 if quick else None]
    ]
    reduced = [
        {"input": kind, "faces for each of the proxy": reduction, **_reduced(kind, reduction)}
        for kind in THIN
        for reduction in (() if quick else REDUCTIONS)
    ]
    save_json(
        results / "scaling.json", {"certificates": certificates, "runs": runs, "limited": limited, "reduced": reduced}
    )
    _write(results, certificates, runs, limited, reduced)


def _write(
    results: Path,
    certificates: list[dict[str, Any]],
    runs: dict[str, list[dict[str, Any]]],
    limited: list[dict[str, Any]],
    reduced: list[dict[str, Any]],
) -> None:
    """Fit exponents, and write scaling.md and scaling.png."""
    order = _exponent(certificates, "genus", "seconds", len(certificates))
    tables = {f"Linking numbers of lattices, exponent {order or float('nan'):.2f}": markdown_table(certificates)}
    for kind, rows in runs.items():
        keys = [key for key in dict.fromkeys(key for row in rows for key in row) if key not in NO_SECONDS]
        exponents = [
            {"count": name, **{key: _exponent(some, "count", key, n) for key in keys}}
            for name, some, n in (
                ("exponent", [row for row in rows if row["count"] < LARGEST], len(rows)),
                ("exponent of the last two", rows, 2),
            )
        ]
        tables[kind.capitalize()] = markdown_table([*rows, *exponents])
    tables["Time limits, in seconds"] = markdown_table(limited)
    if reduced:
        tables["Proxies of thin inputs, at most 128,000 faces or this share"] = markdown_table(reduced)
    save_markdown(results / "scaling.md", "Cost of each stage by the size of the input", tables)
    save_picture(results / "scaling.png", lambda figure: _picture(runs, certificates, figure), size=(10, 5))


NO_SECONDS = ("wall clock", "count", "faces", "cycle rank", "tips", "error", "peak megabytes")


def _certificate(n: int) -> dict[str, Any]:
    answer = run_in_subprocess(certify_lattice, n, timeout=LIMIT)
    row = {"genus": KINDS["handles of a lattice"][2](n), **answer.get("value", {"error": answer.get("error")})}
    return {**row, "peak megabytes": answer.get("peak_megabytes")}


def _limited(name: str, time_limit: float) -> dict[str, Any]:
    """Answer of :func:`skeletonize_within` in a process of its own."""
    answer = run_in_subprocess(skeletonize_within, name, time_limit, timeout=LIMIT)
    return answer.get("value", {"error": answer.get("error")})


def _reduced(kind: str, reduction: int) -> dict[str, Any]:
    """Answer of :func:`skeletonize_reduced` in a process of its own."""
    answer = run_in_subprocess(skeletonize_reduced, kind, reduction, timeout=LIMIT)
    return answer.get("value", {"error": answer.get("error")})


def _runs(kind: str, sizes: tuple[int, ...]) -> list[dict[str, Any]]:
    """Run the sizes in turn, as long as they take little of the limit."""
    rows: list[dict[str, Any]] = []
    for n in sizes:
        if rows and not rows[-1].get("all", np.inf) < LIMIT / 5:
            rows.append({"count": KINDS[kind][2](n)})
            break
        answer = run_in_subprocess(skeletonize_kind, kind, n, timeout=LIMIT)
        row = {"count": KINDS[kind][2](n), **answer.get("value", {"error": answer.get("error")})}
        rows.append({**row, "peak megabytes": answer.get("peak_megabytes")})
    return rows


def _exponent(rows: list[dict[str, Any]], size: str, key: str, n: int) -> float | None:
    """Slope fitted to the n largest inputs that took long enough, if there are two."""
    known = [row for row in rows if isinstance(row.get(key), float) and row[key] > MIN_SECONDS][-n:]
    return fitted_order([row[size] for row in known], [row[key] for row in known]) if len(known) > 1 else None


def _picture(runs: dict[str, list[dict[str, Any]]], certificates: list[dict[str, Any]], figure: Any) -> None:
    """Draw seconds over counts, in logarithms."""
    axes = figure.subplots()
    for kind, rows in runs.items():
        known = [row for row in rows if "all" in row]
        axes.loglog([row["count"] for row in known], [row["all"] for row in known], "o-", label=kind)
    known = [row for row in certificates if "seconds" in row]
    axes.loglog([row["genus"] for row in known], [row["seconds"] for row in known], "k--", label="linking numbers")
    axes.set_xlabel("count")
    axes.set_ylabel("processor time [s]")
    axes.legend()
