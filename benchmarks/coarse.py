"""Coarse meshes: machine parts of long and of small faces, with other bounds on what is refined.

The parts are solids of boxes, balls, tubes and holes that manifold3d (of the extra ``peers``) unites and cuts, so that
flat faces have few long triangles and round ones many small ones, as those of CAD programs have. Ribbons and
``--meshes`` have faces that are coarse here and there.
"""

from __future__ import annotations

__all__ = ["run"]

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.preprocess.automatic import COARSE_EDGE
from lbskel.preprocess.subdivision import coarse_faces
from lbskel.shapes.hard import HARD_SHAPES

KNOBS = (160, 240)  # segments around a knob: about 12,800 and 28,800 faces
ARCS = (120.0, 180.0, 240.0)  # of a tube that is bent to a circle, in degrees
HOLES, SIDES = (10, 20), (1000, 4000)  # in a row of a plate, and around a washer
WIDTHS = (5.0, 10.0, 20.0)  # of ribbons, over their thickness
MAX_ERROR = 0.15  # of the length of an axis that is right: tips are a radius before their ends

BOUNDS: dict[str, dict[str, float]] = {
    "as they are": {},
    **{f"MAX_COARSE_AREA {value:g}": {"automatic.MAX_COARSE_AREA": value} for value in (0.05, 0.1, 0.3, 0.5, 1.0)},
    **{f"MAX_GROWTH {value:g}": {"subdivision.MAX_GROWTH": value} for value in (1.0, 1.15, 1.3, 1.5, 3.0)},
}


class Part(NamedTuple):
    """A mesh, the numbers of tips and cycles of its axis, and its length."""

    name: str
    mesh: lbskel.Mesh
    n_tips: int
    n_cycles: int
    length: float


def run(quick: bool, results: Path, meshes: Sequence[Path] = ()) -> None:
    """Measure, and write coarse.json and coarse.md; ``meshes`` are real ones."""
    parts = [*_parts(quick)]
    ribbons = [HARD_SHAPES["ribbon"](ratio=ratio, n_vertices=3000).mesh for ratio in WIDTHS[: 1 if quick else None]]
    real = [lbskel.read_mesh(path) for path in meshes]
    shares = [_share(part.name, part.mesh) for part in parts]
    shares += [_share(f"ribbon {ratio:g}", mesh) for ratio, mesh in zip(WIDTHS, ribbons, strict=False)]
    shares += [_share(path.stem, mesh) for path, mesh in zip(meshes, real, strict=True)]
    rows = [_row(name, parts, ribbons, real) for name in [*BOUNDS][: 2 if quick else None]]
    save_json(results / "coarse.json", {"bounds": rows, "meshes": shares}, packages=("manifold3d",), meshes=meshes)
    save_markdown(
        results / "coarse.md",
        "Coarse meshes",
        {"Skeletons that are right": markdown_table(rows), "Shares that are coarse": markdown_table(shares)},
    )


