"""Winding numbers of closed, open and unconnected triangles, against the sum of their solid angles by libigl."""

from unittest.mock import patch

import igl
import numpy as np
import pytest

from lbskel import Mesh
from lbskel.geometry.winding import WindingNumbers, winding_numbers_of
from lbskel.shapes import sphere, torus, voxel_surface

BALL = sphere(3)
POINTS = np.random.default_rng(5).uniform(-1.3, 1.3, (300, 3))


def exact(mesh):
    return igl.winding_number(mesh.vertices, mesh.faces, POINTS)


def cut(mesh, *, below):
    """The faces of a mesh below a height."""
    return Mesh(mesh.vertices, mesh.faces[mesh.vertices[mesh.faces, 2].mean(axis=1) < below])


HALF_TURNED = np.where(np.arange(len(BALL.faces))[:, None] < 300, BALL.faces, BALL.faces[:, ::-1])
SURFACES = {
    "closed": BALL,
    "reversed": Mesh(BALL.vertices, BALL.faces[:, ::-1]),
    "with a hole": cut(BALL, below=0.8),
    "half": cut(BALL, below=0.0),
    "ring with a wide and a narrow rim": cut(torus(1.0, 0.3, 40, 20), below=0.2),
    "with a seam between two orientations": Mesh(BALL.vertices, HALF_TURNED),
    "with a face three times": Mesh(BALL.vertices, np.concatenate([BALL.faces, BALL.faces[[9, 9]]])),
}


@pytest.mark.parametrize("name", SURFACES)
def test_winding_numbers_are_the_sums_of_solid_angles(name):
    assert winding_numbers_of(SURFACES[name]).around(POINTS) == pytest.approx(exact(SURFACES[name]), abs=0.02)


@pytest.mark.parametrize("name", SURFACES)
def test_a_point_is_inside_where_its_winding_number_is_above_a_half(name):
    """Far from the fans that of the closed surface decides, and near them the angle of each."""
    trees, fine = winding_numbers_of(SURFACES[name]), np.random.default_rng(6).uniform(-1.3, 1.3, (3000, 3))
    assert (trees.contain(fine) == (np.abs(trees.around(fine)) > 0.5)).all()


@pytest.mark.parametrize("name", SURFACES)
def test_points_that_are_not_finite_are_not_inside(name):
    points = np.array([[np.nan, 0, 0], [0, np.inf, 0], [0, 0, 0]])
    trees = winding_numbers_of(SURFACES[name])
    assert not trees.contain(points)[:2].any()
    assert trees.contain(points[:0]).tolist() == []


def test_far_from_the_fans_their_numbers_are_not_needed():
    trees = winding_numbers_of(cut(BALL, below=0.8))
    far = POINTS[(POINTS[:, 2] < -0.5)]
    with patch.object(WindingNumbers, "around", lambda trees, points, deadline: np.zeros(len(points))):
        assert (trees.contain(far) == (np.linalg.norm(far, axis=1) < 0.99)).mean() > 0.99
        assert trees.contain(far).any()


def test_closed_surfaces_have_integers_and_no_tree_of_libigl():
    trees = winding_numbers_of(BALL)
    assert trees.others is None
    assert set(trees.around(POINTS)) == {0.0, 1.0}


def test_a_surface_with_few_holes_is_closed_by_as_many_faces_as_rim_edges():
    open_ball = cut(BALL, below=0.8)
    trees = winding_numbers_of(open_ball)
    assert len(trees.closed.order) == len(open_ball.faces) + (open_ball.faces_per_edge == 1).sum()


def test_points_on_the_fans_have_the_sums_of_solid_angles():
    """The fans of a block without two adjacent sides go through its inside, and so do planes of symmetric shapes."""
    block = voxel_surface(np.ones((4, 4, 4)))
    x, _, z = block.vertices[block.faces].mean(axis=1).T
    block = Mesh(block.vertices, block.faces[(x < 3.4) & (z < 3.4)])
    trees = winding_numbers_of(block)
    on_fans = np.concatenate([trees.fans.corners.reshape(-1, 3, 3).mean(axis=1), [[1.5, 0.5, 1.5]]])
    found = trees.around(np.concatenate([on_fans, on_fans + 1e-8]))
    expected = igl.winding_number(block.vertices, block.faces, on_fans)
    assert found == pytest.approx(np.tile(expected, 2), abs=0.02)


@pytest.mark.parametrize(("scale", "shift"), [(1.0, 1e7), (1e-30, 0.0), (1e25, 0.0)])
def test_winding_numbers_depend_neither_on_the_origin_nor_on_the_unit(scale, shift):
    """The trees of libigl have single precision: 8 digits, and magnitudes from 1e-38 to 1e38."""
    half = SURFACES["half"]
    moved = half.with_vertices(scale * half.vertices + shift)
    assert winding_numbers_of(moved).around(scale * POINTS + shift) == pytest.approx(exact(half), abs=0.02)


def test_unconnected_faces_get_the_tree_of_libigl():
    """Fans would have three faces for each of them."""
    soup = Mesh(BALL.vertices[BALL.faces].reshape(-1, 3), np.arange(3 * len(BALL.faces)).reshape(-1, 3))
    trees = winding_numbers_of(soup)
    assert trees.closed is None
    assert trees.around(POINTS) == pytest.approx(exact(BALL), abs=0.02)
