"""Orientation of faces, relative vector area, and splitting of surfaces that touch."""

import numpy as np
import pytest
from helpers import joined, moved, with_reversed_faces, without_faces
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lbskel import Mesh
from lbskel.preprocess.cleaning import remove_duplicates
from lbskel.preprocess.orientation import fix_orientation, relative_vector_area, split_nonmanifold
from lbskel.preprocess.vertex_umbrellas import find_umbrellas
from lbskel.shapes import cylinder, flat_grid, sphere

CUBE = Mesh(
    [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ],
)


def welded(mesh):
    """The mesh with vertices of the same position merged, manifold or not."""
    V, place = np.unique(mesh.vertices, axis=0, return_inverse=True)
    return Mesh(V, place.reshape(-1)[mesh.faces])


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0])
def test_faces_are_oriented_outwards(ring, share):
    chosen = np.flatnonzero(np.random.default_rng(1).random(len(ring.faces)) < share)
    result = fix_orientation(with_reversed_faces(ring, chosen))
    assert result.mesh.is_closed_manifold
    assert result.mesh.volume == pytest.approx(ring.volume)


def test_the_wall_of_a_cavity_faces_inwards_and_a_separate_body_outwards():
    ball = sphere(2)
    hollow = joined(ball, Mesh(0.5 * ball.vertices, ball.faces[:, ::-1]))
    assert fix_orientation(hollow).mesh is hollow
    beside = joined(ball, Mesh(ball.vertices + [3, 0, 0], ball.faces[:, ::-1]))
    assert fix_orientation(beside).mesh.volume == pytest.approx(2 * ball.volume)


def with_twisted_handle(mesh, one, other):
    """The mesh with two of its faces joined by a handle that is glued the wrong way round."""
    A, B = mesh.faces[one], mesh.faces[other]
    handle = [q for i in range(3) for q in ([A[i], A[i - 2], B[i]], [A[i - 2], B[i - 2], B[i]])]
    return Mesh(mesh.vertices, np.concatenate([np.delete(mesh.faces, [one, other], axis=0), handle]))


@pytest.mark.parametrize("is_inward", [False, True])
def test_a_body_with_a_small_part_that_cannot_be_oriented_is_not_turned_in_part(is_inward):
    ball = sphere(3)
    height = ball.vertices[ball.faces].mean(axis=1)[:, 2]
    twisted = with_twisted_handle(ball, height.argmax(), height.argmin())
    if is_inward:
        twisted = with_reversed_faces(twisted, np.arange(len(twisted.faces)))
    result = fix_orientation(joined(twisted, moved(ball, 5.0))).mesh
    of_ball = np.arange(len(ball.faces) - 2)
    assert (np.einsum("ij,ij->i", result.face_normals, result.vertices[result.faces[:, 0]])[of_ball] > 0).all()


def test_faces_of_mixed_orientation_are_turned_where_that_makes_the_seam_shorter():
    ball = sphere(3)
    given = with_twisted_handle(ball, 0, 700)
    mixed = with_reversed_faces(given, np.flatnonzero(np.random.default_rng(0).random(len(given.faces)) < 0.5))

    def seam(mesh):
        directed = mesh.half_edges @ [len(mesh.vertices), 1]
        return len(directed) - len(np.unique(directed))

    assert 0 < seam(fix_orientation(mixed).mesh) < seam(mixed) / 5


def reversed_in(mesh, how):
    """The mesh with all faces reversed, every second one or one in ten."""
    m = len(mesh.faces)
    return with_reversed_faces(mesh, {"all": np.arange(m), "half": np.arange(0, m, 2), "few": np.arange(0, m, 10)}[how])


@pytest.mark.parametrize("how", ["all", "half", "few"])
@pytest.mark.parametrize("hole", [[], [0]])
def test_a_hollow_body_stays_hollow(how, hole):
    ball = sphere(2)
    wall = Mesh(0.4 * ball.vertices, ball.faces[:, ::-1])
    core = Mesh(0.2 * ball.vertices, ball.faces)
    hollow = joined(without_faces(ball, hole), wall, core)
    result = fix_orientation(reversed_in(hollow, how)).mesh
    assert result.volume == pytest.approx(hollow.volume)
    assert result.is_edge_manifold


