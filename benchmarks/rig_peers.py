"""Rigs in other programs: three.js, Blender and the Khronos validator read the file, libigl makes weights.

The validator and three.js are the npm packages gltf-validator and three, if Node finds them (``NODE_PATH``). Blender is
its Python module, bpy, which requires numpy 1 but also runs with numpy 2 (``pip install --no-deps bpy``).
"""

from __future__ import annotations

__all__ = [
    "PosedElsewhere",
    "biharmonic_weights",
    "blender_weights",
    "issues_of_validator",
    "posed_by_blender",
    "posed_by_three",
]

import json
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import lbskel
from benchmarks.harness import run_in_subprocess

VALIDATE = """
require('gltf-validator').validateBytes(new Uint8Array(require('fs').readFileSync(process.argv[1])))
  .then(report => console.log(JSON.stringify(report.issues)))
"""
POSE = """
const {GLTFLoader} = require('three/examples/jsm/loaders/GLTFLoader.js');
const data = require('fs').readFileSync(process.argv[1]);
const [name, ...turn] = JSON.parse(process.argv[2]);
const bytes = data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength);
new GLTFLoader().parse(bytes, '', gltf => {
  let mesh;
  gltf.scene.traverse(node => { if (node.isSkinnedMesh) mesh = node; });
  mesh.skeleton.getBoneByName(name).quaternion.set(...turn);
  gltf.scene.updateMatrixWorld(true);
  const positions = [], place = mesh.geometry.attributes.position, point = mesh.position.clone();
  for (let i = 0; i < place.count; i++) {
    mesh.applyBoneTransform(i, point.fromBufferAttribute(place, i));
    positions.push(mesh.localToWorld(point).toArray());
  }
  console.log(JSON.stringify({bones: mesh.skeleton.bones.map(bone => bone.name), positions}));
}, error => { throw error; });
"""
# The rows of glTF's axes in Blender's, where z points up.
TO_BLENDER = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
TETGEN = "pq2YQ"  # libigl's flags (a quality of 2, the surface kept), quietly
BBW_ITERATIONS = 8  # of the active set: libigl's tutorial
BLENDER_SECONDS = 300.0  # time limit of Blender for a mesh; it needs a few


@dataclass(frozen=True, eq=False)
class PosedElsewhere:
    """What another program makes of a rig's file after a bone was turned.

    Parameters
    ----------
    bones : tuple of str
        Names of its bones.
    vertices : (n, 3) array of float
        In the axes of the file.
    """

    bones: tuple[str, ...]
    vertices: NDArray[np.float64]


def _by_node(script: str, *arguments: str) -> Any:
    """Run a script and read its output as JSON; None if Node or a package is missing."""
    node = shutil.which("node")
    if node is None:
        return None
    done = subprocess.run([node, "-e", script, *arguments], capture_output=True, text=True)
    if done.returncode and "Cannot find module" in done.stderr:
        return None
    if done.returncode:
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout)


def issues_of_validator(path: Path) -> dict[str, Any] | None:
    """Issues of the Khronos validator, with ``numErrors`` and ``numWarnings``; None if it is not installed."""
    issues: dict[str, Any] | None = _by_node(VALIDATE, str(path))
    return issues


def posed_by_three(path: Path, bone: str, turn: NDArray[np.float64]) -> PosedElsewhere | None:
    """Load a file by three.js and turn a bone; None if it is not installed.

    Parameters
    ----------
    path : Path
    bone : str
    turn : (3, 3) array of float
        A rotation, in the axes of the file.
    """
    found = _by_node(POSE, str(path), json.dumps([bone, *Rotation.from_matrix(turn).as_quat().tolist()]))
    return found and PosedElsewhere(tuple(found["bones"]), np.array(found["positions"]))


def posed_by_blender(path: Path, bone: str, turn: NDArray[np.float64]) -> PosedElsewhere | None:
    """Import a file into Blender and turn a bone; None if Blender is not installed. Arguments as of three.js."""
    if find_spec("bpy") is None:
        return None
    answer = run_in_subprocess(
        _pose_in_blender, str(path), bone, TO_BLENDER @ turn @ TO_BLENDER.T, timeout=BLENDER_SECONDS
    )
    if "value" not in answer:
        raise RuntimeError(answer["error"])
    names, vertices = answer["value"]
    return PosedElsewhere(tuple(names), vertices @ TO_BLENDER)


