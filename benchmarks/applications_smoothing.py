"""Smoothing beside trimesh, MeshLab and libigl: distance to the clean surface, also at equal time; operators."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import igl
import numpy as np
from numpy.polynomial.chebyshev import cheb2poly
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.smoothing_operators import distance, noisy_copy, operators
from lbskel.applications import smoothing_filters
from lbskel.applications.smoothing import DEFAULTS
from lbskel.shapes import make, sphere
from lbskel.visualization import Panel, render

SHAPES = ("dinosaur", "knot", "hand", "octopus", "tripod")
STEPS, ITERATIONS = (0.25, 0.5, 1.0), (2, 4)  # of our implicit methods: mean vertex areas, number
COUNTS = (3, 10, 30, 100)  # iterations of explicit filters
POLYNOMIALS = (1, 2)  # iterations of the polynomial
CUTOFFS, DEGREES = (0.2, 0.3, 0.4, 0.5, 0.8), (3, 4, 6, 8, 12)  # of the filter
TURNS = 5  # of which the median time is taken, each with a new mesh, which has no tables yet
Smooth = Callable[[lbskel.Mesh], NDArray[np.float64]]


def ours() -> Iterator[tuple[str, str, Smooth]]:
    """Name, setting and function of every method of lbskel, and of the default."""
    yield "lbskel, as called without options", "", lambda mesh: lbskel.smooth(mesh).vertices
    yield "lbskel, keep_volume", "", lambda mesh: lbskel.smooth(mesh, keep_volume=True).vertices
    for t in STEPS:
        for volume in (False, True):
            name = "lbskel bilaplacian, operator graph" + (", keep_volume" if volume else "")
            yield name, f"{t:g} areas, 4 iterations", _ours("bilaplacian", t, 4, volume, "graph")
    for n in POLYNOMIALS:
        for volume in (False, True):
            name = "lbskel polynomial, operator random_walk" + (", keep_volume" if volume else "")
            yield name, f"{n} iterations", _ours("polynomial", None, n, volume, "random_walk")
    for method in DEFAULTS:
        for volume in (False, True):
            name = f"lbskel {method}" + (", keep_volume" if volume else "")
            if method in ("taubin", "explicit", "polynomial"):
                for n in POLYNOMIALS if method == "polynomial" else COUNTS:
                    yield name, f"{n} iterations", _ours(method, None, n, volume)
                continue
            for t in STEPS:
                for n in ITERATIONS:
                    yield name, f"{t:g} areas, {n} iterations", _ours(method, t, n, volume)


def _ours(method: str, step: float | None, n: int, volume: bool, operator: str = "cotangent") -> Smooth:
    def call(mesh: lbskel.Mesh) -> NDArray[np.float64]:
        t = None if step is None else step * mesh.area / len(mesh.vertices)
        result = lbskel.smooth(mesh, method=method, time_step=t, iterations=n, keep_volume=volume, operator=operator)
        return result.vertices

    return call


def peers() -> Iterator[tuple[str, str, Smooth]]:
    """Name, setting and function of every filter of other libraries, each with its iterations swept."""
    from functools import partial

    for n in COUNTS:
        setting = f"{n} iterations"
        yield "trimesh laplacian", setting, partial(_trimesh, "filter_laplacian", iterations=n)
        yield "trimesh taubin", setting, partial(_trimesh, "filter_taubin", lamb=0.5, nu=0.53, iterations=n)
        yield "trimesh humphrey", setting, partial(_trimesh, "filter_humphrey", iterations=n)
        yield "trimesh mut_dif", setting, partial(_trimesh, "filter_mut_dif_laplacian", iterations=n)
        if n <= 10:
            yield (
                "trimesh laplacian, implicit",
                setting,
                partial(_trimesh, "filter_laplacian", iterations=n, implicit_time_integration=True),
            )
        yield "MeshLab laplacian", setting, partial(_meshlab, "apply_coord_laplacian_smoothing", stepsmoothnum=n)
        yield (
            "MeshLab taubin",
            setting,
            partial(_meshlab, "apply_coord_taubin_smoothing", stepsmoothnum=n, lambda_=0.5, mu=-0.53),
        )
        yield "MeshLab two steps", setting, partial(_meshlab, "apply_coord_two_steps_smoothing", stepsmoothnum=n)
    yield "MeshLab HC", "", partial(_meshlab, "apply_coord_hc_laplacian_smoothing")
    for t in STEPS:
        yield "libigl implicit", f"{t:g} areas", partial(_igl, step=t)


def _trimesh(name: str, mesh: lbskel.Mesh, **options: Any) -> NDArray[np.float64]:
    import trimesh

    copy = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    getattr(trimesh.smoothing, name)(copy, **options)
    return np.asarray(copy.vertices)


def _meshlab(name: str, mesh: lbskel.Mesh, **options: Any) -> NDArray[np.float64]:
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.faces))
    getattr(meshes, name)(**options)
    return np.asarray(meshes.current_mesh().vertex_matrix())


def _igl(mesh: lbskel.Mesh, step: float) -> NDArray[np.float64]:
    """One implicit step of the cotangent Laplacian, as in libigl's tutorial, by its own Cholesky factorization."""
    V, F = mesh.vertices, mesh.faces
    M = igl.massmatrix(V, F, igl.MASSMATRIX_TYPE_VORONOI)
    t = step * mesh.area / len(V)
    A = csc_matrix(M - t * igl.cotmatrix(V, F))
    n = len(V)
    none = csc_matrix((0, n))
    return igl.min_quad_with_fixed(A, -(M @ V), np.empty(0, np.int64), np.empty((0, 3)), none, np.empty((0, 3)), True)


