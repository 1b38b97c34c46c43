"""``lbskel compare MESH -o FOLDER``: a page that compares operators, treatments, energies and presets on a mesh."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import json
from pathlib import Path
from typing import Any

from lbskel.cli.options import add_command, add_force_option, refuse_unwritable
from lbskel.cli.terminal import tell
from lbskel.contraction.result import Status
from lbskel.errors import FormatError, counted
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io import as_shape
from lbskel.io.atomic_write import Content, write_all_safely
from lbskel.pipeline.comparison import CASES, ComparisonResult, record, representative, run_case
from lbskel.preprocess import reconstruct_surface
from lbskel.visualization import Panel, Table, draw
from lbskel.visualization.html import cell, document, image, paragraphs, table
from lbskel.visualization.line_plots import draw_curves

MOST_FACES = 6000  # that are compared: some thirty contractions, twice each, should not take minutes
COLUMNS_DRAWN, WIDTH, HEIGHT = 5, 320, 400  # panels in a row, and pixels of each; they fit a page of 1300 pixels
MAX_DISTANCE = 0.6  # from the center, in diameter bounds: vertices beyond are drawn at the edge of the picture; a guess

COLUMNS = {  # headings of the table, and the key of the record below each
    "breaks at step": "broke at",
    "how": "how",
    "largest box": "largest box",
    "steps": "steps",
    "ended": "ended",
    "area left": "area",
    "tips": "tips",
    "topology right": "topology right",
    "length inside": "inside",
    "from default, radii": "from default",
    "seconds": "seconds",
}
EXPLANATION = (
    "The first columns show the steps as published, without roll-back, down to a millionth of the volume: the step at "
    "which the area or the bounding box first grew, and the largest bounding box relative to that of the mesh. The "
    "others show the result with roll-back, which undoes such a step, as lbskel skeletonize computes it."
)


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel compare``."""
    parser = add_command(
        subparsers,
        "compare",
        "compare operators, treatments of degenerate triangles and energies on a mesh",
        example="lbskel compare meshes/knot.off -o report",
    )
    parser.add_argument("mesh", metavar="MESH")
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help="gets index.html and comparison.json")
    add_force_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Compare and write the page; 0 also where settings break, since the page shows that."""
    folder = Path(arguments.output)
    names = [folder / name for name in ("index.html", "comparison.json")]
    if not folder.parent.is_dir() or (folder.exists() and not folder.is_dir()):
        raise FormatError(f"{folder}: is no folder, and cannot be made in a folder that exists")
    if folder.exists():
        refuse_unwritable(zip(names, (("html",), ("json",)), strict=True), arguments.force)
    shape = as_shape(arguments.mesh)
    given = reconstruct_surface(shape).mesh if isinstance(shape, PointCloud) else shape
    mesh = representative(given, most_faces=MOST_FACES)
    results: dict[str, ComparisonResult] = {}
    for number, (case, settings) in enumerate(CASES.items(), 1):
        arguments.on_stage(f"{number}/{len(CASES)} {case}")
        results[case] = run_case(mesh, settings)
    reference = results["curvature_flow"].skeleton
    records = {case: _with_reason(record(result, reference=reference)) for case, result in results.items()}
    title = f"Contractions of {Path(arguments.mesh).name}"
    what = f"{counted(len(given.vertices), 'vertex')} and {counted(len(given.faces), 'face')}; "
    what += f"compared on {counted(len(mesh.faces), 'face')}"
    what += " of its largest component." if given.n_components > 1 else "."
    pictures = {
        "Area and bounding box by step, without roll-back": _curves(records),
        "Contracted meshes, without roll-back: at the first step that breaks, or the last": _drawn(
            [
                Panel(mesh, title=Path(arguments.mesh).name),
                *(_contracted(case, result, mesh) for case, result in results.items() if result.meshes),
            ]
        ),
        "Skeletons, with roll-back": _drawn([_skeleton(case, result, mesh) for case, result in results.items()]),
    }
    facts = {"mesh": Path(arguments.mesh).name, "cases": records}
    contents: dict[Path, Content] = {
        names[0]: _page(records, title, what, pictures),
        names[1]: json.dumps(facts, indent=1) + "\n",
    }
    folder.mkdir(exist_ok=True)
    write_all_safely(contents, arguments.force)
    tell(arguments, f"{_summary(records)}\n{names[0]}", facts)
    return 0


def _with_reason(row: dict[str, Any]) -> dict[str, Any]:
    """Add the reason why the contraction with roll-back ended to a record."""
    ended = Status(row["status"]).name.lower().replace("_", " ") if "status" in row else "no skeleton"
    return {**row, "ended": ended}


def _short(case: str) -> str:
    """Shorten the name of a case to a title over its drawing."""
    return (
        case.replace("right-hand side zero", "zero")
        .replace("least squares", "l. s.")
        .replace("curvature flow", "c. f.")
    )


def _drawn(panels: list[Panel]) -> bytes:
    """Draw a picture of many panels."""
    n_rows = -(-len(panels) // COLUMNS_DRAWN)
    return draw(panels, size=(WIDTH * min(len(panels), COLUMNS_DRAWN), HEIGHT * n_rows))


def _curves(records: dict[str, dict[str, Any]]) -> bytes:
    """Area and box curves of every case of least squares, the published energy, and of the default."""
    shown = {case: row for case, row in records.items() if "areas" in row and "curvature flow" not in case}
    return draw_curves(
        {
            "area over that at the start": {case: row["areas"] for case, row in shown.items()},
            "bounding box over that at the start": {case: row["boxes"] for case, row in shown.items()},
        }
    )


def _contracted(case: str, result: ComparisonResult, mesh: Mesh) -> Panel:
    """Show the mesh at the first step that breaks, or the last, with vertices far away at the edge."""
    assert result.free is not None
    number = min(result.free.first_failed_step or len(result.meshes), len(result.meshes))
    V = result.meshes[number - 1].vertices
    far = (V**2).sum(axis=1, keepdims=True) ** 0.5
    near = V * (MAX_DISTANCE / far.clip(min=MAX_DISTANCE))
    return Panel(mesh.with_vertices(near * mesh.diameter_bound + mesh.centroid), title=f"{_short(case)}, step {number}")


def _skeleton(case: str, result: ComparisonResult, mesh: Mesh) -> Panel:
    return Panel(mesh, result.skeleton, _short(case) if result.skeleton else f"{_short(case)}: none")


def _reasons(records: dict[str, dict[str, Any]]) -> list[str]:
    """List the reasons why cases have no skeleton."""
    return [f"{case}: {row['error']}" for case, row in records.items() if "error" in row]


def _page(records: dict[str, dict[str, Any]], title: str, what: str, pictures: dict[str, bytes]) -> bytes:
    """Compose the page."""
    rows = [(case, *(row.get(key) for key in COLUMNS.values())) for case, row in records.items()]
    kinds = ["fail" if row.get("broke at") else "" for row in records.values()]
    body = [
        paragraphs([what, EXPLANATION]),
        table(Table("Cases; a row in red breaks without roll-back", ("", *COLUMNS), rows, kinds)),
        paragraphs([f"No skeleton by {reason}." for reason in _reasons(records)]),
        *(f"<h2>{heading}</h2>\n{image(png, heading)}" for heading, png in pictures.items()),
    ]
    return document(title, "\n".join(body))


def _summary(records: dict[str, dict[str, Any]]) -> str:
    """Compose the table for a terminal, and the reasons for its gaps."""
    lines = [
        ["case", *COLUMNS],
        *([case, *(cell(row.get(k)) for k in COLUMNS.values())] for case, row in records.items()),
    ]
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    table = ["  ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])]).rstrip() for line in lines]
    return "\n".join([*table, *(f"no skeleton by {reason}" for reason in _reasons(records))])
