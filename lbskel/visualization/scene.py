"""The content of an interactive page, and its geometry in the form that the page's program reads.

Browsers draw in single precision, so coordinates are projected to the view of the pictures and divided by the size of
the shape. Positions of surfaces and clouds are stored as 16-bit integers: a step is 1/32767 of half the size, a
thirtieth of a pixel. Surfaces of more faces than a bound are simplified for display
(:mod:`lbskel.visualization.cell_merging`).
"""

from __future__ import annotations

__all__ = ["Scene", "encode_scene"]

import base64
import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.camera import View
from lbskel.visualization.cell_merging import merged_by_cells
from lbskel.visualization.colormaps import field_scales, radius_scale
from lbskel.visualization.html import Table, cell
from lbskel.visualization.panel import Panel
from lbskel.visualization.viewpoint import unobstructed_view

# Bounds on what a page holds, so that it has less than 8 MB at any size of a mesh, 2 of which are plotly.js. Before it
# is packed, a face takes 8 bytes, or 16 with more than 65,536 vertices, a vertex and a point 8, and a step of the
# contraction 8 for each of its vertices. Choices of style.
MAX_FACES, MAX_POINTS, MAX_STEP_FACES, MAX_STEPS, MAX_MENDED = 40_000, 60_000, 10_000, 30, 3_000
MAX_BALLS = 150  # inscribed balls of 162 vertices each that a page draws, evenly chosen; a choice of style
WIDTH_RANGE, WIDTH_SHARE = (2.5, 7.0), 400.0  # of lines in pixels, and pixels for a radius of 1; choices of style
HALF_RANGE = 32767  # largest 16-bit integer


@dataclasses.dataclass(frozen=True, eq=False)
class Scene:
    """The content of an interactive page; all positions in the coordinates of the mesh.

    Parameters
    ----------
    mesh : Mesh or PointCloud, optional
    skeleton : Skeleton, optional
    title : str
    part_of_face : (m,) array of int, optional
        The part of each face of the mesh, shown by color.
    parts_name : str
        What the parts are, for the label of the toggle.
    parts_first : bool
        Whether the parts are shown at first, in place of the plain mesh.
    field : (n,) array of float, optional
        A number for each vertex of the mesh, shown as color.
    field_name : str
        What the numbers are.
    contracted : Mesh, optional
        The surface that was contracted.
    positions : sequence of (k, 3) array of float
        Positions of the vertices of ``contracted`` after each step, or after some.
    step_numbers : sequence of int
        The steps of ``positions``, from 1; empty where they are of every step.
    area_ratios, volume_ratios : sequence of float
        Area and volume after each step, relative to the start; the volume may be NaN.
    columns : mapping of str to (b,) array
        The branch table: a value for each branch of the skeleton.
    off_center : array of int
        Nodes that are marked as off their center.
    mended : (p, 3) array of float
        Points of the surface that preprocessing added or moved.
    notes : sequence of str
        Sentences below the view.
    tables : sequence of Table
    """

    mesh: Mesh | PointCloud | None = None
    skeleton: Skeleton | None = None
    title: str = ""
    part_of_face: NDArray[np.int64] | None = None
    parts_name: str = "parts by branch"
    parts_first: bool = False
    field: NDArray[np.float64] | None = None
    field_name: str = "field"
    contracted: Mesh | None = None
    positions: Sequence[NDArray[np.float64]] = ()
    step_numbers: Sequence[int] = ()
    area_ratios: Sequence[float] = ()
    volume_ratios: Sequence[float] = ()
    columns: Mapping[str, NDArray[Any]] = dataclasses.field(default_factory=dict)
    off_center: NDArray[np.int64] = dataclasses.field(default_factory=lambda: np.empty(0, dtype=np.int64))
    mended: NDArray[np.float64] = dataclasses.field(default_factory=lambda: np.empty((0, 3)))
    notes: Sequence[str] = ()
    tables: Sequence[Table] = ()


