"""Sorting by digits, compared with numpy."""

import numpy as np
import pytest

from lbskel._kernels.radix_sort import stable_order


@pytest.mark.parametrize("largest", [0, 1, 2047, 2048, 10**9, 2**62, 2**63 - 1])
@pytest.mark.parametrize("n", [0, 1, 2, 300])
def test_the_order_is_that_of_a_stable_sort(n, largest):
    numbers = np.random.default_rng(n).integers(0, largest, n, endpoint=True)
    numbers[n // 2 :] = numbers[: n - n // 2]  # some twice
    assert np.array_equal(stable_order(numbers), np.argsort(numbers, kind="stable"))


def test_numbers_are_ordered_by_their_first_digit_first():
    digits = [0, 1, 2**11, 2**22, 2**33, 2**44, 2**55, 2**62]
    assert stable_order(np.array(digits[::-1])).tolist() == list(range(len(digits)))[::-1]
