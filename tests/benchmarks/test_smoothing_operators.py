"""The measures of smoothing: noise of a known size, distances, and meshes whose smoothing is known."""

import numpy as np
import pytest

from benchmarks.applications_smoothing import _within
from benchmarks.smoothing_operators import NOISE, _cases, _irregular_plane, distance, irregular_sphere, noisy_copy
from lbskel.shapes import flat_grid, sphere


def test_noise_has_its_size_and_distances_are_in_edge_lengths():
    ball = sphere(4)
    assert distance(noisy_copy(ball).vertices, ball) == pytest.approx(NOISE, rel=0.1)
    plane = flat_grid(9, 9)
    assert distance(plane.vertices + [0, 0, 0.3], plane) == pytest.approx(0.3 / plane.edge_lengths.mean())


def test_irregular_meshes_are_a_sphere_and_a_square_of_the_same_boundary():
    assert np.linalg.norm(irregular_sphere(2).vertices, axis=1) == pytest.approx(1)
    flat = _irregular_plane()
    assert (flat.face_areas > 0).all()
    assert flat.area == pytest.approx(1)


def test_cotangents_do_not_drift_and_graph_weights_do():
    drift = _cases(())["drift"]
    assert drift("cotangent") < 1e-12
    assert drift("graph") > 0.01


def test_the_best_setting_within_a_time_is_one_for_all_shapes():
    def row(shape, tool, setting, seconds, error):
        return {"shape": shape, "tool": tool, "setting": setting, "seconds": seconds, "error": error}

    rows = [
        *(row(shape, "lbskel", "slow", 0.04, 0.1) for shape in "ab"),
        *(row(shape, "lbskel", "fast", 0.01, 0.3) for shape in "ab"),
        *(row(shape, "other", "", seconds, 0.2) for shape, seconds in (("a", 0.005), ("b", 0.03))),
        row("a", "other", "fails on b", 0.01, 0.01),
    ]
    beside, faster = _within(rows)
    assert (beside["others"], beside["seconds"], beside["error"]) == (
        "other",
        pytest.approx(0.0175),
        pytest.approx(0.2),
    )
    assert (beside["lbskel"], beside["lbskel: error"]) == ("lbskel, fast", pytest.approx(0.3))
    assert (faster["others"], faster["lbskel"], faster["lbskel: error"]) == ("none", "lbskel, slow", pytest.approx(0.1))
