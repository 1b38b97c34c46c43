"""Arrays of the mesh objects of other packages, and triangulation of polygons."""

from types import SimpleNamespace

import numpy as np
import pytest

from lbskel import MeshError
from lbskel.geometry.conversion import arrays_of, triangulate


@pytest.mark.parametrize(
    "data",
    [
        ("points", "faces"),
        ["points", "faces"],
        SimpleNamespace(vertices="points", faces="faces"),
        SimpleNamespace(points="points", cells_dict={"line": "lines", "triangle": "faces"}),
    ],
    ids=["tuple", "list", "trimesh", "meshio"],
)
def test_arrays_are_taken_as_they_are(data):
    assert arrays_of(data) == ("points", "faces")


def test_blocks_of_triangles_and_quads_are_concatenated():
    data = SimpleNamespace(points="points", cells_dict={"quad": [[3, 4, 5, 6]], "triangle": [[0, 1, 2]]})
    assert arrays_of(data) == ("points", [[0, 1, 2], [3, 4, 5, 6]])


def test_the_flat_list_of_pyvista_is_split():
    _, faces = arrays_of(SimpleNamespace(points="points", faces=np.array([3, 0, 1, 2, 4, 3, 4, 5, 6])))
    assert [face.tolist() for face in faces] == [[0, 1, 2], [3, 4, 5, 6]]


@pytest.mark.parametrize("data", [None, 3, ("points",), ("points", "faces", "more"), SimpleNamespace(vertices=1)])
def test_other_objects_are_rejected(data):
    with pytest.raises(MeshError, match="cannot take a mesh from"):
        arrays_of(data)


def test_polygons_become_fans_and_keep_their_numbers():
    triangles, polygon = triangulate([[5, 6, 7], [0, 1, 2, 3, 4]])
    assert triangles.tolist() == [[5, 6, 7], [0, 1, 2], [0, 2, 3], [0, 3, 4]]
    assert polygon.tolist() == [0, 1, 1, 1]


def test_padded_rows_end_at_minus_one():
    triangles, polygon = triangulate([[0, 1, 2, -1], [0, 1, 2, 3]])
    assert triangles.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3]]
    assert polygon.tolist() == [0, 1, 1]


def test_polygons_of_two_corners_are_named():
    with pytest.raises(MeshError, match="faces 1 have fewer than three corners"):
        triangulate([[0, 1, 2], [0, 1]])
