"""``lbskel laplacian MESH``: the properties of every discrete Laplacian on a mesh."""

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

from lbskel.cli.options import add_command, add_force_option, read_surface, refuse_unwritable
from lbskel.errors import MeshError, UnknownChoice
from lbskel.evaluation.operator_health import laplacian_diagnostics
from lbskel.evaluation.operator_report import LaplacianDiagnostics, diagnostics_table
from lbskel.geometry.mesh import Mesh
from lbskel.io import write_safely
from lbskel.operators import OPERATORS, Laplacian, laplacian


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
    parser.add_argument("-o", "--output", metavar="JSON", help="write the measures")
    parser.add_argument("--picture", metavar="PNG", help="draw the mean curvature by each operator that has one")
    add_force_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Measure, print and write; return 0 also if properties do not hold, since no operator has all of them."""
    refuse_unwritable([(arguments.output, ("json",)), (arguments.picture, ("png",))], arguments.force)
    mesh = read_surface(arguments.mesh)
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
    shown = {name: operator for name, operator in operators.items() if operator.mass_unit != "number"}
    if arguments.picture and not shown:
        raise UnknownChoice(
            f"{arguments.operator} has no curvature to draw, as its masses are degrees; leave --picture out"
        )
    diagnostics = {name: laplacian_diagnostics(operator, mesh) for name, operator in operators.items()}
    if not (arguments.json or arguments.quiet):
        print(diagnostics_table(diagnostics, refusals))
    document = _document(diagnostics, refusals, mesh)
    if arguments.json:
        print(json.dumps(document))
    if arguments.output:
        write_safely(Path(arguments.output), json.dumps(document, indent=1) + "\n", force=arguments.force)
    if arguments.picture:
        from lbskel.visualization import Panel, render

        fields = {name: _mean_curvature(operator, mesh) for name, operator in shown.items()}
        panels = [
            Panel(mesh, title=name, field=field, field_name=f"mean curvature, {name}") for name, field in fields.items()
        ]
        render(panels, arguments.picture, force=arguments.force)
    return 0


def _mean_curvature(operator: Laplacian, mesh: Mesh) -> NDArray[np.float64]:
    """Return H at each vertex, positive where the surface is convex with respect to its normal."""
    normals = np.nan_to_num(igl.per_vertex_normals(mesh.vertices, mesh.faces))
    curvature: NDArray[np.float64] = np.einsum("nx,nx->n", operator.mean_curvature_normals(mesh.vertices), normals)
    return curvature


def _document(diagnostics: dict[str, LaplacianDiagnostics], refusals: dict[str, str], mesh: Mesh) -> dict[str, Any]:
    """Return all measures, the properties that hold, and why operators are not defined."""
    return {
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "notes": list(mesh.notes),
        "operators": {name: {**asdict(each), "passed": each.passed} for name, each in diagnostics.items()},
        "refused": refusals,
    }
