"""The command line: parse, call one command, turn every error of lbskel's into one line.

Exit codes: 0 done; 1 done, but the result failed its own checks; 2 bad input or usage. Ctrl-C and SIGTERM end every
command at once, also in the middle of a compiled loop, and leave no partial file.
"""

from __future__ import annotations

__all__ = ["command_line_parser", "main"]

import argparse
import io
import os
import sys
import traceback
from collections.abc import Sequence
from typing import NoReturn

import lbskel
from lbskel.cli import COMMANDS
from lbskel.errors import LbskelError
from lbskel.geometry.signals import ended_after_tidying_up, ended_at_once
from lbskel.pipeline.environment import SLOW, are_kernels_compiled


class _Parser(argparse.ArgumentParser):
    """Reports wrong usage in one line, as every other error."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"lbskel: {message}; see {self.prog} --help\n")


def command_line_parser() -> argparse.ArgumentParser:
    """Make the parser of all commands."""
    parser = _Parser(prog="lbskel", description="Curve skeletons and discrete Laplace-Beltrami operators of meshes.")
    parser.add_argument("--version", action="version", version=f"lbskel {lbskel.__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add_parser(subparsers)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # the name of a file may hold characters that the terminal cannot show
            stream.reconfigure(errors="backslashreplace")
    parsed = command_line_parser().parse_args(arguments)
    if not are_kernels_compiled():
        print(f"lbskel: warning: {SLOW}", file=sys.stderr)
    # a batch tidies up after an interrupt: it ends its processes and leaves out what they have not finished
    how_signals_end = ended_after_tidying_up if parsed.command == "batch" else ended_at_once
    try:
        with how_signals_end():
            code = int(parsed.run(parsed))
        sys.stdout.flush()
        return code
    except BrokenPipeError:  # the reader of the output has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (LbskelError, OSError) as error:  # OSError: a name that the system refuses
        return _failed(str(error))
    except KeyboardInterrupt:
        print("lbskel: interrupted; no partial file is left", file=sys.stderr)
        return 130
    except MemoryError:
        return _failed("out of memory; simplify the mesh first")
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{os.path.basename(place.filename)} line {place.lineno}"
        return _failed(f"internal error in {where}, please report it: {type(error).__name__}: {error}")


def _failed(message: str) -> int:
    """Print an error in one line and return the exit code of bad input."""
    print(f"lbskel: {' '.join(message.splitlines())}", file=sys.stderr)
    return 2
