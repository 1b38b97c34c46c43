"""Rows of the committed results, and the figures that README.md takes from them."""

from __future__ import annotations

__all__ = [
    "Figures",
    "Rows",
    "bound",
    "claim",
    "lower_bound",
    "mean",
    "named",
    "of",
    "percent",
    "read",
    "small_bound",
    "span",
    "values",
]

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from decimal import ROUND_CEILING, Context, Decimal
from pathlib import Path
from typing import Any

import numpy as np

Rows = Sequence[dict[str, Any]]
Figures = Mapping[str, Any]
NUMBERS = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"]


def read(results: Path, name: str, key: str = "rows") -> Rows:
    """Read a table of a result."""
    table: Rows = json.loads((results / f"{name}.json").read_text(encoding="utf-8"))[key]
    return table


def of(table: Rows, **where: Any) -> Rows:
    """Return the rows that have these values."""
    return [row for row in table if all(row[key] == value for key, value in where.items())]


def values(table: Rows, key: str) -> list[Any]:
    """Return the values of a column, where there are any."""
    return [row[key] for row in table if row.get(key) is not None]


def mean(table: Rows, key: str) -> float:
    """Return the mean of a column."""
    return float(np.mean(values(table, key)))


def span(figures: Iterable[float], form: str = ".3g") -> str:
    """Tell the smallest and the largest, or one if they read alike."""
    found = sorted(figures)
    least, largest = f"{found[0]:{form}}", f"{found[-1]:{form}}"
    return least if least == largest else f"{least} to {largest}"


def percent(figures: Iterable[float]) -> str:
    """Tell the smallest and the largest share, in percent."""
    return span((100 * figure for figure in figures), ".1f")


def bound(figures: Iterable[float], digits: int) -> str:
    """Tell the largest, rounded up to so many digits after the point."""
    return f"{math.ceil(max(figures) * 10**digits) / 10**digits:.{digits}f}"


def lower_bound(figures: Iterable[float], digits: int) -> str:
    """Tell the smallest, rounded down to so many digits after the point."""
    return f"{math.floor(min(figures) * 10**digits) / 10**digits:.{digits}f}"


def small_bound(figures: Iterable[float]) -> str:
    """Tell the largest magnitude in two digits and a power of ten, rounded up."""
    largest = Decimal(repr(float(max(map(abs, figures)))))  # as it is written, so that 4.2e-07 stays 4.2e-7
    rounded = Context(prec=2, rounding=ROUND_CEILING).create_decimal(largest)
    return re.sub(r"e([+-])0(?=\d)", r"e\1", f"{rounded:.1e}")


def named(count: int) -> str:
    """Write a count in letters up to twelve."""
    return NUMBERS[count] if count < len(NUMBERS) else f"{count:,}"


def claim(is_so: bool, sentence: str) -> None:
    """Refuse to write a sentence that the results do not bear out.

    Raises
    ------
    ValueError
        If it is not so.
    """
    if not is_so:
        raise ValueError(f"README.md says: {sentence}. The results do not say so any more: change the sentence.")
