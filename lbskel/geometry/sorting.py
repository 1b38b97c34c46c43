"""Sorting of integers that are not negative and of rows of them, by their digits, and groups laid end to end.

For 78,000 half-edges, sorting takes a quarter of the time of ``numpy.sort``, as measured on an AMD EPYC.
"""

from __future__ import annotations

__all__ = [
    "distinct",
    "first_in_groups",
    "first_of_each",
    "group_medians",
    "is_among",
    "split_at",
    "stable_float_order",
    "stable_order",
    "unique_inverse",
    "unique_rows",
]

from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels import radix_sort

Scalar = TypeVar("Scalar", bound=np.generic)

INFINITY_BITS = int(np.float64(np.inf).view(np.int64))  # the largest of a double that is not NaN


def stable_order(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) indices that sort numbers in ascending order; equal numbers keep their order.

    Parameters
    ----------
    numbers : (n,) array of int
        None negative.
    """
    order: NDArray[np.int64] = radix_sort.stable_order(np.ascontiguousarray(numbers, dtype=np.int64))
    return order


def stable_float_order(values: NDArray[np.float64], *, descending: bool = False) -> NDArray[np.int64]:
    """(n,) indices that sort values; equal values keep their order.

    Numpy's stable sort takes longer on unordered values. The bits of doubles that are not negative, read as integers,
    have the order of the doubles (IEEE 754).

    Parameters
    ----------
    values : (n,) array of float
        None negative or NaN.
    descending : bool
        Whether the largest values come first.
    """
    bits = (np.ascontiguousarray(values, dtype=np.float64) + 0.0).view(np.int64)  # -0.0 becomes 0.0
    return stable_order(INFINITY_BITS - bits if descending else bits)


def distinct(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the distinct numbers in ascending order: sorting takes a fraction of the time of numpy.unique's hash table.

    Parameters
    ----------
    numbers : (n,) array of int
        None negative.
    """
    ascending = numbers[stable_order(numbers)]
    found: NDArray[np.int64] = ascending[np.append(True, ascending[1:] != ascending[:-1])[: len(ascending)]]
    return found


def is_among(numbers: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether each number is one of others: sorting and searching takes half of the time of numpy.isin, or less.

    Parameters
    ----------
    numbers : (...) array of int
    others : (m,) array of int
        None negative.
    """
    if len(others) == 0:
        return np.zeros(numbers.shape, dtype=bool)
    ascending = others[stable_order(others)]
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


def unique_rows(rows: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find the index of the first of equal rows, in the order of the sorted rows, and for each row its place there.

    ``numpy.unique`` takes ten times as long for rows.

    Parameters
    ----------
    rows : (m, d) array of int
        None negative.
    """
    order = np.arange(len(rows))
    for column in rows.T[::-1]:
        order = order[stable_order(column[order])]
    is_new = np.arange(len(rows)) == 0
    for column in rows.T:
        ascending = column[order]
        is_new[1:] |= ascending[1:] != ascending[:-1]
    place = np.empty(len(rows), dtype=np.int64)
    place[order] = np.cumsum(is_new) - 1
    return order[is_new], place


def first_of_each(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """(k,) index of the first of equal rows, in ascending order.

    Parameters
    ----------
    rows : (m, d) array of int
        None negative.
    """
    return np.sort(unique_rows(rows)[0])


def split_at(values: NDArray[Scalar], cuts: NDArray[np.int64]) -> list[NDArray[Scalar]]:
    """Divide an array as ``numpy.split`` does: into a thousand parts, in a fifth of the time.

    Parameters
    ----------
    values : (n, ...) array
    cuts : (c,) array of int
        Where each part but the first begins; the parts are views.
    """
    return [values[begin:end] for begin, end in pairwise([0, *cuts.tolist(), len(values)])]


def group_medians(values: NDArray[np.float64], begins: NDArray[np.int64]) -> NDArray[np.float64]:
    """(g,) median of each group of values that are laid end to end.

    Parameters
    ----------
    values : (n,) array of float
    begins : (g + 1,) array of int
        Where each group begins and the last ends; no group is empty.
    """
    sizes, begin = np.diff(begins), begins[:-1]
    ascending = values[np.lexsort((values, np.repeat(np.arange(len(sizes)), sizes)))]
    medians: NDArray[np.float64] = (ascending[begin + (sizes - 1) // 2] + ascending[begin + sizes // 2]) / 2
    return medians


def first_in_groups(is_met: NDArray[np.bool_], begins: NDArray[np.int64]) -> NDArray[np.int64]:
    """(g,) row of the first member of each group that meets a condition, or the end of the group if none does.

    Parameters
    ----------
    is_met : (n,) array of bool
        Of groups that are laid end to end.
    begins : (g + 1,) array of int
        Where each group begins and the last ends.
    """
    rows = np.append(np.flatnonzero(is_met), len(is_met))
    firsts: NDArray[np.int64] = np.minimum(rows[np.searchsorted(rows, begins[:-1])], begins[1:])
    return firsts