def _pose_in_blender(path: str, bone: str, turn: NDArray[np.float64]) -> tuple[list[str], NDArray[np.float64]]:
    import bpy  # type: ignore[import-not-found]
    from mathutils import Matrix  # type: ignore[import-not-found]

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    armature = next(each for each in bpy.data.objects if each.type == "ARMATURE")
    mesh = next(each for each in bpy.data.objects if each.type == "MESH" and each.parent == armature)
    posed = armature.pose.bones[bone]
    head = Matrix.Translation(posed.head)
    posed.matrix = head @ Matrix(turn.tolist()).to_4x4() @ head.inverted() @ posed.matrix
    bpy.context.view_layer.update()
    evaluated = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
    vertices = np.array([list(mesh.matrix_world @ vertex.co) for vertex in evaluated.data.vertices])
    return [each.name for each in armature.data.bones], vertices


def blender_weights(rig: lbskel.Rig) -> NDArray[np.float64] | None:
    """(n, b) weights by Blender's automatic ones for the bones of a rig; None if Blender is not installed."""
    if find_spec("bpy") is None:
        return None
    arrays = [np.array(each) for each in (rig.mesh.vertices, rig.mesh.faces, rig.heads, rig.tails, rig.parents)]
    answer = run_in_subprocess(_weigh_in_blender, list(rig.names), *arrays, timeout=BLENDER_SECONDS)
    if "value" not in answer:
        raise RuntimeError(answer["error"])
    weights: NDArray[np.float64] = answer["value"]
    return weights


def _weigh_in_blender(
    names: Sequence[str],
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    heads: NDArray[np.float64],
    tails: NDArray[np.float64],
    parents: NDArray[np.int64],
) -> NDArray[np.float64]:
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    data = bpy.data.meshes.new("mesh")
    data.from_pydata(vertices.tolist(), [], faces.tolist())
    mesh, armature = (
        bpy.data.objects.new("mesh", data),
        bpy.data.objects.new("armature", bpy.data.armatures.new("bones")),
    )
    for each in (mesh, armature):
        bpy.context.collection.objects.link(each)
        each.select_set(True)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bones: list[Any] = []
    for name, head, tail, parent in zip(names, heads.tolist(), tails.tolist(), parents.tolist(), strict=True):
        bone = armature.data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        if parent >= 0:
            bone.parent = bones[parent]
        bones.append(bone)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.object.parent_set(type="ARMATURE_AUTO")
    weights = np.zeros((len(vertices), len(names)))
    column = [names.index(group.name) for group in mesh.vertex_groups]
    for number, vertex in enumerate(mesh.data.vertices):
        for group in vertex.groups:
            weights[number, column[group.group]] = group.weight
    total = weights.sum(axis=1, keepdims=True)
    return np.divide(weights, total, out=np.zeros_like(weights), where=total > 0)


def biharmonic_weights(rig: lbskel.Rig) -> NDArray[np.float64]:
    """(n, b) bounded biharmonic weights by libigl on tetrahedra: Jacobson, Baran, Popovic, Sorkine 2011.

    Roots, whose tails are arbitrary, have none.

    Raises
    ------
    RuntimeError
        If the inside cannot be divided, as where the surface cuts itself.
    """
    import igl
    from igl.copyleft import tetgen

    size = rig.mesh.diameter_bound
    V, heads, tails = ((each - rig.mesh.centroid) / size for each in (rig.mesh.vertices, rig.heads, rig.tails))
    own = np.flatnonzero(rig.parents >= 0)
    joints, inverse = np.unique(np.concatenate([heads[own], tails[own]]).round(9), axis=0, return_inverse=True)
    bones = np.stack([inverse[: len(own)], inverse[len(own) :]], axis=1)
    TV, TT, _ = tetgen.mesh_with_skeleton(V, rig.mesh.faces, joints, BE=bones, tetgen_flags=TETGEN)
    rows, values = igl.boundary_conditions(TV, TT, joints, BE=bones)
    weights = np.zeros((len(V), len(heads)))
    weights[:, own] = np.clip(igl.bbw(TV, TT, rows, values, max_iter=BBW_ITERATIONS)[: len(V)], 0, None)
    return weights / weights.sum(axis=1, keepdims=True)
