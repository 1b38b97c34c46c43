"""Filters that may crash or never return, run in a subprocess with a time limit.

The subprocess is a new interpreter that reads the mesh from a pipe and writes the result to another. Nothing is shared,
so its crashes, its memory and its threads do not affect the caller.
"""

from __future__ import annotations

__all__ = ["run_in_subprocess"]

import io
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from lbskel.errors import MeshError, MissingDependency
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.signals import ended_after_tidying_up

SCRIPT = Path(__file__).with_name("pymeshlab_adapter.py")
BASE_SECONDS = 60.0  # time limit, in seconds, of a filter on a small mesh; a guess
SECONDS_PER_FACE = 2e-3  # time added to the limit for each face, in seconds; a guess


def run_in_subprocess(filter_name: str, mesh: Mesh, *, seconds: float | None = None, **options: float) -> Mesh:
    """Apply a filter of pymeshlab to a mesh.

    Parameters
    ----------
    filter_name : str
        A key of ``pymeshlab_adapter.FILTERS``.
    mesh : Mesh
    seconds : float, optional
        Time limit; by default a minute, and longer for large meshes.
    options : float
        Options of the filter.

    Raises
    ------
    MissingDependency
        If pymeshlab is not installed.
    MeshError
        If the subprocess crashed, took too long, or returned no usable mesh.
    """
    if find_spec("pymeshlab") is None:
        raise MissingDependency("pymeshlab", "preprocess", filter_name)
    limit = BASE_SECONDS + SECONDS_PER_FACE * len(mesh.faces) if seconds is None else seconds
    call = io.BytesIO()
    np.savez(call, filter=filter_name, vertices=mesh.vertices, faces=mesh.faces, **options)  # type: ignore[arg-type]
    try:
        with ended_after_tidying_up():  # the subprocess is ended, too
            process = subprocess.run(
                [sys.executable, str(SCRIPT)], input=call.getvalue(), capture_output=True, timeout=limit, check=False
            )
    except subprocess.TimeoutExpired:
        raise MeshError(
            f"pymeshlab's {filter_name} took more than {limit:.0f} s on this mesh and was stopped"
        ) from None
    if process.returncode != 0:
        raise MeshError(f"pymeshlab's {filter_name} failed on this mesh: {_reason(process)}")
    try:
        with np.load(io.BytesIO(process.stdout), allow_pickle=False) as result:
            V, F = result["vertices"], result["faces"]
    except (ValueError, EOFError, OSError, TypeError):
        raise MeshError(f"pymeshlab's {filter_name} returned nothing that can be read") from None
    if len(F) == 0 or not np.isfinite(V).all():
        raise MeshError(f"pymeshlab's {filter_name} returned no faces or positions that are not finite")
    return Mesh(V, F, mesh.notes)


def _reason(process: subprocess.CompletedProcess[bytes]) -> str:
    """Explain why a subprocess failed: the signal that ended it, or the last line of its error output."""
    if process.returncode < 0:
        return f"its process was ended by signal {-process.returncode}"
    lines = process.stderr.decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else f"its process ended with code {process.returncode}"
