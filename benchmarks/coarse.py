"""Coarse meshes: skeletons of parts of long faces with a fine body beside them, with other bounds on what is refined.

Parts are made of boxes in a grid, whose faces are as long as these, as those of machine parts: combs, ladders, and
frames of many holes. The fine body is a sphere of more faces. Ribbons and ``--meshes`` have faces that are coarse here
and there.
"""

from __future__ import annotations

__all__ = ["run"]

import itertools
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.preprocess.automatic import COARSE_EDGE
from lbskel.preprocess.subdivision import coarse_faces
from lbskel.shapes import sphere
from lbskel.shapes.hard import HARD_SHAPES

THICKNESS, GAP = 2.0, 6.0  # of bars, and between them
SPHERES = (4, 5)  # subdivisions of the fine body: 5,120 and 20,480 faces
TEETH, RUNGS, HOLES = (5, 9), (3, 5), (3, 40)  # 30 by 30 holes have 22,000 faces
WIDTHS = (5.0, 10.0, 20.0)  # of ribbons, over their thickness
MAX_ERROR = 0.15  # of the length of an axis that is right: tips are a radius before their ends

BOUNDS: dict[str, dict[str, float]] = {
    "as they are": {},
    **{f"MAX_COARSE_AREA {value:g}": {"automatic.MAX_COARSE_AREA": value} for value in (0.05, 0.1, 0.3, 0.5, 1.0)},
    **{f"MAX_GROWTH {value:g}": {"subdivision.MAX_GROWTH": value} for value in (1.0, 1.15, 1.5, 2.0, 3.0)},
}

