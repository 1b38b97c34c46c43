"""Geodesic distances beside potpourri3d, libigl and LaPy, against exact ones; operators on thin triangles.

``lbskel, integrated`` are the distances of the heat method as in its paper, which the other tools have too.
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
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from benchmarks.damage import damaged
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.operators_speed import mesh_of
from lbskel import OPERATORS, HeatMethod, LbskelError, Mesh, read_mesh
from lbskel.applications import heat_method
from lbskel.shapes import flat_grid, schwarz_lantern, sphere, torus
from lbskel.visualization import Panel, render

MESHES = Path(__file__).parent.parent / "meshes"
PACKAGES = ("potpourri3d", "pygeodesic", "lapy")
N_SOURCES = 4
Array = NDArray[np.float64]
Query = Callable[[int], Array]


def shapes(quick: bool) -> dict[str, Mesh]:
    """Return the repository's meshes, and regular ones."""
    files = {} if quick else {path.name: read_mesh(path) for path in sorted(MESHES.glob("*.*")) if path.suffix != ".md"}
    return {**files, "sphere": sphere(3 if quick else 5), "torus": torus(1.0, 0.4, 90, 45), "grid": flat_grid(60, 60)}


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


def exact_of(mesh: Mesh) -> Query:
    """Return exact distances: by pygeodesic if there is one, else by libigl, by the algorithm of Mitchell et al."""
    V, F = np.array(mesh.vertices), np.array(mesh.faces)
    if find_spec("pygeodesic"):
        algorithm = import_module("pygeodesic.geodesic").PyGeodesicAlgorithmExact(V, F)
        return lambda source: np.array(algorithm.geodesicDistances(np.array([source]))[0])
    none = np.empty(0, dtype=np.int64)
    return lambda source: np.array(igl.exact_geodesic(V, F, np.array([source]), none, np.arange(len(V)), none))


def tools(peers: bool) -> dict[str, Callable[[Mesh], Query]]:
    found: dict[str, Callable[[Mesh], Query]] = {"lbskel": lbskels, "lbskel, integrated": integrated, "libigl": igls}
    if peers and find_spec("potpourri3d"):
        found["potpourri3d"] = potpourris
    if peers and find_spec("lapy"):
        found["LaPy"] = lapys
    return found


def sources_of(mesh: Mesh) -> list[int]:
    """Return vertices in faces, chosen by chance."""
    return [int(v) for v in np.random.default_rng(0).choice(mesh.used_vertices, N_SOURCES, replace=False)]


def errors(distance: Array, exact: Array) -> tuple[float, float, float]:
    """Return the mean error over the largest distance, the mean relative error, and the largest error likewise."""
    reached = np.isfinite(exact) & (exact < 1e9) & (exact > 0)
    error = np.abs(distance - exact)[reached]
    largest = exact[reached].max()
    return float(error.mean() / largest), float((error / exact[reached]).mean()), float(error.max() / largest)


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


def square(peers: bool) -> list[dict[str, Any]]:
    """Measure the largest distance from the boundary of a unit square, of as many vertices as in LaPy's own test.

    Exactly it is that of the vertex nearest to the middle, at most 1/2. LaPy's test asks for 0.60497826 on its mesh.
    """
    random = np.random.default_rng(0)
    side = np.linspace(0, 1, 16)[:-1]
    edge = np.concatenate([np.stack([side, 0 * side], axis=1) - 0.5])
    turns = [np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]]).round() for t in np.pi / 2 * np.arange(4)]
    inner = random.uniform(-0.5, 0.5, (20_000, 2))
    points = np.concatenate([edge @ turn.T for turn in turns])
    boundary = np.arange(len(points))
    for point in inner:  # no two nearer than what gives about 415 in all
        if np.linalg.norm(points - point, axis=1).min() > 0.039:
            points = np.concatenate([points, point[None]])
    faces = Delaunay(points).simplices
    flat = np.column_stack([points, np.zeros(len(points))])
    p, q, r = points[faces].transpose(1, 0, 2)
    is_flipped = np.cross(q - p, r - p) < 0
    faces[is_flipped] = faces[is_flipped][:, ::-1]
    mesh = Mesh(flat, faces)
    exact = float((0.5 - np.abs(points).max(axis=1)).max())
    rows = [{"tool": "exact", "vertices": len(points), "largest distance": exact}]
    method = HeatMethod(mesh)
    for name, unfolded in (("lbskel", True), ("lbskel, integrated", False)):
        largest = float(method.distance(boundary, unfolded=unfolded).max())
        rows.append({"tool": name, "vertices": len(points), "largest distance": largest})
    if peers and find_spec("lapy"):
        lapy, heat, geometry = (import_module(name) for name in ("lapy", "lapy.heat", "lapy.diffgeo"))
        surface = lapy.TriaMesh(np.array(mesh.vertices), np.array(mesh.faces))
        distance = np.array(geometry.compute_geodesic_f(surface, heat.diffusion(surface, boundary)))
        rows.append({"tool": "LaPy", "vertices": len(points), "largest distance": float(distance.max())})
    rows.append({"tool": "LaPy, published", "vertices": 415, "largest distance": 0.60497826})
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


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Write applications_geodesics.json, .md and .png."""
    measured: dict[str, Any] = {
        "quick": quick,
        "accuracy": accuracy(quick, peers),
        "speed": speed(quick, peers),
        "times": times(quick),
        "operators": operators(quick),
        "square": square(peers),
    }
    save_json(results / "applications_geodesics.json", measured, packages=PACKAGES)
    units = "Mean and worst errors over the largest distance; relative: the mean of errors over distances. "
    units += f"{N_SOURCES} sources each; exact distances on the polyhedron by pygeodesic. Processor seconds.\n"
    sections = {
        "Accuracy": units + "\n" + markdown_table(measured["accuracy"]),
        "Speed": markdown_table(measured["speed"]),
        "Time of the flow": "Mean errors of lbskel, integrated, by the time in squared mean edge lengths.\n\n"
        + markdown_table(measured["times"]),
        "Operators on thin triangles": "Mean errors of lbskel, integrated.\n\n" + markdown_table(measured["operators"]),
        "From the boundary of a square": "As in LaPy's own test, whose mesh has other vertices.\n\n"
        + markdown_table(measured["square"]),
    }
    save_markdown(results / "applications_geodesics.md", "Geodesic distances", sections)
    picture(results, quick)
