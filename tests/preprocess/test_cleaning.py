"""Tidying: what is merged and left out, what is said of it, and that every vertex keeps its way."""

import numpy as np
import pytest
from helpers import joined, moved
from hypothesis import given
from hypothesis import strategies as st

from lbskel import Mesh
from lbskel.geometry.components import components
from lbskel.preprocess.cleaning import tidy
from lbskel.shapes import capsule, cylinder, flat_grid, torus


def soup(mesh):
    """Every triangle with three vertices of its own, as in an STL file."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))


def places_are_kept(given, result):
    """Whether each vertex went to one at its own place."""
    there = result.vertex_map.indices >= 0
    return (given.vertices[there] == result.mesh.vertices[result.vertex_map.indices[there]]).all()


@pytest.mark.parametrize("make", [lambda: torus(1.0, 0.3, 12, 8), lambda: cylinder(0.3, 2.0, 8, 4), flat_grid])
def test_a_tidy_mesh_is_given_back(make):
    mesh = make()
    result = tidy(mesh)
    assert result.mesh is mesh
    assert result.vertex_map.tolist() == list(range(len(mesh.vertices)))
    assert result.notes == ()


@pytest.mark.parametrize(
    "make", [lambda: torus(1.0, 0.3, 12, 8), lambda: capsule(2.0, 0.3, 8), lambda: cylinder(0.3, 2.0, 8, 4)]
)
def test_a_soup_becomes_the_surface_again(make):
    mesh = make()
    given = soup(mesh)
    result = tidy(given)
    assert len(result.mesh.vertices) == len(mesh.vertices)
    assert (result.mesh.genus, result.mesh.is_closed, result.mesh.n_components) == (mesh.genus, mesh.is_closed, 1)
    assert result.mesh.area == pytest.approx(mesh.area)
    assert places_are_kept(given, result)
    n_merged = len(given.vertices) - len(mesh.vertices)
    assert result.notes == (f"{n_merged} vertices at the place of another were merged with it",)


def test_zero_and_minus_zero_are_one_place():
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, -0.0, -0.0], [1, -0.0, 0], [0, 0, 1]])
    result = tidy(Mesh(V, [[0, 1, 2], [3, 5, 4]]))
    assert len(result.mesh.vertices) == 4
    assert result.vertex_map.indices[3] == result.vertex_map.indices[0]
    assert result.vertex_map.indices[4] == result.vertex_map.indices[1]


def test_vertices_that_are_merely_near_stay(tetrahedron):
    given = soup(tetrahedron)
    V = given.vertices + 1e-12 * np.arange(len(given.vertices))[:, None]
    assert tidy(Mesh(V, given.faces)).notes == ()


def test_surfaces_that_touch_in_vertices_stay_apart(tetrahedron):
    """Two closed surfaces that share the place of a vertex are two, and a manifold as they stand."""
    mesh = joined(tetrahedron, Mesh(-tetrahedron.vertices, tetrahedron.faces[:, ::-1]))
    assert mesh.is_closed_manifold
    assert tidy(mesh).mesh is mesh


def test_duplicate_faces_are_named(tetrahedron):
    F = tetrahedron.faces
    given = Mesh(tetrahedron.vertices, np.concatenate([F, F[[2]], F[[0]][:, [1, 2, 0]], F[[1]][:, ::-1]]))
    result = tidy(given)
    assert result.mesh.faces.tolist() == F.tolist()
    assert result.notes == ("3 faces that copy another were left out: 4, 5, 6",)
    assert places_are_kept(given, result)


def test_faces_without_three_corners_are_named(tetrahedron):
    given = Mesh(tetrahedron.vertices, [[1, 1, 2], *tetrahedron.faces.tolist(), [3, 3, 3]])
    result = tidy(given)
    assert result.mesh.faces.tolist() == tetrahedron.faces.tolist()
    assert result.notes == ("2 faces with a corner twice were left out: 0, 5",)


def test_a_face_that_merging_makes_thin_is_left_out(tetrahedron):
    """Corner 4 is at the place of vertex 0, so that the last face has two corners there."""
    V = [*tetrahedron.vertices.tolist(), [0, 0, 0]]
    result = tidy(Mesh(V, [*tetrahedron.faces.tolist(), [0, 1, 4]]))
    assert result.mesh.faces.tolist() == tetrahedron.faces.tolist()
    assert result.vertex_map.tolist() == [0, 1, 2, 3, 0]
    assert len(result.notes) == 2


def test_unused_vertices_have_no_place(tetrahedron):
    V = np.concatenate([[[9, 9, 9]], tetrahedron.vertices, [[8, 8, 8], [9, 9, 9]]])
    result = tidy(Mesh(V, tetrahedron.faces + 1))
    assert result.vertex_map.tolist() == [-1, 0, 1, 2, 3, -1, -1]
    assert result.mesh.genus == 0
    assert result.notes == ("3 vertices belong to no face and are mapped to the nearest node",)


def test_zero_area_faces_that_hold_a_surface_together_stay():
    """A face with three corners on a line closes the gap of a vertex on an edge: without it there is a hole."""
    V = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 0, 0]]
    F = [[0, 2, 4], [4, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [0, 4, 1]]
    mesh = Mesh(V, F)
    assert (mesh.face_areas == 0).sum() == 1
    assert mesh.genus == 0
    assert tidy(mesh).mesh is mesh


def test_where_no_face_is_left_the_mesh_is_given_back():
    mesh = Mesh([[0, 0, 0], [1, 0, 0]], [[0, 1, 1], [0, 0, 0]])
    assert tidy(mesh).mesh is mesh


def test_notes_of_the_mesh_stay_with_it(tetrahedron):
    given = Mesh(soup(tetrahedron).vertices, soup(tetrahedron).faces, ("read from a soup",))
    assert tidy(given).mesh.notes == ("read from a soup",)


@given(st.integers(0, 2**32 - 1))
def test_tidying_twice_is_tidying_once(seed):
    rng = np.random.default_rng(seed)
    given = Mesh(rng.integers(0, 3, size=(12, 3)), rng.integers(0, 12, size=(10, 3)))
    once = tidy(given)
    assert places_are_kept(given, once)
    assert len(once.vertex_map.indices) == len(given.vertices)
    assert tidy(once.mesh).mesh is once.mesh


# --- components


def test_one_component_is_given_back(ring):
    [part] = components(ring)
    assert part.mesh is ring
    assert part.vertices.tolist() == list(range(len(ring.vertices)))


def test_components_are_told_apart(ring, tetrahedron, rod):
    whole = joined(ring, moved(tetrahedron, 4), moved(rod, 8))
    parts = components(whole)
    assert [part.mesh.genus for part in parts] == [1, 0, 0]
    for part, alone in zip(parts, (ring, moved(tetrahedron, 4), moved(rod, 8)), strict=True):
        assert (part.mesh.vertices == alone.vertices).all()
        assert (part.mesh.faces == alone.faces).all()
        assert (whole.vertices[part.vertices] == part.mesh.vertices).all()
    assert np.concatenate([part.vertices for part in parts]).tolist() == list(range(len(whole.vertices)))


def test_interleaved_numbering_is_no_matter(ring, tetrahedron):
    whole = joined(ring, moved(tetrahedron, 4))
    order = np.random.default_rng(0).permutation(len(whole.vertices))
    mixed = Mesh(whole.vertices[order], np.random.default_rng(1).permutation(np.argsort(order)[whole.faces]))
    parts = components(mixed)
    assert sorted((len(part.mesh.vertices), part.mesh.genus) for part in parts) == [(4, 0), (128, 1)]
    assert sum(part.mesh.area for part in parts) == pytest.approx(whole.area)
    assert all((mixed.vertices[part.vertices] == part.mesh.vertices).all() for part in parts)


def test_unused_vertices_are_in_no_component(tetrahedron):
    V = np.concatenate([[[9, 9, 9]], tetrahedron.vertices, [[8, 8, 8]]])
    [part] = components(Mesh(V, tetrahedron.faces + 1))
    assert part.vertices.tolist() == [1, 2, 3, 4]
    assert part.mesh.genus == 0


def test_surfaces_joined_by_a_vertex_alone_are_one_component(tetrahedron):
    V = np.concatenate([tetrahedron.vertices, -tetrahedron.vertices[1:]])
    F = np.concatenate([tetrahedron.faces, np.array([0, 4, 5, 6])[tetrahedron.faces[:, ::-1]]])
    assert len(components(Mesh(V, F))) == 1
