"""Editing beside libigl: exact motions, displacements, as-rigid-as-possible energies, seconds, and pictures."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix

import lbskel
import lbskel.applications.deformation_methods as deformation_methods
from benchmarks.damage import damaged
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.shapes import make, mesh_solid, solid_of, torus
from lbskel.visualization import Panel, render

METHODS = tuple(lbskel.EDITING_METHODS)
STARTS = (0, 1, 2, 5, 10, 20)  # iterations before as-rigid-as-possible ones
Case = tuple[lbskel.Mesh, list[NDArray[np.int64]], list[NDArray[np.float64]]]


def bar(angle_deg: float, *, twist: bool, stretch: float = 1.0) -> Case:
    """A bar of square section, bent or twisted, with triangles that are so many times as long as wide."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-2.5, 2.5)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    box = lbskel.as_mesh((corners, quads))
    short = lbskel.Pipeline(["remesh_isotropic"])(box.with_vertices(box.vertices / [1.0, 1.0, stretch])).mesh
    mesh = short.with_vertices(short.vertices * [1.0, 1.0, stretch])
    z = mesh.vertices[:, 2]
    handles = [np.flatnonzero(z < z.min() + 0.3), np.flatnonzero(z > z.max() - 0.3)]
    if twist:
        return mesh, handles, [np.eye(4), lbskel.rigid_motion(angle_deg=angle_deg)]
    top = mesh.vertices[handles[1]].mean(axis=0)
    motion = lbskel.rigid_motion(axis=[0, 1, 0], angle_deg=angle_deg, center=top, translation=[1.6, 0, -1.6])
    return mesh, handles, [np.eye(4), motion]


def cactus() -> Case:
    """A trunk with two arms, bent over at its top."""
    trunk = (np.array([[0, 0, 0], [0, 0, 1.5], [0, 0, 3.0]]), 0.35)
    left = (np.array([[0, 0, 1.2], [-0.9, 0, 1.2], [-0.9, 0, 2.0]]), 0.2)
    right = (np.array([[0, 0, 1.6], [0.9, 0, 1.6], [0.9, 0, 2.4]]), 0.2)
    mesh = mesh_solid(solid_of([trunk, left, right]), n_vertices=6000)
    z = mesh.vertices[:, 2]
    handles = [np.flatnonzero(z < 0.3), np.flatnonzero(z > 2.9)]
    top = mesh.vertices[handles[1]].mean(axis=0)
    motion = lbskel.rigid_motion(axis=[0, 1, 0], angle_deg=75, center=top, translation=[1.2, 0, -0.7])
    return mesh, handles, [np.eye(4), motion]


def exactness(mesh: lbskel.Mesh, handles: list[NDArray[np.int64]]) -> list[dict[str, Any]]:
    """Largest distance from the mesh moved as a whole, when all handles are moved alike, relative to the diagonal."""
    motions = {
        "identity": np.eye(4),
        "translation": lbskel.rigid_motion(translation=[1, 2, 3]),
        "rotation by 120 degrees": lbskel.rigid_motion(axis=[1, 2, 3], angle_deg=120),
    }
    rows = []
    for method in METHODS:
        editor = lbskel.Editor(mesh, handles, method=method)
        row: dict[str, Any] = {"method": method}
        for name, motion in motions.items():
            expected = mesh.vertices @ motion[:3, :3].T + motion[:3, 3]
            found = editor.edit([motion] * len(handles)).vertices
            row[name] = float(np.abs(found - expected).max() / mesh.diagonal)
        rows.append(row)
    return rows


def displacements(case: Case) -> list[dict[str, Any]]:
    """Largest difference from libigl's harmonic and biharmonic displacements, relative to the diagonal."""
    mesh, handles, motions = case
    b, rows = np.concatenate(handles), []
    for order, method in ((1, "harmonic"), (2, "biharmonic")):
        result = lbskel.edit(mesh, handles, motions, method=method, operator="cotangent").vertices
        theirs = igl.harmonic(mesh.vertices, mesh.faces, b, (result - mesh.vertices)[b], order)
        difference = float(np.abs(result - mesh.vertices - theirs).max() / mesh.diagonal)
        rows.append({"method": method, "vertices": len(mesh.vertices), "difference from libigl": difference})
    return rows


def _libigl(mesh: lbskel.Mesh, b: NDArray[np.int64], iterations: int) -> Any:
    data = igl.ARAPData()
    data.energy, data.max_iter = igl.ARAP_ENERGY_TYPE_SPOKES, iterations
    igl.arap_precomputation(mesh.vertices, mesh.faces, 3, b.astype(np.int32), data)
    return data


