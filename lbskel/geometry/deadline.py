"""Deadlines of computations, and long queries in slices between which the deadline is checked.

The caller that sets a deadline catches :class:`OutOfTime` and leaves out what was not finished. Values are frozen, so
nothing is left half changed. Between slices the interpreter also handles signals, such as Ctrl-C; a kernel does not.
The slices are divided among threads (:mod:`lbskel.geometry.threads`); their results do not depend on how many.
"""

from __future__ import annotations

__all__ = ["NEVER", "Deadline", "OutOfTime", "in_slices"]

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.threads import in_threads

# Rows of a slice: sections and rays among needles take up to a quarter of a millisecond each (a fan of 50,000 faces, a
# brush of 2,500 bristles), so a slice takes up to half a second; the calls themselves take microseconds
SLICE = 2000


Item = TypeVar("Item")


class OutOfTime(Exception):
    """Raised where a deadline has passed."""


@dataclass(frozen=True)
class Deadline:
    """The time by which a computation has to end.

    Parameters
    ----------
    end : float
        A value of :func:`time.perf_counter`, in seconds; infinite without a limit.
    """

    end: float = float("inf")

    @property
    def seconds_left(self) -> float:
        """Seconds until the deadline, negative after it."""
        return self.end - time.perf_counter()

    def check(self) -> None:
        """Raise OutOfTime after the deadline."""
        if self.end < float("inf") and self.seconds_left <= 0:
            raise OutOfTime

    def until(self, items: Iterable[Item]) -> Iterator[Item]:
        """Yield the items; raise OutOfTime in place of the first item after the deadline.

        Parameters
        ----------
        items : iterable
        """
        for item in items:
            self.check()
            yield item


NEVER = Deadline()


def in_slices(
    query: Callable[..., tuple[NDArray[Any], ...]], *rows: NDArray[Any], deadline: Deadline = NEVER
) -> tuple[NDArray[Any], ...]:
    """Concatenate the results of a query on slices of its arguments, whose rows do not depend on each other.

    Parameters
    ----------
    query : callable
        Takes arrays of k rows each, and returns a tuple of arrays of k rows; several threads call it.
    rows : arrays
        The arguments of the query, with equal numbers of rows.
    deadline : Deadline

    Raises
    ------
    OutOfTime
        If the deadline passes before the last slice begins.
    """
    if len(rows[0]) <= SLICE:
        deadline.check()
        return query(*rows)

    def answer(first: int) -> tuple[NDArray[Any], ...]:
        deadline.check()
        return query(*(each[first : first + SLICE] for each in rows))

    parts = in_threads(answer, range(0, len(rows[0]), SLICE))
    return tuple(map(np.concatenate, zip(*parts, strict=True)))
