# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Numbers out of text, each the double that is nearest to it."""

from __future__ import annotations

__all__ = ["numbers_in"]

import cython
import numpy as np
from numpy.typing import NDArray

FEW = cython.declare(
    cython.Py_ssize_t, 15
)  # digits that a double holds, so that one quotient is exact but for rounding
DIGITS = cython.declare(cython.Py_ssize_t, 18)  # that an integer of 64 bits holds; and 10^18 is a double
SPLIT = cython.declare(cython.double, 2.0**27 + 1)  # leaves half the bits
UNSURE = cython.declare(cython.double, 1e-10)  # share of a correction, far more than its rounding error


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _is_space(character: cython.uchar) -> cython.bint:
    """Whether a character stands between numbers."""
    return character == 32 or 9 <= character <= 13


@cython.cfunc
@cython.exceptval(check=False)
def _quotient(whole: cython.longlong, ten: cython.double) -> cython.double:
    """The double nearest to a whole number of many digits over a power of ten; not a number where that is not sure.

    The quotient of doubles and what it leaves, which is exact: Dekker 1971, "A floating-point technique for extending
    the available precision", https://doi.org/10.1007/BF01397083.
    """
    high: cython.double = float(whole)
    low: cython.double = whole - cython.cast(cython.longlong, high)
    first: cython.double = high / ten
    a: cython.double = SPLIT * first
    b: cython.double = SPLIT * ten
    a, b = a - (a - first), b - (b - ten)
    c: cython.double = first - a
    d: cython.double = ten - b
    product: cython.double = first * ten
    rest: cython.double = (high - product) - (((a * b - product) + a * d + c * b) + c * d)
    correction: cython.double = (rest + low) / ten
    below: cython.double = first + correction * (1 - UNSURE)
    above: cython.double = first + correction * (1 + UNSURE)
    return below if below == above else float("nan")


@cython.locals(n=cython.Py_ssize_t, at=cython.Py_ssize_t, begin=cython.Py_ssize_t, point=cython.Py_ssize_t)
@cython.locals(digits=cython.Py_ssize_t, whole=cython.longlong, value=cython.double, ten=cython.double)
def numbers_in(text: cython.const[cython.uchar][::1]) -> NDArray[np.float64]:
    """All numbers of a text, whatever white space is between them.

    What has too many digits, or is no plain decimal, is left to Python; what it does not know either is a ValueError.
    """
    n = len(text)
    at = 0
    count: cython.Py_ssize_t = 0
    array = np.empty(n // 2 + 1)
    result: cython.double[::1] = array
    tens: cython.double[::1] = np.array([float(10**k) for k in range(DIGITS + 1)])
    while True:
        while at < n and _is_space(text[at]):
            at += 1
        if at == n:
            return array[:count]
        begin = at
        if text[at] == 45 or text[at] == 43:  # a sign
            at += 1
        digits, whole, point = 0, 0, -1
        while at < n and digits <= DIGITS:
            if 48 <= text[at] <= 57:
                whole = 10 * whole + (text[at] - 48) if digits < DIGITS else 0
                digits += 1
            elif text[at] == 46 and point < 0:
                point = digits
            else:
                break
            at += 1
        value = float("nan")
        if 0 < digits <= DIGITS and (at == n or _is_space(text[at])):
            ten = tens[digits - point if point >= 0 else 0]
            value = whole / ten if digits <= FEW else _quotient(whole, ten)
        if value == value:
            result[count] = -value if text[begin] == 45 else value
        else:
            while at < n and not _is_space(text[at]):
                at += 1
            result[count] = _by_python(bytes(text[begin:at]))
        count += 1


def _by_python(word: bytes) -> float:
    """A number as Python reads it, but for what is only a number in a program."""
    if b"_" in word:
        raise ValueError(f"no number: {word!r}")
    return float(word)
