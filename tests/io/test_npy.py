"""NPY and NPZ files of points."""

import io

import numpy as np
import pytest

from lbskel import FormatError, read_points

POINTS = np.arange(12.0).reshape(4, 3) / 7


def bytes_of(save, *arrays, **named):
    data = io.BytesIO()
    save(data, *arrays, **named)
    return data.getvalue()


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.npy", bytes_of(np.save, POINTS)),
        ("a.npy", bytes_of(np.save, np.column_stack([POINTS, np.ones(4)]))),
        ("a.npz", bytes_of(np.savez, POINTS)),
        ("a.npz", bytes_of(np.savez, points=POINTS, colors=np.zeros(4))),
    ],
    ids=range(4),
)
def test_points_are_read_exactly(read, name, content):
    np.testing.assert_array_equal(read(name, content, read_points).points, POINTS)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.npy", b"no array", "not a file of numpy arrays"),
        ("a.npy", bytes_of(np.save, POINTS)[:100], "not a file of numpy arrays"),
        ("a.npz", bytes_of(np.savez, POINTS)[:100], "not a zip file"),
        ("a.npy", bytes_of(np.save, POINTS[:, :2]), r"shape \(4, 2\)"),
        ("a.npy", bytes_of(np.save, np.array([["a", "b", "c"]])), "array of numbers"),
        ("a.npy", bytes_of(np.savez, POINTS), "name it .npz"),
        ("a.npz", bytes_of(np.save, POINTS), "name it .npy"),
        ("a.npz", bytes_of(np.savez, a=POINTS, b=POINTS), "no array 'points' but a, b"),
        ("a.npz", bytes_of(np.savez, np.array([None], dtype=object)), "cannot be read"),
    ],
    ids=range(9),
)
def test_errors_say_what_to_do(rejects, name, content, message):
    rejects(name, content, FormatError, message, read_points)


def test_a_file_that_is_not_there_is_named_as_in_other_formats(tmp_path):
    with pytest.raises(FormatError, match=r"nowhere\.npy: no such file"):
        read_points(tmp_path / "nowhere.npy")
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(FormatError, match="is a folder, not a file"):
        read_points(tmp_path / "folder.npz")
