"""Polygons of a file as a mesh: validated, triangulated, notes kept."""

import numpy as np
import pytest

from lbskel.errors import MeshError
from lbskel.io.polygon_soup import PolygonSoup, mesh_from_polygons

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9.0]])


def soup(*polygons, **options):
    corners = np.array([corner for polygon in polygons for corner in polygon], dtype=np.int64)
    return PolygonSoup(POINTS, corners, np.array([len(polygon) for polygon in polygons]), **options)


def test_triangles_are_taken_as_they_are():
    mesh = mesh_from_polygons(soup([0, 1, 2], [0, 2, 3], notes=("made by hand",)))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(mesh.vertices, POINTS)
    assert mesh.notes == ("made by hand",)
    assert mesh.polygon_of_face is None


@pytest.mark.parametrize(
    ("polygons", "faces", "polygon_of_face"),
    [
        ([[0, 1, 2, 3]], [[0, 1, 2], [0, 2, 3]], [0, 0]),
        ([[4, 1, 2], [0, 1, 2, 3]], [[4, 1, 2], [0, 1, 2], [0, 2, 3]], [0, 1, 1]),
    ],
)
def test_polygons_are_triangulated_and_notes_kept(polygons, faces, polygon_of_face):
    mesh = mesh_from_polygons(soup(*polygons, notes=("made by hand",)))
    np.testing.assert_array_equal(mesh.faces, faces)
    np.testing.assert_array_equal(mesh.polygon_of_face, polygon_of_face)
    assert mesh.notes == ("made by hand", "1 polygon was cut into triangles")


@pytest.mark.parametrize("first_index", [0, 1])
def test_missing_vertices_are_named_in_the_numbering_of_the_file(first_index):
    message = rf"faces 1, 2 \(0-based\) use vertices .*5 vertices, numbered {first_index} to {4 + first_index}$"
    with pytest.raises(MeshError, match=message):
        mesh_from_polygons(soup([0, 1, 2], [0, 1, 5], [0, 1, 2, -1], first_index=first_index))


def test_polygons_of_two_corners_are_an_error():
    with pytest.raises(MeshError, match=r"faces 1 \(0-based\) have fewer than three corners"):
        mesh_from_polygons(soup([0, 1, 2], [0, 1]))


def test_a_soup_without_faces_is_an_error_of_the_mesh():
    with pytest.raises(MeshError, match="no faces"):
        mesh_from_polygons(PolygonSoup(POINTS))