def _by_functions(
    mesh: lbskel.Mesh, b: NDArray[np.int64], start: NDArray[np.float64], n: int, *, single_precision: bool
) -> NDArray[np.float64]:
    """As rigid as possible by libigl's cotangents, rotations and solver, with rotations of either precision.

    `igl.arap_solve` fits them in single precision and has no option for it.
    """
    S = csr_matrix(-igl.cotmatrix(mesh.vertices, mesh.faces))
    none = csc_matrix((0, len(start)))
    data = igl.min_quad_with_fixed_data()
    igl.min_quad_with_fixed_precompute(csc_matrix(S), b, none, True, data)
    W = S.tocoo()
    is_edge = W.row != W.col
    i, j, w = W.row[is_edge], W.col[is_edge], -W.data[is_edge]
    V, X = mesh.vertices, np.array(start)
    sums = csr_matrix((w, (i, np.arange(len(i)))), shape=(len(V), len(i)))
    for _ in range(n):
        products = np.einsum("ea,eb->eab", V[i] - V[j], X[i] - X[j]).reshape(-1, 9)
        covariances = (sums @ products).reshape(-1, 3, 3).transpose(0, 2, 1)
        stacked = igl.fit_rotations(np.concatenate([covariances[:, axis] for axis in range(3)]), single_precision)
        R = stacked.T.reshape(-1, 3, 3)
        right = sums @ np.einsum("eab,eb->ea", (R[i] + R[j]) / 2, V[i] - V[j])
        X = igl.min_quad_with_fixed_solve(data, -right, X[b], np.empty((0, 3)))
    return X


def energies(case: Case, counts: tuple[int, ...]) -> list[dict[str, Any]]:
    """Energies after the same number of iterations from the same start, ours relative to libigl's."""
    mesh, handles, motions = case
    editor = lbskel.Editor(mesh, handles, operator="cotangent")
    start, b, rows = editor.edit(motions, iterations=0), np.concatenate(handles), []
    for n in counts:
        energy = editor.rigidity_energy(editor.edit(motions, iterations=n, initial=start))
        called = igl.arap_solve(start.vertices[b], _libigl(mesh, b, n), np.array(start.vertices))
        theirs = editor.rigidity_energy((called, mesh.faces))
        double, single = (
            editor.rigidity_energy((_by_functions(mesh, b, start.vertices, n, single_precision=each), mesh.faces))
            for each in (False, True)
        )
        rows.append(
            {
                "iterations": n,
                "energy": energy,
                "relative to libigl, double precision, minus 1": energy / double - 1,
                "relative to `igl.arap_solve`, minus 1": energy / theirs - 1,
                "libigl, single precision, relative to `igl.arap_solve`, minus 1": single / theirs - 1,
            }
        )
    return rows


def seconds(quick: bool) -> list[dict[str, Any]]:
    """Processor milliseconds of an iteration and of the factorization, in turns."""
    mesh = torus(1.0, 0.3, *((60, 30) if quick else (250, 100)))
    x = mesh.vertices[:, 0]
    handles = [np.flatnonzero(x < -1.1), np.flatnonzero(x > 1.1)]
    motions = [np.eye(4), lbskel.rigid_motion(axis=[0, 1, 0], angle_deg=30)]
    b, n = np.concatenate(handles), 10
    times: dict[str, list[float]] = {}

    def timed(name: str, call: Any) -> Any:
        began = time.process_time()
        value = call()
        times.setdefault(name, []).append(time.process_time() - began)
        return value

    for _ in range(5):
        editor = timed("lbskel factorization", lambda: lbskel.Editor(mesh, handles, operator="cotangent"))
        data = timed("libigl factorization", lambda: _libigl(mesh, b, n))
        start = editor.edit(motions, iterations=0)
        timed("lbskel iterations", lambda e=editor, s=start: e.edit(motions, iterations=n, initial=s))
        timed("libigl iterations", lambda d=data, s=start: igl.arap_solve(s.vertices[b], d, np.array(s.vertices)))
    return [
        {
            "tool": tool,
            "faces": len(mesh.faces),
            "factorization, ms": 1e3 * float(np.median(times[f"{tool} factorization"])),
            "iteration, ms": 1e3 / n * float(np.median(times[f"{tool} iterations"])),
        }
        for tool in ("lbskel", "libigl")
    ]


def starts(cases: dict[str, Case]) -> list[dict[str, Any]]:
    """Energies after ten iterations, by the number of those of ``rotated`` before."""
    before, rows = deformation_methods.START_ITERATIONS, []
    try:
        for deformation_methods.START_ITERATIONS in STARTS:
            row: dict[str, Any] = {"iterations before": deformation_methods.START_ITERATIONS}
            for name, (mesh, handles, motions) in cases.items():
                editor = lbskel.Editor(mesh, handles)
                row[name] = editor.rigidity_energy(editor.edit(motions))
            rows.append(row)
    finally:
        deformation_methods.START_ITERATIONS = before
    return rows


