"""Sorting of integers by their digits."""

from __future__ import annotations

__all__ = ["stable_order"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython

DIGIT_BITS = cython.declare(cython.int, 11)
N_DIGITS = cython.declare(cython.int, 2048)  # their counts, 16 KB, stay in the first cache
N_BITS = cython.declare(cython.int, 63)  # value bits of a signed 64-bit integer


@cython.locals(at=cython.Py_ssize_t, row=cython.longlong, largest=cython.longlong, shift=cython.longlong)
@cython.locals(digit=cython.longlong, now=cython.Py_ssize_t, n_before=cython.longlong, count=cython.longlong)
def stable_order(numbers: cython.const[cython.longlong][::1]) -> NDArray[np.int64]:
    """(n,) indices that sort numbers in ascending order; equal numbers keep their order.

    Radix sort from the least significant digit: Knuth 1998, "The art of computer programming", volume 3, 2nd edition,
    section 5.2.5, algorithm R.

    Parameters
    ----------
    numbers : (n,) array of int
        None negative.
    """
    n: cython.Py_ssize_t = numbers.shape[0]
    array = np.stack([np.arange(n), np.empty(n, dtype=np.int64)])
    orders: cython.longlong[:, ::1] = array
    places: cython.longlong[::1] = np.empty(N_DIGITS, dtype=np.int64)
    largest, shift, now = 0, 0, 0
    with cython.nogil:
        for at in range(n):
            largest = max(largest, numbers[at])
        while shift < N_BITS and largest >> shift > 0:
            for digit in range(N_DIGITS):
                places[digit] = 0
            for at in range(n):
                places[numbers[at] >> shift & (N_DIGITS - 1)] += 1
            n_before = 0
            for digit in range(N_DIGITS):
                count = places[digit]
                places[digit] = n_before
                n_before += count
            for at in range(n):
                row = orders[now, at]
                digit = numbers[row] >> shift & (N_DIGITS - 1)
                orders[1 - now, places[digit]] = row
                places[digit] += 1
            now, shift = 1 - now, shift + DIGIT_BITS
    return array[now]
