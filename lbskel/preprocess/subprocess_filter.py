"""Filters that may end the process or never return, in a child process with a time limit.

The child is a fresh interpreter that reads the mesh from a pipe and writes the result to one: nothing is shared, so
that its crash, its memory and its threads are its own.
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

SCRIPT = Path(__file__).with_name("pymeshlab_adapter.py")
SECONDS = 60.0
SECONDS_PER_FACE = 2e-3


def run_in_subprocess(filter_name: str, mesh: Mesh, *, seconds: float | None = None, **options: float) -> Mesh:
    """What a filter of pymeshlab makes of a mesh.

    Parameters
    ----------
    filter_name : str
        A key of ``pymeshlab_adapter.FILTERS``.
    mesh : Mesh
    seconds : float, optional
        Limit after which the child is ended; a minute and more for large meshes where it is left out.
    options
        Numbers, handed to the filter.

    Raises
    ------
    MissingDependency
        If pymeshlab is not installed.
    MeshError
        If the child crashed, took too long, or what it made is no mesh.
    """
    if find_spec("pymeshlab") is None:
        raise MissingDependency("pymeshlab", "preprocess", filter_name)
    limit = SECONDS + SECONDS_PER_FACE * len(mesh.faces) if seconds is None else seconds
    call = io.BytesIO()
    np.savez(call, filter=filter_name, vertices=mesh.vertices, faces=mesh.faces, **options)  # type: ignore[arg-type]
    try:
        done = subprocess.run(
            [sys.executable, str(SCRIPT)], input=call.getvalue(), capture_output=True, timeout=limit, check=False
        )
    except subprocess.TimeoutExpired:
        raise MeshError(f"pymeshlab's {filter_name} took more than {limit:.0f} s on this mesh and was ended") from None
    if done.returncode != 0:
        raise MeshError(f"pymeshlab's {filter_name} cannot take this mesh: {_reason(done)}")
    try:
        with np.load(io.BytesIO(done.stdout), allow_pickle=False) as answer:
            V, F = answer["vertices"], answer["faces"]
    except (ValueError, EOFError, OSError, TypeError):
        raise MeshError(f"pymeshlab's {filter_name} answered nothing that could be read") from None
    if len(F) == 0 or not np.isfinite(V).all():
        raise MeshError(f"pymeshlab's {filter_name} leaves nothing of this mesh that could be used")
    return Mesh(V, F, mesh.notes)


def _reason(done: subprocess.CompletedProcess[bytes]) -> str:
    """Why a child failed: the signal that ended it, or the last line of its complaint."""
    if done.returncode < 0:
        return f"its process was ended by signal {-done.returncode}"
    lines = done.stderr.decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else f"its process ended with code {done.returncode}"
