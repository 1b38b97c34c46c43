"""Validation of coordinates and indices, and read-only arrays."""

import numpy as np
import pytest

from lbskel import MeshError
from lbskel.geometry.arrays import checked_points, checked_triangles, finite_numbers, read_only, to_builtin


def test_points_are_copied_to_read_only_doubles():
    given = np.asfortranarray(np.arange(6, dtype=np.float32).reshape(2, 3))
    points = checked_points(given, "points")
    given[:] = 9
    assert points.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert points.dtype == np.float64
    assert points.flags.c_contiguous
    assert not points.flags.writeable


def test_points_that_are_not_finite_are_named():
    with pytest.raises(MeshError, match=r"anchors 1 have NaN or infinite coordinates"):
        checked_points([[0, 0, 0], [0, np.inf, 0]], "anchors")


def test_numbers_of_any_shape_are_finite():
    assert finite_numbers([[1, 2]], "values").tolist() == [[1.0, 2.0]]
    for wrong, message in (
        (["a"], "values must be an array of numbers"),
        ([[1], [2, 3]], "values must be an array of numbers"),
        ([1, np.inf], "values must be finite numbers"),
        ([1 + 2j], "values must be real numbers, not complex ones"),
    ):
        with pytest.raises(MeshError, match=message):
            finite_numbers(wrong, "values")


def test_triangles_are_copied_to_read_only_integers():
    given = np.array([[0, 1, 2.0]])
    triangles = checked_triangles(given, 3)
    given[:] = 0
    assert triangles.tolist() == [[0, 1, 2]]
    assert triangles.dtype == np.int64
    assert not triangles.flags.writeable


@pytest.mark.parametrize("index", [-1, 3])
def test_indices_must_be_those_of_vertices(index):
    with pytest.raises(MeshError, match=r"faces 1 use a vertex index outside 0\.\.2"):
        checked_triangles([[0, 1, 2], [0, 1, index]], 3)


def test_rows_of_different_lengths_are_no_triangles():
    with pytest.raises(MeshError, match=r"shape \(m, 3\), not rows of different lengths; as_mesh"):
        checked_triangles([[0, 1, 2], [0, 1]], 3)


def test_read_only_returns_the_same_array():
    array = np.zeros(3)
    assert read_only(array) is array
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 1


def test_complex_coordinates_are_refused():
    with pytest.raises(MeshError, match="vertices must be real numbers, not complex ones"):
        checked_points(1j * np.eye(3), "vertices")


def test_values_for_json_are_of_python_and_finite():
    given = {"a": np.array([[1, 2]]), 3: (np.float32(0.5), np.inf, [np.nan]), "b": np.bool_(True), "c": "text"}
    assert to_builtin(given) == {"a": [[1, 2]], "3": [0.5, None, [None]], "b": True, "c": "text"}
