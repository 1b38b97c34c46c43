"""Volumes kept by an offset: of several components, with fixed vertices, and where none is defined."""

import numpy as np
import pytest
from helpers import box_mesh, joined, moved, with_reversed_faces, without_faces

from lbskel import SolveError
from lbskel.applications.volume import has_volume, keep_volumes
from lbskel.shapes import sphere


def volumes(mesh, X):
    A, B, C = X[mesh.faces].transpose(1, 0, 2)
    signed = np.einsum("mx,mx->m", A, np.cross(B, C)) / 6
    return np.bincount(mesh.component_of_vertex[mesh.faces[:, 0]], signed)


def test_each_component_gets_its_volume_and_fixed_vertices_stay():
    mesh = joined(sphere(2), moved(box_mesh((1, 2, 1)), 3.0))
    is_fixed = np.zeros(len(mesh.vertices), dtype=bool)
    is_fixed[:20] = True
    shrunk = mesh.vertices * 0.9
    result = keep_volumes(mesh.vertices, shrunk, mesh, is_fixed)
    assert volumes(mesh, result) == pytest.approx(volumes(mesh, mesh.vertices), rel=1e-10)
    assert (result[:20] == shrunk[:20]).all()


@pytest.mark.parametrize("radius", [1e-3, 1e-6])
def test_a_small_component_far_from_the_origin_gets_its_volume(radius):
    ball = sphere(2)
    mesh = joined(ball, ball.with_vertices(radius * ball.vertices + [1.5, 0.3, 0.2]))
    center = np.repeat([[0.0, 0, 0], [1.5, 0.3, 0.2]], 162, axis=0)
    shrunk = center + 0.9 * (mesh.vertices - center)
    result = keep_volumes(mesh.vertices, shrunk, mesh, np.zeros(324, dtype=bool))
    ratios = volumes(mesh, result - center) / volumes(mesh, mesh.vertices - center)
    assert ratios == pytest.approx(1.0, abs=1e-9)  # coordinates of 1.5 are rounded by 1e-16


def test_components_that_have_shrunk_too_far_are_named():
    mesh = joined(sphere(2), moved(sphere(1), 3.0), moved(sphere(1), 6.0))
    shrunk = mesh.vertices.copy()
    shrunk[162:204] = [3.0, 0, 0] + 1e-6 * (shrunk[162:204] - [3.0, 0, 0]) * [1, -1, 1]
    with pytest.raises(SolveError, match="with the vertices 162, which have shrunk"):
        keep_volumes(mesh.vertices, shrunk, mesh, np.zeros(len(shrunk), dtype=bool))


def test_a_sphere_is_rescaled():
    ball = sphere(2)
    result = keep_volumes(ball.vertices, 0.9 * ball.vertices, ball, np.zeros(162, dtype=bool))
    assert result == pytest.approx(ball.vertices, abs=4e-3)  # normals of the polyhedron are radial up to 0.03


def test_a_surface_shrunk_to_a_point_is_refused_or_left():
    ball = sphere(1)
    free = np.zeros(42, dtype=bool)
    flat = ball.vertices * [1, 1, 0]
    with pytest.raises(SolveError, match="no offset"):
        keep_volumes(1e3 * ball.vertices, 1e-3 * ball.vertices * [1, -1, 1] + 0.1 * flat, ball, free)
    assert (keep_volumes(ball.vertices, 0 * ball.vertices, ball, free) == 0).all()


def test_a_volume_needs_orientation_and_a_fixed_boundary(ring):
    free = np.zeros(128, dtype=bool)
    assert has_volume(ring, free)
    assert not has_volume(with_reversed_faces(ring, [0]), free)
    opened = without_faces(ring, [0])
    assert not has_volume(opened, free)
    free[opened.edges[opened.faces_per_edge == 1]] = True
    assert has_volume(opened, free)
