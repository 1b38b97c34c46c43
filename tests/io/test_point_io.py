"""Point clouds in their formats, and what is a mesh and what a cloud."""

from types import SimpleNamespace

import numpy as np
import pytest

from lbskel import FormatError, Mesh, MeshError, PointCloud, read_points
from lbskel.io import POINT_READERS, as_shape

POINTS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]]
ROWS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n9 9 9\n"
PLY = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
FACE = "element face 1\nproperty list uchar int vertex_indices\n"
OBJ = "".join(f"v {row}\n" for row in ROWS.splitlines())


@pytest.mark.parametrize(
    ("name", "content", "is_mesh"),
    [
        ("a.xyz", ROWS, False),
        ("a.txt", ROWS, False),
        ("a.csv", "x,y,z\n" + ROWS.replace(" ", ","), False),
        ("a.off", "OFF\n5 0 0\n" + ROWS, False),
        ("a.off", "NOFF\n5 0\n" + ROWS.replace("\n", "\t0 0 1\n"), False),
        ("a.off", "OFF\n5 1 0\n" + ROWS + "4 0 1 2 3\n", True),
        ("a.ply", PLY + "end_header\n" + ROWS, False),
        ("a.ply", PLY + FACE + "end_header\n" + ROWS + "4 0 1 2 3\n", True),
        ("a.obj", OBJ, False),
        ("a.obj", OBJ + "f 1 2 3\n", True),
    ],
)
def test_points_with_and_without_faces(read, name, content, is_mesh):
    cloud = read(name, content, read_points)
    assert isinstance(cloud, PointCloud)
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert isinstance(read(name, content, as_shape), Mesh if is_mesh else PointCloud)


def test_arrays_and_objects_of_points():
    points = np.array(POINTS, dtype=np.float64)
    for given in (points, SimpleNamespace(points=POINTS), SimpleNamespace(vertices=points)):
        np.testing.assert_array_equal(as_shape(given).points, points)
    assert as_shape((points, [[0, 1, 2]])).faces.tolist() == [[0, 1, 2]]
    cloud = PointCloud(points)
    assert as_shape(cloud) is cloud


def test_what_is_neither():
    with pytest.raises(MeshError, match="cannot take a mesh from dict"):
        as_shape({})


def test_the_extensions_of_point_clouds(tmp_path):
    assert {"xyz", "txt", "csv", "ply", "off", "obj", "npy", "npz", "pcd", "las", "laz"} == set(POINT_READERS)
    with pytest.raises(FormatError, match="unknown extension 'stl'; known for point clouds: xyz"):
        read_points(tmp_path / "a.stl")
    with pytest.raises(FormatError, match="no such file"):
        as_shape(tmp_path / "a.ply")


def test_an_stl_without_faces_is_a_broken_mesh_and_no_cloud(read):
    with pytest.raises((FormatError, MeshError)):
        read("a.stl", "solid a\nendsolid a\n", as_shape)


def test_a_cloud_of_pyvista_is_a_cloud():
    pyvista = pytest.importorskip("pyvista", reason="pip install pyvista")
    for given in (pyvista.PolyData(np.array(POINTS, dtype=float)), PointCloud(POINTS).to_pyvista()):
        np.testing.assert_array_equal(as_shape(given).points, POINTS)
    assert isinstance(as_shape(pyvista.Sphere()), Mesh)
