"""The command line: parse, call one command, turn every error of lbskel's into one line.

Exit codes: 0 done; 1 done, but the result failed its own checks; 2 bad input or usage; 130 interrupted. Ctrl-C and
SIGTERM end every command at once, also in the middle of a compiled loop, except ``batch``, which first ends its
processes. They leave no partial file.
"""

from __future__ import annotations

__all__ = ["command_line_parser", "main"]

import argparse
import io
import os
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import lbskel
from lbskel.cli import COMMANDS
from lbskel.cli.terminal import message_of, progress, with_options
from lbskel.errors import MeshError, MissingDependency, nearest
from lbskel.geometry.signals import ended_after_tidying_up, ended_at_once
from lbskel.pipeline.environment import SLOW, are_kernels_compiled


class _Parser(argparse.ArgumentParser):
    """Reports wrong usage in one line, as every other error, and takes points such as -1,0,0 for values."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._negative_number_matcher = re.compile(r"-\.?\d[\d.,eE+-]*$")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            names = [str(choice) for choice in action.choices]
            message = f"invalid choice: {value!r}{nearest(value, names)} (choose from {', '.join(names)})"
            raise argparse.ArgumentError(action, message)

    _given: Sequence[str] = ()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        self._given = sys.argv[1:] if args is None else list(args)
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        if "required" in message:  # argparse tells what is missing first; the slip may be why
            message += "".join(f"; unrecognized argument: {each}{hint}" for each, hint in self._slips(self._given))
        self.exit(2, f"lbskel: {message}; see {self.prog} --help\n")

    def _slips(self, given: Sequence[str]) -> list[tuple[str, str]]:
        """List the given options that do not exist, each with the nearest one that does."""
        known = [option for action in self._actions for option in action.option_strings]
        options = [each.split("=")[0] for each in given if each.startswith("--") and each != "--"]
        return [(each, nearest(each, known)) for each in options if not any(one.startswith(each) for one in known)]


class _Completion(argparse.Action):
    """Prints the completions for a shell, by shtab."""

    def __call__(self, parser: argparse.ArgumentParser, _: object, values: Any, option: str | None = None) -> NoReturn:
        try:
            import shtab
        except ImportError:
            parser.exit(2, f"lbskel: {MissingDependency('shtab', 'completion', str(option))}\n")
        (commands,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
        for command in commands.choices.values():
            for action in command._actions:
                if action.choices is None and action.type is None and action.nargs != 0:
                    action.complete = shtab.FILE
        print(shtab.complete(parser, shell=values), flush=True)
        parser.exit()


def command_line_parser() -> argparse.ArgumentParser:
    """Make the parser of all commands."""
    parser = _Parser(
        prog="lbskel",
        description="Curve skeletons and discrete Laplace-Beltrami operators of meshes.",
        epilog="example:\n  lbskel view meshes/dinosaur.ply -o dinosaur.html\n  lbskel skeletonize --help",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"lbskel {lbskel.__version__}")
    parser.add_argument(
        "--print-completion",
        action=_Completion,
        choices=("bash", "zsh", "tcsh"),
        metavar="SHELL",
        help="print a script that completes commands, options and their choices in bash, zsh or tcsh",
    )
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add_parser(subparsers)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # the caller has closed it, as a daemon does
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115  to the end of the process
        if isinstance(stream, io.TextIOWrapper):  # the name of a file may hold characters that the terminal cannot show
            stream.reconfigure(errors="backslashreplace")
    try:
        parsed = _parse(arguments)
    except BrokenPipeError:
        return _without_a_reader()
    if not are_kernels_compiled():
        print(f"lbskel: warning: {SLOW}", file=sys.stderr)
    # a batch tidies up after an interrupt: it ends its processes and removes files that they have not finished
    how_signals_end = ended_after_tidying_up if parsed.command == "batch" else ended_at_once
    try:
        with how_signals_end(), progress(parsed):
            code = int(parsed.run(parsed))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        return _without_a_reader()
    except KeyboardInterrupt:
        print("lbskel: interrupted; no partial file is left", file=sys.stderr)
        return 130
    except Exception as error:
        mesh = getattr(parsed, "mesh", None)
        is_unnamed = isinstance(error, MeshError) and isinstance(mesh, str) and mesh not in str(error)
        return _failed(with_options(f"{mesh}: {error}" if is_unnamed else message_of(error), parsed))


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse; an option that a command does not have is an error that names the nearest one."""
    parser = command_line_parser()
    parsed, unknown = parser.parse_known_args(arguments)
    (commands,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    command: argparse.ArgumentParser = commands.choices[parsed.command]
    parsed.options = {action.dest: action.option_strings[-1] for action in command._actions if action.option_strings}
    if unknown:
        known = [option for action in command._actions for option in action.option_strings]
        hints = "".join(nearest(option.split("=")[0], known) for option in unknown if option.startswith("-"))
        command.error(f"unrecognized arguments: {' '.join(unknown)}{hints}")
    return parsed


def _without_a_reader() -> int:
    """Return the exit code when the reader of the output has gone, and let nothing more be written to it."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


def _failed(message: str) -> int:
    """Print an error in one line and return the exit code of bad input."""
    print(f"lbskel: {' '.join(message.splitlines())}", file=sys.stderr)
    return 2
