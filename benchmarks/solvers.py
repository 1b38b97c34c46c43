"""Least-squares solvers on the systems of a contraction: error by iteration and by time, memory, conditioning.

Early, middle and late steps of the published energy on a chain of two rings, solved for the displacement. Every method
runs in a process of its own, on to larger systems as long as it ends within the cap with an error below a hundredth.
"""

from __future__ import annotations

__all__ = ["run"]

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, load_npz, save_npz
from scipy.sparse.linalg import LinearOperator, eigsh

from benchmarks.harness import in_child, markdown_table, peak_growth, save_json, save_markdown, save_picture
from lbskel import Mesh, factorize
from lbskel.degeneracy import DEGENERATE
from lbskel.energies import Pull, rectangular
from lbskel.operators import laplacian
from lbskel.shapes import chain_of_tori
from lbskel.solvers import DIRECT, solve_once
from lbskel.solvers.least_squares import LARGEST_DENSE, LEAST_SQUARES, lstsq
from lbskel.weights import HOLDS, STARTS, mean_ring_area, ring_areas

STEPS = {"early": 1, "middle": 4, "late": 8}
GRIDS = {1_000: 0.1687, 5_000: 0.0737, 25_000: 0.032, 170_000: 0.01227}  # of marching cubes, for about so many vertices
USEFUL = 1e-2  # relative error, beyond which a method is not tried on larger systems
REFINEMENTS = 3  # of the solution that errors are measured from
OPERATOR = "intrinsic_delaunay"


def _system(start: Mesh, now: Mesh, step: int) -> tuple[csr_array, NDArray[np.float64]]:
    """K and its right-hand side at a step of the contraction, on a mesh of extent 1."""
    weight = STARTS["reach"](start, 0.02) / mean_ring_area(start) * 4.0 ** (step - 1)
    none: NDArray[np.int64] = np.empty(0, dtype=np.int64)
    pull = Pull(
        laplacian(now, operator=OPERATOR),
        now.vertices,
        weight,
        HOLDS["ring_areas"](start, now),
        ring_areas(start) / 3,
        lambda L: DEGENERATE["none"](L, none),
    )
    return rectangular(pull)


def _write_systems(n_vertices: int, folder: Path) -> dict[str, dict[str, Any]]:
    """Contract a mesh of about that many vertices, and write the systems asked for, each with its solution."""
    mesh = chain_of_tori(2, step=GRIDS[n_vertices])
    now = start = mesh.with_vertices((mesh.vertices - mesh.centroid) / mesh.extent)
    told: dict[str, dict[str, Any]] = {}
    for step in range(1, 1 + max(STEPS.values())):
        K, B = _system(start, now, step)
        factorization = factorize(csc_array(K.T @ K), "cholmod")
        X = factorization.solve(K.T @ B)
        for _ in range(REFINEMENTS):
            X = X + factorization.solve(K.T @ (B - K @ X))
        for name, number in STEPS.items():
            if number == step:
                save_npz(folder / f"{n_vertices}_{name}.npz", K)
                np.savez(folder / f"{n_vertices}_{name}_sides.npz", B=B, X=X)
                condition = _condition(K, factorization)
                told[name] = {"vertices": len(start.vertices), "entries of K": K.nnz, "condition of K": condition}
        now = now.with_vertices(now.vertices + X)
    return told


def _condition(K: csr_array, factorization: Any) -> float:
    """The ratio of the largest singular value to the smallest, the latter by inverse iteration."""
    n = K.shape[1]
    T = K.T.tocsr()
    forward = LinearOperator((n, n), matvec=lambda x: T @ (K @ x), dtype=np.float64)
    inverse = LinearOperator((n, n), matvec=lambda x: factorization._solve_once(x[:, None])[:, 0], dtype=np.float64)
    start = np.cos(np.arange(n, dtype=np.float64))
    largest, smallest = (eigsh(A, k=1, v0=start, tol=1e-2, return_eigenvectors=False)[0] for A in (forward, inverse))
    return float(np.sqrt(largest * smallest))


def _read(n_vertices: int, when: str, folder: Path) -> tuple[csr_array, NDArray[np.float64], NDArray[np.float64]]:
    sides = np.load(folder / f"{n_vertices}_{when}_sides.npz")
    return csr_array(load_npz(folder / f"{n_vertices}_{when}.npz")), sides["B"], sides["X"]


def trial(n_vertices: int, when: str, method: str, cap: float, folder: Path) -> dict[str, Any]:
    """One method on one system, for a process of its own; the iterates' errors, and seconds without looking at them."""
    K, B, exact = _read(n_vertices, when, folder)
    size = float(np.linalg.norm(exact))
    curve: list[tuple[int, float, float]] = []
    looking = 0.0
    began = time.perf_counter()

    class OutOfTimeError(Exception):
        pass

    def watch(number: int, X: NDArray[np.float64]) -> None:
        nonlocal looking
        at = time.perf_counter()
        spent = at - began - looking
        if number < 8 or number & (number - 1) == 0 or number % 100 == 0 or spent > cap:
            curve.append((number, spent, float(np.linalg.norm(X - exact)) / size))
            looking += time.perf_counter() - at
        if spent > cap:
            raise OutOfTimeError

    found: list[NDArray[np.float64]] = []

    def solve() -> None:
        nonlocal began
        began = time.perf_counter()
        if method == "plain normal equations":
            found.append(solve_once(csc_array(K.T @ K), K.T @ B))
        else:
            iterative = method not in ("qr", "svd", "augmented", *DIRECT)
            options: dict[str, Any] = {"on_iterate": watch, "iterations": 2000} if iterative else {}
            found.append(lstsq(K, B, method, **options))

    answer: dict[str, Any] = {}
    is_shown_by_restarts = method in ("lsqr", "lsmr")
    try:
        answer["megabytes"] = peak_growth(solve)
        error = float(np.linalg.norm(found[0] - exact)) / size
    except OutOfTimeError:
        answer["ended"] = f"cap of {cap:g} s"
        error = curve[-1][2]
    seconds = time.perf_counter() - began - looking
    if is_shown_by_restarts:
        seconds /= 2  # every look starts anew, at 1, 2, 4, ... iterations
        curve = [(number, spent / 2, error) for number, spent, error in curve]
    if method not in ("qr", "svd", "augmented", "plain normal equations", *DIRECT):
        answer["iterations"] = curve[-1][0] if curve else 0
    return {**answer, "error": error, "seconds": seconds, "curve": curve}


