"""Topology under stress: edge collapse of random positions, and skeletons of noisy surfaces, of genus 0 to 9.

The collapse must keep every handle and leave no other loop, whatever the positions are: random, permuted, projected to
a plane or a line, rounded to a coarse grid, or scaled unevenly. Noise is Gaussian in all directions, in mean edge
lengths; from about 0.3 on, surfaces intersect themselves.
"""

from __future__ import annotations

__all__ = ["run"]

import functools
import time
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.contraction import surgery
from lbskel.contraction.homology import find_tunnels
from lbskel.shapes import capsule, chain_of_tori, sphere, torus

RUNS, QUICK_RUNS = 2000, 120
SKELETONS, QUICK_SKELETONS = 200, 4
NOISES = (0.25, 0.5, 1.0, 1.5)

POSITIONS: dict[str, Callable[[lbskel.Mesh, np.random.Generator], NDArray[np.float64]]] = {
    "scattered": lambda mesh, rng: rng.normal(size=mesh.vertices.shape),
    "shuffled": lambda mesh, rng: rng.permutation(mesh.vertices),
    "on a plane": lambda mesh, rng: rng.normal(size=mesh.vertices.shape) * [1, 1, 0],
    "on a line": lambda mesh, rng: rng.normal(size=mesh.vertices.shape) * [1, 0, 0],
    "on a grid": lambda mesh, rng: np.rint(rng.normal(size=mesh.vertices.shape)),
    "squeezed": lambda mesh, rng: mesh.vertices * 10.0 ** rng.uniform(-4, 1, size=3),
}


def surfaces() -> dict[str, lbskel.Mesh]:
    """Return small closed surfaces of genus 0 to 9."""
    return {
        "ball": sphere(2),
        "rod": capsule(3.0, 0.4, 16),
        "thin ring": torus(1.0, 0.1, 40, 6),
        "thick ring": torus(1.0, 0.6, 20, 16),
        **{f"{genus} rings": chain_of_tori(genus, step=0.3) for genus in range(2, 10)},
    }


def run(quick: bool, results: Path) -> None:
    """Collapse, skeletonize, count, and write topology.json and topology.md."""
    meshes = surfaces()
    collapses = _collapses(meshes, QUICK_RUNS if quick else RUNS)
    skeletons = _skeletons(meshes, QUICK_SKELETONS if quick else SKELETONS)
    save_json(results / "topology.json", {"collapses": collapses, "skeletons": skeletons})
    counts = ("runs", "handles lost", "loops too many", "in pieces")
    total = {"surface": "all", **{key: sum(row[key] for row in collapses) for key in counts}}
    save_markdown(
        results / "topology.md",
        "Topology under stress",
        {
            "Surgery on random positions": markdown_table([*collapses, total]),
            "Whole skeletons of noisy surfaces": markdown_table(skeletons),
        },
    )


def _collapses(meshes: dict[str, lbskel.Mesh], n_runs: int) -> list[dict[str, Any]]:
    """Collapse each surface, one row each: all kinds of positions in turn, handles by the original surface."""
    rows = []
    each = -(-n_runs // len(meshes))
    cached = functools.cache(find_tunnels)  # the surface stays the same, only the positions differ
    for name, mesh in meshes.items():
        kinds = list(POSITIONS.values())
        began = time.perf_counter()
        with mock.patch.object(surgery, "find_tunnels", cached):
            found = [_counts(mesh, kinds[i % len(kinds)](mesh, np.random.default_rng(i))) for i in range(each)]
        wrong = np.array(found)
        rows.append(
            {
                "surface": name,
                "vertices": len(mesh.vertices),
                "genus": mesh.genus,
                "runs": each,
                "handles lost": int((wrong[:, 0] < 0).sum()),
                "loops too many": int((wrong[:, 0] > 0).sum()),
                "in pieces": int((wrong[:, 1] != 1).sum()),
                "loops cut, mean": float(wrong[:, 2].mean()),
                "ms per run": 1e3 * (time.perf_counter() - began) / each,
            }
        )
    return rows


def _counts(mesh: lbskel.Mesh, positions: NDArray[np.float64]) -> tuple[int, int, int]:
    """Count cycles minus genus, components, and loops that were removed."""
    graph = lbskel.collapse_mesh(mesh.with_vertices(positions), mesh)
    skeleton = lbskel.Skeleton(graph.nodes, graph.edges, np.zeros(len(graph.nodes)))
    assert mesh.genus is not None
    return skeleton.cycle_rank - mesh.genus, skeleton.n_components, graph.n_spurious_loops_removed


def _skeletons(meshes: dict[str, lbskel.Mesh], n_runs: int) -> list[dict[str, Any]]:
    """Make skeletons of each surface with each noise, one row each."""
    cases = list(product((name for name, mesh in meshes.items() if mesh.genus), NOISES))
    cases = cases[:: max(1, len(cases) // n_runs)]
    each = -(-n_runs // len(cases))
    return [_noisy_row(name, meshes[name], noise, each) for name, noise in cases]


def _noisy_row(name: str, mesh: lbskel.Mesh, noise: float, n_runs: int) -> dict[str, Any]:
    """Count how often the handles were certified and kept."""
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    height = noise * np.linalg.norm(end - start, axis=1).mean()
    row = {"surface": name, "genus": mesh.genus, "noise": noise, "runs": n_runs}
    outcomes = {
        "right": 0,
        "handles lost": 0,
        "loops too many": 0,
        "wrong and not reported": 0,
        "not guarded": 0,
        "errors": 0,
    }
    for seed in range(n_runs):
        heights = height * np.random.default_rng(seed).standard_normal(mesh.vertices.shape)
        noisy = mesh.with_vertices(mesh.vertices + heights)
        outcomes["not guarded"] += find_tunnels(noisy) is None
        try:
            skeleton = lbskel.skeletonize(noisy)
        except lbskel.LbskelError:
            outcomes["errors"] += 1
            continue
        surplus = skeleton.cycle_rank - (mesh.genus or 0)
        outcomes["right"] += surplus == 0
        outcomes["handles lost"] += surplus < 0
        outcomes["loops too many"] += surplus > 0
        outcomes["wrong and not reported"] += surplus != 0 and skeleton.report["passed"]
    return {**row, **outcomes}
