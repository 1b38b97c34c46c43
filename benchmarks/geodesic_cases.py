"""Meshes, sources, exact distances and errors for benchmarks of geodesic distances."""

from __future__ import annotations

__all__ = ["MESHES", "N_SOURCES", "Array", "Query", "errors", "exact_of", "files", "shapes", "sources_of"]

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel import Mesh, read_mesh
from lbskel.shapes import flat_grid, sphere, torus

MESHES = Path(__file__).parent.parent / "meshes"
N_SOURCES = 4
Array = NDArray[np.float64]
Query = Callable[[int], Array]


def files() -> list[Path]:
    """List the repository's meshes."""
    return [path for path in sorted(MESHES.glob("*.*")) if path.suffix != ".md"]


def shapes(quick: bool) -> dict[str, Mesh]:
    """Return the repository's meshes, and regular ones."""
    read = {} if quick else {path.name: read_mesh(path) for path in files()}
    return {**read, "sphere": sphere(3 if quick else 5), "torus": torus(1.0, 0.4, 90, 45), "grid": flat_grid(60, 60)}


def exact_of(mesh: Mesh) -> Query:
    """Return exact distances: by pygeodesic if there is one, else by libigl, by the algorithm of Mitchell et al."""
    V, F = np.array(mesh.vertices), np.array(mesh.faces)
    if find_spec("pygeodesic"):
        algorithm = import_module("pygeodesic.geodesic").PyGeodesicAlgorithmExact(V, F)
        return lambda source: np.array(algorithm.geodesicDistances(np.array([source]))[0])
    none = np.empty(0, dtype=np.int64)
    return lambda source: np.array(igl.exact_geodesic(V, F, np.array([source]), none, np.arange(len(V)), none))


def sources_of(mesh: Mesh) -> list[int]:
    """Return vertices in faces, chosen by chance."""
    return [int(v) for v in np.random.default_rng(0).choice(mesh.used_vertices, N_SOURCES, replace=False)]


def errors(distance: Array, exact: Array) -> tuple[float, float, float]:
    """Return the mean error over the largest distance, the mean relative error, and the largest error likewise."""
    reached = np.isfinite(exact) & (exact < 1e9) & (exact > 0)
    error = np.abs(distance - exact)[reached]
    largest = exact[reached].max()
    return float(error.mean() / largest), float((error / exact[reached]).mean()), float(error.max() / largest)
