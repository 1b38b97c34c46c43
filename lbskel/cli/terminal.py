"""Output of a command: its result on stdout, as text or JSON, a bar on stderr if it takes long, and errors."""

from __future__ import annotations

__all__ = ["message_of", "progress", "tell", "with_options"]

import argparse
import json
import os
import re
import sys
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext, redirect_stdout
from typing import Any, TextIO

from lbskel.errors import LbskelError
from lbskel.geometry.arrays import to_builtin
from lbskel.pipeline.progress import StageBar

PATIENCE = 2.0  # seconds after which a command shows that it works; asked for by users


def tell(arguments: argparse.Namespace, text: str, facts: Mapping[str, Any]) -> None:
    """Print a result: its facts with ``--json``, NaN as null, else the text, and nothing with ``--quiet``."""
    if arguments.json:
        print(json.dumps(to_builtin(facts), allow_nan=False), flush=True)
    elif not arguments.quiet:
        print(text, flush=True)


def with_options(message: str, arguments: argparse.Namespace) -> str:
    """Replace the arguments of Python that a message names, with an underscore or as ``name='value'``, by options.

    A name next to a dot, a slash or a hyphen is a part of the name of a file, and stays.
    """
    for name, option in arguments.options.items():
        message = re.sub(rf"\b{name}='([^']*)'", rf"{option} \1", message)
        message = re.sub(rf"(?<![\w./-]){name}(?![\w/-]|\.\w)", option, message) if "_" in name else message
    return message


def message_of(error: Exception) -> str:
    """Say what went wrong; an error that lbskel does not raise on purpose is named with its place."""
    if isinstance(error, LbskelError | OSError):  # OSError: a name that the system refuses
        return str(error)
    if isinstance(error, MemoryError):
        return "out of memory; simplify the mesh first"
    place = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{os.path.basename(place.filename)} line {place.lineno}"
    return f"internal error in {where}, please report it: {type(error).__name__}: {error}"


@contextmanager
def progress(arguments: argparse.Namespace) -> Iterator[None]:
    """Show the command, the stage that it tells by ``arguments.on_stage``, and the seconds, on a terminal only.

    A batch has a bar of its own. What is printed meanwhile takes the place of the bar.
    """
    is_shown = sys.stderr.isatty() and not arguments.quiet and arguments.command != "batch"
    with StageBar(f"lbskel {arguments.command}", is_shown=is_shown, delay=PATIENCE) as bar:
        arguments.on_stage = bar.show
        with redirect_stdout(_Cleared(sys.stdout, bar)) if is_shown else nullcontext():
            yield


class _Cleared:
    """A stream that clears the bar before it writes."""

    def __init__(self, stream: TextIO, bar: StageBar):
        self._stream = stream
        self._bar = bar

    def write(self, text: str) -> int:
        self._bar.clear()
        return self._stream.write(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)
