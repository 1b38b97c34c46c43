"""Solvers on the systems of a contraction: error by iteration and by time, memory, conditioning; ordinary meshes.

Early, middle and late steps of the published energy on a chain of two rings are solved for the displacement, so that
zero is the warm start. Every method runs in a process of its own and is measured in processor seconds, so that other
load matters less. For each of the three steps it goes on to larger systems as long as it ends in time with an error
below a hundredth, and the last row says how it ended. On the largest early system all methods run.
"""

from __future__ import annotations

__all__ = ["run"]

import json
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, load_npz, save_npz
from scipy.sparse.linalg import LinearOperator, eigsh

from benchmarks import solvers_ordinary
from benchmarks.harness import markdown_table, peak_growth, run_in_subprocess, save_json, save_markdown, save_picture
from benchmarks.solvers_trials import DENSE, ITERATIONS, OTHER_LOAD, OutOfTimeError, Watch, how_ended, is_iterative
from lbskel import Mesh, SolveError, factorize
from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.energies import ContractionStepInput, stacked_system
from lbskel.contraction.weights import ATTRACTIONS, INITIAL_WEIGHT_RULES, mean_ring_area, ring_areas
from lbskel.operators import laplacian
from lbskel.shapes import chain_of_tori
from lbskel.solvers import solve_once
from lbskel.solvers.least_squares import LEAST_SQUARES, MAX_DENSE_BYTES, lstsq

STEPS = {"early": 1, "middle": 4, "late": 8}
GRIDS = {
    1_000: 0.1687,
    5_000: 0.0737,
    25_000: 0.032,
    170_000: 0.01227,
}  # grid spacing of marching cubes, by the number of vertices that it gives
DENSE_GRIDS = {2_000: 0.114, 3_000: 0.093}  # sizes between the first and the second of GRIDS, for dense methods
CAP, QUICK_CAP = 20.0, 5.0  # seconds of a trial, and of a quick one; guesses
USEFUL = 1e-2  # relative error above which a method is not tried on larger systems; a guess
REFINEMENTS = 3  # steps of iterative refinement of the reference solution
OPERATOR = "intrinsic_delaunay"


def _system(start: Mesh, now: Mesh, step: int) -> tuple[csr_array, NDArray[np.float64]]:
    """Build K and its right-hand side at a step of the contraction, on a mesh with a diameter bound of 1."""
    weight = INITIAL_WEIGHT_RULES["diffusion_length"](start, 0.02) / mean_ring_area(start) * 4.0 ** (step - 1)
    none: NDArray[np.int64] = np.empty(0, dtype=np.int64)
    pull = ContractionStepInput(
        laplacian(now, operator=OPERATOR),
        now.vertices,
        weight,
        ATTRACTIONS["ring_areas"](start, now),
        ring_areas(start) / 3,
        lambda L: ROW_TREATMENTS["none"](L, none),
    )
    return stacked_system(pull)


def _write_systems(n_vertices: int, folder: Path, last: int = max(STEPS.values())) -> dict[str, dict[str, Any]]:
    """Contract a mesh of about that many vertices, and write the systems of STEPS, each with its solution."""
    mesh = chain_of_tori(2, step={**GRIDS, **DENSE_GRIDS}[n_vertices])
    now = start = mesh.with_vertices((mesh.vertices - mesh.centroid) / mesh.diameter_bound)
    facts: dict[str, dict[str, Any]] = {}
    for step in range(1, 1 + last):
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
                facts[name] = {
                    "vertices": len(start.vertices),
                    "entries of K": K.nnz,
                    "condition of K": condition,
                }
        now = now.with_vertices(now.vertices + X)
    return facts


def _condition(K: csr_array, factorization: Any) -> float:
    """Compute the ratio of the largest to the smallest singular value, the latter by inverse iteration."""
    n = K.shape[1]
    T = K.T.tocsr()
    forward = LinearOperator((n, n), matvec=lambda x: T @ (K @ x), dtype=np.float64)
    inverse = LinearOperator(
        (n, n), matvec=lambda x: factorization._solve_unrefined(x[:, None])[:, 0], dtype=np.float64
    )
    start = np.cos(np.arange(n, dtype=np.float64))
    largest, smallest = (eigsh(A, k=1, v0=start, tol=1e-2, return_eigenvectors=False)[0] for A in (forward, inverse))
    return float(np.sqrt(largest * smallest))


def _read(n_vertices: int, when: str, folder: Path) -> tuple[csr_array, NDArray[np.float64], NDArray[np.float64]]:
    sides = np.load(folder / f"{n_vertices}_{when}_sides.npz")
    return csr_array(load_npz(folder / f"{n_vertices}_{when}.npz")), sides["B"], sides["X"]


