"""Shared by all benchmarks: timing, memory, subprocesses, provenance, JSON, Markdown tables, pictures."""

from __future__ import annotations

__all__ = [
    "fitted_order",
    "interleaved",
    "machine",
    "markdown_table",
    "median_ratio",
    "peak_growth",
    "run_in_subprocess",
    "save_json",
    "save_markdown",
    "save_picture",
]

import gc
import json
import os
import platform
import re
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.provenance import code_digests, commit, mesh_files

PACKAGES = ("lbskel", "numpy", "scipy", "libigl", "robust_laplacian", "cvxopt")


def _processor() -> str:
    """Return the name of the processor."""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        lines = [line for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        if lines:
            return lines[0].split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def _cgal_version() -> str:
    """Return the version in the headers of CGAL, which are where those of the system are."""
    header = Path("/usr/include/CGAL/version.h")
    found = header.exists() and re.search(r"define CGAL_VERSION (\S+)", header.read_text(encoding="utf-8"))
    return found[1] if found else "not installed"


def machine(packages: Sequence[str] = ()) -> dict[str, Any]:
    """Return the commit, the date, the machine and the versions of packages, for the header of results.

    CGAL, which is no package, has the version of the headers that compilers find.
    """
    versions = {}
    for package in dict.fromkeys((*PACKAGES, *packages)):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = _cgal_version() if package == "CGAL" else "not installed"
    return {
        "commit": commit(),
        "date": datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "threads": os.environ.get("OMP_NUM_THREADS", "as many as the libraries take"),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "versions": versions,
    }


def interleaved(
    calls: Mapping[str, Callable[..., Any]],
    repeats: int = 5,
    *,
    prepare: Mapping[str, Callable[[], Any]] | None = None,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, list[float]]:
    """Time calls in turns, so that other load slows all of them alike, after one warm-up round; seconds of each turn.

    A call that has a function in ``prepare`` is passed a new result of it each time, which is not timed. Seconds are
    those of the ``clock``: ``time.process_time`` counts those of the processor, which other load hardly changes.
    """
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    for turn in range(repeats + 1):
        for name, call in calls.items():
            given = (prepare[name](),) if prepare and name in prepare else ()
            gc.collect()
            start = clock()
            call(*given)
            if turn > 0:
                seconds[name].append(clock() - start)
    return seconds


def median_ratio(ours: Sequence[float], theirs: Sequence[float]) -> float:
    """Compute the median over the turns of the ratio of two series of :func:`interleaved`."""
    return float(np.median(np.divide(ours, theirs)))


def _measure(connection: Any, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    """Call, in the child process, and send the value or the error, the seconds and the peak of resident memory."""
    import resource

    os.setsid()  # a process group of its own, which includes what it starts
    unit = 1 if platform.system() == "Darwin" else 1024
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    try:
        answer = {"value": function(*arguments)}
    except Exception as error:
        answer = {"error": f"{type(error).__name__}: {error}"}
    answer["seconds"] = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    answer["megabytes"] = (after - before) * unit / 1e6
    answer["peak_megabytes"] = after * unit / 1e6
    connection.send(answer)


def run_in_subprocess(function: Callable[..., Any], *arguments: Any, timeout: float = 600.0) -> dict[str, Any]:
    """Call a module-level function in a fresh process: its value or error, seconds, and peak memory.

    Returns
    -------
    dict
        ``value`` or ``error``; ``seconds``; ``megabytes``, the growth of the peak of resident memory during the call;
        ``peak_megabytes``, that peak. After a crash or at the time limit only ``error`` and ``seconds``; programs that
        the process has started are ended too.
    """
    context = get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_measure, args=(sender, function, arguments))
    start = time.perf_counter()
    process.start()
    sender.close()
    try:
        if receiver.poll(timeout):
            return receiver.recv()
        return {"error": f"over {timeout:g} s", "seconds": time.perf_counter() - start}
    except EOFError:
        process.join()
        return {"error": f"the process ended with code {process.exitcode}", "seconds": time.perf_counter() - start}
    finally:
        process.kill()
        if process.pid is not None:
            with suppress(ProcessLookupError):  # all processes of the group have ended
                os.killpg(process.pid, signal.SIGKILL)
        process.join()


def peak_growth(call: Callable[[], Any]) -> float | None:
    """Measure the peak memory of a call in megabytes above what the process held before; None without /proc."""
    reset, status = Path("/proc/self/clear_refs"), Path("/proc/self/status")
    if not reset.exists():
        return None

    def kilobytes(name: str) -> int:
        return next(int(line.split()[1]) for line in status.read_text().splitlines() if line.startswith(name))

    gc.collect()
    reset.write_text("5")
    before = kilobytes("VmRSS")
    call()
    return (kilobytes("VmHWM") - before) * 1024 / 1e6


def fitted_order(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Fit p of errors ~ sizes^p by least squares in logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def _text(value: Any) -> str:
    """Format a table cell: numbers with three digits, None as a dash."""
    if value is None:
        return "-"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return f"{value:.3g}"
    return str(value)


def markdown_table(rows: Sequence[Mapping[str, Any]], columns: Sequence[str] | None = None) -> str:
    """Format rows as a Markdown table; columns default to all keys in the order of their first appearance."""
    columns = list(columns or dict.fromkeys(key for row in rows for key in row))
    lines = ["| " + " | ".join(columns) + " |", "|" + " --- |" * len(columns)]
    lines += ["| " + " | ".join(_text(row.get(column)) for column in columns) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def _plain(value: Any) -> Any:
    """Convert numpy's numbers and arrays for JSON."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


def save_json(
    path: Path, measured: Mapping[str, Any], *, packages: Sequence[str] = (), meshes: Sequence[Path] = ()
) -> None:
    """Write measurements with a header of the machine, the versions, the code, and the files of meshes.

    The file has the name of the module that measured. Meshes that no file is named for are those of lbskel.shapes.
    """
    header = {**machine(packages), "code": code_digests(path.stem), "meshes": mesh_files(meshes)}
    document = {"machine": header, **measured}
    path.write_text(json.dumps(document, indent=1, default=_plain) + "\n", encoding="utf-8")


def save_markdown(path: Path, title: str, sections: Mapping[str, str]) -> None:
    """Write a page with a title, the commit and the machine in one line, and the sections by their headings."""
    here = machine()
    where = f"{here['date']}, {here['processor']}, {here['cores']} cores, threads: {here['threads']}"
    parts = [f"# {title}\n\nCommit {here['commit']}, {where}.\n"] + [
        f"## {heading}\n\n{text}" for heading, text in sections.items()
    ]
    path.write_text("\n".join(parts), encoding="utf-8")


def save_picture(path: Path, draw: Callable[[Any], None], *, size: tuple[float, float] = (8, 5)) -> None:
    """Save as PNG what ``draw(figure)`` draws on an empty matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=110, layout="constrained")
    draw(figure)
    figure.savefig(path, metadata={"Software": None})
