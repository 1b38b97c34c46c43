"""Geodesic distances beside potpourri3d, libigl and LaPy, against exact ones; operators on thin triangles.

``lbskel, integrated`` stands for the distances of the heat method as in its paper, which the other tools compute too.
"""

from __future__ import annotations

__all__ = ["run"]

import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import igl
import numpy as np

from benchmarks.damage import damaged
from benchmarks.geodesic_cases import MESHES, N_SOURCES, Query, errors, exact_of, files, shapes, sources_of
from benchmarks.geodesic_sources import PUBLISHED, published, rings, several
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.operators_speed import mesh_of
from lbskel import OPERATORS, HeatMethod, LbskelError, Mesh, read_mesh
from lbskel.applications import heat_method
from lbskel.shapes import schwarz_lantern, sphere, torus
from lbskel.visualization import Panel, render

PACKAGES = ("potpourri3d", "pygeodesic", "lapy")


def lbskels(mesh: Mesh) -> Query:
    return HeatMethod(mesh).distance


def integrated(mesh: Mesh) -> Query:
    method = HeatMethod(mesh)
    return lambda source: method.distance(source, unfolded=False)


def potpourris(mesh: Mesh) -> Query:
    solver = import_module("potpourri3d").MeshHeatMethodDistanceSolver(np.array(mesh.vertices), np.array(mesh.faces))
    return lambda source: np.array(solver.compute_distance(source))


def igls(mesh: Mesh) -> Query:
    data = igl.HeatGeodesicsData()
    data.use_intrinsic_delaunay = False  # with it libigl aborts on open meshes
    igl.heat_geodesics_precompute(np.array(mesh.vertices), np.array(mesh.faces), data)
    return lambda source: np.array(igl.heat_geodesics_solve(data, np.array([source])))


def lapys(mesh: Mesh) -> Query:
    lapy = import_module("lapy")
    heat, geometry = import_module("lapy.heat"), import_module("lapy.diffgeo")
    surface = lapy.TriaMesh(np.array(mesh.vertices), np.array(mesh.faces))
    return lambda source: np.array(geometry.compute_geodesic_f(surface, heat.diffusion(surface, source)))


def tools(peers: bool) -> dict[str, Callable[[Mesh], Query]]:
    found: dict[str, Callable[[Mesh], Query]] = {"lbskel": lbskels, "lbskel, integrated": integrated, "libigl": igls}
    if peers and find_spec("potpourri3d"):
        found["potpourri3d"] = potpourris
    if peers and find_spec("lapy"):
        found["LaPy"] = lapys
    return found


def accuracy(quick: bool, peers: bool) -> list[dict[str, Any]]:
    """Measure errors and processor time of the first query, with all preparation, and of later ones."""
    rows = []
    for name, mesh in shapes(quick).items():
        exact, sources = exact_of(mesh), sources_of(mesh)
        truth = [exact(source) for source in sources]
        for tool, prepare in tools(peers).items():
            start = time.process_time()
            query = prepare(mesh)
            query(sources[0])
            first = time.process_time() - start
            start = time.process_time()
            found = [query(source) for source in sources]
            later = (time.process_time() - start) / len(sources)
            mean, relative, worst = np.mean([errors(d, e) for d, e in zip(found, truth, strict=True)], axis=0)
            rows.append(
                {
                    "mesh": name,
                    "vertices": len(mesh.vertices),
                    "tool": tool,
                    "mean error": mean,
                    "relative": relative,
                    "worst": worst,
                    "first query, s": first,
                    "later, s": later,
                }
            )
    return rows


def speed(quick: bool, peers: bool) -> list[dict[str, Any]]:
    """Measure processor time of queries on larger meshes, tools in turns."""
    rows = []
    for n_faces in (2_000,) if quick else (20_000, 100_000, 350_000):
        mesh = mesh_of(n_faces)
        for tool, prepare in tools(peers).items():
            if tool == "LaPy" and n_faces > 100_000:
                continue
            start = time.process_time()
            query = prepare(mesh)
            query(0)
            first = time.process_time() - start
            start = time.process_time()
            for source in range(1, 4):
                query(source)
            rows.append(
                {
                    "faces": len(mesh.faces),
                    "tool": tool,
                    "first query, s": first,
                    "later, s": (time.process_time() - start) / 3,
                }
            )
    return rows


def times(quick: bool) -> list[dict[str, Any]]:
    """Measure the mean error by the time of the flow, in squared mean edge lengths."""
    rows: list[dict[str, Any]] = []
    before = heat_method.TIME
    meshes = shapes(quick)
    truth = {name: [(s, exact_of(mesh)(s)) for s in sources_of(mesh)] for name, mesh in meshes.items()}
    try:
        for factor in (0.1, 0.3, 1.0, 3.0):
            heat_method.TIME = factor
            row: dict[str, Any] = {"time": factor}
            for name, mesh in meshes.items():
                method = HeatMethod(mesh)
                found = [(method.distance(s, unfolded=False), exact) for s, exact in truth[name]]
                row[name] = float(np.mean([errors(distance, exact)[0] for distance, exact in found]))
            rows.append(row)
    finally:
        heat_method.TIME = before
    return rows


