"""Cleaning: which vertices are merged, which faces are removed, what the notes say, and the vertex map."""

import numpy as np
import pytest
from helpers import joined, moved, triangle_soup, without_faces
from hypothesis import given
from hypothesis import strategies as st

from lbskel import Mesh, UnknownChoice
from lbskel.errors import were
from lbskel.preprocess.cleaning import clean, extract_faces, keep_components, merge_close
from lbskel.shapes import capsule, cylinder, flat_grid, sphere, torus


def positions_are_kept(given, result):
    """Whether each vertex is mapped to one at the same position."""
    there = result.vertex_map.indices >= 0
    return (given.vertices[there] == result.mesh.vertices[result.vertex_map.indices[there]]).all()


@pytest.mark.parametrize("make", [lambda: torus(1.0, 0.3, 12, 8), lambda: cylinder(0.3, 2.0, 8, 4), flat_grid])
def test_a_clean_mesh_is_returned_unchanged(make):
    mesh = make()
    result = clean(mesh)
    assert result.mesh is mesh
    assert result.vertex_map.indices.tolist() == list(range(len(mesh.vertices)))
    assert result.notes == ()


@pytest.mark.parametrize(
    "make", [lambda: torus(1.0, 0.3, 12, 8), lambda: capsule(2.0, 0.3, 8), lambda: cylinder(0.3, 2.0, 8, 4)]
)
def test_a_triangle_soup_becomes_a_closed_surface(make):
    mesh = make()
    given = triangle_soup(mesh)
    result = clean(given)
    assert len(result.mesh.vertices) == len(mesh.vertices)
    assert (result.mesh.genus, result.mesh.is_closed, result.mesh.n_components) == (mesh.genus, mesh.is_closed, 1)
    assert result.mesh.area == pytest.approx(mesh.area)
    assert positions_are_kept(given, result)
    n_merged = len(given.vertices) - len(mesh.vertices)
    assert result.notes == (f"{were(n_merged, 'vertex')} merged with another at the same position",)


def test_zero_and_minus_zero_are_the_same_position():
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, -0.0, -0.0], [1, -0.0, 0], [0, 0, 1]])
    result = clean(Mesh(V, [[0, 1, 2], [3, 5, 4]]))
    assert len(result.mesh.vertices) == 4
    assert result.vertex_map.indices[3] == result.vertex_map.indices[0]
    assert result.vertex_map.indices[4] == result.vertex_map.indices[1]


def test_close_but_distinct_vertices_are_not_merged_by_default(tetrahedron):
    given = triangle_soup(tetrahedron)
    V = given.vertices + 1e-12 * np.arange(len(given.vertices))[:, None]
    assert clean(Mesh(V, given.faces)).notes == ()


def test_closed_surfaces_that_touch_in_a_vertex_stay_separate(tetrahedron):
    """Two closed surfaces with a vertex at the same position are already a manifold."""
    mesh = joined(tetrahedron, Mesh(-tetrahedron.vertices, tetrahedron.faces[:, ::-1]))
    assert mesh.is_closed_manifold
    assert clean(mesh).mesh is mesh


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 1, 0]])
def test_copies_of_a_closed_surface_at_its_place_are_removed(order):
    ball, ring = sphere(1), torus(1.0, 0.3, 12, 8)
    turned = Mesh(ball.vertices[::-1], len(ball.vertices) - 1 - ball.faces[::-1][:, order])
    given = joined(ring, ball, moved(ball, 5.0), turned, ball)
    result = clean(given)
    assert len(result.mesh.faces) == len(ring.faces) + 2 * len(ball.faces)
    assert result.mesh.volume == pytest.approx(ring.volume + 2 * ball.volume)
    assert (result.mesh.n_components, result.mesh.is_closed_manifold) == (3, True)
    assert (result.vertex_map.indices >= 0).all()
    assert positions_are_kept(given, result)
    assert result.notes[0] == f"{2 * len(ball.vertices):,} vertices were merged with another at the same position"
    assert result.notes[1].startswith(f"{2 * len(ball.faces):,} duplicate faces were removed")


