"""How figures are told."""

import pytest

from benchmarks.readme_figures import bound, claim, lower_bound, named, percent, small_bound, span, values


@pytest.mark.parametrize(("value", "digits", "told"), [(0.2242, 2, "0.23"), (0.05, 2, "0.05"), (3.001, 0, "4")])
def test_a_bound_is_rounded_up(value, digits, told):
    assert bound([0.0, value], digits) == told


def test_a_lower_bound_is_rounded_down():
    assert lower_bound([2.79, 5.0], 1) == "2.7"
    assert lower_bound([94.78], 0) == "94"


@pytest.mark.parametrize(("value", "told"), [(-9.217e-13, "9.3e-13"), (4.2e-07, "4.2e-7"), (9.99e-5, "1.0e-4")])
def test_a_small_bound_has_two_digits_rounded_up(value, told):
    assert small_bound([0.0, value]) == told


def test_a_span_is_one_figure_where_both_read_alike():
    assert span([2.0, 0.5]) == "0.5 to 2"
    assert span([0.961, 0.958], ".2f") == "0.96"
    assert percent([1e-16, 0.0081]) == "0.0 to 0.8"


def test_counts_are_in_letters_up_to_twelve():
    assert [named(count) for count in (0, 1, 12, 13, 1234)] == ["no", "one", "twelve", "13", "1,234"]


def test_missing_values_are_left_out():
    assert values([{"a": 1}, {"a": None}, {}], "a") == [1]


def test_a_claim_that_does_not_hold_is_refused():
    claim(True, "it is so")
    with pytest.raises(ValueError, match=r"^README.md says: it is so\. The results do not say so any more"):
        claim(False, "it is so")
