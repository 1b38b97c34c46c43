"""Simplification for display."""

import numpy as np
import pytest
from helpers import joined, moved

from lbskel import Mesh
from lbskel.shapes import sphere, torus
from lbskel.visualization.cell_merging import merged_by_cells


def test_cells_keep_a_surface_near_and_below_the_bound():
    mesh = torus(1.0, 0.3, 200, 80)
    kept, faces, rows = merged_by_cells(mesh.vertices, mesh.faces, 3000)
    assert 1000 < len(faces) <= 3000
    assert len(rows) == len(faces)
    assert faces.max() == len(kept) - 1
    V = mesh.vertices[kept]
    tube = np.hypot(np.hypot(V[:, 0], V[:, 1]) - 1.0, V[:, 2])
    np.testing.assert_allclose(tube, 0.3, atol=1e-9)  # vertices are vertices of the mesh
    original = mesh.vertices[mesh.faces[rows]].mean(axis=1)
    assert np.linalg.norm(V[faces].mean(axis=1) - original, axis=1).max() < 2.6 / np.sqrt(3000) * 2
    area = Mesh(V, faces).area
    assert area == pytest.approx(mesh.area, rel=0.1)


@pytest.mark.parametrize("first", [0, 1])
def test_an_unused_vertex_far_away_changes_nothing(first):
    mesh = torus(1.0, 0.3, 80, 40)
    far = np.array([[1e16, 0, 0]])
    vertices = np.concatenate([far, mesh.vertices] if first else [mesh.vertices, far])
    found = merged_by_cells(vertices, mesh.faces + first, 1000)
    kept, faces, rows = merged_by_cells(mesh.vertices, mesh.faces, 1000)
    for one, other in zip(found, (kept + first, faces, rows), strict=True):
        assert np.array_equal(one, other)


def test_a_surface_below_the_bound_is_kept():
    mesh = torus(1.0, 0.3, 16, 8)
    kept, faces, rows = merged_by_cells(mesh.vertices, mesh.faces, len(mesh.faces))
    assert np.array_equal(faces, mesh.faces)
    assert np.array_equal(kept, np.arange(len(mesh.vertices)))
    assert np.array_equal(rows, np.arange(len(mesh.faces)))


def test_parts_that_are_small_beside_the_whole_and_faces_without_area_leave_some_faces():
    ball = sphere(4)
    far = joined(ball, moved(ball, 500.0))
    n = np.arange(5000)
    flat = np.stack([np.append(n, 5000), np.sin(np.append(n, 5000)), np.zeros(5001)], axis=1)
    for vertices, given in ((far.vertices, far.faces), (flat, np.stack([n, n + 1, n + 1], axis=1))):
        kept, faces, rows = merged_by_cells(vertices, given, 1000)
        assert len(faces) == 1000
        assert np.array_equal(kept[faces], given[rows])
        assert (rows[0], rows[-1]) == (0, len(given) - 1)
