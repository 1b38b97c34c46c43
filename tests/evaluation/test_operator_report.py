"""Diagnostics as a value: which measure decides which property, and how they are printed."""

from dataclasses import fields, replace

import pytest

from lbskel.evaluation.operator_report import COLUMNS, LaplacianDiagnostics, diagnostics_table

PERFECT = LaplacianDiagnostics(
    asymmetry=0.0,
    nonlocal_fraction=0.0,
    row_sum_error=0.0,
    linear_precision_error=0.0,
    n_negative_weights=0,
    negative_fraction=0.0,
    most_negative_weight=0.0,
    smallest_eigenvalue=0.0,
    n_zero_eigenvalues=1,
    n_components=1,
    overshoot=0.0,
    condition_number=100.0,
    n_fallback_rows=0,
    area_ratio=1.0,
)

LOST = {  # a value just too large, and one that rounding explains
    "symmetric": ("asymmetry", 1e-11, 1e-13),
    "local": ("nonlocal_fraction", 1e-4, 0.0),
    "constants": ("row_sum_error", 1e-11, 1e-13),
    "linear": ("linear_precision_error", 1e-7, 1e-9),
    "positive": ("n_negative_weights", 1, 0),
    "semidefinite": ("smallest_eigenvalue", -1e-9, -1e-11),
    "null space": ("n_zero_eigenvalues", 0, 1),
    "maximum": ("overshoot", 1e-8, 1e-10),
    "untreated": ("n_fallback_rows", 3, 0),
    "area": ("area_ratio", 0.99, 1 - 1e-7),
}


def test_the_perfect_operator_has_every_property():
    assert set(PERFECT.passed) == set(LOST)
    assert all(PERFECT.passed.values())
    assert "!" not in str(PERFECT).splitlines()[1]


@pytest.mark.parametrize("key", LOST)
def test_each_measure_decides_its_property_and_no_other(key):
    name, lost, kept = LOST[key]
    passed = replace(PERFECT, **{name: lost}).passed
    assert [other for other, holds in passed.items() if not holds] == [key]
    assert all(replace(PERFECT, **{name: kept}).passed.values())


def test_an_area_that_is_too_large_is_as_wrong_as_one_too_small():
    assert replace(PERFECT, area_ratio=1.01).passed["area"] is False


@pytest.mark.parametrize("key", ["linear", "semidefinite", "null space", "maximum", "area"])
def test_what_was_not_measured_neither_passes_nor_fails(key):
    unknown = replace(PERFECT, **{LOST[key][0]: None})
    assert unknown.passed[key] is None
    assert "-" in str(unknown).splitlines()[1].split()


def test_the_null_space_has_a_dimension_for_each_component():
    two = replace(PERFECT, n_components=2)
    assert two.passed["null space"] is False
    assert replace(two, n_zero_eigenvalues=2).passed["null space"]
    assert "null space: its dimension, which should be 2." in str(two)


def test_the_table_has_a_row_for_each_operator_and_a_line_for_each_refused():
    skew = replace(PERFECT, asymmetry=0.25, nonlocal_fraction=0.125)
    lines = diagnostics_table({"good": PERFECT, "skew": skew}, {"other": "not on this mesh"}).splitlines()
    assert lines[0].split("  ")[0] == "operator"
    assert lines[1].startswith("good ")
    assert lines[2].split()[:3] == ["skew", "0.25!", "12.5%!"]
    assert lines[3:5] == ["other: not on this mesh", ""]
    assert all(heading in lines[0] for heading in COLUMNS)
    assert {name for name, _ in COLUMNS.values()} <= {field.name for field in fields(PERFECT)}


def test_print_shows_the_table_of_the_command_line():
    assert str(PERFECT) == diagnostics_table({"Laplacian": PERFECT})
