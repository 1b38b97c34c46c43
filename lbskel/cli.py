"""The command line: parse, call one command, turn every error of lbskel's into one line.

Exit codes: 0 done; 1 done, but the result failed its own checks; 2 bad input or usage.
"""

from __future__ import annotations

__all__ = ["main"]

import argparse
import sys
from collections.abc import Sequence

import lbskel
from lbskel.commands import COMMANDS
from lbskel.errors import LbskelError


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="lbskel", description="Curve skeletons and discrete Laplace-Beltrami operators of meshes."
    )
    parser.add_argument("--version", action="version", version=f"lbskel {lbskel.__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add_parser(subparsers)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit code."""
    parsed = _parser().parse_args(arguments)
    try:
        return parsed.run(parsed)
    except LbskelError as error:
        print(f"lbskel: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader of the output has gone
        sys.stderr.close()
        return 0
    except KeyboardInterrupt:
        print("lbskel: interrupted, nothing half-written is left", file=sys.stderr)
        return 130
    except MemoryError:
        print("lbskel: out of memory; simplify the mesh first", file=sys.stderr)
        return 2
