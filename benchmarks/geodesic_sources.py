"""Distances from several sources at once beside potpourri3d's, and the value that LaPy's own test expects."""

from __future__ import annotations

__all__ = ["PUBLISHED", "published", "rings", "several"]

import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from benchmarks.geodesic_cases import Array, errors, shapes
from lbskel import HeatMethod, Mesh, factorize, laplacian, read_mesh
from lbskel.applications import unfolded_distances
from lbskel.operators.gradients import gradient_matrix, unit_gradients
from lbskel.operators.masses import barycentric_mass

SEVERAL = (2, 10, 100)  # sources at once
PUBLISHED = 0.60497826  # max_distance of test_Geodesics_format in LaPy's expected_outcomes.json
Sources = NDArray[np.int64]


def _exact(mesh: Mesh, n_sources: int) -> tuple[Sources, Array]:
    """Return sources and the exact distance to the nearest of them."""
    V, F, none = np.array(mesh.vertices), np.array(mesh.faces), np.empty(0, dtype=np.int64)
    sources = np.random.default_rng(1).choice(mesh.used_vertices, n_sources, replace=False)
    return sources, np.array(igl.exact_geodesic(V, F, sources, none, np.arange(len(V)), none))


def _potpourris(mesh: Mesh) -> Callable[[Sources], Array]:
    solver = import_module("potpourri3d").MeshHeatMethodDistanceSolver(np.array(mesh.vertices), np.array(mesh.faces))
    return lambda sources: np.array(solver.compute_distance_multisource(sources.tolist()))


def several(quick: bool, peers: bool) -> list[dict[str, Any]]:
    """Measure the mean error of distances to the nearest of several sources, and the time of a later query."""
    rows = []
    for name, mesh in shapes(quick).items():
        queries: dict[str, Callable[[Sources], Array]] = {"lbskel": HeatMethod(mesh).distance}
        if peers and find_spec("potpourri3d"):
            queries["potpourri3d"] = _potpourris(mesh)
        for n_sources in SEVERAL:
            sources, exact = _exact(mesh, n_sources)
            row: dict[str, Any] = {"mesh": name, "sources": n_sources}
            for tool, query in queries.items():
                query(sources)
                start = time.process_time()
                found = query(sources)
                row[f"{tool}, s"] = time.process_time() - start
                row[f"{tool}, mean error"], _, row[f"{tool}, worst"] = errors(found, exact)
            rows.append(row)
    return rows


def rings(quick: bool) -> list[dict[str, Any]]:
    """Measure the mean error of ten sources by the rings that are added to their regions."""
    rows: list[dict[str, Any]] = []
    before = unfolded_distances.RINGS
    try:
        for unfolded_distances.RINGS in (1, 2, 3):
            row: dict[str, Any] = {"rings": unfolded_distances.RINGS}
            for name, mesh in shapes(quick).items():
                sources, exact = _exact(mesh, 10)
                row[name] = errors(HeatMethod(mesh).distance(sources), exact)[0]
            rows.append(row)
    finally:
        unfolded_distances.RINGS = before
    return rows


def published(path: Path, peers: bool) -> list[dict[str, Any]]:
    """Compare the largest distance from the boundary of LaPy's square with that which LaPy's own test asks for.

    LaPy's is that of the heat method on the given triangles, with barycentric masses, the time of a squared mean edge
    length, and the least distance set to zero.
    """
    mesh = read_mesh(path)
    boundary = np.unique(mesh.edges[mesh.faces_per_edge == 1])
    V, F, n = mesh.vertices, mesh.faces, len(mesh.vertices)
    S, M = laplacian(mesh, operator="cotangent").stiffness, barycentric_mass(mesh)
    heat = np.zeros(n)
    heat[boundary] = 1.0
    heat = factorize((M + mesh.edge_lengths.mean() ** 2 * S).tocsc()).solve(heat)
    G, areas = gradient_matrix(F, igl.edge_lengths(V, F), n)
    divergence = G.T @ (np.concatenate([areas, areas]) * unit_gradients(G, -heat))
    potential = np.zeros(n)
    potential[1:] = factorize(S[1:][:, 1:].tocsc()).solve(divergence[1:])
    method = HeatMethod(mesh)
    found = {
        "exact, to the vertices of the boundary": np.linalg.norm(V[:, None] - V[boundary], axis=2).min(axis=1).max(),
        "lbskel": method.distance(boundary).max(),
        "lbskel, integrated": method.distance(boundary, unfolded=False).max(),
        "LaPy's formula by lbskel's matrices": np.ptp(potential),
        "LaPy, published": PUBLISHED,
    }
    if peers and find_spec("lapy"):
        lapy, heats, geometry = (import_module(name) for name in ("lapy", "lapy.heat", "lapy.diffgeo"))
        surface = lapy.TriaMesh(np.array(V), np.array(F))
        distance = np.array(geometry.compute_geodesic_f(surface, heats.diffusion(surface, boundary)))
        found["LaPy"] = distance.max()
    return [
        {"tool": tool, "largest distance": float(value), "from LaPy's": f"{abs(value / PUBLISHED - 1):.1e}"}
        for tool, value in found.items()
    ]