def bad_meshes(quick: bool) -> dict[str, Mesh]:
    """Return one shape sound and with thin triangles, and a lantern of thin triangles alone."""
    ring = torus(1.0, 0.4, 60, 30)
    bad = {kind: damaged(kind, ring) for kind in ("needles", "caps", "noise")}
    meshes = {"sound": ring, **{kind: Mesh(each.vertices, each.faces) for kind, each in bad.items()}}
    stretched = sphere(2 if quick else 4)
    meshes["stretched"] = stretched.with_vertices(stretched.vertices * [1.0, 1.0, 20.0])
    meshes["lantern"] = schwarz_lantern(12, 60)
    return meshes


def operators(quick: bool) -> list[dict[str, Any]]:
    """Measure the mean error of every operator on thin triangles; an error's first words where it is refused."""
    meshes = bad_meshes(quick)
    truth = {name: [(s, exact_of(mesh)(s)) for s in sources_of(mesh)] for name, mesh in meshes.items()}
    rows = []
    for operator in OPERATORS:
        row: dict[str, Any] = {"operator": f"`{operator}`"}
        for name, mesh in meshes.items():
            try:
                method = HeatMethod(mesh, operator)
                found = [(method.distance(s, unfolded=False), exact) for s, exact in truth[name]]
                row[name] = float(np.mean([errors(distance, exact)[0] for distance, exact in found]))
            except LbskelError as error:
                row[name] = "not symmetric" if "symmetric" in str(error) else type(error).__name__
        rows.append(row)
    return rows


def picture(results: Path, quick: bool) -> None:
    """Draw the distance from a foot, its error, and two values extended."""
    mesh = sphere(2) if quick else read_mesh(MESHES / "dinosaur.ply")
    method = HeatMethod(mesh)
    source = int(np.argmax(method.distance(0)))
    distance, exact = method.distance(source), exact_of(mesh)(source)
    far = [source, int(np.argmax(distance)), int(np.argmin(mesh.vertices[:, 2]))]
    panels = [
        Panel(mesh, title="distance", field=distance, field_name="distance"),
        Panel(
            mesh, title="bands of a twentieth", field=np.floor(20 * distance / distance.max()) % 2, field_name="band"
        ),
        Panel(mesh, title="error", field=np.abs(distance - exact) / exact.max(), field_name="error over the largest"),
        Panel(mesh, title="three values extended", field=method.extend(far, [0.0, 1.0, 2.0]), field_name="value"),
    ]
    render(panels, results / "applications_geodesics.png", force=True)


def run(quick: bool, results: Path, peers: bool = False, meshes: list[Path] | None = None) -> None:
    """Write applications_geodesics.json, .md and .png; with LaPy's square-mesh.off among the meshes, its value too."""
    squares = [path for path in meshes or () if path.name == "square-mesh.off"]
    measured: dict[str, Any] = {
        "quick": quick,
        "accuracy": accuracy(quick, peers),
        "speed": speed(quick, peers),
        "times": times(quick),
        "operators": operators(quick),
        "several": several(quick, peers),
        "rings": rings(quick),
        "published": [row for path in squares for row in published(path, peers)],
    }
    save_json(results / "applications_geodesics.json", measured, packages=PACKAGES, meshes=[*files(), *squares])
    units = "Mean and worst errors over the largest distance; relative: the mean of errors over distances. "
    units += f"{N_SOURCES} sources each; exact distances on the polyhedron by pygeodesic. Processor seconds.\n"
    sections = {
        "Accuracy": units + "\n" + markdown_table(measured["accuracy"]),
        "Speed": markdown_table(measured["speed"]),
        "Time of the flow": "Mean errors of lbskel, integrated, by the time in squared mean edge lengths.\n\n"
        + markdown_table(measured["times"]),
        "Operators on thin triangles": "Mean errors of lbskel, integrated.\n\n" + markdown_table(measured["operators"]),
        "Several sources": "Mean and worst errors over the largest distance to the nearest of the sources, by libigl's "
        "exact ones. Processor seconds of a later query.\n\n"
        + markdown_table(measured["several"])
        + "\n\nMean error of ten sources by the rings of triangles that are added to the region of each.\n\n"
        + markdown_table(measured["rings"]),
        "From the boundary of a square": "On the mesh of LaPy's own test, data/square-mesh.off of its repository: the "
        f"largest distance from the boundary, for which the test asks {PUBLISHED} to a part of 1e-5.\n\n"
        + markdown_table(measured["published"]),
    }
    if not squares:
        del sections["From the boundary of a square"]
    save_markdown(results / "applications_geodesics.md", "Geodesic distances", sections)
    picture(results, quick)