def operators(case: Case) -> list[dict[str, Any]]:
    """The 90-degree bar as rigid as possible by every operator, on its own triangles and on bad ones.

    The error on bad triangles is the distance from the surface that cotangent weights give on good ones.
    """
    mesh, handles, motions = case
    good = lbskel.edit(mesh, handles, motions, operator="cotangent")
    bad = {kind: damaged(kind, mesh) for kind in ("needles", "caps")}
    others = {
        **{kind: (lbskel.Mesh(each.vertices, each.faces), handles, motions) for kind, each in bad.items()},
        "stretched": bar(90, twist=False, stretch=5.0),
    }
    rows: list[dict[str, Any]] = []
    for operator in lbskel.OPERATORS:
        row: dict[str, Any] = {"operator": f"`{operator}`"}
        try:
            result = lbskel.edit(mesh, handles, motions, operator=operator)
            row["edges changed by"] = float(np.abs(result.edge_lengths / mesh.edge_lengths - 1).mean())
            row["volume changed by"] = abs(result.volume / mesh.volume - 1)
        except lbskel.LbskelError as error:
            row["edges changed by"] = type(error).__name__
        for name, (surface, regions, moved) in others.items():
            try:
                result = lbskel.edit(surface, regions, moved, operator=operator)
            except lbskel.LbskelError as error:
                row[name] = type(error).__name__
                continue
            squares = igl.point_mesh_squared_distance(result.vertices, good.vertices, good.faces)[0]
            row[name] = float(np.sqrt(squares.mean()) / mesh.diagonal)
        rows.append(row)
    return rows


def _pictures(cases: dict[str, Case], results: Path) -> None:
    for name, (mesh, handles, motions) in cases.items():
        panels = [Panel(mesh, title="at rest")]
        for method in (each for each in METHODS if each != "naive"):  # looks like biharmonic
            panels.append(Panel(lbskel.edit(mesh, handles, motions, method=method), title=method))
        render(panels, results / f"applications_editing_{name}.png", size=(1500, 400), force=True)


def run(quick: bool, results: Path, peers: bool = False) -> None:
    """Measure, and write applications_editing.json, .md and pictures; libigl is always there."""
    cases = {"bent": bar(90, twist=False), "twisted": bar(135, twist=True), "cactus": cactus()}
    tripod = make("tripod", n_vertices=1000 if quick else 5000).mesh
    x = tripod.vertices[:, 0]
    handles = [np.flatnonzero(x < np.quantile(x, 0.05)), np.flatnonzero(x > np.quantile(x, 0.95))]
    motions = [np.eye(4), lbskel.rigid_motion(axis=[0, 1, 0], angle_deg=60, translation=[0, 0, 0.2])]
    case = tripod, handles, motions
    counts = (1, 5) if quick else (1, 2, 5, 10, 20, 50, 200)
    measured = {
        "exactness": exactness(tripod, handles),
        "displacements": displacements(case),
        "energies": energies(case, counts),
        "seconds": seconds(quick),
        "starts": starts(cases),
        "operators": operators(cases["bent"]),
    }
    name = "applications_editing"
    save_json(results / f"{name}.json", measured)
    save_markdown(
        results / f"{name}.md",
        "Editing",
        {
            "All handles moved alike": "Largest distance from the surface moved as a whole, relative to the diagonal."
            "\n\n" + markdown_table(measured["exactness"]),
            "Displacements": "Cotangent weights. Largest difference, relative to the diagonal.\n\n"
            + markdown_table(measured["displacements"]),
            "As rigid as possible": "Energy after iterations from the same start, cotangent weights. `igl.arap_solve` "
            "fits rotations in single precision; its iterations are repeated by libigl's own cotangents, "
            "`igl.fit_rotations` and solver in either precision.\n\n" + markdown_table(measured["energies"]),
            "Seconds": "Cotangent weights. Processor milliseconds, medians of five turns. The factorization of lbskel "
            "is that of the editor, without that of the method from which it starts.\n\n"
            + markdown_table(measured["seconds"]),
            "Start": "Energy after ten iterations, by the iterations of the method `rotated` before.\n\n"
            + markdown_table(measured["starts"]),
            "Operators": "The bar bent by 90 degrees, as rigid as possible, ten iterations: mean change of edge "
            "lengths, and of the volume. On needles, caps, and triangles five times as long as wide: root mean square "
            "distance, relative to the diagonal, from what cotangent weights give on good triangles.\n\n"
            + markdown_table(measured["operators"]),
        },
    )
    _pictures(cases, results)
