"""The measures: thresholds that point the right way, and verdicts at and between them."""

from dataclasses import fields, replace

import numpy as np
import pytest

from lbskel.evaluation.measures import MEASURES, Measure, Score

GOOD = Score(
    nodes_inside_fraction=1.0,
    inside_fraction=1.0,
    centeredness_error=0.0,
    centeredness_error_worst_branch=0.0,
    medial_accuracy_95=0.0,
    medial_coverage_98=0.0,
    uncovered_parts=0,
    near_surface_fraction=0.0,
    coverage=1.0,
    extremities=2,
    extremities_missed=0,
    missed_limb_fraction=0.0,
    rms_curvature=0.0,
    extra_components=0,
    extra_cycles=0,
    tunnels_missed=0,
    connected_regions=1.0,
    adjacent_regions=1.0,
    shortcut_edges=0,
    spurs=0,
)


def with_value(name, value):
    return Score(**{field.name: value if field.name == name else getattr(GOOD, field.name) for field in fields(Score)})


@pytest.mark.parametrize(
    ("value", "verdict"),
    [
        (0.0, "pass"),
        (0.1, "pass"),
        (-0.1, "pass"),
        (0.2, "warn"),
        (0.25, "fail"),
        (-0.3, "fail"),
        (np.nan, "fail"),
        (None, "not measured"),
    ],
)
def test_the_verdict_of_an_error(value, verdict):
    assert Measure("an error", 0.1, 0.25).verdict(value) == verdict


@pytest.mark.parametrize(
    ("value", "verdict"), [(1.0, "pass"), (0.9, "pass"), (0.5, "warn"), (0.3, "fail"), (0.0, "fail")]
)
def test_the_verdict_of_a_share(value, verdict):
    assert Measure("a share", 0.9, 0.3).verdict(value) == verdict


@pytest.mark.parametrize("name", MEASURES)
def test_one_failed_measure_fails_the_whole_and_a_warning_does_not(name):
    measure = MEASURES[name]
    assert GOOD.verdict == "pass"
    if np.isfinite(measure.fails):
        assert with_value(name, measure.fails).verdict == "fail"
        assert not with_value(name, measure.fails).passed
    between = (measure.passes + min(measure.fails, 100)) / 2
    assert with_value(name, between).verdict == "warn"
    assert with_value(name, between).passed


def test_a_missing_measure_is_named_and_decides_nothing():
    found = with_value("connected_regions", None)
    assert (found.verdict, found.not_measured) == ("pass", ("connected_regions",))
    assert "not measured, since the skeleton has no vertex map: connected regions" in str(found)


def test_each_missing_measure_is_told_with_its_own_cause():
    without = {"connected_regions": None, "adjacent_regions": None, "extra_cycles": None, "tunnels_missed": None}
    told = [line for line in str(replace(GOOD, **without)).splitlines() if line.startswith("not measured")]
    assert told == [
        "not measured, since edges of the mesh have more than two faces: extra cycles",
        "not measured, since the mesh, or the skeleton, is in pieces, open, non-manifold or intersects itself: "
        "tunnels missed",
        "not measured, since the skeleton has no vertex map: connected regions, adjacent regions",
    ]


def test_the_table_shows_value_verdict_and_thresholds():
    rows = str(with_value("coverage", 0.25)).splitlines()
    [row] = [row for row in rows if row.startswith("coverage")]
    assert row.split()[:6] == ["coverage", "0.250", "fail", ">=", "0.9", "<="]
    assert rows[-1] == "verdict: fail; the shape has 2 extremities"


def test_every_measure_is_a_field_of_the_score():
    assert set(MEASURES) == {field.name for field in fields(Score)} - {"extremities"}