def test_closed_surfaces_that_share_some_faces_are_kept(tetrahedron):
    """Two tetrahedra on the two sides of a face, and an octahedron with four of its faces moved."""
    apex = tetrahedron.vertices[3]
    normal = np.array([1.0, 1, 1]) / np.sqrt(3)
    others = Mesh([*tetrahedron.vertices[:3], apex - 2 * (apex @ normal + 1) * normal], tetrahedron.faces[:, ::-1])
    ball = sphere(1)
    raised = ball.with_vertices(ball.vertices * [1, 1, 2])
    half = Mesh(np.where(ball.vertices[:, 2:] > 1e-9, raised.vertices, ball.vertices), ball.faces)
    for mesh in (joined(tetrahedron, others), joined(ball, half)):
        assert mesh.is_closed_manifold
        assert clean(mesh).mesh is mesh


def test_duplicate_faces_are_removed(tetrahedron):
    F = tetrahedron.faces
    given = Mesh(tetrahedron.vertices, np.concatenate([F, F[[2]], F[[0]][:, [1, 2, 0]], F[[1]][:, ::-1]]))
    result = clean(given)
    assert result.mesh.faces.tolist() == F.tolist()
    assert result.notes == ("3 duplicate faces were removed: 4, 5, 6",)
    assert positions_are_kept(given, result)


def test_faces_that_name_a_vertex_twice_are_removed(tetrahedron):
    given = Mesh(tetrahedron.vertices, [[1, 1, 2], *tetrahedron.faces.tolist(), [3, 3, 3]])
    result = clean(given)
    assert result.mesh.faces.tolist() == tetrahedron.faces.tolist()
    assert result.notes == ("2 faces were removed for naming a vertex twice: 0, 5",)


def test_a_face_that_merging_collapses_is_removed(tetrahedron):
    """Vertex 4 has the position of vertex 0, so the last face has two corners there."""
    V = [*tetrahedron.vertices.tolist(), [0, 0, 0]]
    result = clean(Mesh(V, [*tetrahedron.faces.tolist(), [0, 1, 4]]))
    assert result.mesh.faces.tolist() == tetrahedron.faces.tolist()
    assert result.vertex_map.indices.tolist() == [0, 1, 2, 3, 0]
    assert len(result.notes) == 2


def test_unused_vertices_are_not_mapped(tetrahedron):
    V = np.concatenate([[[9, 9, 9]], tetrahedron.vertices, [[8, 8, 8], [9, 9, 9]]])
    result = clean(Mesh(V, tetrahedron.faces + 1))
    assert result.vertex_map.indices.tolist() == [-1, 0, 1, 2, 3, -1, -1]
    assert result.mesh.genus == 0
    assert result.notes == ("3 vertices were removed for being in no face",)


