"""Rigs: bones, symmetry and smoothness of weights, volume kept by bent limbs, joints of characters, other programs.

With ``--peers`` the files are read by the Khronos validator, three.js and Blender, and the weights are compared with
Blender's automatic weights and libigl's bounded biharmonic weights, where these programs are installed. With
``--meshes FOLDER`` more meshes are rigged, and drawn bent.
"""

from __future__ import annotations

__all__ = ["run"]

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import lbskel
import lbskel.applications.bone_heat as heat
from benchmarks.application_constants import FACTORS, swept
from benchmarks.characters import CHARACTERS
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.rig_peers import (
    biharmonic_weights,
    blender_weights,
    issues_of_validator,
    posed_by_blender,
    posed_by_three,
)
from lbskel.applications.branch_measures import face_volumes
from lbskel.applications.mirror import find_mirror_plane
from lbskel.shapes import make, tube
from lbskel.visualization import Panel, render

NAMES = ("dinosaur", "hand", "octopus", "limbs")
CONSTANTS = tuple(f"applications/{name}.py" for name in ("bones", "bone_heat", "rigging", "mirror"))
BONE_LENGTHS = (1.5, 2.0, 3.0, 4.0, 6.0)  # of the bones of a cylinder, in its radii
WIDTHS = (0.5, 1.0, 2.0, 4.0)  # over which the weights of a cylinder change, in its radii
LONG_LIMB = 0.1  # of the diagonal, that two bones at an elbow or a knee are long at least; at fingers, 0.04 at most
MOST_FACES = 8000  # of a mesh for biharmonic weights, which take minutes on 50,000
HEATS = (0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 9.0)
TURN = Rotation.from_rotvec([0.5, 0.7, -0.3]).as_matrix()  # of a bone in other programs; about 52 degrees


def run(quick: bool, results: Path, peers: bool = False, meshes: list[Path] | None = None) -> None:
    """Measure, and write rig.json and rig.md, and rig.png if there are meshes."""
    cases = {name: make(name, n_vertices=3000).mesh for name in (NAMES[:1] if quick else NAMES)}
    cases |= {
        f"{name}, with joints": make_it().mesh for name, make_it in list(CHARACTERS.items())[: 1 if quick else None]
    }
    cases |= {path.stem: lbskel.read_mesh(path) for path in meshes or []}
    rigs = {}
    for name, mesh in cases.items():
        skeleton = lbskel.skeletonize(mesh, preset="character")
        began = time.process_time()
        rig = lbskel.rig(mesh, skeleton)
        rigs[name] = rig, skeleton, time.process_time() - began
    measured = {
        "rows": [_rigged(name, *each) for name, each in rigs.items()],
        "programs": [_elsewhere(name, rig) for name, (rig, _, _) in rigs.items()] if peers else [],
        "weights": [_weighed(name, rig, skeleton) for name, (rig, skeleton, _) in rigs.items()] if peers else [],
        "cylinders": _cylinders(),
        "heat": _heat(peers),
        "constants": _constants((0.7, 1.4) if quick else FACTORS),
    }
    if meshes:
        _draw({name: each[0] for name, each in rigs.items() if name not in NAMES}, results / "rig.png")
    save_json(results / "rig.json", measured, packages=("bpy",), meshes=meshes or ())
    sections = {
        "Each mesh": "Volume kept: at the inner joints of limbs; of arms and legs: where two bones have over "
        f"{LONG_LIMB:g} of the diagonal together, which those of fingers and toes have not. Mirrored but for: the "
        "largest difference of a weight from that of the twin bone at the vertex at the mirror image, where the mesh "
        "is symmetric and has such vertices.\n\n" + markdown_table(measured["rows"]),
        "In other programs": "Errors and warnings of the Khronos validator; whether three.js and Blender find the "
        "same bones, and the largest distance of a vertex from linear blend skinning after the last bone was turned, "
        "relative to the diagonal.\n\n" + markdown_table(measured["programs"]),
        "Weights of others": "For the same bones: the mean over the vertices of the sum of the differences of weights, "
        "at most 2; the largest difference of a weight along an edge; volume kept as above. Bounded biharmonic weights "
        "are libigl's on tetrahedra, without roots, on meshes of up to 8,000 faces.\n\n"
        + markdown_table(measured["weights"]),
        "Cylinders": "Volume kept by a cylinder of two bones, bent by 90 degrees in the middle by linear blend "
        "skinning: weights that change linearly over so many radii, and bone heat. In radii: the length of a bone.\n\n"
        + markdown_table(measured["cylinders"]),
        "Heat": "The characters with known joints by the constant `HEAT`: the differences of weights from Blender's, "
        "the largest jump of a weight along an edge, the least volume kept, and that of a cylinder whose bones are two "
        "radii long.\n\n" + markdown_table(measured["heat"]),
        "Constants": "Each times a factor, on the characters with known joints: all bones, bones with a left or right "
        "name, distance of the nearest joint from a known one in local radii, the largest jump of a weight along an "
        "edge, and the least volume kept.\n\n" + markdown_table(measured["constants"]),
    }
    save_markdown(
        results / "rig.md", "Rigs", {name: text for name, text in sections.items() if not text.endswith("\n\n")}
    )


