"""Cleaning of clouds: the maps, the counts, what is refused."""

import numpy as np
import pytest

from lbskel import MeshError, UnknownChoice
from lbskel.preprocess import point_cleaning
from lbskel.preprocess.point_cleaning import clean_points
from lbskel.shapes import sphere

SPHERE = sphere(4).vertices


def test_duplicates_are_merged_and_mapped():
    cleaned = clean_points(np.concatenate([SPHERE, SPHERE[:5]]))
    assert cleaned.report == {
        "points": len(SPHERE) + 5,
        "duplicates": 5,
        "outliers": 0,
        "kept": len(SPHERE),
    }
    np.testing.assert_array_equal(cleaned.points[cleaned.vertex_map.indices[-5:]], SPHERE[:5])
    assert cleaned.notes == ("5 duplicate points were merged",)


@pytest.mark.parametrize(("preparation", "n_outliers"), [("auto", 3), ("scan", 3), ("none", 0)])
def test_outliers_are_left_out_unless_nothing_is_asked_for(preparation, n_outliers):
    far = np.array([[2.0, 0, 0], [0, 0, 3], [2.1, 0, 0]])
    cleaned = clean_points(np.concatenate([SPHERE, far]), preparation)
    assert cleaned.report["outliers"] == n_outliers
    assert (~cleaned.vertex_map.is_mapped).sum() == n_outliers
    assert cleaned.vertex_map.is_mapped[:-3].all()


@pytest.mark.parametrize("distance", [1e4, 1e9, 1e12])
def test_one_stray_point_is_an_outlier_however_far_it_is(distance):
    """From 1e9 away, all other points lie on a line with it."""
    cleaned = clean_points(np.concatenate([SPHERE, [[distance, 0, 0]]]))
    assert cleaned.report["outliers"] == 1
    assert cleaned.vertex_map.is_mapped[:-1].all()


def test_a_cloud_of_a_tiny_unit_is_measured():
    assert clean_points(1e-200 * SPHERE).report["kept"] == len(SPHERE)


def test_density_that_falls_gradually_makes_no_outliers():
    rng = np.random.default_rng(2)
    z = 2 * rng.random(9000) ** 2 - 1  # 1 to 20 in density from one pole to the other
    angle, r = rng.uniform(0, 2 * np.pi, 9000), np.sqrt(1 - z**2)
    cleaned = clean_points(np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1))
    assert cleaned.report["outliers"] == 0


def test_a_large_cloud_is_thinned_to_means_of_its_cells(monkeypatch):
    monkeypatch.setattr(point_cleaning, "FEWEST", 500)
    cleaned = clean_points(SPHERE)
    assert 400 < cleaned.report["kept"] <= 500
    moved = np.linalg.norm(cleaned.points[cleaned.vertex_map.indices] - SPHERE, axis=1)
    assert moved.max() < np.sqrt(3) * cleaned.report["cell"]
    means = np.zeros_like(cleaned.points)
    np.add.at(means, cleaned.vertex_map.indices, SPHERE)
    count = np.bincount(cleaned.vertex_map.indices)[:, None]
    assert cleaned.points == pytest.approx(means / count)


def test_without_preparation_a_large_cloud_keeps_all_points(monkeypatch):
    monkeypatch.setattr(point_cleaning, "FEWEST", 500)
    [note] = clean_points(SPHERE, "auto").notes
    assert "was thinned to" in note
    assert "none keeps all points" in note
    kept = clean_points(SPHERE, "none")
    assert (len(kept.points), kept.notes) == (len(SPHERE), ())


@pytest.mark.parametrize("stray", [[1e9, 0, 0], [-3e9, 1e8, 0]])
def test_a_stray_point_does_not_make_the_cells_of_a_large_cloud_larger(monkeypatch, stray):
    """It was left with two points: itself, and the mean of all others."""
    monkeypatch.setattr(point_cleaning, "FEWEST", 500)
    cleaned = clean_points(np.concatenate([SPHERE, [stray]]))
    assert (cleaned.vertex_map.indices < 0).nonzero()[0].tolist() == [len(SPHERE)]
    assert 400 < cleaned.report["kept"] <= 500
    assert np.abs(np.linalg.norm(cleaned.points, axis=1) - 1).max() < 0.05


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (SPHERE[:9], "has 9 distinct points among 9, and needs 20"),
        (np.repeat(SPHERE[:9], 9, axis=0), "has 9 distinct points among 81.*double precision"),
        (SPHERE * [1, 1, 0] + [0, 0, 5], "in a plane"),
        (np.arange(99)[:, None] * [1.0, 2, 3], "on a line"),
    ],
)
def test_points_that_enclose_nothing_are_refused(points, message):
    with pytest.raises(MeshError, match=message):
        clean_points(points)


def test_an_unknown_preparation_names_the_known_ones():
    with pytest.raises(UnknownChoice, match="auto, scan, none"):
        clean_points(SPHERE, "cad")


def test_neighbors_of_the_given_points():
    points = np.random.default_rng(3).normal(size=(200, 3))
    expected = np.argsort(np.linalg.norm(points[:, None] - points, axis=2), axis=1)[:, :6]
    np.testing.assert_array_equal(clean_points(points, "none").source_neighbors(6), expected)
    assert clean_points(np.concatenate([points, points[:1]]), "none").source_neighbors(6) is None
    assert clean_points(np.concatenate([points, [[90.0, 0, 0]]])).source_neighbors(6) is None
