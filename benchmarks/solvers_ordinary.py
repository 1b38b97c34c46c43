"""Solvers on meshes without slivers beside one with them, for the published energy and for the default.

The systems are those of the first step and of step 8, without merging of vertices. Every trial runs in a process of its
own and is measured in processor seconds; a method that ends in time with a small error has solved the system.
"""

from __future__ import annotations

__all__ = ["measure", "sentences", "table"]

import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, eye_array, load_npz, save_npz

from benchmarks.harness import run_in_subprocess
from benchmarks.solvers_trials import ITERATIONS, OTHER_LOAD, OutOfTimeError, Watch, how_ended, is_iterative
from lbskel import Mesh, SolveError, factorize
from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES, ContractionStepInput, stacked_system
from lbskel.contraction.weights import ATTRACTIONS, INITIAL_WEIGHT_RULES, WEIGHTS, mean_ring_area, ring_areas
from lbskel.operators import laplacian
from lbskel.shapes import chain_of_tori, make, torus
from lbskel.solvers.least_squares import lstsq

STEPS = (1, 8)
SOLVED = 1e-6  # relative error up to which a method has solved a system; a guess
TICK = 0.01  # step of the clock of processor seconds, which are at least so many
REFINEMENTS = 3  # steps of iterative refinement of the reference solution, with residuals in extended precision
MESHES: dict[str, Callable[[], Mesh]] = {
    "torus": lambda: torus(1.0, 0.3, 250, 100),
    "dinosaur": lambda: make("dinosaur", n_vertices=25_000).mesh,
    "two rings, slivers": lambda: chain_of_tori(2, step=0.032),
    "torus, large": lambda: torus(1.0, 0.3, 658, 263),
}
QUICK: dict[str, Callable[[], Mesh]] = {"torus": lambda: torus(1.0, 0.3, 80, 40)}
METHODS = {
    "least_squares": ("cholmod", "superlu", "cg_amg", "cg_jacobi", "cgls"),
    "curvature_flow": ("cholmod", "superlu", "cg_amg", "cg_jacobi"),
}
WEIGHT = {"least_squares": "diffusion_length", "curvature_flow": "local_radius"}
LARGE_ENERGIES = ("curvature_flow",)  # of meshes called large: the published energy at that size is measured elsewhere


def _input(start: Mesh, now: Mesh, step: int, energy: str) -> ContractionStepInput:
    """Describe a step of the contraction, on a mesh with a diameter bound of 1."""
    chosen = WEIGHTS[WEIGHT[energy]]
    tau = INITIAL_WEIGHT_RULES[chosen["initial_weight_rule"]](start, chosen["initial_weight"])
    growth = chosen["contraction_growth"] ** (step - 1)
    none: NDArray[np.int64] = np.empty(0, dtype=np.int64)
    return ContractionStepInput(
        laplacian(now, operator="intrinsic_delaunay"),
        now.vertices,
        tau / mean_ring_area(start) * growth**2 if energy == "least_squares" else tau * growth,
        ATTRACTIONS["ring_areas"](start, now),
        ring_areas(start) / 3,
        lambda L: ROW_TREATMENTS["none"](L, none),
    )


def _write(mesh: Mesh, energy: str, folder: Path) -> None:
    """Contract, and write the system of each of STEPS: A, or K for the published energy, B, and the solution X."""
    now = start = mesh.with_vertices((mesh.vertices - mesh.centroid) / mesh.diameter_bound)
    for step in range(1, 1 + max(STEPS)):
        given = _input(start, now, step, energy)
        if energy == "least_squares":
            matrix, B = stacked_system(given)
            left, A = matrix.T.tocsr().astype(np.longdouble), csc_array(matrix.T @ matrix)
        else:
            system = ENERGIES[energy](given)
            matrix, B, A = csr_array(system.A), system.B, system.A
            left = csr_array(eye_array(len(B), dtype=np.longdouble))
        factorization, exact = factorize(A), matrix.astype(np.longdouble)
        X = np.zeros((len(now.vertices), 3), dtype=np.longdouble)
        for _ in range(1 + REFINEMENTS):
            X = X + factorization.solve(np.asarray(left @ (B - exact @ X), dtype=np.float64))
        X = X.astype(np.float64)
        if step in STEPS:
            save_npz(folder / f"{step}.npz", matrix)
            np.savez(folder / f"{step}_sides.npz", B=B, X=X)
        now = now.with_vertices(now.vertices + X)