def _jump(rig: lbskel.Rig, weights: NDArray[np.float64]) -> float:
    """The largest difference of a weight along an edge."""
    ends = weights[rig.mesh.edges]
    return float(np.abs(ends[:, 0] - ends[:, 1]).max())


def _sided(rig: lbskel.Rig) -> int:
    """The number of bones whose name says left or right."""
    return sum("_left_" in name or "_right_" in name for name in rig.names)


def _asymmetry(rig: lbskel.Rig) -> float | None:
    """The largest difference of a weight from that of the twin bone at the twin vertex; None if nothing is mirrored."""
    plane = find_mirror_plane(rig.mesh)
    if plane is None or _sided(rig) == 0:
        return None
    other = {"left": "right", "right": "left"}
    swapped = ["_".join(other.get(word, word) for word in name.split("_")) for name in rig.names]
    twins = [rig.names.index(name) for name in swapped]
    rows = np.flatnonzero(plane.twins >= 0)
    return float(np.abs(rig.weights[rows] - rig.weights[plane.twins[rows]][:, twins]).max(initial=0.0))


def _kept(rig: lbskel.Rig, skeleton: lbskel.Skeleton, longer: float = 0.0) -> list[float]:
    """The volume kept at each inner joint of a limb, of those with two bones over a share of the diagonal."""
    lengths = np.linalg.norm(rig.tails - rig.heads, axis=1)
    is_long = lengths + lengths[rig.parents] > longer * rig.mesh.diagonal
    bones = np.flatnonzero(is_long).tolist()
    return [value for bone in bones if (value := _volume_kept(rig, skeleton, bone)) is not None]


def _rigged(name: str, rig: lbskel.Rig, skeleton: lbskel.Skeleton, seconds: float) -> dict[str, Any]:
    kept = _kept(rig, skeleton)
    return {
        "mesh": name,
        "faces": len(rig.mesh.faces),
        "cpu seconds": seconds,
        "bones": len(rig.names),
        "bones left or right": _sided(rig),
        "largest jump of a weight": _jump(rig, rig.weights),
        "mirrored but for": _asymmetry(rig),
        "inner joints": len(kept),
        "volume kept at 90 degrees, median": float(np.median(kept)) if kept else None,
        "least": min(kept, default=None),
        "least of arms and legs": min(_kept(rig, skeleton, LONG_LIMB), default=None),
    }


def _volume_kept(rig: lbskel.Rig, skeleton: lbskel.Skeleton, bone: int) -> float | None:
    """Volume after a turn of 90 degrees over that before, of a bone of a limb and the one it goes on from."""
    parent = int(rig.parents[bone])
    if parent < 0 or rig.names[bone].rpartition("_")[2] == "1" or rig.names[bone].startswith("spine"):
        return None
    turn = _quarter_turn(rig, bone)
    is_own = np.isin(rig.weights.argmax(axis=1), [bone, parent])[rig.mesh.faces].mean(axis=1) > 0.5
    limb = face_volumes(skeleton, rig.mesh)[is_own].sum()
    return float(1 + (rig.posed({rig.names[bone]: turn}).volume - rig.mesh.volume) / limb)


