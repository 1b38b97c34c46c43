"""The exceptions that lbskel raises, and the lookup of a name in a table of choices.

Each message says where the fault is (which vertices, which faces, which line) and how to fix it.
"""

from __future__ import annotations

__all__ = [
    "FormatError",
    "LbskelError",
    "MemoryLimitError",
    "MeshError",
    "MissingDependency",
    "OperatorError",
    "SolveError",
    "UnknownChoice",
    "checked_count",
    "choose",
    "counted",
    "first_few",
    "is_number",
    "nearest",
    "were",
]

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from math import inf
from numbers import Integral, Real
from typing import TypeVar

Value = TypeVar("Value")

# Least similarity, as difflib measures it, at which a name is taken for a misspelling of another; a choice of style
MIN_SIMILARITY = 0.75
# Of nouns that do not just add an s
PLURALS = {"branch": "branches", "cavity": "cavities", "entry": "entries", "vertex": "vertices"}


class LbskelError(Exception):
    """Base class of all exceptions of lbskel.

    Examples
    --------
    >>> import lbskel
    >>> try:
    ...     lbskel.Mesh([[0, 0, 0]], [[0, 0, 7]])
    ... except lbskel.LbskelError as error:
    ...     print(type(error).__name__)
    MeshError
    """


class MeshError(LbskelError, ValueError):
    """The vertices or faces are invalid; the message names them.

    Examples
    --------
    >>> import lbskel
    >>> try:
    ...     lbskel.Mesh([[0, 0, 0], [1, 0, 0], [0, float("nan"), 0]], [[0, 1, 2]])
    ... except lbskel.MeshError as error:
    ...     print("2" in str(error))
    True
    """


class UnknownChoice(LbskelError, ValueError):
    """A name is not in its table of choices; the message lists the valid names.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> try:
    ...     lbskel.laplacian(torus(1.0, 0.2), operator="cotangnet")
    ... except lbskel.UnknownChoice as error:
    ...     print(str(error).partition(";")[0])
    unknown operator 'cotangnet', did you mean 'cotangent'?
    """


class OperatorError(LbskelError, TypeError):
    """A function given as an operator returned something other than a usable Laplacian; the message says what to do.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> try:
    ...     lbskel.contract(torus(1.0, 0.2), lbskel.ContractionSettings(operator=lambda mesh: 7))
    ... except lbskel.OperatorError as error:
    ...     print("Laplacian" in str(error))
    True
    """


class FormatError(LbskelError, ValueError):
    """A file cannot be read or written, or is not in the format of its extension.

    Examples
    --------
    >>> import lbskel
    >>> try:
    ...     lbskel.read_mesh("nowhere.off")
    ... except lbskel.FormatError as error:
    ...     print(error)
    nowhere.off: no such file
    """


class SolveError(LbskelError, ArithmeticError):
    """A linear system could not be solved to a useful accuracy.

    Attributes
    ----------
    residual : float
        Relative residual of the solution that was found; infinity if none was found.

    Examples
    --------
    >>> import lbskel
    >>> from scipy.sparse import csc_array
    >>> try:
    ...     lbskel.factorize(csc_array([[1.0, 1.0], [1.0, 1.0]])).solve([1.0, 0.0])
    ... except lbskel.SolveError:
    ...     print("singular")
    singular
    """

    def __init__(self, message: str, residual: float = float("inf")):
        super().__init__(message)
        self.residual = residual


class MemoryLimitError(LbskelError, MemoryError):
    """The input needs more memory than there is; the message says how much, and the way out.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> try:
    ...     lbskel.skeletonize(torus(1.0, 0.2), memory_limit=1)
    ... except lbskel.MemoryLimitError as error:
    ...     print(str(error).split(":")[0])
    a mesh of 2,304 faces takes about 113 MB of memory, and the limit is 1
    """


class MissingDependency(LbskelError, ImportError):
    """An optional package is not installed; the message contains the pip command that installs it.

    Examples
    --------
    >>> import lbskel
    >>> print(lbskel.MissingDependency("plotly", "view", "an interactive page"))
    an interactive page needs plotly, which is not installed: pip install 'lbskel[view]'
    """

    def __init__(self, package: str, extra: str, purpose: str):
        super().__init__(f"{purpose} needs {package}, which is not installed: pip install 'lbskel[{extra}]'")
        self._arguments = package, extra, purpose

    def __reduce__(self) -> tuple[type[MissingDependency], tuple[str, str, str]]:
        return type(self), self._arguments  # pickle would pass the message, and __init__ takes three arguments


def choose(table: Mapping[str, Value], name: str, what: str) -> Value:
    """Return the entry of a table of choices.

    Parameters
    ----------
    table : mapping
        The choices by name.
    name : str
        The requested choice.
    what : str
        What the choices are, for the message: ``operator``, ``solver``.

    Raises
    ------
    UnknownChoice
        If the table has no such name; the message lists the valid names.
    """
    try:
        return table[name]
    except (KeyError, TypeError):
        raise UnknownChoice(
            f"unknown {what} {name!r}{nearest(name, table)}; choose one of: {', '.join(table)}"
        ) from None


def is_number(value: object) -> bool:
    """Whether a value is a real number, and no truth value or text."""
    return isinstance(value, Real) and not isinstance(value, bool)


def checked_count(value: object, name: str, low: int, high: float = inf) -> int:
    """Return a number of things; raise UnknownChoice if it is no whole number from ``low`` to ``high``.

    Parameters
    ----------
    value : int
    name : str
        The parameter, for the message.
    low : int
    high : int, optional
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or not low <= int(value) <= high:
        raise UnknownChoice(
            f"{name} must be a whole number from {low} {'on' if high == inf else f'to {high:,}'}, not {value!r}"
        )
    return int(value)


def nearest(name: object, names: Iterable[str]) -> str:
    """Format the question for a similar name, for a message: ``, did you mean 'robust'?``; empty if none is similar."""
    similar = get_close_matches(str(name), list(names), n=1, cutoff=MIN_SIMILARITY)
    return f", did you mean {similar[0]!r}?" if similar else ""


def first_few(indices: Iterable[object], at_most: int = 5) -> str:
    """Format the first ``at_most`` of some indices for a message: ``3, 17, 40 and 12 more``."""
    names = [str(index) for index in indices]
    shown = ", ".join(names[:at_most])
    return shown if len(names) <= at_most else f"{shown} and {len(names) - at_most} more"


def counted(n: int, noun: str) -> str:
    """Format a number of things for a message: ``1 cycle``, ``2,304 faces``."""
    return f"{n:,} {noun if n == 1 else PLURALS.get(noun, f'{noun}s')}"


def were(n: int, noun: str) -> str:
    """Format a number of things with their verb, for a message: ``1 cycle was``, ``2,304 faces were``."""
    return f"{counted(n, noun)} {'was' if n == 1 else 'were'}"
