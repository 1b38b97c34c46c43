"""Rigs: bones, symmetry and smoothness of weights, volume kept by bent limbs, and the Khronos validator's findings.

With ``--peers`` the files are checked by gltf-validator, an npm package, where Node finds it. With ``--meshes FOLDER``
further meshes are rigged.
"""

from __future__ import annotations

__all__ = ["run"]

import json
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.applications.branch_measures import face_volumes
from lbskel.shapes import SHAPES, make

NAMES = ("dinosaur", "hand", "octopus", "limbs")
VALIDATE = """
require('gltf-validator').validateBytes(new Uint8Array(require('fs').readFileSync(process.argv[1])))
  .then(report => console.log(JSON.stringify(report.issues)))
"""


def run(quick: bool, results: Path, peers: bool = False, meshes: list[Path] | None = None) -> None:
    """Measure, and write rig.json and rig.md."""
    cases = {name: make(name, n_vertices=3000).mesh for name in (NAMES[:1] if quick else NAMES) if name in SHAPES}
    cases |= {path.stem: lbskel.read_mesh(path) for path in meshes or []}
    rows = [_rigged(name, mesh, peers) for name, mesh in cases.items()]
    save_json(results / "rig.json", {"rows": rows}, meshes=meshes or ())
    save_markdown(results / "rig.md", "Rigs", {"Each mesh": markdown_table(rows)})


def _rigged(name: str, mesh: lbskel.Mesh, peers: bool) -> dict[str, Any]:
    skeleton = lbskel.skeletonize(mesh, preset="character")
    began = time.process_time()
    rig = lbskel.rig(mesh, skeleton)
    seconds = time.process_time() - began
    ends = rig.weights[mesh.edges]
    kept = [value for bone in range(len(rig.names)) if (value := _volume_kept(rig, skeleton, bone)) is not None]
    row: dict[str, Any] = {
        "mesh": name,
        "faces": len(mesh.faces),
        "cpu seconds": seconds,
        "bones": len(rig.names),
        "bones left or right": sum("_left_" in each or "_right_" in each for each in rig.names),
        "largest jump of a weight": float(np.abs(ends[:, 0] - ends[:, 1]).max()),
        "inner joints": len(kept),
        "volume kept at 90 degrees, median": float(np.median(kept)) if kept else None,
        "least": min(kept, default=None),
    }
    if peers:
        row |= _validated(rig)
    return row


def _volume_kept(rig: lbskel.Rig, skeleton: lbskel.Skeleton, bone: int) -> float | None:
    """Volume after a turn of 90 degrees over that before, of a bone of a limb and the one it goes on from."""
    parent = int(rig.parents[bone])
    if parent < 0 or rig.names[bone].rpartition("_")[2] == "1" or rig.names[bone].startswith("spine"):
        return None
    along = rig.tails[bone] - rig.heads[bone]
    axis = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    turn = Rotation.from_rotvec(np.pi / 2 * axis / np.linalg.norm(axis)).as_matrix()
    is_own = np.isin(rig.weights.argmax(axis=1), [bone, parent])[rig.mesh.faces].mean(axis=1) > 0.5
    limb = face_volumes(skeleton, rig.mesh)[is_own].sum()
    return float(1 + (rig.posed({rig.names[bone]: turn}).volume - rig.mesh.volume) / limb)


def _validated(rig: lbskel.Rig) -> dict[str, Any]:
    """Errors and warnings of gltf-validator."""
    node = shutil.which("node")
    if node is None:
        return {"validator": "no Node"}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rig.glb"
        lbskel.write_rig(path, rig)
        done = subprocess.run([node, "-e", VALIDATE, str(path)], capture_output=True, text=True)
    if done.returncode:
        return {"validator": "not installed"}
    issues = json.loads(done.stdout)
    return {"validator's errors": issues["numErrors"], "warnings": issues["numWarnings"]}
