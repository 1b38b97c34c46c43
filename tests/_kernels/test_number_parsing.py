"""Numbers out of text, against Python's ``float``."""

import numpy as np
import pytest

WORDS = "0 -0 1e5 -1.5E-300 1e400 .5 5. +3 123456789012345678 1234567890123456789 0.30000000000000004 nan -inf 2.675"
HALFWAY = (
    "9007199254740993 4503599627370497.5 900719925474099.25 1.0000000000000001110223024625156540423631668090820312"
)


def bits(values):
    """The bits of doubles, in which 0 and -0 differ; those of all NaN count as the same."""
    values = np.array(values, dtype=np.float64)
    return np.where(np.isnan(values), np.nan, values).view(np.int64).tolist()


def test_numbers_are_those_of_python(kernel):
    words = [f"{value:.{digits}g}" for value in np.pi ** np.arange(-40, 40.0) for digits in range(1, 25)]
    words += [*WORDS.split(), *HALFWAY.split()]
    found = kernel.parse_decimals(" \r\n\t".join(words).encode())
    assert bits(found) == bits([float(word) for word in words])


def test_numbers_of_many_digits_are_rounded_to_the_nearest(kernel):
    """Between 16 and 18 digits one division is not enough: a double holds 53 bits."""
    rng = np.random.default_rng(0)
    whole = rng.integers(10**15, 10**18, size=3000)
    words = [
        f"{number}"[:-k] + "." + f"{number}"[-k:] for number, k in zip(whole, rng.integers(1, 15, 3000), strict=True)
    ]
    assert bits(kernel.parse_decimals(" ".join(words).encode())) == bits([float(word) for word in words])


def test_white_space_alone_holds_no_number(kernel):
    assert kernel.parse_decimals(b"").shape == kernel.parse_decimals(b" \t\r\n\v\f ").shape == (0,)


@pytest.mark.parametrize(
    "text", ["1 2 x", "1_0", "--1", "1..2", ".", "-", "1,2", "0x10", "1\0", "1e", "\u0661", "1\x002", "1\x1f2"]
)
def test_what_is_not_a_number_is_an_error(kernel, text):
    with pytest.raises(ValueError, match=r"number|convert"):
        kernel.parse_decimals(text.encode())


def test_compiled_or_not_is_the_same(assert_same):
    rng = np.random.default_rng(5)
    values = rng.normal(size=600) * 10.0 ** rng.integers(-9, 9, size=600)
    forms = ("{!r}", "{:.6f}", "{:.15e}", "{:.18f}", "{:.17g}")
    words = [form.format(value) for value in values.tolist() for form in forms]
    assert_same(lambda kernel: [kernel.parse_decimals(" ".join([*words, WORDS, HALFWAY]).encode())])