def _parts(quick: bool) -> Iterator[Part]:
    """Make combs and ladders with and without a knob, bent tubes with crossbars, plates with holes, and washers."""
    from manifold3d import CrossSection, Manifold

    teeth = sum((Manifold.cube((1, 10, 1)).translate((x, 0, 0.5)) for x in range(0, 20, 4)), Manifold())
    comb = Manifold.cube((20, 2, 2)) + teeth
    # the spine goes on beyond its last tooth
    yield Part("comb", _mesh(comb), 6, 0, 19 + 5 * 8.5)
    rails = sum((Manifold.cube((1, 1, 40), True).translate((x, 0, 0)) for x in (-4, 4)), Manifold())
    rungs = sum((Manifold.cube((8, 0.8, 0.8), True).translate((0, 0, z)) for z in (-12, 0, 12)), Manifold())
    yield Part("ladder", _mesh(rails + rungs), 4, 2, 2 * 39 + 3 * 8)
    last = 1 if quick else None
    for segments in KNOBS[:last]:
        knob = Manifold.sphere(1.2, segments).translate((20, 1, 1))
        yield Part(f"comb, knob of {segments}", _mesh(comb + knob), 6, 0, 19 + 5 * 8.5)
        knob = Manifold.sphere(0.8, segments).translate((4, 0, 20))
        yield Part(f"ladder, knob of {segments}", _mesh(rails + rungs + knob), 4, 2, 2 * 39 + 3 * 8)
    for angle in ARCS[:last]:
        tube = Manifold.revolve(CrossSection.circle(1, 48).translate((6, 0)), 96, angle)
        bar = Manifold.cylinder(8, 0.7, 0.7, 32, True).translate((6, 0, 0))
        yield Part(f"arc of {angle:g}", _mesh(tube + bar + bar.rotate((0, 0, angle))), 4, 0, 6 * np.radians(angle) + 14)
    for n in HOLES[:last]:
        hole = Manifold.cylinder(3, 0.6, 0.6, 24)
        holes = [hole.translate((2 * i + 1, 2 * j + 1, -1)) for i in range(n) for j in range(n)]
        plate = Manifold.cube((2 * n, 2 * n, 1)) - sum(holes, Manifold())
        yield Part(f"plate of {n * n} holes", _mesh(plate), 0, n * n, 4 * n * (n + 1))
    for sides in SIDES[:last]:
        washer = Manifold.cylinder(1, 5, 5, sides) - Manifold.cylinder(3, 3, 3, sides).translate((0, 0, -1))
        yield Part(f"washer of {sides} sides", _mesh(washer), 0, 1, 2 * np.pi * 4)


def _mesh(solid: Any) -> lbskel.Mesh:
    """Convert a solid of manifold3d."""
    found = solid.to_mesh()
    return lbskel.Mesh(np.array(found.vert_properties[:, :3], dtype=np.float64), np.array(found.tri_verts))


def _share(name: str, mesh: lbskel.Mesh) -> dict[str, Any]:
    """Measure what is coarse of a mesh, before it is refined."""
    is_coarse = coarse_faces(mesh, COARSE_EDGE)
    area = float(mesh.face_areas[is_coarse].sum() / mesh.area)
    return {"mesh": name, "faces": len(mesh.faces), "of the faces": float(is_coarse.mean()), "of the area": area}


def _row(name: str, parts: list[Part], ribbons: list[lbskel.Mesh], real: list[lbskel.Mesh]) -> dict[str, Any]:
    """Count what is right with some bounds."""
    with ExitStack() as bounds:
        for target, value in BOUNDS[name].items():
            bounds.enter_context(mock.patch(f"lbskel.preprocess.{target}", value))
        wrong = [part.name for part in parts if not _is_right(lbskel.skeletonize(part.mesh), part)]
        flat = [len(lbskel.skeletonize(mesh).tips) == 2 for mesh in ribbons]
        skeletons = [lbskel.skeletonize((mesh.vertices, mesh.faces)) for mesh in real]
    errors = [skeleton.report["score"]["measures"]["medial_accuracy_95"] for skeleton in skeletons]
    return {
        "bounds": name,
        "parts": f"{len(parts) - len(wrong)}/{len(parts)}",
        "wrong": "; ".join(wrong),
        "ribbons": f"{sum(flat)}/{len(flat)}",
        "tips of meshes": sum(len(skeleton.tips) for skeleton in skeletons),
        "medial accuracy": float(np.mean(errors)) if errors else None,
    }


def _is_right(skeleton: lbskel.Skeleton, part: Part) -> bool:
    """Whether a skeleton has the tips, the cycles and about the length of an axis."""
    found = (len(skeleton.tips), skeleton.cycle_rank, skeleton.n_components)
    return found == (part.n_tips, part.n_cycles, 1) and abs(skeleton.length / part.length - 1) < MAX_ERROR