def _timed(call: Smooth, mesh: lbskel.Mesh) -> tuple[NDArray[np.float64], float]:
    """Positions by one function, and the median of its processor seconds."""
    seconds = []
    for _ in range(TURNS):
        copy = lbskel.Mesh(np.array(mesh.vertices), np.array(mesh.faces))
        began = time.process_time()
        vertices = call(copy)
        seconds.append(time.process_time() - began)
    return vertices, float(np.median(seconds))


def filters(shapes: tuple[str, ...]) -> list[dict[str, Any]]:
    """Mean error of the polynomial with `random_walk` by the cutoff and the degree of its filter."""
    before, rows = smoothing_filters.FILTER, []
    pairs = [(make(shape).mesh, noisy_copy(make(shape).mesh)) for shape in shapes]
    try:
        for cutoff in CUTOFFS:
            row: dict[str, Any] = {"cutoff": cutoff}
            for degree in DEGREES:
                smoothing_filters.FILTER = cheb2poly(smoothing_filters.filter_coefficients(cutoff, degree))
                call = _ours("polynomial", None, 1, False, "random_walk")
                row[f"degree {degree}"] = float(np.mean([distance(call(noisy), clean) for clean, noisy in pairs]))
            rows.append(row)
    finally:
        smoothing_filters.FILTER = before
    return rows


def denoising(shapes: tuple[str, ...], with_peers: bool) -> list[dict[str, Any]]:
    """A row for each shape, tool and setting."""
    rows = []
    for shape in shapes:
        clean = make(shape).mesh
        noisy = noisy_copy(clean)
        rows.append({"shape": shape, "tool": "nothing", "setting": "", "error": distance(noisy.vertices, clean)})
        for name, setting, call in [*ours(), *(peers() if with_peers else ())]:
            try:
                vertices, seconds = _timed(call, noisy)
            except Exception as error:
                rows.append({"shape": shape, "tool": name, "setting": setting, "failure": str(error)})
                continue
            row = {"shape": shape, "tool": name, "setting": setting, "seconds": seconds}
            if not np.isfinite(vertices).all():
                rows.append({**row, "failure": "NaN"})
                continue
            change = abs(noisy.with_vertices(vertices).volume / noisy.volume - 1)
            rows.append({**row, "error": distance(vertices, clean), "volume": change})
    return rows


