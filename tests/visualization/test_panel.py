"""The content of a panel: what is refused, and the points that must be visible."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import flat_tube, planar_fork

from lbskel import Mesh, MeshError, PointCloud
from lbskel.visualization import Panel


def test_panels_without_content_or_with_wrong_fields_are_refused():
    with pytest.raises(MeshError, match="needs a mesh"):
        Panel(title="nothing")
    with pytest.raises(MeshError, match=r"one number for each vertex of a mesh, shape \(578,\), not \(3,\)"):
        Panel(flat_tube(), field=[1, 2, 3])
    with pytest.raises(MeshError, match="one number for each vertex"):
        Panel(PointCloud([[0, 0, 0]]), field=[1])


def test_a_field_is_copied_read_only_with_nan_for_infinity():
    values = np.arange(578.0)
    values[3] = np.inf
    panel = Panel(flat_tube(), field=values)
    assert np.isnan(panel.field[3])
    assert values[3] == np.inf
    with pytest.raises(ValueError, match="read-only"):
        panel.field[0] = 1.0


def test_the_direction_of_view_is_that_of_the_mesh_if_there_is_one():
    mesh, skeleton = flat_tube(), planar_fork()
    assert Panel(mesh, skeleton).subject is mesh
    assert Panel(None, skeleton).subject is skeleton


def test_vertices_without_faces_need_not_be_visible_but_nodes_and_points_must():
    mesh = flat_tube()
    stray = Mesh(np.concatenate([mesh.vertices, [[99.0, 0, 0]]]), mesh.faces)
    np.testing.assert_array_equal(Panel(stray).points, mesh.vertices)
    skeleton = planar_fork()
    np.testing.assert_array_equal(Panel(mesh, skeleton).points, np.concatenate([skeleton.nodes, mesh.vertices]))
    cloud = PointCloud(mesh.vertices)
    np.testing.assert_array_equal(Panel(cloud).points, mesh.vertices)
