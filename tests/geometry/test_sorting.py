"""Stable sorting of numbers, compared with numpy."""

import numpy as np
import pytest

from lbskel.geometry.sorting import (
    distinct,
    first_in_groups,
    first_of_each,
    group_medians,
    is_among,
    split_at,
    stable_float_order,
    stable_order,
    unique_inverse,
    unique_rows,
)


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


def test_orders_of_floats_are_those_of_numpy():
    values = np.concatenate([[0.0, -0.0, np.inf, 5e-324, 1e300, 0.0], np.random.default_rng(0).random(1000).round(2)])
    assert np.array_equal(stable_float_order(values), np.argsort(values, kind="stable"))
    assert np.array_equal(stable_float_order(values, descending=True), np.argsort(-values, kind="stable"))
    assert np.array_equal(stable_float_order(values[::2]), np.argsort(values[::2], kind="stable"))


@pytest.mark.parametrize("n", [0, 1, 200])
def test_unique_rows_are_those_of_numpy(n):
    rows = np.random.default_rng(n).integers(0, 5, (n, 3))
    _, first, place = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    ours = unique_rows(rows)
    assert np.array_equal(ours[0], first)
    assert np.array_equal(ours[1], place.ravel())
    assert np.array_equal(first_of_each(rows), np.sort(first))


@pytest.mark.parametrize("cuts", [[], [0], [5], [2, 2, 4]])
def test_parts_are_those_of_numpy(cuts):
    values = np.arange(10.0).reshape(5, 2)
    for ours, theirs in zip(split_at(values, np.array(cuts, dtype=int)), np.split(values, cuts), strict=True):
        assert np.array_equal(ours, theirs)


def test_medians_of_groups_are_those_of_numpy():
    values, begins = np.random.default_rng(0).normal(size=20), np.array([0, 1, 3, 6, 20])
    medians = [np.median(group) for group in np.split(values, begins[1:-1])]
    assert np.array_equal(group_medians(values, begins), medians)
    assert group_medians(values[:0], begins[:1]).shape == (0,)


def test_the_first_member_of_each_group_that_meets_a_condition_or_its_end():
    is_met = np.array([0, 1, 1, 0, 0, 0, 1], dtype=bool)
    begins = np.array([0, 2, 2, 3, 5, 7])
    assert first_in_groups(is_met, begins).tolist() == [1, 2, 2, 5, 6]
    assert first_in_groups(is_met[:0], np.array([0, 0])).tolist() == [0]