def _row(n_vertices: int, when: str, method: str, cap: float, folder: Path) -> dict[str, Any]:
    """What came of a trial, or why none did."""
    answer = in_child(trial, n_vertices, when, method, cap, folder, timeout=2 * cap + 20)
    row = {"size": n_vertices, "when": when, "method": method}
    if "error" in answer:
        return {**row, "ended": answer["error"]}
    return {**row, **answer["value"]}


def run(quick: bool, results: Path) -> None:
    """Measure, and write solvers.json, solvers.md and solvers.png."""
    sizes = tuple(GRIDS)[: 1 if quick else None]
    cap = 5.0 if quick else 20.0
    rows: list[dict[str, Any]] = []
    systems: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        given_up: set[tuple[str, str]] = set()
        for n_vertices in sizes:
            told = _write_systems(n_vertices, folder)
            systems += [{"size": n_vertices, "when": when, **facts} for when, facts in told.items()]
            for when in STEPS:
                for method in (*LEAST_SQUARES, "plain normal equations"):
                    if (method, when) in given_up:
                        continue
                    row = _row(n_vertices, when, method, cap, folder)
                    rows.append(row)
                    if not row.get("error", 1.0) <= USEFUL or "ended" in row:
                        given_up.add((method, when))
            _save(rows, systems, quick, cap, results)


def _save(rows: list[dict[str, Any]], systems: list[dict[str, Any]], quick: bool, cap: float, results: Path) -> None:
    """What has been measured so far."""
    measured = {"quick": quick, "cap": cap, "systems": systems, "rows": rows}
    save_json(results / "solvers.json", measured, packages=["pyamg"])
    save_markdown(results / "solvers.md", "Solvers of the least-squares step", _tables(rows, systems, cap))
    save_picture(results / "solvers.png", lambda figure: _picture(rows, figure), size=(14, 8))


def _tables(rows: list[dict[str, Any]], systems: list[dict[str, Any]], cap: float) -> dict[str, str]:
    """A table for each time of the contraction: error, iterations, seconds and memory of each method by size."""
    sections = {"The systems": markdown_table(systems)}
    for when in STEPS:
        lines: dict[str, dict[str, Any]] = {}
        for row in (row for row in rows if row["when"] == when):
            line = lines.setdefault(row["method"], {"method": row["method"]})
            size = f"{row['size'] // 1000}k: "
            line[f"{size}error"] = row.get("error", "-")
            line[f"{size}iterations"] = row.get("iterations")
            line[f"{size}s"] = _short(row["ended"]) if "ended" in row else row.get("seconds")
            line[f"{size}MB"] = row.get("megabytes")
        sections[f"{when.capitalize()}, step {STEPS[when]}"] = markdown_table(list(lines.values()))
    largest = int((LARGEST_DENSE / 16) ** 0.5)
    sections["Notes"] = (
        f"Each run may take {cap:g} s and 2000 iterations; a method is tried on larger systems while its error, "
        f"relative, stays below {USEFUL:g}. A dash: not tried. MB: at the peak, beyond what the system itself "
        f"takes. Dense methods are refused over {LARGEST_DENSE / 1e9:g} GB for K alone, {largest} vertices. "
        "Seconds of lsqr and lsmr are halved, since showing iterates 1, 2, 4, ... costs them twice.\n"
    )
    return sections


def _short(reason: str) -> str:
    """A reason as a table has room for it."""
    return "refused: memory" if "GB" in reason else reason.replace("cap of", "over").split(":")[0][:40]


def _picture(rows: list[dict[str, Any]], figure: Any) -> None:
    """Error against iterations and against seconds, of the smallest systems, on which all methods were tried."""
    size = min(row["size"] for row in rows)
    axes = figure.subplots(2, len(STEPS), sharey=True)
    shown = [row for row in rows if row["size"] == size and row.get("curve")]
    methods = list(dict.fromkeys(row["method"] for row in shown))
    for column, when in enumerate(STEPS):
        for row in (row for row in shown if row["when"] == when):
            number, seconds, error = zip(*row["curve"], strict=True)
            style = {"color": f"C{methods.index(row['method']) % 10}", "label": row["method"]}
            axes[0, column].loglog(number, error, **style)
            axes[1, column].loglog(seconds, error, **style)
        for row in rows:
            if (row["size"], row["when"], row["method"]) == (size, when, "cholmod") and "error" in row:
                axes[1, column].loglog(row["seconds"], max(row["error"], 1e-12), "k*", markersize=12, label="cholmod")
        axes[0, column].set_title(f"{when}, {size // 1000}k vertices")
        axes[0, column].set_xlabel("iteration")
        axes[1, column].set_xlabel("seconds")
        axes[0, column].set_ylim(1e-12, 10)
    for ax in axes.flat:
        ax.grid(alpha=0.3)
    axes[0, 0].set_ylabel("relative error")
    axes[1, 0].set_ylabel("relative error")
    handles, labels = axes[1, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", fontsize=8)
