"""Parser of decimal numbers, each rounded to the nearest double."""

from __future__ import annotations

__all__ = ["parse_decimals"]

import numpy as np
from numpy.typing import NDArray

try:
    import cython
except ImportError:  # not needed where this is compiled
    from lbskel._kernels import c_types as cython

NAN = cython.declare(cython.double, float("nan"))
# decimal digits that a double represents exactly: one division by a power of ten is then correctly rounded
EXACT_DIGITS = cython.declare(cython.Py_ssize_t, 15)
# decimal digits that a 64-bit integer holds; 10^18 is exact as a double
MAX_DIGITS = cython.declare(cython.Py_ssize_t, 18)
SPLITTER = cython.declare(cython.double, 2.0**27 + 1)  # splits a double of 53 bits into halves: Dekker 1971
CORRECTION_MARGIN = cython.declare(cython.double, 1e-10)  # relative; above the rounding error of a correction (a guess)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _is_space(character: cython.uchar) -> cython.bint:
    """Whether a character is white space."""
    return character == 32 or 9 <= character <= 13


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _quotient(integer: cython.longlong, power: cython.double) -> cython.double:
    """Divide an integer of up to 18 digits by a power of ten, to the nearest double; NaN where that is not decided.

    The quotient of doubles, corrected by its exact remainder: Dekker 1971, "A floating-point technique for extending
    the available precision", https://doi.org/10.1007/BF01397083.
    """
    high: cython.double = float(integer)
    low: cython.double = integer - cython.cast(cython.longlong, high)
    first: cython.double = high / power
    a: cython.double = SPLITTER * first
    b: cython.double = SPLITTER * power
    a, b = a - (a - first), b - (b - power)
    c: cython.double = first - a
    d: cython.double = power - b
    product: cython.double = first * power
    remainder: cython.double = (high - product) - (((a * b - product) + a * d + c * b) + c * d)
    correction: cython.double = (remainder + low) / power
    below: cython.double = first + correction * (1 - CORRECTION_MARGIN)
    above: cython.double = first + correction * (1 + CORRECTION_MARGIN)
    return below if below == above else NAN


@cython.locals(n=cython.Py_ssize_t, i=cython.Py_ssize_t, begin=cython.Py_ssize_t, point=cython.Py_ssize_t)
@cython.locals(digits=cython.Py_ssize_t, integer=cython.longlong, value=cython.double, power=cython.double)
def parse_decimals(text: cython.const[cython.uchar][::1]) -> NDArray[np.float64]:
    """All numbers of a text, separated by white space.

    Numbers with too many digits or with an exponent are left to Python's ``float``.

    Parameters
    ----------
    text : (n,) array of uint8, or bytes

    Raises
    ------
    ValueError
        If a word is not a number.
    """
    n = len(text)
    i = 0
    count: cython.Py_ssize_t = 0
    array = np.empty(n // 2 + 1)
    result: cython.double[::1] = array
    powers: cython.double[::1] = np.array([float(10**k) for k in range(MAX_DIGITS + 1)])
    with cython.nogil:
        while True:
            while i < n and _is_space(text[i]):
                i += 1
            if i == n:
                break
            begin = i
            if text[i] == 45 or text[i] == 43:  # a sign
                i += 1
            digits, integer, point = 0, 0, -1
            while i < n and digits <= MAX_DIGITS:
                if 48 <= text[i] <= 57:
                    integer = 10 * integer + (text[i] - 48) if digits < MAX_DIGITS else 0
                    digits += 1
                elif text[i] == 46 and point < 0:
                    point = digits
                else:
                    break
                i += 1
            value = NAN
            if 0 < digits <= MAX_DIGITS and (i == n or _is_space(text[i])):
                power = powers[digits - point if point >= 0 else 0]
                value = integer / power if digits <= EXACT_DIGITS else _quotient(integer, power)
            if value == value:
                result[count] = -value if text[begin] == 45 else value
            else:
                while i < n and not _is_space(text[i]):
                    i += 1
                with cython.gil:
                    result[count] = _python_float(bytes(text[begin:i]))
            count += 1
    return array[:count]


def _python_float(word: bytes) -> float:
    """Python's ``float``, except for underscores between digits, which are an error here."""
    if b"_" in word:
        raise ValueError(f"not a number: {word!r}")
    return float(word)
