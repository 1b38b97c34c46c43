"""Spectra, signatures, shape-DNA and compression beside LaPy and pyFM; operators on thin triangles."""

from __future__ import annotations

__all__ = ["run"]

import time
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.operators_spectrum import meshes
from benchmarks.operators_speed import mesh_of
from benchmarks.smoothing_operators import irregular_sphere
from lbskel import (
    BASES,
    OPERATORS,
    LbskelError,
    Mesh,
    compress,
    eigenpairs,
    heat_kernel_signature,
    laplacian,
    read_mesh,
    shape_dna_distance,
    spectral_basis,
    wave_kernel_signature,
)
from lbskel.shapes import sphere, torus
from lbskel.visualization import Panel, render

MESHES = Path(__file__).parent.parent / "meshes"
PACKAGES = ("lapy", "pyFMaps")
ZERO = 1e-9  # of the largest eigenvalue, up to which one counts as zero: rounding errors are 1e-12 and less


def eigenvalues(quick: bool, peers: bool) -> list[dict[str, Any]]:
    """Measure processor time on the matrices of linear finite elements, and the difference of the eigenvalues."""
    rows = []
    cases = [(name, mesh, 50) for name, mesh in meshes(2_000 if quick else 50_000).items()]
    cases += [] if quick else [("torus", mesh_of(350_000), 100)]
    for name, mesh, k in cases:
        start = time.process_time()
        L = laplacian(mesh, mass="full")
        values, X = eigenpairs(L, k)
        row: dict[str, Any] = {
            "mesh": name,
            "faces": len(mesh.faces),
            "pairs": k,
            "lbskel, s": time.process_time() - start,
        }
        row["residual"] = float(np.abs(L.stiffness @ X - (L.mass @ X) * values).max() / abs(L.stiffness).max())
        row["orthonormal to"] = float(np.abs(X.T @ (L.mass @ X) - np.eye(k)).max())
        if peers and find_spec("lapy"):
            lapy = import_module("lapy")
            start = time.process_time()
            theirs, _ = lapy.Solver(lapy.TriaMesh(np.array(mesh.vertices), np.array(mesh.faces))).eigs(k)
            row["LaPy, s"] = time.process_time() - start
            row["LaPy / lbskel"] = row["LaPy, s"] / row["lbskel, s"]
            positive = values > ZERO * values[-1]
            row["difference"] = float(np.abs(theirs[positive] / values[positive] - 1).max())
        rows.append(row)
    return rows


def signatures(peers: bool) -> list[dict[str, Any]]:
    """Compare signatures and shape-DNA with those of other libraries from their own eigenpairs."""
    if not (peers and find_spec("lapy")):
        return []
    lapy, heat, dna = import_module("lapy"), import_module("lapy.heat"), import_module("lapy.shapedna")
    rows = []
    stretched = sphere(4).with_vertices(sphere(4).vertices * [1.0, 1.3, 1.7])
    normalized, bases = [], []
    for name, mesh in {"ellipsoid": stretched, "dinosaur": read_mesh(MESHES / "dinosaur.ply")}.items():
        surface = lapy.TriaMesh(np.array(mesh.vertices), np.array(mesh.faces))
        values, functions = lapy.Solver(surface).eigs(60)
        basis = spectral_basis(mesh, 60, operator="cotangent", mass="full")
        bases.append(basis)
        normalized.append(dna.reweight_ev(dna.normalize_ev(surface, values)))
        first, last = 4 * np.log(10) / basis.values[[-1, 1]]
        times = np.geomspace(first, last, 20)
        everywhere = np.arange(len(mesh.vertices))
        theirs = heat.diagonal(times[None], everywhere, functions, values[:, None], 60)
        ours = heat_kernel_signature(basis, times)
        rows.append({"mesh": name, "what": "heat kernel", "by": "LaPy", "difference": _difference(ours, theirs)})
        if find_spec("pyFM"):
            hks = import_module("pyFM.signatures.HKS_functions").HKS(values, functions, times)
            rows.append({"mesh": name, "what": "heat kernel", "by": "pyFM", "difference": _difference(ours, hks)})
            energies = np.linspace(np.log(basis.values[1]), np.log(basis.values[-1]), 20)
            wks = import_module("pyFM.signatures.WKS_functions").WKS(values, functions, energies, 0.5, scaled=True)
            ours = wave_kernel_signature(basis, energies, width=0.5)
            rows.append({"mesh": name, "what": "wave kernel", "by": "pyFM", "difference": _difference(ours, wks)})
    distance = dna.compute_distance(*normalized)
    difference = abs(shape_dna_distance(*bases) - distance) / distance
    rows.append({"mesh": "both", "what": "shape-DNA", "by": "LaPy", "difference": difference})
    return rows


def _difference(ours: Any, theirs: Any) -> float:
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