def trial(n_vertices: int, when: str, method: str, cap: float, folder: Path) -> dict[str, Any]:
    """Measure one method on one system."""
    K, B, exact = _read(n_vertices, when, folder)
    watch = Watch(exact, cap, by_restarts=method in ("lsqr", "lsmr"))
    found: list[NDArray[np.float64]] = []

    def solve() -> None:
        watch.began = time.process_time()
        if method == "plain normal equations":
            found.append(solve_once(csc_array(K.T @ K), K.T @ B))
        else:
            options: dict[str, Any] = {"on_iterate": watch, "iterations": ITERATIONS} if is_iterative(method) else {}
            found.append(lstsq(K, B, method, **options))

    answer: dict[str, Any] = {}
    try:
        answer["megabytes"] = peak_growth(solve)
        answer["error"], answer["seconds"] = watch.error(found[0]), time.process_time() - watch.began - watch.looking
    except OutOfTimeError:
        answer["ended"] = f"over {cap:g} s"
    except SolveError as refusal:
        answer["ended"] = f"refused: {refusal}"
    if not watch.curve:
        return answer
    if watch.number >= ITERATIONS:
        answer["ended"] = f"{ITERATIONS} iterations"
    if not watch.by_restarts and "error" in answer:
        watch.curve.append((watch.number, answer["seconds"], answer["error"]))
    _, answer["seconds"], answer["error"] = watch.curve[-1]
    return {**answer, "iterations": watch.number, "curve": watch.curve}


def limited_trial(n_vertices: int, when: str, method: str, cap: float, folder: Path) -> dict[str, Any]:
    """A trial in a process of its own, which the system ends: factorizations cannot be interrupted."""
    import resource

    longest = time.process_time() + (2 if is_iterative(method) else 1) * cap
    resource.setrlimit(resource.RLIMIT_CPU, (int(np.ceil(longest)), resource.getrlimit(resource.RLIMIT_CPU)[1]))
    return trial(n_vertices, when, method, cap, folder)


def _row(n_vertices: int, when: str, method: str, cap: float, folder: Path) -> dict[str, Any]:
    """Return the result of a trial, or how its process ended."""
    answer = run_in_subprocess(limited_trial, n_vertices, when, method, cap, folder, timeout=OTHER_LOAD * cap)
    row = {"size": n_vertices, "when": when, "method": method}
    if "error" in answer:
        return {**row, "ended": how_ended(answer["error"], cap)}
    return {**row, **answer["value"]}


def _is_useful(row: dict[str, Any]) -> bool:
    """Whether the method is worth trying on a larger system."""
    return row.get("error", np.inf) <= USEFUL and not row.get("ended", "").startswith(("over", "refused"))


def run(quick: bool, results: Path, package: str | None = None) -> None:
    """Measure, and write solvers.json, solvers.md and solvers.png; with ``ordinary`` as package, that part alone."""
    if package == "ordinary":
        path = results / "solvers.json"
        before = json.loads(path.read_text(encoding="utf-8"))
        earlier = before.get("earlier") or {key: before["machine"][key] for key in ("commit", "date", "processor")}
        for ordinary in solvers_ordinary.measure(quick, CAP):
            _save(before["rows"], before["systems"], quick, before["cap"], results, ordinary, earlier)
        return
    sizes = tuple(GRIDS)[: 1 if quick else None]
    cap = QUICK_CAP if quick else CAP
    rows: list[dict[str, Any]] = []
    systems: list[dict[str, Any]] = []
    ended: set[tuple[str, str]] = set()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for n_vertices in sizes:
            written = _write_systems(n_vertices, folder)
            systems += [{"size": n_vertices, "when": when, **facts} for when, facts in written.items()]
            for when in STEPS:
                for method in (*LEAST_SQUARES, "plain normal equations"):
                    shows_all = n_vertices == max(GRIDS) and when == "early"
                    if (method, when) in ended and not shows_all:
                        continue
                    row = _row(n_vertices, when, method, cap, folder)
                    rows.append(row)
                    if not _is_useful(row):
                        # the time of a direct method hardly depends on the step
                        ended |= {(method, when)} if is_iterative(method) else {(method, other) for other in STEPS}
                _save(rows, systems, quick, cap, results)
        for n_vertices in () if quick else DENSE_GRIDS:
            (system,) = _write_systems(n_vertices, folder, STEPS["early"]).values()
            for method in DENSE:
                rows.append({**_row(n_vertices, "early", method, cap, folder), "size": system["vertices"]})
    for ordinary in solvers_ordinary.measure(quick, cap):
        _save(rows, systems, quick, cap, results, ordinary)