def trial(energy: str, step: int, method: str, cap: float, folder: Path) -> dict[str, Any]:
    """Measure one method on one system: processor seconds, relative error, iterations, and how it ended if early."""
    import resource

    limit = int(np.ceil(time.process_time() + 2 * cap))
    resource.setrlimit(resource.RLIMIT_CPU, (limit, resource.getrlimit(resource.RLIMIT_CPU)[1]))
    matrix, sides = csr_array(load_npz(folder / f"{step}.npz")), np.load(folder / f"{step}_sides.npz")
    watch = Watch(sides["X"], cap, by_restarts=False)
    options: dict[str, Any] = {"on_iterate": watch, "iterations": ITERATIONS} if is_iterative(method) else {}
    A = csc_array(matrix) if energy == "curvature_flow" else None
    B = sides["B"]
    watch.began = time.process_time()
    try:
        X = lstsq(matrix, B, method, **options) if A is None else factorize(A, method).solve(B, **options)
    except OutOfTimeError:
        number, seconds, error = watch.curve[-1]
        return {"seconds": seconds, "error": error, "iterations": number, "ended": f"over {cap:g} s"}
    except SolveError as refusal:
        return {"ended": f"refused: {refusal}"}
    seconds = max(time.process_time() - watch.began - watch.looking, TICK)
    answer = {"seconds": seconds, "error": watch.error(X)}
    return answer | ({"iterations": watch.number} if options else {})


def measure(quick: bool, cap: float) -> Iterator[list[dict[str, Any]]]:
    """Measure every method on every system, one row each; yields the rows of all meshes up to now after each mesh."""
    rows: list[dict[str, Any]] = []
    for name, make_mesh in (QUICK if quick else MESHES).items():
        mesh = make_mesh()
        for energy in LARGE_ENERGIES if "large" in name else METHODS:
            with tempfile.TemporaryDirectory() as folder:
                _write(mesh, energy, Path(folder))
                for step in STEPS:
                    system = {"mesh": name, "vertices": len(mesh.vertices), "energy": energy.replace("_", " ")}
                    for method in METHODS[energy]:
                        given = energy, step, method, cap, Path(folder)
                        answer = run_in_subprocess(trial, *given, timeout=OTHER_LOAD * cap)
                        found = answer.get("value") or {"ended": how_ended(answer["error"], cap)}
                        rows.append({**system, "step": step, "method": method, **found})
        yield rows


def _is_solved(row: dict[str, Any]) -> bool:
    return row.get("error", np.inf) <= SOLVED and "ended" not in row


def _systems(rows: Sequence[dict[str, Any]]) -> dict[tuple[Any, ...], dict[str, dict[str, Any]]]:
    """Group the rows by system, then by method."""
    found: dict[tuple[Any, ...], dict[str, dict[str, Any]]] = {}
    for row in rows:
        key = tuple(row[column] for column in ("mesh", "vertices", "energy", "step"))
        found.setdefault(key, {})[row["method"]] = row
    return found


def table(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Tabulate one line for each system: seconds of CHOLMOD, and the multiple of them that each method takes."""
    lines = []
    for key, by_method in _systems(rows).items():
        line = dict(zip(("mesh", "vertices", "energy", "step"), key, strict=True))
        cholmod = by_method["cholmod"]
        line["cholmod"] = f"{cholmod['seconds']:.2g} s, {cholmod['error']:.0e}"
        for method in METHODS["least_squares"][1:]:
            row = by_method.get(method)
            if row is None or "error" not in row:
                line[method] = None if row is None else row["ended"].split(":")[0]
            elif _is_solved(row):
                line[method] = f"{row['seconds'] / cholmod['seconds']:.2g} x, {row['error']:.0e}"
            else:
                line[method] = f"fails: {row['error']:.0e} after {row['seconds'] / cholmod['seconds']:.2g} x"
        lines.append(line)
    return lines


def sentences(rows: Sequence[dict[str, Any]]) -> str:
    """Say how often CHOLMOD is first, and for each other method where it solves the systems and by how much slower."""
    systems = _systems(rows)
    first = sum(
        min((row for row in found.values() if _is_solved(row)), key=lambda row: row["seconds"])["method"] == "cholmod"
        for found in systems.values()
    )
    said = [f"CHOLMOD is the first of the methods that solve a system on {first} of {len(systems)} systems."]
    for method in METHODS["least_squares"][1:]:
        for energy in METHODS:
            name = energy.replace("_", " ")
            for step in STEPS:
                own = [found for key, found in systems.items() if key[2:] == (name, step) and method in found]
                if not own:
                    continue
                times = [
                    each[method]["seconds"] / each["cholmod"]["seconds"] for each in own if _is_solved(each[method])
                ]
                span = f", in {min(times):.2g} to {max(times):.2g} times CHOLMOD's time" if times else ""
                said.append(f"`{method}`, {name}, step {step}: solves {len(times)} of {len(own)}{span}.")
    return f"Solved means a relative error below {SOLVED:g}.\n\n" + "\n".join(f"- {each}" for each in said) + "\n"