def compression(quick: bool) -> list[dict[str, Any]]:
    """Measure rate and error of both bases, and of positions rounded to so many bits."""
    mesh = sphere(2) if quick else read_mesh(MESHES / "dinosaur.ply")
    rows = []
    for basis in BASES:
        for k in (50, 100) if quick else (50, 100, 200, 400):
            for bits in (8, 10, 12):
                packed = compress(mesh, k, basis=basis, bits=bits)
                rows.append(
                    {
                        "basis": basis,
                        "functions": k,
                        "bits": bits,
                        "bits a vertex": packed.bits_per_vertex,
                        "rms error": packed.rms_error(mesh) / mesh.diameter_bound,
                    }
                )
    V = mesh.vertices - mesh.vertices.min(axis=0)
    for bits in (5, 6, 7, 8, 10):
        step = V.max() / 2**bits
        error = np.sqrt(((np.rint(V / step) * step - V) ** 2).sum(axis=1).mean())
        rate = 3.0 * bits
        rows.append(
            {"basis": "positions", "bits": bits, "bits a vertex": rate, "rms error": error / mesh.diameter_bound}
        )
    return rows


def operators(quick: bool) -> list[dict[str, Any]]:
    """Measure, by operator, errors of a sphere's first 25 eigenvalues and of a shape from 100 functions."""
    ball = sphere(3 if quick else 4)
    irregular = irregular_sphere(3 if quick else 4)
    degree = np.repeat(np.arange(5), 2 * np.arange(5) + 1)
    exact = degree * (degree + 1.0)
    shape = torus(1.0, 0.4, 30, 15) if quick else read_mesh(MESHES / "dinosaur.ply")
    rows = []
    for operator in OPERATORS:
        row: dict[str, Any] = {"operator": f"`{operator}`"}
        for name, mesh in {"regular sphere": ball, "irregular sphere": irregular}.items():
            try:
                found = spectral_basis(mesh, 25, operator=operator).values
            except LbskelError as error:
                row[name] = _reason(error)
                continue
            factor = float(exact[1:] @ found[1:] / (found[1:] @ found[1:]))  # of operators without a scale
            row[name] = float(np.abs(found - exact)[1:].max() / exact[-1])
            row[f"{name}, best factor"] = float(np.abs(factor * found - exact)[1:].max() / exact[-1])
        try:
            basis = spectral_basis(shape, 100, operator=operator)
            offsets = basis.reconstruct(basis.project(shape.vertices)) - shape.vertices
            row["100 functions, rms"] = float(np.sqrt((offsets**2).sum(axis=1).mean()) / shape.diameter_bound)
        except LbskelError as error:
            row["100 functions, rms"] = _reason(error)
        rows.append(row)
    return rows


def _reason(error: LbskelError) -> str:
    return "not symmetric" if "symmetric" in str(error) else type(error).__name__


def picture(results: Path, quick: bool) -> None:
    """Draw a signature, an eigenfunction, and the shape from a few coefficients."""
    mesh = sphere(2) if quick else read_mesh(MESHES / "dinosaur.ply")
    basis = spectral_basis(mesh, 60)
    panels = [
        Panel(mesh, title="eigenfunction 9", field=basis.functions[:, 8], field_name="eigenfunction"),
        Panel(
            mesh,
            title="heat kernel signature",
            field=np.log(heat_kernel_signature(basis, [4 * np.log(10) / basis.values[20]])[:, 0]),
            field_name="log of the signature",
        ),
    ]
    for k in (20, 100) if quick else (30, 100, 300):
        packed = compress(mesh, k)
        title = f"{k} functions, {packed.bits_per_vertex:.2g} bits a vertex"
        panels.append(Panel(Mesh(packed.mesh.vertices, mesh.faces), title=title))
    render(panels, results / "applications_spectrum.png", force=True)


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Write applications_spectrum.json, .md and .png."""
    measured: dict[str, Any] = {
        "quick": quick,
        "eigenvalues": eigenvalues(quick, peers),
        "signatures": signatures(peers),
        "compression": compression(quick),
        "operators": operators(quick),
    }
    save_json(results / "applications_spectrum.json", measured, packages=PACKAGES, meshes=[MESHES / "dinosaur.ply"])
    sections = {
        "Eigenvalues": "The matrices of linear finite elements with their full mass, assembly included. Processor "
        "seconds; largest relative difference of an eigenvalue that is not zero.\n\n"
        + markdown_table(measured["eigenvalues"]),
        "Signatures": "Largest differences over the largest value, each from its own eigenpairs.\n\n"
        + markdown_table(measured["signatures"]),
        "Compression": "The dinosaur; root mean square errors in diameter bounds.\n\n"
        + markdown_table(measured["compression"]),
        "Operators": "Largest error of the first 25 eigenvalues of a sphere over the largest, as they are and times "
        "the best factor; the rms error of the dinosaur from 100 functions, in diameter bounds.\n\n"
        + markdown_table(measured["operators"]),
    }
    save_markdown(results / "applications_spectrum.md", "Spectra, signatures, compression", sections)
    picture(results, quick)
