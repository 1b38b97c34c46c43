"""Scenes of trimesh: all instances with their transforms, in the order of the file."""

import numpy as np
import pytest

from lbskel.errors import FormatError
from lbskel.io.polygon_soup import mesh_from_polygons
from lbskel.io.scenes import polygons_from_scene

trimesh = pytest.importorskip("trimesh")


def test_every_instance_is_included_with_its_transform(tetrahedron):
    scene = trimesh.Scene()
    geometry = trimesh.Trimesh(tetrahedron.vertices, tetrahedron.faces, process=False)
    for x in (0, 5, 10):
        scene.add_geometry(
            geometry, geom_name="shared", transform=trimesh.transformations.translation_matrix([x, 0, 0])
        )
    mesh = mesh_from_polygons(polygons_from_scene(scene))
    assert mesh.n_components == 3
    assert mesh.volume == pytest.approx(3 * tetrahedron.volume, rel=1e-12)
    assert mesh.vertices[:, 0].max() == 11
    assert mesh.notes == ("3 meshes of the scene were joined into one",)


def test_the_order_is_that_of_the_geometries(tetrahedron):
    scene = trimesh.Scene()
    for name, scale in (("z", 1.0), ("a", 2.0), ("m", 3.0)):
        scene.add_geometry(
            trimesh.Trimesh(scale * tetrahedron.vertices, tetrahedron.faces, process=False), geom_name=name
        )
    points = polygons_from_scene(scene).points
    np.testing.assert_array_equal(points.reshape(3, 4, 3).max(axis=(1, 2)), [1, 2, 3])


def test_a_scene_without_triangles_is_an_error():
    with pytest.raises(FormatError, match="no triangles"):
        polygons_from_scene(trimesh.Scene([trimesh.points.PointCloud([[0, 0, 0]])]))


@pytest.mark.parametrize("index", [-1, 4])
def test_an_index_outside_of_its_mesh_is_an_error(tetrahedron, index):
    faces = tetrahedron.faces.copy()
    faces[0, 0] = index
    scene = trimesh.Scene([trimesh.Trimesh(tetrahedron.vertices, faces, process=False)])
    with pytest.raises(FormatError, match=r"vertex indices outside 0\.\.3"):
        polygons_from_scene(scene)
