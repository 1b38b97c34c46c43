"""``lbskel laplacian MESH``: how healthy every discrete Laplacian is on a mesh."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.cli.options import add_command
from lbskel.errors import FormatError, MeshError
from lbskel.evaluation.operator_health import LaplacianDiagnostics, laplacian_diagnostics
from lbskel.geometry.mesh import Mesh
from lbskel.io import read_mesh, write_safely
from lbskel.operators import OPERATORS, Laplacian, laplacian

COLUMNS: dict[str, tuple[str, str]] = {  # heading: the measure, and the property that it decides
    "asymmetry": ("asymmetry", "symmetric"),
    "off edges": ("off_edges", "local"),
    "constants": ("constants", "constants"),
    "linear": ("linear_precision", "linear"),
    "negative": ("negative_share", "positive"),
    "worst": ("worst_negative", "positive"),
    "smallest": ("smallest_eigenvalue", "semidefinite"),
    "zeros": ("n_zero_eigenvalues", "null space"),
    "overshoot": ("overshoot", "maximum"),
    "condition": ("condition", ""),
    "treated": ("n_fallback_rows", "untreated"),
    "area": ("area_ratio", "area"),
}
LEGEND = """\
! the property does not hold; - not defined here, or not found.
asymmetry, constants: of the largest entry. off edges: share of weights that belong to no edge. linear: error on planar
patches. negative: share of weights, worst: in mean weights. smallest: eigenvalue below zero. zeros: functions without
energy, of which there should be {components}. overshoot: of the maximum principle. treated: vertices that a guard
changed. area: total mass over area."""


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel laplacian``."""
    parser = add_command(
        subparsers,
        "laplacian",
        "measure the properties of discrete Laplacians on a mesh",
        example="lbskel laplacian meshes/knot.off --operator cotangent",
    )
    parser.add_argument("mesh", metavar="MESH")
    parser.add_argument(
        "--operator",
        default="all",
        choices=("all", *OPERATORS),
        metavar="NAME",
        help=f"all, or one of {', '.join(OPERATORS)} (%(default)s)",
    )
    parser.add_argument("--json", metavar="PATH", help="write the measures as JSON; - for standard output, no table")
    parser.add_argument("--picture", metavar="PNG", help="draw the mean curvature by each operator side by side")
    parser.add_argument("--force", action="store_true", help="replace files that exist")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Measure, print, write; 0 also where properties do not hold, since none has them all."""
    for path in (arguments.json, arguments.picture):
        if path and path != "-" and Path(path).exists() and not arguments.force:
            raise FormatError(f"{path} exists already; give --force to replace it")
    mesh = read_mesh(arguments.mesh)
    names = OPERATORS if arguments.operator == "all" else [arguments.operator]
    operators: dict[str, Laplacian] = {}
    refusals: dict[str, str] = {}
    for name in names:
        try:
            operators[name] = laplacian(mesh, operator=name)
        except MeshError as error:
            if arguments.operator != "all":
                raise
            refusals[name] = str(error)
    sheets = {name: laplacian_diagnostics(operator, mesh) for name, operator in operators.items()}
    if arguments.json != "-":
        print(_table(sheets, refusals, mesh))
    if arguments.json:
        text = json.dumps(_document(sheets, refusals, mesh), indent=1) + "\n"
        if arguments.json == "-":
            print(text, end="")
        else:
            write_safely(Path(arguments.json), text, force=arguments.force)
    if arguments.picture:
        from lbskel.visualization import Panel, render

        fields = {name: _mean_curvature(operator, mesh) for name, operator in operators.items()}
        panels = [
            Panel(mesh, title=name, field=field, field_name=f"mean curvature, {name}") for name, field in fields.items()
        ]
        render(panels, arguments.picture, force=arguments.force)
    return 0


def _mean_curvature(operator: Laplacian, mesh: Mesh) -> NDArray[np.float64]:
    """H at each vertex, positive where the surface bends away from its normal."""
    normals = np.nan_to_num(igl.per_vertex_normals(mesh.vertices, mesh.faces))
    return np.einsum("nx,nx->n", operator.mean_curvature_normals(mesh.vertices), normals)


def _document(sheets: dict[str, LaplacianDiagnostics], refusals: dict[str, str], mesh: Mesh) -> dict[str, Any]:
    """All measures, the properties that hold, and why an operator is not defined."""
    return {
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "notes": list(mesh.notes),
        "operators": {name: {**asdict(sheet), "passed": sheet.passed} for name, sheet in sheets.items()},
        "refused": refusals,
    }


def _table(sheets: dict[str, LaplacianDiagnostics], refusals: dict[str, str], mesh: Mesh) -> str:
    """One row for each operator, each failed property marked."""
    rows = [["operator", *COLUMNS]]
    for name, sheet in sheets.items():
        passed = sheet.passed
        rows.append([name, *(_cell(field, getattr(sheet, field), passed.get(key)) for field, key in COLUMNS.values())])
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip() for row in rows]
    lines += [f"{name}: {message}" for name, message in refusals.items()]
    return "\n".join([*lines, "", LEGEND.format(components=mesh.n_components)])


def _cell(field: str, value: float | None, holds: bool | None) -> str:
    """A measure as a person reads it, marked where its property does not hold."""
    if value is None:
        return "- "
    if field in ("off_edges", "negative_share"):
        text = f"{100 * value:.3g}%"
    else:
        text = str(value) if isinstance(value, int) else f"{value:.2g}"
    return text + ("!" if holds is False else " ")
