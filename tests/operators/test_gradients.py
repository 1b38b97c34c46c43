"""Gradients on triangles of given lengths: linear functions, the stiffness as their divergence, faces without area."""

import igl
import numpy as np
from scipy.sparse import diags_array

from lbskel import laplacian
from lbskel.operators.gradients import gradient_matrix, unit_gradients
from lbskel.shapes import sphere, torus


def test_the_gradient_of_a_linear_function_has_the_length_of_its_slope_in_the_plane_of_the_face():
    mesh, slope = sphere(2), np.array([1.0, -2.0, 0.5])
    G, areas = gradient_matrix(mesh.faces, igl.edge_lengths(mesh.vertices, mesh.faces), len(mesh.vertices))
    found = np.hypot(*(G @ (mesh.vertices @ slope)).reshape(2, -1))
    tangential = slope - (mesh.face_normals @ slope)[:, None] * mesh.face_normals
    assert np.abs(found - np.linalg.norm(tangential, axis=1)).max() < 1e-12
    assert np.abs(areas - mesh.face_areas).max() < 1e-14


def test_divergence_of_the_gradient_is_the_cotangent_stiffness():
    mesh = torus(1.0, 0.4, 20, 11)
    G, areas = gradient_matrix(mesh.faces, igl.edge_lengths(mesh.vertices, mesh.faces), len(mesh.vertices))
    S = G.T @ diags_array(np.tile(areas, 2)) @ G
    assert abs(S - laplacian(mesh, operator="cotangent").stiffness).max() < 1e-12


def test_faces_without_area_have_no_gradient():
    lengths = np.array([[1.0, 1.0, 2.0], [0.0, 1.0, 1.0], [0.0, 0.0, 0.0], [3.0, 4.0, 5.0]])
    G, areas = gradient_matrix(np.tile([0, 1, 2], (4, 1)), lengths, 3)
    assert areas.tolist() == [0, 0, 0, 6]
    assert np.isfinite(G.data).all()
    assert np.abs(G @ [1.0, 2.0, 3.0]).reshape(2, 4)[:, :3].max() == 0


def test_unit_gradients_have_length_one_or_zero_also_of_tiny_values():
    lengths = np.array([[5.0, 4.0, 3.0], [0.0, 1.0, 1.0]])
    G, _ = gradient_matrix(np.tile([0, 1, 2], (2, 1)), lengths, 3)
    x, y = unit_gradients(G, np.array([0.0, 3e-300, 4e-300])).reshape(2, -1)  # slopes 1 along both legs
    assert np.allclose([x[0], y[0]], np.sqrt(0.5), rtol=1e-12)
    assert x[1] == y[1] == 0
    assert (unit_gradients(G, np.zeros(3)) == 0).all()
