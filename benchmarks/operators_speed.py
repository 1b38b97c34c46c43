"""Time and memory of every operator compared with direct calls of libigl, robust_laplacian, LaPy and gpytoolbox.

Every call gets a new Mesh, made beforehand; all calls of one size take turns in one process, timed in processor
seconds. Memory is the peak of one call in a process of its own, beyond what the mesh and the packages hold.
"""

from __future__ import annotations

__all__ = ["measure", "picture", "tables"]

import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import igl
import numpy as np
import robust_laplacian

from benchmarks.harness import interleaved, markdown_table, median_ratio, peak_growth, run_in_subprocess
from lbskel import Mesh
from lbskel.operators import OPERATORS
from lbskel.shapes import torus

LIBIGL = "libigl: cotmatrix, massmatrix"
PACKAGES = ("lapy", "gpytoolbox")


def mesh_of(n_faces: int) -> Mesh:
    """Make a torus of about that many faces, with vertices displaced so that some angles are obtuse."""
    m = round(np.sqrt(n_faces / 5))
    ring = torus(1.0, 0.4, n_faces // (2 * m), m)
    by = np.random.default_rng(0).normal(size=ring.vertices.shape)
    return Mesh(ring.vertices + 0.5 / m * by, ring.faces)


def _libigl(mesh: Mesh) -> None:
    igl.cotmatrix(mesh.vertices, mesh.faces)
    igl.massmatrix(mesh.vertices, mesh.faces, igl.MASSMATRIX_TYPE_VORONOI)


def _libigl_delaunay(mesh: Mesh) -> None:
    igl.intrinsic_delaunay_cotmatrix(mesh.vertices, mesh.faces)
    igl.massmatrix(mesh.vertices, mesh.faces, igl.MASSMATRIX_TYPE_VORONOI)


def _robust_laplacian(mesh: Mesh) -> None:
    robust_laplacian.mesh_laplacian(np.array(mesh.vertices), np.array(mesh.faces))


def _lapy(mesh: Mesh) -> None:
    lapy = import_module("lapy")
    lapy.Solver(lapy.TriaMesh(np.array(mesh.vertices), np.array(mesh.faces)), lump=True)


def _gpytoolbox(mesh: Mesh) -> None:
    gpytoolbox = import_module("gpytoolbox")
    gpytoolbox.cotangent_laplacian(np.array(mesh.vertices), np.array(mesh.faces))
    gpytoolbox.massmatrix(np.array(mesh.vertices), np.array(mesh.faces), type="voronoi")


DIRECT: dict[str, tuple[str | None, Callable[[Mesh], None]]] = {  # the optional package that each call needs
    LIBIGL: (None, _libigl),
    "libigl: intrinsic_delaunay_cotmatrix, massmatrix": (None, _libigl_delaunay),
    "robust_laplacian: mesh_laplacian": (None, _robust_laplacian),
    "LaPy: Solver, lumped": ("lapy", _lapy),
    "gpytoolbox: cotangent_laplacian, massmatrix": ("gpytoolbox", _gpytoolbox),
}


def calls() -> dict[str, Callable[[Mesh], Any]]:
    """Return the operators of lbskel by name, then the calls of other packages that are installed."""
    others = {name: call for name, (package, call) in DIRECT.items() if not package or find_spec(package)}
    return {**OPERATORS, **others}


def megabytes(n_faces: int, name: str) -> float | None:
    """Measure the memory of one call in a new process, after a call on a small mesh that loads lazy imports."""
    mesh, call = mesh_of(n_faces), calls()[name]
    call(mesh_of(200))
    return peak_growth(lambda: call(mesh))


def measure(sizes: tuple[int, ...], repeats: dict[int, int]) -> list[dict[str, Any]]:
    """One row for each size and call: seconds of each turn, the median ratio to libigl's, megabytes."""
    rows: list[dict[str, Any]] = []
    for n_faces in sizes:
        mesh = mesh_of(n_faces)
        fresh = dict.fromkeys(calls(), lambda mesh=mesh: Mesh(mesh.vertices, mesh.faces))
        seconds = interleaved(calls(), repeats[n_faces], prepare=fresh, clock=time.process_time)
        rows.extend(
            {
                "faces": len(mesh.faces),
                "call": name,
                "seconds": taken,
                "ratio to libigl": median_ratio(taken, seconds[LIBIGL]),
                "megabytes": run_in_subprocess(megabytes, n_faces, name).get("value"),
            }
            for name, taken in seconds.items()
        )
        absent = [name for name, (package, _) in DIRECT.items() if package and not find_spec(package)]
        rows.extend({"faces": len(mesh.faces), "call": name, "skipped": "not installed"} for name in absent)
    return rows


def tables(rows: list[dict[str, Any]]) -> dict[str, str]:
    """One line for each call: its median seconds, their ratio to libigl's, and megabytes, at each size."""
    lines: dict[str, dict[str, Any]] = {}
    for row in rows:
        line = lines.setdefault(row["call"], {"call": row["call"]})
        size = f"{row['faces'] / 1000:,.0f}k faces: "
        if "skipped" in row:
            line[f"{size}s"] = row["skipped"]
        else:
            line[f"{size}s"] = float(np.median(row["seconds"]))
            line[f"{size}x libigl"] = row["ratio to libigl"]
            line[f"{size}MB"] = row["megabytes"]
    note = "Processor seconds, medians of the turns; x libigl: median of the ratios to its two calls in the same turn."
    return {"Time and memory": f"{markdown_table(list(lines.values()))}\n{note}\n"}


def picture(rows: list[dict[str, Any]], figure: Any) -> None:
    """Plot seconds against faces: operators of lbskel solid, others dashed."""
    ax = figure.subplots()
    for number, name in enumerate(dict.fromkeys(row["call"] for row in rows)):
        own = [row for row in rows if row["call"] == name and "seconds" in row]
        style = "o-" if name in OPERATORS else "s--"
        ax.loglog(
            [r["faces"] for r in own],
            [np.median(r["seconds"]) for r in own],
            style,
            color=f"C{number % 10}",
            label=name,
        )
    ax.set_xlabel("faces")
    ax.set_ylabel("seconds")
    ax.grid(alpha=0.3)
    figure.legend(loc="outside right upper", fontsize=8)
