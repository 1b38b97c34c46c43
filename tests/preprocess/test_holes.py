"""Holes: which boundary loops are found, and what fills them."""

import numpy as np
import pytest
from helpers import with_reversed_faces, without_faces

from lbskel import Mesh
from lbskel.preprocess import holes
from lbskel.preprocess.holes import boundary_loops, close_holes
from lbskel.preprocess.result import hausdorff_distance
from lbskel.shapes import cylinder, flat_grid, sphere


def test_the_ends_of_a_pipe_are_closed():
    pipe = cylinder(0.3, 2.0, 24, 8)
    assert sorted(map(len, boundary_loops(pipe))) == [24, 24]
    result = close_holes(pipe, max_perimeter=1.0)
    assert result.mesh.genus == 0
    # a prism of 24 sides
    assert result.mesh.volume == pytest.approx(2.0 * 0.3**2 * 12 * np.sin(2 * np.pi / 24))
    assert np.array_equal(result.mesh.vertices[: len(pipe.vertices)], pipe.vertices)
    assert close_holes(pipe, max_perimeter=0.5).mesh is pipe


@pytest.mark.parametrize("seed", range(4))
def test_a_surface_with_many_missing_faces_is_closed(seed):
    ball = sphere(3)
    rng = np.random.default_rng(seed)
    given = without_faces(ball, np.flatnonzero(rng.random(len(ball.faces)) < 0.12))
    result = close_holes(given, max_perimeter=2.0)
    assert result.mesh.is_closed
    assert result.mesh.is_edge_manifold
    assert hausdorff_distance(ball, result.mesh) < 0.1  # holes are two or three edges of 0.15 wide, of a bound of 2


def neighbors_of_face(mesh, face):
    """The three faces beside a face."""
    shared = np.isin(mesh.faces, mesh.faces[face]).sum(axis=1)
    return np.flatnonzero(shared == 2)


@pytest.mark.parametrize("face", [0, 7, 500])
def test_holes_that_meet_at_vertices_are_closed_each_for_itself(face):
    ball = sphere(3)
    given = without_faces(ball, neighbors_of_face(ball, face))
    assert sorted(map(len, boundary_loops(given))) == [3, 3, 3]
    filled = close_holes(given).mesh
    assert (filled.genus, filled.n_components, filled.is_closed_manifold) == (0, 1, True)
    assert {tuple(sorted(f)) for f in filled.faces.tolist()} == {tuple(sorted(f)) for f in ball.faces.tolist()}


def test_every_second_face_around_a_vertex_is_a_hole_of_its_own():
    ball = sphere(3)
    around = np.flatnonzero((ball.faces == 200).any(axis=1))
    assert len(around) == 6
    centers = ball.vertices[ball.faces[around]].mean(axis=1) - ball.vertices[200]
    frame = np.linalg.svd(centers)[2][:2]
    turn = np.argsort(np.arctan2(*(frame @ centers.T)))
    given = without_faces(ball, around[turn[::2]])
    assert sorted(map(len, boundary_loops(given))) == [3, 3, 3]
    assert close_holes(given).mesh.is_closed_manifold


def test_two_bodies_that_touch_at_a_vertex_of_their_holes_are_closed_each_for_itself():
    ball = without_faces(sphere(2), [0])
    at = boundary_loops(ball)[0][0]
    mirrored = Mesh(2 * ball.vertices[at] - ball.vertices, ball.faces[:, ::-1])
    n = len(ball.vertices)
    faces = np.where(mirrored.faces == at, at, mirrored.faces + n)
    both = Mesh(np.concatenate([ball.vertices, mirrored.vertices]), np.concatenate([ball.faces, faces]))
    assert sorted(map(len, boundary_loops(both))) == [3, 3]
    assert len(close_holes(both).mesh.faces) == 2 * 320