@dataclasses.dataclass(frozen=True, eq=False)
class _Frame:
    """The map from the caller's coordinates to those of the page, in which the shape lies in a cube of side 2."""

    view: View
    size: float

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.view.project(points) / self.size

    def encode(self, points: NDArray[np.float64]) -> dict[str, Any]:
        """Encode (n, 3) points as 16-bit integers; points outside the cube are moved to its faces."""
        scaled = np.clip(self.project(points), -1, 1) * HALF_RANGE
        return {**_encoded(scaled.round().astype(np.int16)), "scale": HALF_RANGE}


def encode_scene(scene: Scene) -> tuple[dict[str, Any], list[str]]:
    """Encode a scene as data ready for JSON, and list in sentences what was simplified.

    Parameters
    ----------
    scene : Scene

    Raises
    ------
    MeshError
        If there is neither a mesh nor a skeleton.
    """
    panel = Panel(scene.mesh, scene.skeleton)
    view = unobstructed_view(panel.subject)
    extent = np.abs(view.project(panel.points)).max(axis=0, initial=0.0)
    frame = _Frame(view, float(extent.max()) or 1.0)
    data: dict[str, Any] = {"extent": (extent / frame.size).tolist()}
    notes: list[str] = []
    if isinstance(scene.mesh, Mesh):
        data["mesh"] = _encode_mesh(scene, scene.mesh, frame, notes)
        data["palette"] = _palette()
    elif scene.mesh is not None:
        data["cloud"] = frame.encode(_thinned(scene.mesh.points, MAX_POINTS, "points of the cloud", notes))
    if len(scene.mended):
        data["mended"] = frame.encode(_thinned(scene.mended, MAX_MENDED, "mended points", notes))
    if scene.contracted is not None and len(scene.positions):
        data["steps"] = _encode_steps(scene, frame, notes)
    if scene.skeleton is not None:
        data["skeleton"] = _encode_skeleton(scene.skeleton, scene.off_center, frame)
        data["ball"] = _encode_ball()
    if scene.columns:
        data["columns"] = [
            {"name": name, "values": [cell(value) for value in np.asarray(values).tolist()]}
            for name, values in scene.columns.items()
        ]
    return data, notes


def _encode_mesh(scene: Scene, mesh: Mesh, frame: _Frame, notes: list[str]) -> dict[str, Any]:
    kept, faces, rows = merged_by_cells(mesh.vertices, mesh.faces, MAX_FACES)
    if len(rows) < len(mesh.faces):
        notes.append(f"The mesh is simplified for display: {len(rows):,} of its {len(mesh.faces):,} faces are shown.")
    encoded: dict[str, Any] = {"vertices": frame.encode(mesh.vertices[kept]), "faces": _encoded_indices(faces)}
    if scene.part_of_face is not None and len(scene.part_of_face):
        encoded["parts"] = _encoded_indices(np.maximum(scene.part_of_face[rows], 0))
    if scene.field is not None:
        scale = field_scales([("", scene.field)])[""]
        values = np.clip(np.nan_to_num(scene.field[kept], nan=scale.low), scale.low, scale.high)
        encoded["field"] = {"name": scene.field_name, "low": scale.low, "high": scale.high}
        encoded["field"]["colors"] = "RdBu" if scale.colormap == "RdBu_r" else "Viridis"  # plotly.js: blue is low
        encoded["field"] |= _encoded(values.astype(np.float32))
    return encoded


def _encode_steps(scene: Scene, frame: _Frame, notes: list[str]) -> dict[str, Any]:
    mesh = scene.contracted
    assert mesh is not None  # see encode_scene
    kept, faces, rows = merged_by_cells(mesh.vertices, mesh.faces, MAX_STEP_FACES)
    if len(rows) < len(mesh.faces):
        notes.append(f"The contracted surface is shown by {len(rows):,} of its {len(mesh.faces):,} faces.")
    n, n_states = len(scene.area_ratios), len(scene.positions)
    shown = np.unique(np.linspace(0, n_states, min(n_states, MAX_STEPS) + 1).round().astype(int)).tolist()
    numbers = [[0, *(scene.step_numbers or range(1, n + 1))][state] for state in shown]
    if len(numbers) <= n:
        notes.append(f"The slider shows {len(numbers) - 1} of the {n} steps of the contraction.")
    areas, volumes = [1.0, *scene.area_ratios], [1.0, *scene.volume_ratios]
    labels = []
    for step in numbers:
        volume = "" if volumes[step] != volumes[step] else f", volume {100 * volumes[step]:.3g} %"
        labels.append(f"step {step} of {n}: area {100 * areas[step]:.3g} %{volume}")
    states = [mesh.vertices, *scene.positions]
    return {
        "faces": _encoded_indices(faces),
        "positions": [frame.encode(states[state][kept]) for state in shown],
        "numbers": numbers,
        "labels": labels,
        "curve_x": list(range(n + 1)),
        "areas": [float(area) for area in areas],
        "volumes": None if any(volume != volume for volume in volumes) else [float(volume) for volume in volumes],
    }


