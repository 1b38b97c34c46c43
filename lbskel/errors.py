"""Every error that lbskel raises on purpose.

Each message names the place (which vertices, which faces, which line) and the way out.
"""

from __future__ import annotations

__all__ = [
    "FormatError",
    "LbskelError",
    "MeshError",
    "MissingDependency",
    "OperatorError",
    "SolveError",
    "UnknownChoice",
    "choose",
    "first_few",
]

from collections.abc import Iterable, Mapping
from typing import TypeVar

Value = TypeVar("Value")


class LbskelError(Exception):
    """The parent of all of lbskel's errors."""


class MeshError(LbskelError, ValueError):
    """The vertices or faces cannot be used; the message names them."""


class UnknownChoice(LbskelError, ValueError):
    """A name that is in no table; the message lists the names that are."""


class OperatorError(LbskelError, TypeError):
    """A function given as an operator returned something other than a usable Laplacian; the message says what to do."""


class FormatError(LbskelError, ValueError):
    """A file that cannot be read or written as the format that its name tells."""


class SolveError(LbskelError, ArithmeticError):
    """A linear system that could not be solved to a useful accuracy.

    Attributes
    ----------
    residual : float
        Relative residual that was reached; infinity where there is no solution at all.
    """

    def __init__(self, message: str, residual: float = float("inf")):
        super().__init__(message)
        self.residual = residual


class MissingDependency(LbskelError, ImportError):
    """An optional package is not installed; the message carries the pip line."""

    def __init__(self, package: str, extra: str, purpose: str):
        super().__init__(f"{purpose} needs {package}, which is not installed: pip install 'lbskel[{extra}]'")
        self._given = package, extra, purpose

    def __reduce__(self) -> tuple[type[MissingDependency], tuple[str, str, str]]:
        return type(self), self._given  # so that it comes back from another process


def choose(table: Mapping[str, Value], name: str, what: str) -> Value:
    """The table's entry of that name.

    Raises
    ------
    UnknownChoice
        If there is none; the message lists those that exist.
    """
    try:
        return table[name]
    except (KeyError, TypeError):
        raise UnknownChoice(f"unknown {what} {name!r}; choose one of: {', '.join(table)}") from None


def first_few(indices: Iterable[object], at_most: int = 5) -> str:
    """The first of some indices as text for a message: ``3, 17, 40 and 12 more``."""
    names = [str(index) for index in indices]
    shown = ", ".join(names[:at_most])
    return shown if len(names) <= at_most else f"{shown} and {len(names) - at_most} more"
