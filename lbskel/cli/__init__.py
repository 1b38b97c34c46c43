"""The commands of the command line, one module each: ``add_parser(subparsers)`` and ``run(arguments) -> int``."""

__all__ = ["COMMANDS"]

from lbskel.cli import (
    batch,
    branches,
    check,
    compare,
    compress,
    edit,
    geodesic,
    info,
    laplacian,
    preprocess,
    quantize,
    rig,
    score,
    segment,
    skeletonize,
    smooth,
    spectrum,
    view,
)

COMMANDS = (
    skeletonize,
    view,
    batch,
    score,
    check,
    preprocess,
    info,
    branches,
    segment,
    rig,
    smooth,
    edit,
    quantize,
    compress,
    spectrum,
    geodesic,
    laplacian,
    compare,
)
