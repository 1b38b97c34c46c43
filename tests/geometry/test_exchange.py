"""Meshes and clouds as objects of other packages, with the vertices in their order."""

import sys

import numpy as np
import pytest

import lbskel
from lbskel import Mesh, MissingDependency, PointCloud


def test_trimesh_has_the_same_mesh_of_its_own(rod):
    converted = rod.to_trimesh()
    assert converted.volume == pytest.approx(rod.volume)
    assert np.array_equal(lbskel.as_mesh(converted).vertices, rod.vertices)
    assert np.array_equal(lbskel.as_mesh(converted).faces, rod.faces)
    converted.vertices[0] += 1  # a copy, which may be changed
    assert np.array_equal(PointCloud(rod.vertices).to_trimesh().vertices, rod.vertices)


def test_vertices_without_a_face_and_double_ones_are_kept():
    mesh = Mesh([[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0]], [[1, 2, 3], [4, 3, 2]])
    assert np.array_equal(mesh.to_trimesh().faces, mesh.faces)
    assert len(mesh.to_trimesh().vertices) == 5


def test_pyvista_has_the_same_mesh(rod):
    pytest.importorskip("pyvista", reason="pip install pyvista")
    converted = rod.to_pyvista()
    assert converted.volume == pytest.approx(rod.volume)
    assert np.array_equal(lbskel.as_mesh(converted).faces, rod.faces)
    cloud = PointCloud(rod.vertices).to_pyvista()
    assert np.array_equal(cloud.points, rod.vertices)
    assert cloud.n_cells == len(rod.vertices)


@pytest.mark.parametrize("value_of", [lambda mesh: mesh, lambda mesh: PointCloud(mesh.vertices)])
def test_a_missing_pyvista_is_reported(rod, monkeypatch, value_of):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(MissingDependency, match=r"pip install 'lbskel\[pyvista\]'"):
        value_of(rod).to_pyvista()
