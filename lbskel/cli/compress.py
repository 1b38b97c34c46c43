"""``lbskel compress MESH -o OUT``: a mesh from few rounded coefficients, with the rate and the error."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
from typing import Any

from lbskel.applications import BASES, compress
from lbskel.cli.options import add_command, add_force_option, add_mesh_and_output, read_mesh_to_write
from lbskel.cli.terminal import tell
from lbskel.errors import counted
from lbskel.io import write_mesh

N_FUNCTIONS = 200  # of the basis, by default; it bounds the size of the file and the time. "Compression" in
# benchmarks/results/applications_spectrum.md: at 12 bits a quarter of the error of 50, half of that of 100


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel compress``."""
    parser = add_command(
        subparsers,
        "compress",
        "rebuild a mesh from few coefficients in a basis that follows from its faces",
        details="The vertices keep their order.",
        example="lbskel compress meshes/hand.ply -o few.ply -k 200 --bits 10",
    )
    add_mesh_and_output(parser)
    parser.add_argument(
        "-k",
        type=int,
        metavar="N",
        help=f"number of functions ({N_FUNCTIONS}, or one a vertex of a smaller mesh)",
    )
    parser.add_argument("--bits", type=int, default=12, metavar="N", help="of a coefficient (%(default)s)")
    parser.add_argument(
        "--basis", default="spectral", choices=BASES, metavar="NAME", help=f"{', '.join(BASES)} (%(default)s)"
    )
    add_force_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Compress, write what is decoded, and print rate and error."""
    mesh = read_mesh_to_write(arguments)
    k = min(N_FUNCTIONS, len(mesh.used_vertices)) if arguments.k is None else arguments.k
    packed = compress(mesh, k, basis=arguments.basis, bits=arguments.bits)
    write_mesh(arguments.output, packed.mesh, force=arguments.force)
    error = packed.rms_error(mesh)
    share = f" ({100 * error / mesh.diameter_bound:.2g} % of the diameter bound)" if mesh.diameter_bound > 0 else ""
    text = (
        f"{arguments.output}: {counted(len(packed.coefficients), 'coefficient')} of "
        f"{counted(packed.n_vertices, 'vertex')}, in each axis\n"
        f"{packed.bits_per_vertex:.3g} bits a vertex without the faces, rms error {error:.3g}{share}"
    )
    facts = {
        "output": arguments.output,
        "n_vertices": packed.n_vertices,
        "n_coefficients": len(packed.coefficients),
        "bits_per_vertex": packed.bits_per_vertex,
        "rms_error": error,
    }
    tell(arguments, text, facts)
    return 0
