"""CGAL's skeleton and segmentation, by small C++ drivers that are compiled where a compiler and the headers are found.

Each program is cached in the system's folder for temporary files under the hash of its source, because compiling takes
a minute.
"""

from __future__ import annotations

__all__ = ["Graph", "cgal_medial", "cgal_parts", "cgal_seconds", "driver"]

import functools
import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

import lbskel

SOURCE = Path(__file__).parent / "cgal_skeleton.cpp"
PARTS_SOURCE = Path(__file__).parent / "cgal_segmentation.cpp"
FLAGS = ("-std=c++17", "-O3", "-DNDEBUG", "-DCGAL_EIGEN3_ENABLED")
INCLUDES = ("/usr/include/eigen3", "/usr/local/include/eigen3", "/opt/homebrew/include/eigen3", "/opt/homebrew/include")
LIBRARIES = ("-lmpfr", "-lgmp")


@functools.cache
def driver(source: Path = SOURCE) -> Path:
    """Return the path of a program, which is compiled first if it is not cached.

    Raises
    ------
    RuntimeError
        If there is no compiler, or the headers of CGAL and Eigen are not where compilers look.
    """
    compiler = shutil.which(os.environ.get("CXX", "c++"))
    if compiler is None:
        raise RuntimeError("CGAL is not built: there is no C++ compiler")
    recipe = source.read_bytes() + repr((compiler, FLAGS)).encode()
    folder = Path(tempfile.gettempdir()) / f"lbskel-cgal-{os.getuid()}-{hashlib.sha256(recipe).hexdigest()[:16]}"
    folder.mkdir(mode=0o700, exist_ok=True)
    program = folder / source.stem
    if not program.exists():
        unfinished = folder / f"unfinished-{os.getpid()}"
        includes = [f"-I{path}" for path in INCLUDES if Path(path).is_dir()]
        command = [compiler, *FLAGS, *includes, "-o", str(unfinished), str(source), *LIBRARIES]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            reason = next((line for line in done.stderr.splitlines() if "error" in line), "the compiler failed")
            raise RuntimeError(f"CGAL is not built: {reason.split('error: ')[-1][-200:]}")
        unfinished.replace(program)
    return program


Graph: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int64]]


def cgal_seconds(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], kind: str
) -> tuple[Graph, tuple[float, float, float]]:
    """Compute a skeleton by the driver, of the kind ``medial`` or ``plain``.

    Returns
    -------
    tuple
        Nodes and edges; and the seconds of reading, the seconds of the rest, and the peak of memory in megabytes.

    Raises
    ------
    RuntimeError
        If it is not built or refuses the mesh.
    """
    program = driver()
    with tempfile.TemporaryDirectory() as folder:
        mesh, output = Path(folder) / "mesh.off", Path(folder) / "skeleton.txt"
        lbskel.write_mesh(mesh, lbskel.Mesh(vertices, faces))
        done = subprocess.run([program, mesh, output, kind], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"CGAL: {(done.stderr.strip() or f'ended with code {done.returncode}')[-200:]}")
        lines = output.read_text().splitlines()
    reading, rest, megabytes = map(float, lines[0].split())
    n_nodes = int(lines[1].split()[0])
    nodes = np.array([line.split() for line in lines[2 : 2 + n_nodes]], dtype=np.float64).reshape(-1, 3)
    edges = np.array([line.split() for line in lines[2 + n_nodes :]], dtype=np.int64).reshape(-1, 2)
    return (nodes, edges), (reading, rest, megabytes)


def cgal_medial(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Graph:
    """Compute the medially centered mean curvature skeleton, CGAL's default."""
    return cgal_seconds(vertices, faces, "medial")[0]


def cgal_parts(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> tuple[NDArray[np.int64], float]:
    """Segment by shape diameters, with CGAL's own defaults: the part of each face, and the seconds of the processor.

    Raises
    ------
    RuntimeError
        If it is not built or refuses the mesh.
    """
    program = driver(PARTS_SOURCE)
    with tempfile.TemporaryDirectory() as folder:
        mesh, output = Path(folder) / "mesh.off", Path(folder) / "parts.txt"
        lbskel.write_mesh(mesh, lbskel.Mesh(vertices, faces))
        done = subprocess.run([program, mesh, output], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"CGAL: {(done.stderr.strip() or f'ended with code {done.returncode}')[-200:]}")
        seconds, *parts = output.read_text().split()
    return np.array(parts, dtype=np.int64), float(seconds)