def test_zero_area_faces_that_close_a_surface_are_kept():
    """A face with three collinear corners closes a T-junction; without it there is a hole."""
    V = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 0, 0]]
    F = [[0, 2, 4], [4, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [0, 4, 1]]
    mesh = Mesh(V, F)
    assert (mesh.face_areas == 0).sum() == 1
    assert mesh.genus == 0
    assert clean(mesh).mesh is mesh


def test_a_mesh_without_a_valid_face_is_returned_unchanged():
    mesh = Mesh([[0, 0, 0], [1, 0, 0]], [[0, 1, 1], [0, 0, 0]])
    assert clean(mesh).mesh is mesh


def test_notes_of_the_mesh_are_kept(tetrahedron):
    given = Mesh(triangle_soup(tetrahedron).vertices, triangle_soup(tetrahedron).faces, ("read from a soup",))
    assert clean(given).mesh.notes == ("read from a soup",)


@given(st.integers(0, 2**32 - 1))
def test_cleaning_is_idempotent(seed):
    rng = np.random.default_rng(seed)
    given = Mesh(rng.integers(0, 3, size=(12, 3)), rng.integers(0, 12, size=(10, 3)))
    once = clean(given)
    assert positions_are_kept(given, once)
    assert len(once.vertex_map.indices) == len(given.vertices)
    assert clean(once.mesh).mesh is once.mesh


def test_close_vertices_become_one(ring):
    soup = ring.vertices[ring.faces].reshape(-1, 3)
    soup = soup + 1e-9 * np.random.default_rng(0).standard_normal(soup.shape)
    given = Mesh(soup, np.arange(len(soup)).reshape(-1, 3))
    result = merge_close(given)
    assert result.mesh.genus == 1
    assert np.array_equal(result.vertex_map.indices[given.faces], result.mesh.faces)
    # a vertex moves no further than the noise on both, which has a deviation of 1e-9
    assert np.abs(result.mesh.vertices[result.vertex_map.indices] - given.vertices).max() < 2e-8
    assert merge_close(given, tolerance=0.0).mesh is given


def test_a_tolerance_that_would_merge_most_of_the_mesh_is_rejected(ring):
    with pytest.raises(UnknownChoice, match="smaller"):
        merge_close(without_faces(sphere(4), [0]), tolerance=0.5)
    with pytest.raises(UnknownChoice, match="negative"):
        merge_close(ring, tolerance=-1.0)


def test_ten_thousand_vertices_at_one_position_are_merged():
    """They have fifty million pairs, which must not be listed."""
    corner = np.zeros((10_000, 3))
    V = np.concatenate([corner, [[1, 0, 0], [0, 1, 0], [0, 0, 1]]])
    result = merge_close(Mesh(V, [[0, 10_000, 10_001], [5, 10_001, 10_002], [9, 10_002, 10_000]]))
    assert len(result.mesh.vertices) == 4


def test_small_components_are_removed(ring, tetrahedron):
    small = Mesh(0.05 * tetrahedron.vertices + [3, 0, 0], tetrahedron.faces)
    result = keep_components(joined(ring, small, moved(ring, 5)))
    assert (result.mesh.n_components, result.mesh.genus) == (2, 2)
    assert (result.vertex_map.indices[len(ring.vertices) : len(ring.vertices) + 4] == -1).all()
    assert keep_components(joined(ring, small), min_area=0.0).mesh.n_components == 2


def test_components_are_compared_with_the_largest_not_with_the_sum(tetrahedron):
    """Of 60 equal bodies each has a sixtieth of the sum, and all of the largest one's area."""
    many = joined(*(moved(tetrahedron, 3 * k) for k in range(60)))
    assert keep_components(many, min_area=0.5).mesh is many
    bigger = Mesh(2 * tetrahedron.vertices + [0, 5, 0], tetrahedron.faces)  # four times the area
    result = keep_components(joined(many, bigger), min_area=0.3)
    assert result.mesh.n_components == 1
    assert result.vertex_map.indices.tolist() == [-1] * 240 + [0, 1, 2, 3]
    assert keep_components(joined(many, bigger), min_area=0.2).mesh.n_components == 61


def test_extracted_faces_keep_their_positions(ring):
    result = extract_faces(ring, ring.faces[5:7], "two faces were kept")
    assert np.array_equal(result.mesh.vertices[result.mesh.faces], ring.vertices[ring.faces[5:7]])
    used = np.unique(ring.faces[5:7])
    assert result.vertex_map.indices[used].tolist() == list(range(len(used)))
    assert (np.delete(result.vertex_map.indices, used) == -1).all()
    assert result.notes == ("two faces were kept",)


def test_the_tolerance_is_relative_to_the_diameter_bound():
    """A rectangle of diameter bound 5, with a corner twice, 0.04 apart: between a thousandth and a hundredth."""
    V = np.array([[0.0, 0, 0], [3, 0, 0], [3, 4, 0], [0, 4, 0], [0.04, 0, 0]])
    mesh = Mesh(V, [[0, 1, 2], [4, 2, 3]])
    assert len(merge_close(mesh, tolerance=0.01).mesh.vertices) == 4
    assert merge_close(mesh, tolerance=0.001).mesh is mesh


def test_a_closed_manifold_that_touches_itself_is_not_merged(tetrahedron):
    mesh = joined(tetrahedron, Mesh(-tetrahedron.vertices, tetrahedron.faces[:, ::-1]))
    assert merge_close(mesh).mesh is mesh
    opened = without_faces(mesh, [0])
    assert len(merge_close(opened).mesh.vertices) == 7


def test_copies_of_a_surface_that_touches_itself_stay_apart(ring):
    """Two opposite vertices of a ring at one place: which of them a vertex of the copy stands for is not known."""
    vertices = np.array(ring.vertices)
    vertices[len(vertices) // 2] = vertices[0]
    pinched = ring.with_vertices(vertices)
    result = merge_close(joined(pinched, pinched, moved(pinched, 9.0)))
    assert len(result.mesh.vertices) == 3 * len(vertices)
    assert len(merge_close(joined(ring, ring, pinched)).mesh.vertices) == 2 * len(vertices)
