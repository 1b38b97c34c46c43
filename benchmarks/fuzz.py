"""Coverage-guided fuzzing of the readers and of as_mesh by atheris: every error must be one of lbskel's.

Each target runs in a process of its own for a fixed time. Inputs that cause another error are written next to the
results. Needs atheris, which no extra of the package installs.
"""

from __future__ import annotations

__all__ = ["run"]

import os
import re
import subprocess
import sys
import tempfile
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import markdown_table, save_json, save_markdown

SECONDS, QUICK_SECONDS = 20, 3
MESHES = ("obj", "off", "ply", "stl", "glb", "gltf", "3mf")
CLOUDS = ("xyz", "txt", "csv", "pcd", "npy")
SKELETONS = ("swc", "json", "npz", "vtp", "graphml")
TARGETS = (*MESHES, *CLOUDS, *SKELETONS, "as_mesh")
PCD = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n"
MEMORY = 2048  # limit for one input, in megabytes; a guess
ONE_INPUT = 20  # time limit for one input, in seconds; a guess


def run(quick: bool, results: Path) -> None:
    """Fuzz each target, and write fuzz.json and fuzz.md."""
    if find_spec("atheris") is None:
        raise RuntimeError("nothing can be fuzzed without atheris: pip install atheris")
    rows = [_row(target, QUICK_SECONDS if quick else SECONDS, results) for target in TARGETS]
    save_json(results / "fuzz.json", {"targets": rows}, packages=("atheris",))
    save_markdown(results / "fuzz.md", "Fuzzing", {"Targets": markdown_table(rows)})


def _row(target: str, seconds: int, results: Path) -> dict[str, Any]:
    """Fuzz one target in a process of its own; a process that ends otherwise than by its time has found something."""
    with tempfile.TemporaryDirectory() as folder:
        _seed(target, Path(folder))
        found = results / f"fuzz-{target}-"
        done = subprocess.run(
            [sys.executable, __file__, target, folder, str(seconds), str(found)],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=seconds + 300,
        )
    lines = done.stderr.splitlines()
    runs = re.findall(r"Done (\d+) runs", done.stderr) or re.findall(r"#(\d+)\s", done.stderr)
    wrong = [
        line for line in lines if "Uncaught Python exception" in line or line.startswith("ERROR") or "ERROR:" in line
    ]
    after = lines[lines.index(wrong[0]) + 1 : lines.index(wrong[0]) + 3] if wrong else []
    ended = ["", *lines][-1:] if done.returncode and not wrong else []
    return {
        "target": target,
        "seconds": seconds,
        "inputs": int(runs[-1]) if runs else 0,
        "found": " ".join([*wrong[:1], *after, *ended]) or "nothing",
        "code": done.returncode,
    }


def _seed(target: str, folder: Path) -> None:
    """Write a valid file to start from."""
    import trimesh

    import lbskel
    from lbskel.shapes import torus

    mesh = torus(1.0, 0.4, 4, 3)
    skeleton = lbskel.Skeleton(np.eye(3), np.array([[0, 1], [1, 2]]), np.ones(3))
    path = folder / f"seed.{target}"
    if target in ("obj", "off", "ply", "stl"):
        lbskel.write_mesh(path, mesh)
    elif target in ("glb", "3mf"):
        path.write_bytes(trimesh.Scene(trimesh.Trimesh(mesh.vertices, mesh.faces)).export(file_type=target))
    elif target == "gltf":
        exported: Any = trimesh.Trimesh(mesh.vertices, mesh.faces).export(file_type="gltf", embed_buffers=True)
        path.write_bytes(exported["model.gltf"])
    elif target == "npy":
        np.save(path, np.eye(3))
    elif target in (*CLOUDS, "as_mesh"):
        text = (PCD if target == "pcd" else "") + "0 0 0\n1 0 0\n1 1 0\n"
        path.write_text(text.replace(" ", ",") if target == "csv" else text)
    else:
        lbskel.write_skeleton(path, skeleton)


def _fuzz(target: str, folder: str, seconds: str, found: str) -> None:
    """Fuzz, in the process of a target; never returns."""
    import atheris  # type: ignore[import-untyped, import-not-found, unused-ignore]

    with atheris.instrument_imports(include=["lbskel"]):
        import lbskel
        from lbskel.errors import LbskelError
        from lbskel.preprocess import preprocess_mesh

    scratch = Path(tempfile.mkdtemp()) / f"input.{target}"
    read = lbskel.read_mesh if target in MESHES else lbskel.read_points if target in CLOUDS else lbskel.read_skeleton

    def read_bytes(data: bytes) -> None:
        scratch.write_bytes(data)
        with suppress(LbskelError):
            read(scratch)

    def take_values(data: bytes) -> None:
        provider = atheris.FuzzedDataProvider(data)
        n, m, width = (
            provider.ConsumeIntInRange(0, 6),
            provider.ConsumeIntInRange(0, 6),
            provider.ConsumeIntInRange(0, 5),
        )
        vertices: Any = [
            [provider.ConsumeFloat() for _ in range(provider.PickValueInList([3, 3, 3, 2]))] for _ in range(n)
        ]
        faces: Any = [
            [provider.ConsumeIntInRange(-2, 7) for _ in range(provider.PickValueInList([width, 3, 4]))]
            for _ in range(m)
        ]
        if provider.ConsumeBool():
            faces = np.array(faces, dtype=object)
        with suppress(LbskelError):
            preprocess_mesh(lbskel.as_mesh((vertices, faces)))

    limits = [f"-max_total_time={seconds}", f"-rss_limit_mb={MEMORY}", f"-timeout={ONE_INPUT}", "-max_len=4096"]
    atheris.Setup(
        [sys.argv[0], folder, *limits, f"-artifact_prefix={found}"], take_values if target == "as_mesh" else read_bytes
    )
    atheris.Fuzz()


if __name__ == "__main__":
    sys.path[0] = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    _fuzz(*sys.argv[1:])
