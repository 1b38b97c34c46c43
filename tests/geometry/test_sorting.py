"""Stable sorting of integers, compared with numpy."""

import numpy as np
import pytest

from lbskel.geometry.sorting import distinct, is_among, stable_order, unique_inverse


@pytest.mark.parametrize("largest", [0, 1, 9, 10**6, 2**62])
@pytest.mark.parametrize("n", [0, 1, 2, 3, 1000])
def test_orders_and_unique_numbers_are_those_of_numpy(n, largest):
    numbers = np.random.default_rng(n).integers(0, largest, n, endpoint=True)
    numbers[n // 2 :] = numbers[: n - n // 2]  # some twice
    assert np.array_equal(distinct(numbers), np.unique(numbers))
    assert np.array_equal(stable_order(numbers), np.argsort(numbers, kind="stable"))
    others = np.random.default_rng(n + 1).choice(np.append(numbers, largest // 2), n // 2)
    assert np.array_equal(is_among(numbers, others), np.isin(numbers, others))
    unique, which = np.unique(numbers, return_inverse=True)
    for ours, theirs in zip(unique_inverse(numbers), (unique, which), strict=True):
        assert np.array_equal(ours, theirs)