def _quarter_turn(rig: lbskel.Rig, bone: int) -> NDArray[np.float64]:
    """A turn of 90 degrees about an axis across the bone."""
    along = rig.tails[bone] - rig.heads[bone]
    axis = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    return Rotation.from_rotvec(np.pi / 2 * axis / np.linalg.norm(axis)).as_matrix()


def _elsewhere(name: str, rig: lbskel.Rig) -> dict[str, Any]:
    """What the validator, three.js and Blender make of the file."""
    row: dict[str, Any] = {"mesh": name}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rig.glb"
        lbskel.write_rig(path, rig)
        issues = issues_of_validator(path)
        if issues is not None:
            row |= {"validator's errors": issues["numErrors"], "warnings": issues["numWarnings"]}
        expected = rig.posed({rig.names[-1]: TURN}).vertices
        for program, call in (("three.js", posed_by_three), ("Blender", posed_by_blender)):
            found = call(path, rig.names[-1], TURN)
            if found is not None:
                row[f"{program}: same bones"] = "yes" if set(found.bones) == set(rig.names) else "no"
                row[f"{program}: difference"] = float(np.abs(found.vertices - expected).max() / rig.mesh.diagonal)
    return row


def _weighed(name: str, rig: lbskel.Rig, skeleton: lbskel.Skeleton) -> dict[str, Any]:
    """Weights of others for the same bones, beside ours."""
    row: dict[str, Any] = {"mesh": name}
    makers: dict[str, Callable[[lbskel.Rig], NDArray[np.float64] | None]] = {"Blender": blender_weights}
    if len(rig.mesh.faces) <= MOST_FACES:
        makers["biharmonic"] = biharmonic_weights
    for who, make_weights in makers.items():
        began = time.perf_counter()
        try:
            weights = make_weights(rig)
        except RuntimeError as error:
            row[f"{who}: difference"] = str(error).strip().splitlines()[-1][:60]
            continue
        if weights is None or not weights.any():  # Blender's heat finds no solution on some meshes
            row |= {} if weights is None else {f"{who}: difference": "found none"}
            continue
        row[f"{who}: difference"] = float(np.abs(weights - rig.weights).sum(axis=1).mean())
        row[f"{who}: jump"] = _jump(rig, weights)
        if (weights.sum(axis=1) > 0.5).all():
            other = lbskel.Rig(rig.mesh, rig.names, rig.heads, rig.tails, rig.parents, weights)
            row[f"{who}: least volume kept"] = min(_kept(other, skeleton), default=None)
        row[f"{who}: seconds"] = time.perf_counter() - began
    return row


def _cylinders(lengths: tuple[float, ...] = BONE_LENGTHS) -> list[dict[str, Any]]:
    """Volume kept by cylinders of radius 1 bent by 90 degrees in the middle."""
    turn = Rotation.from_euler("y", 90, degrees=True).as_matrix()
    rows = []
    for length in lengths:
        z = np.linspace(-length, length, round(40 * length) + 1)
        mesh = tube(np.stack([0 * z, 0 * z, z], axis=1), 1.0, sides=48)
        heads, tails = np.array([[0, 0, -length], [0, 0, 0.0]]), np.array([[0, 0, 0.0], [0, 0, length]])
        share = {
            f"over {width:g} radii": np.clip(mesh.vertices[:, 2] / width + 0.5, 0, 1)
            for width in WIDTHS
            if width <= 2 * length
        }
        coarse = tube(np.stack([0 * z, 0 * z, z], axis=1)[::8], 1.0, sides=24)
        own = (coarse.vertices[:, 2] > 0).astype(np.int64)
        conducted = heat.bone_weights(coarse, heads, tails, np.array([-1, 0]), own)
        row: dict[str, Any] = {"in radii": length}
        for name, (surface, second) in {
            **{name: (mesh, values) for name, values in share.items()},
            "bone heat": (coarse, conducted[:, 1]),
        }.items():
            rig = lbskel.Rig(
                surface, ("first", "second"), heads, tails, np.array([-1, 0]), np.stack([1 - second, second], axis=1)
            )
            row[name] = rig.posed({"second": turn}).volume / surface.volume
        rows.append(row)
    return rows