def _best(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """For each tool its best setting on each shape, and the mean over the shapes."""
    table = []
    shapes = list(dict.fromkeys(row["shape"] for row in rows))
    for tool in dict.fromkeys(row["tool"] for row in rows):
        best = {}
        for shape in shapes:
            found = [r for r in rows if r["tool"] == tool and r["shape"] == shape and "error" in r]
            if found:
                best[shape] = min(found, key=lambda row: row["error"])
        table.append(
            {
                "tool": tool,
                **{shape: best[shape]["error"] if shape in best else None for shape in shapes},
                "mean": float(np.mean([row["error"] for row in best.values()])) if len(best) == len(shapes) else None,
                "volume changed by": max((row.get("volume", 0.0) for row in best.values()), default=None),
                "seconds": float(np.mean([row.get("seconds", 0.0) for row in best.values()])) if best else None,
            }
        )
    return sorted(table, key=lambda row: row["mean"] if row["mean"] is not None else 9.0)


def _settings(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The mean error over the shapes of every setting of our methods, where DEFAULTS comes from."""
    table = []
    for key in dict.fromkeys((row["tool"], row["setting"]) for row in rows):
        if key[0].startswith("lbskel") and key[1] and "keep_volume" not in key[0]:
            errors = [row["error"] for row in rows if (row["tool"], row["setting"]) == key and "error" in row]
            if errors:
                table.append({"tool": key[0], "setting": key[1], "mean error": float(np.mean(errors))})
    return table


def _within(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of others, the settings that no faster one of theirs beats; beside each the best of lbskel within its time.

    A setting is one for all shapes, error and time are its means over these.
    """
    shapes = {row["shape"] for row in rows}
    settings = []
    for key in dict.fromkeys((row["tool"], row["setting"]) for row in rows if "seconds" in row):
        found = [row for row in rows if (row["tool"], row["setting"]) == key and "error" in row]
        if len(found) == len(shapes):
            error, seconds = (float(np.mean([row[what] for row in found])) for what in ("error", "seconds"))
            settings.append((seconds, error, ", ".join(filter(None, key))))
    settings.sort()
    table: list[dict[str, Any]] = []
    front = [each for each in settings if not each[2].startswith("lbskel")] or settings
    best = np.inf
    for seconds, error, name in front:
        if error >= best:
            continue
        best = error
        within = [each for each in settings if each[2].startswith("lbskel") and each[0] <= seconds]
        ours = min(within, key=lambda each: each[1], default=(None, None, "none"))
        table.append(
            {
                "others": name,
                "seconds": seconds,
                "error": error,
                "lbskel": ours[2],
                "lbskel: seconds": ours[0],
                "lbskel: error": ours[1],
            }
        )
    fastest = min((each for each in settings if each[2].startswith("lbskel") and each[1] < best), default=None)
    if fastest is not None:
        seconds, error, name = fastest
        table.append({"others": "none", "lbskel": name, "lbskel: seconds": seconds, "lbskel: error": error})
    return table


def large(quick: bool, with_peers: bool) -> list[dict[str, Any]]:
    """Processor seconds of one implicit step, in turns."""
    mesh = noisy_copy(sphere(5 if quick else 7))
    area = mesh.area / len(mesh.vertices)
    calls: dict[str, Callable[[], Any]] = {
        "lbskel implicit": lambda: lbskel.smooth(mesh, method="implicit", time_step=area, iterations=1),
        "lbskel bilaplacian": lambda: lbskel.smooth(mesh, method="bilaplacian", time_step=area / 2, iterations=1),
    }
    if with_peers:
        calls["libigl implicit"] = lambda: _igl(mesh, 1.0)
        calls["trimesh laplacian, implicit"] = lambda: _trimesh(
            "filter_laplacian", mesh, iterations=1, implicit_time_integration=True
        )
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    for turn in range(1 if quick else 2):
        for name, call in calls.items():
            if turn and "trimesh" in name:  # which takes minutes
                continue
            began = time.process_time()
            call()
            seconds[name].append(time.process_time() - began)
    best = min(seconds["lbskel implicit"])
    return [
        {"tool": name, "faces": len(mesh.faces), "seconds": min(values), "times lbskel implicit": min(values) / best}
        for name, values in seconds.items()
    ]


def stability() -> list[dict[str, Any]]:
    """The largest distance of a vertex from the centroid after two steps, relative to that before."""
    noisy = noisy_copy(make("tripod", n_vertices=1500).mesh)
    area = noisy.area / len(noisy.vertices)
    reach = np.linalg.norm(noisy.vertices - noisy.centroid, axis=1).max()
    rows = []
    for factor in (1e-3, 1.0, 1e3, 1e6):
        row: dict[str, Any] = {"time step in mean vertex areas": factor}
        for method in ("explicit", "implicit", "curvature_flow", "bilaplacian"):
            try:
                result = lbskel.smooth(noisy, method=method, time_step=factor * area, iterations=2)
                row[method] = float(np.linalg.norm(result.vertices - noisy.centroid, axis=1).max() / reach)
            except lbskel.LbskelError as error:
                row[method] = type(error).__name__
        rows.append(row)
    return rows


def _picture(path: Path) -> None:
    clean = make("dinosaur").mesh
    noisy = noisy_copy(clean)
    panels = [Panel(noisy, title="noise of a quarter of an edge length")]
    for method in ("implicit", "bilaplacian"):
        result = lbskel.smooth(noisy, method=method, keep_volume=True)
        panels.append(Panel(result, title=f"{method}, {distance(result.vertices, clean):.3f}"))
    render(panels, path, size=(1500, 560), force=True)


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Measure, and write applications_smoothing.json, .md and .png."""
    rows = denoising(SHAPES[:1] if quick else SHAPES, peers)
    speeds, stable, by_operator = large(quick, peers), stability(), operators(SHAPES[: 1 if quick else None])
    by_filter = filters(SHAPES[: 1 if quick else None])
    name = "applications_smoothing"
    save_json(
        results / f"{name}.json",
        {"rows": rows, "large": speeds, "stability": stable, "operators": by_operator, "filter": by_filter},
        packages=("trimesh", "pymeshlab"),
    )
    save_markdown(
        results / f"{name}.md",
        "Smoothing",
        {
            "Noise of a quarter of the edge length": "Root mean square distance to the clean surface in mean edge "
            "lengths, and the largest change of the volume; each tool with its best setting of those in the JSON file "
            "on each shape, but lbskel without options has one setting. Processor seconds, mean.\n\n"
            + markdown_table(_best(rows)),
            "At equal time": "Of others, the settings that none of theirs beats in less time, one for all shapes, and "
            "the best of lbskel within the same time; last, the fastest of lbskel that is closer than all others ever "
            f"are. Medians of {TURNS} turns, means over the shapes.\n\n" + markdown_table(_within(rows)),
            "Filter": "Mean error over the shapes of the polynomial with `random_walk`.\n\n"
            + markdown_table(by_filter),
            "One implicit step": "Processor seconds, the lower of two turns; one of trimesh.\n\n"
            + markdown_table(speeds),
            "Stability": "Largest distance from the centroid after two steps, relative to before; an error is named."
            "\n\n" + markdown_table(stable),
            "Settings": "Mean error over the shapes.\n\n" + markdown_table(_settings(rows)),
            "Operators": "Noise: as above, by bilaplacian without options. Drift: how far an implicit step moves the "
            "inner vertices of an irregular mesh in a plane, in mean edge lengths; exactly, not at all. Step: how far "
            "the vertices of an irregular sphere are from where mean curvature moves them in an implicit step of time "
            "0.02, over the distance that it moves them.\n\n" + markdown_table(by_operator),
        },
    )
    _picture(results / f"{name}.png")
