"""``lbskel spectrum MESH``: eigenvalues of the Laplacian, how exact they are, and shape-DNA distances to others."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from lbskel.applications import SpectralBasis, heat_kernel_signature, shape_dna_distance, spectral_basis
from lbskel.cli.options import add_command, add_force_option, add_operator_option, read_surface, refuse_unwritable
from lbskel.errors import MeshError, counted
from lbskel.io import write_safely

N_PRINTED = 10  # eigenvalues that the text has


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel spectrum``."""
    parser = add_command(
        subparsers,
        "spectrum",
        "compute the smallest eigenvalues of the Laplacian of a mesh",
        details="Further meshes are compared with the first by their spectra (shape-DNA).",
        example="lbskel spectrum meshes/hand.ply meshes/octopus.ply -k 50 --picture signature.png",
    )
    parser.add_argument("mesh", nargs="+", metavar="MESH")
    parser.add_argument("-k", type=int, default=50, metavar="N", help="number of eigenvalues (%(default)s)")
    add_operator_option(parser, "robust")
    parser.add_argument("-o", "--output", metavar="JSON", help="write eigenvalues and distances")
    parser.add_argument("--picture", metavar="PNG", help="draw eigenfunctions and heat kernel signatures of the first")
    add_force_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Compute, print and write."""
    refuse_unwritable([(arguments.output, ("json",)), (arguments.picture, ("png",))], arguments.force)
    meshes = [read_surface(path) for path in arguments.mesh]
    bases = []
    for path, mesh in zip(arguments.mesh, meshes, strict=True):
        try:
            bases.append(spectral_basis(mesh, arguments.k, operator=arguments.operator))
        except MeshError as error:
            raise MeshError(f"{path}: {error}") from None
    distances = [shape_dna_distance(bases[0], basis) for basis in bases[1:]]
    if not (arguments.json or arguments.quiet):
        for path, mesh, basis in zip(arguments.mesh, meshes, bases, strict=True):
            _print(path, mesh.area, basis)
        for path, distance in zip(arguments.mesh[1:], distances, strict=True):
            print(f"shape-DNA distance of {path}: {distance:.4g}")
    values = {str(path): basis.values.tolist() for path, basis in zip(arguments.mesh, bases, strict=True)}
    document = {"operator": arguments.operator, "values": values, "shape_dna_distances": distances}
    if arguments.json:
        print(json.dumps(document))
    if arguments.output:
        write_safely(Path(arguments.output), json.dumps(document, indent=1) + "\n", force=arguments.force)
    if arguments.picture:
        from lbskel.visualization import Panel, render

        last = len(bases[0].values) - 1
        numbers = sorted({min(number, last) for number in (1, 4, 16)})
        panels = [
            Panel(
                meshes[0],
                title=f"eigenfunction {j + 1}",
                field=bases[0].functions[:, j],
                field_name=f"function {j + 1}",
            )
            for j in numbers
        ]
        if len(bases[0].positive):
            signature = heat_kernel_signature(bases[0])[:, 50]
            panels.append(Panel(meshes[0], title="heat kernel signature", field=signature, field_name="signature"))
        render(panels, arguments.picture, force=arguments.force)
    return 0


def _print(path: str, area: float, basis: SpectralBasis) -> None:
    """Print the first eigenvalues, and how exact all are."""
    n_zero = len(basis.values) - len(basis.positive)
    shown = " ".join(
        f"{value:.4g}" for value in np.where(np.arange(len(basis.values)) < n_zero, 0.0, basis.values)[:N_PRINTED]
    )
    error = float(np.abs(basis.gram() - np.eye(len(basis.values))).max())
    print(
        f"{path}: {counted(len(basis.values), 'eigenvalue')}, {n_zero} of them zero, one for each component of the "
        f"operator; area {area:.6g}"
    )
    print(f"  {shown}{' ...' if len(basis.values) > N_PRINTED else ''}")
    print(f"  residual {basis.residual():.1e}, orthonormal to {error:.1e}")
