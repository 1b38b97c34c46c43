"""Arrays of the mesh objects of other packages, and triangulation of polygons."""

from types import SimpleNamespace

import numpy as np
import pytest

from lbskel import MeshError, as_mesh
from lbskel.geometry.conversion import arrays_of, triangulate


@pytest.mark.parametrize(
    "data",
    [
        ("points", "faces"),
        ["points", "faces"],
        SimpleNamespace(vertices="points", faces="faces"),
    ],
    ids=["tuple", "list", "trimesh"],
)
def test_arrays_are_taken_as_they_are(data):
    assert arrays_of(data) == ("points", "faces")


def test_blocks_of_faces_are_concatenated():
    cells = {"quad": [[3, 4, 5, 6]], "line": [[7, 8]], "triangle": [[0, 1, 2]], "polygon5": [[0, 1, 2, 3, 4]]}
    data = SimpleNamespace(points="points", cells_dict={kind: np.array(rows) for kind, rows in cells.items()})
    faces = arrays_of(data)[1]
    assert [face.tolist() for face in faces] == [[3, 4, 5, 6], [0, 1, 2], [0, 1, 2, 3, 4]]


@pytest.mark.parametrize(("kind", "n_corners"), [("triangle6", 3), ("quad9", 4), (5, 3), (9, 4)])
def test_faces_have_their_corners_alone(kind, n_corners):
    """Curved faces have nodes on their sides too; 5 and 9 are the numbers of VTK."""
    data = SimpleNamespace(points="points", cells_dict={10: np.arange(4)[None], kind: np.arange(9)[None]})
    assert np.array_equal(arrays_of(data)[1], [range(n_corners)])


def test_strips_of_pyvista_are_faces():
    pyvista = pytest.importorskip("pyvista", reason="pip install pyvista")
    ball = pyvista.Sphere()
    both = ball.append_polydata(ball.translate((3, 0, 0)).strip())
    assert both.n_strips > 0
    assert len(as_mesh(both).faces) == 2 * ball.n_cells
    assert len(as_mesh(ball.cast_to_unstructured_grid()).faces) == ball.n_cells


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