Case = tuple[str, lbskel.Mesh, tuple[int, int, int], float]  # name, mesh, tips, junctions and cycles, length


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write coarse.json and coarse.md; ``meshes`` are real ones."""
    cases = [*_cases(quick)]
    ribbons = [HARD_SHAPES["ribbon"](ratio=ratio, n_vertices=3000).mesh for ratio in WIDTHS[: 1 if quick else None]]
    real = [lbskel.read_mesh(path) for path in meshes]
    shares = [_share(name, mesh) for name, mesh, _, _ in cases]
    shares += [_share(f"ribbon {ratio:g}", mesh) for ratio, mesh in zip(WIDTHS, ribbons, strict=False)]
    shares += [_share(path.stem, mesh) for path, mesh in zip(meshes, real, strict=True)]
    rows = [_row(name, cases, ribbons, real) for name in [*BOUNDS][: 2 if quick else None]]
    save_json(results / "coarse.json", {"bounds": rows, "meshes": shares}, meshes=meshes)
    save_markdown(
        results / "coarse.md",
        "Coarse meshes",
        {"Skeletons that are right": markdown_table(rows), "Shares that are coarse": markdown_table(shares)},
    )


def _boxes(filled: NDArray[np.bool_]) -> lbskel.Mesh:
    """Mesh a solid of boxes; those in even rows and columns of the grid are THICKNESS long, those in odd ones GAP."""
    padded, corners = np.pad(filled, 1), []
    for axis, side in itertools.product(range(3), (0, 1)):
        bare = np.argwhere(padded & ~np.roll(padded, 1 - 2 * side, axis)) - 1
        across, other = np.eye(3, dtype=np.int64)[[(axis + 1) % 3, (axis + 2) % 3]]
        first = bare + side * np.eye(3, dtype=np.int64)[axis]
        square = np.stack([first, first + across, first + across + other, first + other], axis=1)
        corners.append(square if side else square[:, ::-1])
    squares = np.concatenate(corners)
    vertices, row = np.unique(squares.reshape(-1, 3), axis=0, return_inverse=True)
    faces = row.reshape(-1, 4)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    steps = [np.where(np.arange(n) % 2 == 0, THICKNESS, GAP) for n in filled.shape]
    places = [np.append(0.0, np.cumsum(step))[column] for step, column in zip(steps, vertices.T, strict=True)]
    return lbskel.Mesh(np.stack(places, axis=1), faces)


def _cases(quick: bool) -> Iterator[Case]:
    """Make parts, alone and beside a finer sphere, with the graphs of their axes."""
    period = THICKNESS + GAP
    for part in _parts(quick):
        name, mesh, graph, length = part
        yield part
        for level in SPHERES[: 1 if quick else None]:
            ball = sphere(level)
            beside = ball.vertices + [-2 * period, 0, 0]
            faces = np.concatenate([mesh.faces, ball.faces + len(mesh.vertices)])
            both = lbskel.Mesh(np.concatenate([mesh.vertices, beside]), faces)
            yield f"{name}, sphere of {len(ball.faces)}", both, graph, length


def _parts(quick: bool) -> Iterator[Case]:
    """Make combs of teeth, ladders, and frames of square holes."""
    period = THICKNESS + GAP
    last = 1 if quick else None
    for n in TEETH[:last]:
        filled = np.ones((2 * n - 1, 2, 1), dtype=bool)
        filled[1::2, 1] = False
        yield f"comb of {n} teeth", _boxes(filled), (n, n - 2, 0), (n - 1) * period + n * (GAP + THICKNESS / 2)
    for n in RUNGS[:last]:
        filled = np.ones((3, 2 * n + 1, 1), dtype=bool)
        filled[1, ::2] = False
        rails = n * GAP + (n + 1) * THICKNESS
        yield f"ladder of {n} rungs", _boxes(filled), (4, 2 * n, n - 1), 2 * rails + n * (GAP + THICKNESS)
    for n in HOLES[:last]:
        on = np.arange(2 * n + 1) % 2 == 0
        yield f"frame of {n * n} holes", _boxes((on[:, None] | on)[:, :, None]), _frame(n), 2 * n * (n + 1) * period


def _frame(n: int) -> tuple[int, int, int]:
    """Count tips, junctions and cycles of a square grid of n x n cells, whose corners are no junctions."""
    return 0, (n + 1) ** 2 - 4, n * n


def _share(name: str, mesh: lbskel.Mesh) -> dict[str, Any]:
    """Measure what is coarse of a mesh, before it is refined."""
    is_coarse = coarse_faces(mesh, COARSE_EDGE)
    area = float(mesh.face_areas[is_coarse].sum() / mesh.area)
    return {"mesh": name, "faces": len(mesh.faces), "of the faces": float(is_coarse.mean()), "of the area": area}


def _row(name: str, cases: list[Case], ribbons: list[lbskel.Mesh], real: list[lbskel.Mesh]) -> dict[str, Any]:
    """Count what is right with some bounds."""
    with ExitStack() as bounds:
        for target, value in BOUNDS[name].items():
            bounds.enter_context(mock.patch(f"lbskel.preprocess.{target}", value))
        right = [_is_right(lbskel.skeletonize(mesh), graph, length) for _, mesh, graph, length in cases]
        flat = [len(lbskel.skeletonize(mesh).tips) == 2 for mesh in ribbons]
        skeletons = [lbskel.skeletonize((mesh.vertices, mesh.faces)) for mesh in real]
    errors = [skeleton.report["score"]["measures"]["medial_accuracy_95"] for skeleton in skeletons]
    return {
        "bounds": name,
        "parts": f"{sum(right)}/{len(right)}",
        "wrong": "; ".join(case[0] for case, is_right in zip(cases, right, strict=True) if not is_right),
        "ribbons": f"{sum(flat)}/{len(flat)}",
        "tips of meshes": sum(len(skeleton.tips) for skeleton in skeletons),
        "medial accuracy": float(np.mean(errors)) if errors else None,
    }


def _is_right(skeleton: lbskel.Skeleton, graph: tuple[int, int, int], length: float) -> bool:
    """Whether the largest component has the graph and about the length of an axis."""
    component = skeleton.component_of_node
    edges = component[skeleton.edges[:, 0]]
    of_edge = np.linalg.norm(np.diff(skeleton.nodes[skeleton.edges], axis=1), axis=2).ravel()
    lengths = np.bincount(edges, of_edge, skeleton.n_components)
    largest = int(lengths.argmax())
    degrees = skeleton.degrees[component == largest]
    n_cycles = np.count_nonzero(edges == largest) - len(degrees) + 1
    found = (int((degrees == 1).sum()), int((degrees > 2).sum()), int(n_cycles))
    return bool(found == graph and abs(lengths[largest] / length - 1) < MAX_ERROR)
