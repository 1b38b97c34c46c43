"""The caller's mesh, oriented outwards and connected: numbers, volume, and what keeps its own vertices."""

import numpy as np
import pytest
from helpers import joined, triangle_soup, with_reversed_faces, without_faces

from lbskel import Mesh
from lbskel.preprocess.outward_faces import oriented_surface


def test_a_mesh_that_faces_outwards_is_returned_unchanged(ring):
    surface, representative = oriented_surface(ring)
    assert surface is ring
    assert representative.tolist() == list(range(len(ring.vertices)))


@pytest.mark.parametrize("noise", [0.0, 1e-9])
@pytest.mark.parametrize("reverse", [slice(0), slice(None), slice(0, None, 2)])
@pytest.mark.parametrize("hole", [0, 1])
def test_a_soup_becomes_connected_and_outward_with_its_own_numbers(ring, hole, reverse, noise):
    given = triangle_soup(without_faces(ring, range(hole)))
    shaken = given.vertices + noise * np.random.default_rng(0).standard_normal(given.vertices.shape)
    m = len(given.faces)
    given = with_reversed_faces(Mesh(shaken, given.faces), np.arange(m)[reverse])
    surface, representative = oriented_surface(given)
    assert len(surface.vertices) == len(representative) == 3 * m
    assert np.array_equal(np.sort(surface.faces, axis=1), np.sort(representative[given.faces], axis=1))
    assert len(surface.used_vertices) == len(ring.vertices)
    assert surface.is_closed_manifold == (not hole)
    assert surface.is_edge_manifold
    expected = without_faces(ring, range(hole))
    assert surface.volume == pytest.approx(expected.volume, rel=1e-3)  # where it is open, of the origin too


def test_a_stray_face_far_away_does_not_merge_the_rest(ring):
    stray = Mesh([[1e6, 0, 0], [1e6, 1, 0], [1e6, 0, 1]], [[0, 1, 2]])
    given = joined(ring, stray)
    assert oriented_surface(given)[1].tolist() == list(range(len(given.vertices)))


def test_faces_that_would_duplicate_another_or_name_a_vertex_twice_keep_their_vertices(tetrahedron):
    twice = joined(without_faces(tetrahedron, [0]), without_faces(tetrahedron, [0]))
    surface, representative = oriented_surface(twice)
    assert np.array_equal(surface.faces, twice.faces)
    assert representative.tolist() == [0, 1, 2, 3, 0, 1, 2, 3]
    thin = Mesh([[0, 0, 0], [1, 0, 0], [1, 1e-9, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    assert np.sort(oriented_surface(thin)[0].faces, axis=1).tolist() == [[0, 1, 2], [0, 1, 3]]