def test_a_body_inside_another_stays_a_body_when_both_are_turned():
    ball = sphere(2)
    nested = joined(ball, Mesh(0.4 * ball.vertices, ball.faces))
    assert fix_orientation(nested).mesh is nested
    assert fix_orientation(reversed_in(nested, "all")).mesh.volume == pytest.approx(nested.volume)
    assert fix_orientation(reversed_in(nested, "few")).mesh.volume == pytest.approx(nested.volume)


def test_of_bodies_that_cross_none_is_a_cavity():
    ball = sphere(2)
    crossing = joined(
        ball, Mesh(0.4 * ball.vertices + [0.9, 0, 0], ball.faces), Mesh(0.4 * ball.vertices + [0, 0.5, 0.5], ball.faces)
    )
    assert fix_orientation(reversed_in(crossing, "half")).mesh.volume == pytest.approx(crossing.volume)


def test_a_sheet_keeps_the_orientation_of_most_of_its_area():
    grid = flat_grid()
    result = fix_orientation(with_reversed_faces(grid, [0, 5]))
    assert np.array_equal(np.sort(result.mesh.faces, axis=1), np.sort(grid.faces, axis=1))
    normal = np.cross(
        *(result.mesh.vertices[result.mesh.faces[:, k]] - result.mesh.vertices[result.mesh.faces[:, 0]] for k in (1, 2))
    )
    assert (normal[:, 2] > 0).all()


def test_relative_vector_area():
    assert relative_vector_area(sphere(2)) == pytest.approx(0.0, abs=1e-12)
    assert relative_vector_area(flat_grid()) == pytest.approx(1.0)
    assert relative_vector_area(cylinder(0.3, 2.0, 16, 8)) == pytest.approx(0.0, abs=1e-12)
    ball = sphere(4)
    half = without_faces(ball, np.flatnonzero(ball.vertices[ball.faces].mean(axis=1)[:, 2] < 0))
    assert relative_vector_area(half) == pytest.approx(
        0.5, abs=0.02
    )  # the boundary is a row of triangles, about 0.1 wide


@pytest.mark.parametrize("step", [[1, 1, 0], [1, 1, 1]], ids=["edge", "vertex"])
def test_bodies_that_touch_are_split(step):
    touching = welded(joined(CUBE, Mesh(CUBE.vertices + step, CUBE.faces)))
    assert touching.n_components == 1
    assert not touching.is_closed_manifold
    result = split_nonmanifold(touching)
    assert (result.mesh.is_closed_manifold, result.mesh.n_components) == (True, 2)
    assert result.mesh.volume == pytest.approx(2.0)
    assert np.array_equal(result.mesh.vertices[result.vertex_map.indices], touching.vertices)


def test_a_fin_becomes_a_separate_sheet():
    mesh = Mesh([*CUBE.vertices, [2, 2, 0.5]], [*CUBE.faces, [6, 7, 8]])
    assert (mesh.faces_per_edge > 2).sum() == 1
    result = split_nonmanifold(mesh)
    assert result.mesh.is_edge_manifold
    assert result.mesh.area == pytest.approx(mesh.area)


@given(st.integers(0, 2**32 - 1))
@example(364590)  # a fan that passes an edge twice
@settings(max_examples=40)
def test_any_triangles_are_split_into_manifold_pieces(seed):
    rng = np.random.default_rng(seed)
    given = remove_duplicates(Mesh(rng.normal(size=(9, 3)), rng.integers(0, 9, size=(14, 3)))).mesh
    result = split_nonmanifold(given)
    F = result.mesh.faces
    if (np.sort(F, axis=1)[:, :2] != np.sort(F, axis=1)[:, 1:]).all():
        assert result.mesh.is_edge_manifold
    assert np.array_equal(result.mesh.vertices[F], given.vertices[given.faces])
    assert (find_umbrellas(result.mesh).of_corner == F).all()
