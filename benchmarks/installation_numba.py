"""Kernels compiled by numba in place of Cython: how many functions, and how long the first call of each takes."""

from __future__ import annotations

__all__ = ["compile_kernels"]

import json
import subprocess
from pathlib import Path
from typing import Any

# The functions of a kernel are plain Python once the blocks without the interpreter's lock are ordinary ones. Each is
# compiled for the types of a call on a small torus. Classes (sections, shortest paths, collapses) are no functions and
# would have to be written anew, as numba's classes have no inheritance.
PROGRAM = """
import json, re, sys, time, types
from pathlib import Path
import numpy as np

began = time.perf_counter()
import numba

rows = [{"kernel": "import numba", "function": None, "seconds": time.perf_counter() - began}]
import lbskel._kernels
from lbskel._kernels import c_types
from lbskel.shapes import torus

ring = torus(1.0, 0.3, 20, 10)
V, F, tree = np.array(ring.vertices), np.array(ring.faces), ring.aabb_tree
boxes = np.array(tree.corners), np.array(tree.bounds)
calls = {
    "triangles": {"corner_products": (V, F), "integrals": (V, F)},
    "connectivity": {"neighbor_sums": (np.array(ring.edges), V)},
    "bvh": {"spatial_order": (V, F)},
    "nearest_points": {"nearest_points": (*boxes, V)},
    "ray_casting": {"first_hits": (boxes[0], np.array(tree.order), boxes[1], V, V), "winding_numbers": (*boxes, V)},
}


def compiled(name):
    # the module with plain blocks, every function of which is compiled when it is first called
    source = Path(lbskel._kernels.__file__).with_name(name + ".py").read_text()
    module = types.ModuleType(name)
    sys.modules["cython"] = c_types
    exec(compile(re.sub(r"with cython.nogil:", "if True:", source), name, "exec"), module.__dict__)
    for key, value in list(vars(module).items()):
        if isinstance(value, types.FunctionType) and value.__code__.co_filename == name:
            setattr(module, key, numba.njit(value))
    return module


for name, functions in calls.items():
    module = compiled(name)
    for function, arguments in functions.items():
        began = time.perf_counter()
        try:
            getattr(module, function)(*arguments)
            taken = time.perf_counter() - began
        except Exception as error:
            taken = type(error).__name__
        rows.append({"kernel": name, "function": function, "seconds": taken})
seconds = [row["seconds"] for row in rows if not isinstance(row["seconds"], str)]
rows.append({"kernel": "in all", "function": None, "seconds": sum(seconds)})
print(json.dumps(rows))
"""


def compile_kernels(python: Path, folder: Path) -> list[dict[str, Any]]:
    """Compile with an interpreter that has numba and lbskel; a row for each function, with seconds or the error.

    Parameters
    ----------
    python : Path
    folder : Path
        Where the process runs: not the clone, whose package would be imported.
    """
    done = subprocess.run([python, "-c", PROGRAM], capture_output=True, text=True, cwd=folder)
    if done.returncode:
        raise RuntimeError(done.stderr[-2000:])
    rows: list[dict[str, Any]] = json.loads(done.stdout)
    return rows
