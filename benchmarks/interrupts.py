"""Ctrl-C: seconds from the signal to the end of the process, at moments spread over the skeleton of a large mesh.

The signal is sent to a program in Python, where a handler runs only between two calls of compiled code (kernels, numpy,
CHOLMOD), and to the command line.
"""

from __future__ import annotations

__all__ = ["run"]

import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.shapes import make

N_VERTICES, QUICK_VERTICES = 50_000, 5_000  # of the dinosaur: 100,000 faces
MOMENTS, QUICK_MOMENTS = 4, 2  # spread evenly over the time of the whole
PROGRAMS = {
    "in Python": "import sys, lbskel; print('begun', flush=True); lbskel.skeletonize(sys.argv[1])",
    "command line": "import sys; from lbskel.cli.main import main; print('begun', flush=True); "
    "main(['skeletonize', sys.argv[1], '-o', sys.argv[1] + '.swc', '--force'])",
}


def run(quick: bool, results: Path) -> None:
    """Interrupt, and write interrupts.json and interrupts.md."""
    n_moments = QUICK_MOMENTS if quick else MOMENTS
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "dinosaur.ply"
        mesh = make("dinosaur", n_vertices=QUICK_VERTICES if quick else N_VERTICES).mesh
        lbskel.write_mesh(path, mesh)
        for how, program in PROGRAMS.items():
            whole = _seconds(program, path, None)
            waits = [_seconds(program, path, whole * (k + 0.5) / n_moments) for k in range(n_moments)]
            ended = [wait for wait in waits if wait is not None]
            row = {"what": how, "faces": len(mesh.faces), "whole": whole, "interrupted": len(ended)}
            rows.append({**row, "median wait": statistics.median(ended), "longest wait": max(ended)})
    save_json(results / "interrupts.json", {"interrupts": rows})
    text = "\nSeconds of the clock, beside other work; a wait is that from SIGINT to the end of the process.\n"
    save_markdown(results / "interrupts.md", "Interrupts", {"Waits": markdown_table(rows) + text})


def _seconds(program: str, path: Path, moment: float | None) -> Any:
    """Seconds of the whole, or from a signal sent at a moment to the end; None if the process had ended before."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", program, str(path)]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
        text=True,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),  # which shells ignore in jobs behind
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        began = time.perf_counter()
        if moment is not None:
            try:
                process.wait(timeout=moment)
                return None
            except subprocess.TimeoutExpired:
                began = time.perf_counter()
                process.send_signal(signal.SIGINT)
        process.wait()
        return time.perf_counter() - began