def _heat(peers: bool) -> list[dict[str, Any]]:
    """Weights of the characters by the heat from the own bone."""
    characters = {name: make_it().mesh for name, make_it in CHARACTERS.items()}
    skeletons = {name: lbskel.skeletonize(mesh, preset="character") for name, mesh in characters.items()}
    before, rows = heat.HEAT, []
    theirs: dict[str, NDArray[np.float64] | None] = {}
    try:
        for heat.HEAT in HEATS:
            row: dict[str, Any] = {"heat": heat.HEAT}
            rigs = {name: lbskel.rig(mesh, skeletons[name]) for name, mesh in characters.items()}
            for name, rig in rigs.items():
                if peers and name not in theirs:
                    theirs[name] = blender_weights(rig)
                if (weights := theirs.get(name)) is not None:
                    row[f"{name}: from Blender's"] = float(np.abs(weights - rig.weights).sum(axis=1).mean())
            row["jump"] = max(_jump(rig, rig.weights) for rig in rigs.values())
            row["volume kept"] = min(min(_kept(rig, skeletons[name]), default=1.0) for name, rig in rigs.items())
            row["by a cylinder"] = _cylinders((2.0,))[0]["bone heat"]
            rows.append(row)
    finally:
        heat.HEAT = before
    return rows


def _constants(factors: tuple[float, ...]) -> list[dict[str, Any]]:
    """Bones, joints and weights of the characters by the constants."""
    characters = [make_it() for make_it in CHARACTERS.values()]
    skeletons = [lbskel.skeletonize(each.mesh, preset="character") for each in characters]

    def measure() -> dict[str, Any]:
        rigs = [lbskel.rig(each.mesh, skeleton) for each, skeleton in zip(characters, skeletons, strict=True)]
        gaps = []
        for rig, character in zip(rigs, characters, strict=True):
            distances = np.linalg.norm(rig.heads[:, None] - character.joints, axis=2).min(axis=0)
            gaps.append(distances / character.radii)
        return {
            "bones": ", ".join(str(len(rig.names)) for rig in rigs),
            "left or right": ", ".join(map(str, map(_sided, rigs))),
            "from known joints": float(np.concatenate(gaps).mean()),
            "of elbows and knees": float(gaps[0].mean()),
            "jump": max(_jump(rig, rig.weights) for rig in rigs),
            "volume kept": min(min(_kept(*pair), default=1.0) for pair in zip(rigs, skeletons, strict=True)),
        }

    return swept(CONSTANTS, measure, factors)


def _draw(rigs: dict[str, lbskel.Rig], path: Path) -> None:
    """Draw each mesh with the last bone of every limb of several bones turned by 60 degrees."""
    panels = []
    for name, rig in rigs.items():
        last = [
            bone for bone in range(len(rig.names)) if bone not in rig.parents and not rig.names[bone].endswith("_1")
        ]
        turns = {
            rig.names[bone]: Rotation.from_rotvec(2 / 3 * Rotation.from_matrix(_quarter_turn(rig, bone)).as_rotvec())
            for bone in last
        }
        posed = rig.posed({bone: turn.as_matrix() for bone, turn in turns.items()})
        for title, each in ((name, rig.mesh), (f"{len(turns)} bones turned", posed)):
            mesh = each.with_vertices((each.vertices - rig.mesh.centroid) / rig.mesh.diameter_bound)
            panels.append(Panel(mesh, title=title, field=rig.weights.argmax(axis=1) * 0.618034 % 1, field_name="bone"))
    render(panels, path, force=True)
