"""The current stage and the seconds since the start, on a terminal, while a skeleton is made."""

from __future__ import annotations

__all__ = ["StageBar"]

import sys


class StageBar:
    """Shows the stage on stderr while it is open, and nothing where that is no terminal.

    Parameters
    ----------
    name : str
        Of the input.
    is_quiet : bool
    """

    def __init__(self, name: str, is_quiet: bool = False):
        self._name = name
        self._is_quiet = is_quiet or not sys.stderr.isatty()

    def __enter__(self) -> StageBar:
        from tqdm import tqdm

        self._bar = tqdm(desc=self._name, bar_format="{desc} {elapsed}", leave=False, disable=self._is_quiet)
        return self

    def show(self, stage: str) -> None:
        """Show the name of a stage."""
        self._bar.set_description_str(f"{self._name}: {stage}")

    def __exit__(self, *_: object) -> None:
        self._bar.close()