def _encode_skeleton(skeleton: Skeleton, off_center: NDArray[np.int64], frame: _Frame) -> dict[str, Any]:
    from plotly.colors import sample_colorscale

    scale = radius_scale([skeleton.radii])
    ends = {"low": 0.0, "high": 0.0, "colors": [[0.0, "#7e03a8"], [1.0, "#7e03a8"]], "ticks": [], "tick_labels": []}
    if scale is not None:
        ticks = np.linspace(scale.low, scale.high, 4)
        colors = sample_colorscale(scale.colormap, np.linspace(0, scale.fraction, 12))
        ends = {
            "low": scale.low / frame.size,
            "high": scale.high / frame.size,
            "colors": [[k / 11, color] for k, color in enumerate(colors)],
            "ticks": (ticks / frame.size).tolist(),
            "tick_labels": [f"{tick:.3g}" for tick in ticks],
        }
    thickness = np.nanmedian(skeleton.radii) / frame.size if scale is not None else 1.0
    width = float(np.clip(WIDTH_SHARE * thickness, *WIDTH_RANGE))
    is_known = np.isfinite(skeleton.radii)
    balls = np.flatnonzero(is_known & (skeleton.radii > 0))
    if len(balls) > MAX_BALLS:
        balls = balls[np.linspace(0, len(balls) - 1, MAX_BALLS).astype(np.int64)]
    return {
        "nodes": {**_encoded(frame.project(skeleton.nodes).astype(np.float32)), "scale": 1},
        "center": frame.view.center.tolist(),
        "axes": frame.view.axes.tolist(),
        "radii": _encoded((skeleton.radii / frame.size).astype(np.float32)),
        "size": frame.size,
        "radius_kind": skeleton.radius_kind,
        "branches": [branch.tolist() for branch in skeleton.branches],
        "tips": skeleton.tips.tolist(),
        "junctions": skeleton.junctions.tolist(),
        "off_center": np.asarray(off_center).tolist(),
        "balls": balls.tolist(),
        "width": width,
        "marker": 0.6 * width,
        **ends,
    }


def _encode_ball() -> dict[str, Any]:
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=2)
    vertices = (np.asarray(ball.vertices) * HALF_RANGE).round().astype(np.int16)
    return {"vertices": {**_encoded(vertices), "scale": HALF_RANGE}, "faces": _encoded_indices(np.asarray(ball.faces))}


def _palette() -> list[str]:
    from plotly.colors import qualitative

    return [*qualitative.Safe, *qualitative.Vivid]


def _thinned(points: NDArray[np.float64], at_most: int, what: str, notes: list[str]) -> NDArray[np.float64]:
    """Choose points evenly from a list that is too long, and append a note that says so."""
    if len(points) <= at_most:
        return points
    notes.append(f"{at_most:,} of the {len(points):,} {what} are shown.")
    return points[np.linspace(0, len(points) - 1, at_most).astype(np.int64)]


def _encoded_indices(indices: NDArray[Any]) -> dict[str, str]:
    """Encode numbers that are not negative with as few bytes as hold them."""
    return _encoded(indices.astype(np.uint16 if indices.max(initial=0) < 2**16 else np.int32))


def _encoded(values: NDArray[Any]) -> dict[str, str]:
    """Encode an array as its type and its bytes, little end first, in base64."""
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return {"dtype": values.dtype.name, "data": base64.b64encode(little.tobytes()).decode()}