def _save(
    rows: list[dict[str, Any]],
    systems: list[dict[str, Any]],
    quick: bool,
    cap: float,
    results: Path,
    ordinary: Sequence[dict[str, Any]] = (),
    earlier: dict[str, str] | None = None,
) -> None:
    """Write what has been measured so far; ``earlier`` describes where the rows are of an earlier run."""
    measured = {"quick": quick, "cap": cap, "systems": systems, "rows": rows, "ordinary": ordinary}
    measured |= {"earlier": earlier} if earlier else {}
    save_json(results / "solvers.json", measured, packages=["pyamg"])
    sections = {}
    if ordinary:
        text = f"{markdown_table(solvers_ordinary.table(ordinary))}\n{solvers_ordinary.sentences(ordinary)}"
        sections["With and without slivers, both energies"] = text
    if earlier:
        text = f"The tables below: commit {earlier['commit']}, {earlier['date']}, {earlier['processor']}.\n"
        sections["A mesh with slivers, published energy, by size"] = text
    save_markdown(results / "solvers.md", "Solvers of the contraction step", sections | _tables(rows, systems, cap))
    save_picture(results / "solvers.png", lambda figure: _picture(rows, figure), size=(17, 8))


def _tables(rows: list[dict[str, Any]], systems: list[dict[str, Any]], cap: float) -> dict[str, str]:
    """A table for each time of the contraction: error, iterations, seconds and memory of each method by size."""
    sections = {"The systems": markdown_table(systems)}
    for when in STEPS:
        lines: dict[str, dict[str, Any]] = {}
        for row in (row for row in rows if row["when"] == when and row["size"] in GRIDS):
            line = lines.setdefault(row["method"], {"method": row["method"]})
            size = f"{row['size'] // 1000}k: "
            line[f"{size}error"] = row.get("error")
            line[f"{size}iterations"] = row.get("iterations")
            line[f"{size}s"] = _time(row)
            line[f"{size}MB"] = row.get("megabytes")
        sections[f"{when.capitalize()}, step {STEPS[when]}"] = markdown_table(list(lines.values()))
    sections["Where dense least squares ends"] = markdown_table(_dense(rows, systems))
    sections["Notes"] = (
        f"Each run may take {cap:g} s and {ITERATIONS} iterations, and tells the error reached by then; a method is "
        f"tried on larger systems while it ends in time with a relative error below {USEFUL:g}, and all of them on the "
        "largest early one. A dash: not tried, or nothing to tell. MB: at the peak, beyond what the system itself "
        f"takes. Dense methods are refused over {MAX_DENSE_BYTES / 1e9:g} GB for K alone, "
        f"{int((MAX_DENSE_BYTES / 16) ** 0.5)} vertices. Iterates of lsqr and lsmr: see the module.\n"
    )
    return sections


def _time(row: dict[str, Any]) -> float | str | None:
    """Return the seconds, or why the trial ended early."""
    ended = row.get("ended", "")
    if not ended or ended.endswith("iterations"):
        return row.get("seconds")
    return "refused: memory" if "GB" in ended else ended.split(":")[0][:40]


def _dense(rows: list[dict[str, Any]], systems: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Tabulate seconds and memory of the dense methods on early systems by size."""
    vertices = {system["size"]: system["vertices"] for system in systems}
    lines: dict[int, dict[str, Any]] = {}
    for row in (row for row in rows if row["when"] == "early" and row["method"] in DENSE):
        size = vertices.get(row["size"], row["size"])
        line = lines.setdefault(size, {"vertices": size})
        line |= {f"{row['method']}: s": _time(row), f"{row['method']}: MB": row.get("megabytes")}
    return [lines[size] for size in sorted(lines)]


def _picture(rows: list[dict[str, Any]], figure: Any) -> None:
    """Error against iterations and against seconds: the smallest systems, and the largest early one."""
    columns = [(min(GRIDS), when) for when in STEPS]
    columns += [(max(row["size"] for row in rows), "early")] * (max(row["size"] for row in rows) > min(GRIDS))
    axes = figure.subplots(2, len(columns), sharey=True)
    shown = [row for row in rows if (row["size"], row["when"]) in columns]
    methods = list(dict.fromkeys(row["method"] for row in shown if row.get("curve")))
    for column, (size, when) in enumerate(columns):
        for row in (row for row in shown if (row["size"], row["when"]) == (size, when)):
            if row.get("curve"):
                number, seconds, error = zip(*row["curve"], strict=True)
                style = {"color": f"C{methods.index(row['method']) % 10}", "label": row["method"]}
                axes[0, column].loglog(number, error, **style)
                axes[1, column].loglog(seconds, error, **style)
            elif row["method"] == "cholmod" and "error" in row:
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
