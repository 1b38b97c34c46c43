"""Spectra computed by eigenpairs and by LaPy, on the same meshes with the same matrices of linear finite elements."""

from __future__ import annotations

__all__ = ["measure", "tables"]

from collections.abc import Callable
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness import interleaved, markdown_table, median_ratio
from benchmarks.operators_speed import mesh_of
from lbskel import Mesh
from lbskel.applications import eigenpairs
from lbskel.operators import laplacian
from lbskel.shapes import sphere

K = 50
Pairs: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]


def meshes(n_faces: int) -> dict[str, Mesh]:
    """Return a mesh without symmetry, one of three components, and a symmetric one with multiple eigenvalues."""
    ring, part = mesh_of(n_faces), mesh_of(n_faces // 3)
    V, n = part.vertices, len(part.vertices)
    three = Mesh(np.concatenate([V, V + 3, V + 6]), np.concatenate([part.faces + i * n for i in range(3)]))
    return {"torus": ring, "three tori": three, "sphere": sphere(round(np.log(n_faces / 20) / np.log(4)))}


def ours(mesh: Mesh) -> Pairs:
    """Compute eigenvalues and eigenfunctions by eigenpairs."""
    return eigenpairs(laplacian(mesh, mass="full"), K)


def lapys(mesh: Mesh) -> Pairs:
    """Compute eigenvalues and eigenfunctions by LaPy, from the same start vector each time."""
    lapy = import_module("lapy")
    return lapy.Solver(lapy.TriaMesh(np.array(mesh.vertices), np.array(mesh.faces))).eigs(K, rng=0)


def _row(shape: str, mesh: Mesh, by: str, found: Pairs, seconds: list[float]) -> dict[str, Any]:
    values, X = found
    M = laplacian(mesh, mass="full").mass
    return {
        "mesh": shape,
        "vertices": len(mesh.vertices),
        "by": by,
        "seconds": seconds,
        "orthonormal to": float(np.abs(X.T @ (M @ X) - np.eye(K)).max()),
        "zeros": int((np.abs(values) < 1e-6 * values[-1]).sum()),
        "components": mesh.n_components,
        "values": values,
    }


def measure(sizes: tuple[int, ...]) -> list[dict[str, Any]]:
    """Measure each program on each mesh; differences are to eigenpairs, which is complete by Sylvester's law."""
    rows: list[dict[str, Any]] = []
    for n_faces in sizes:
        for shape, mesh in meshes(n_faces).items():
            programs: dict[str, Callable[[Mesh], Pairs]] = {"eigenpairs": ours}
            if find_spec("lapy"):
                programs["LaPy"] = lapys
            seconds = interleaved({name: partial(solve, mesh) for name, solve in programs.items()}, 3)
            found = {name: _row(shape, mesh, name, solve(mesh), seconds[name]) for name, solve in programs.items()}
            exact = found["eigenpairs"]["values"]
            for name, row in found.items():
                difference = np.abs(row["values"] - exact) / exact[-1]
                wrong = difference > 1e-8
                row["first wrong value"] = int(wrong.argmax()) + 1 if wrong.any() else None
                row["difference"] = float(difference[: int(wrong.argmax()) if wrong.any() else K].max())
                row["x eigenpairs"] = median_ratio(seconds[name], seconds["eigenpairs"])
                rows.append(row)
    return rows


def tables(rows: list[dict[str, Any]]) -> dict[str, str]:
    """Tabulate all measures."""
    lines = [{**row, "seconds": float(np.median(row["seconds"]))} for row in rows]
    columns = ["mesh", "vertices", "by", "seconds", "x eigenpairs", "orthonormal to", "zeros", "components"]
    columns += ["difference", "first wrong value"]
    note = f"The {K} smallest eigenpairs. Differences relative to the largest of them, up to the first wrong value,"
    note += " where a function of a multiple eigenvalue is missing and all that follow come too early."
    return {"Spectrum": f"{markdown_table(lines, columns)}\n{note}\n"}
