"""Simplification for display."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.shapes import torus
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


def test_a_surface_below_the_bound_is_kept():
    mesh = torus(1.0, 0.3, 16, 8)
    kept, faces, rows = merged_by_cells(mesh.vertices, mesh.faces, len(mesh.faces))
    assert np.array_equal(faces, mesh.faces)
    assert np.array_equal(kept, np.arange(len(mesh.vertices)))
    assert np.array_equal(rows, np.arange(len(mesh.faces)))