@pytest.mark.parametrize(("n_around", "wave", "n_new"), [(24, 0.0, 2), (24, 0.1, 0), (320, 0.1, 2)])
def test_loops_that_are_planar_or_too_long_to_triangulate_are_filled_with_fans(n_around, wave, n_new):
    pipe = cylinder(0.3, 2.0, n_around, 8)
    at_end = np.abs(pipe.vertices[:, 2] - pipe.vertices[:, 2].mean()) > 0.99
    pipe = pipe.with_vertices(pipe.vertices + (wave * at_end * pipe.vertices[:, 0])[:, None] ** 2 * [0, 0, 100])
    result = close_holes(pipe, max_perimeter=1.2)
    assert (result.mesh.genus, len(result.mesh.vertices)) == (0, len(pipe.vertices) + n_new)


def test_how_a_planar_hole_is_closed_does_not_depend_on_the_order_of_the_vertices():
    pipe = cylinder(0.3, 2.0, 24, 8)
    order = np.random.default_rng(0).permutation(len(pipe.vertices))
    shuffled = Mesh(pipe.vertices[order], np.argsort(order)[pipe.faces])
    caps = [close_holes(mesh, max_perimeter=1.0).mesh for mesh in (pipe, shuffled)]
    centers = [np.unique(mesh.vertices[mesh.faces].mean(axis=1).round(9), axis=0) for mesh in caps]
    assert centers[0] == pytest.approx(centers[1], abs=1e-8)


def test_the_boundary_of_a_sheet_is_not_a_hole():
    grid = flat_grid()
    assert close_holes(grid, max_perimeter=9.0).mesh is grid
    hollow = without_faces(grid, [len(grid.faces) // 2])
    assert len(close_holes(hollow, max_perimeter=9.0).mesh.faces) == len(grid.faces)


def test_a_boundary_that_spans_too_much_area_is_not_triangulated(monkeypatch):
    """The two ends of a short, wide pipe are each larger than half of its wall."""
    monkeypatch.delattr(holes, "min_area_triangulation")
    pipe = cylinder(1.0, 0.2, 24, 4)
    assert close_holes(pipe, max_perimeter=9.0).mesh is pipe


def test_a_seam_of_opposite_orientation_is_not_a_hole(ring):
    given = with_reversed_faces(ring, range(40))
    assert boundary_loops(given) == []


def test_a_missing_face_is_filled_however_long_it_is():
    rod = close_holes(cylinder(0.1, 9.0, 8, 2), max_perimeter=1.0).mesh
    holed = without_faces(rod, [int(np.argmax(rod.face_areas))])
    assert close_holes(holed, max_perimeter=0.3).mesh.is_closed_manifold


def test_a_filled_hole_has_the_orientation_of_its_surface():
    ball = sphere(3)
    given = without_faces(ball, [0, 100, 101])
    filled = close_holes(given).mesh
    assert filled.is_closed_manifold
    assert filled.volume == pytest.approx(ball.volume, rel=0.01)
    new = slice(len(given.faces), None)
    assert (np.einsum("ij,ij->i", filled.face_normals[new], filled.vertices[filled.faces[new, 0]]) > 0).all()


def test_the_limit_is_the_perimeter_relative_to_the_diameter_bound():
    """The ends of a pipe are polygons of 24 chords."""
    pipe = cylinder(0.3, 2.0, 24, 8)
    perimeter = 24 * 2 * 0.3 * np.sin(np.pi / 24)
    assert close_holes(pipe, max_perimeter=0.99 * perimeter / pipe.diameter_bound).mesh is pipe
    assert close_holes(pipe, max_perimeter=1.01 * perimeter / pipe.diameter_bound).mesh.genus == 0


def test_a_folded_sheet_of_two_triangles_stays_open():
    """Two triangles across the gap would have a fifth of the area, but as many faces as the sheet itself."""
    sheet = Mesh([[0, 0, 0], [1, 0, 0], [0.5, 1, 0.05], [0.5, 1, -0.05]], [[0, 1, 2], [1, 0, 3]])
    assert [len(loop) for loop in boundary_loops(sheet)] == [4]
    assert close_holes(sheet, max_perimeter=9.0).mesh is sheet
