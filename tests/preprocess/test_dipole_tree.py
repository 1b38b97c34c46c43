"""The smooth winding number of a sphere, in closed form."""

import numpy as np
import pytest

from lbskel.preprocess.dipole_tree import DipoleTree, leaf_order
from lbskel.shapes import sphere


def _tree(points, moments, widths):
    return DipoleTree.of(points, moments, widths, leaf_order(points))


@pytest.fixture(scope="module")
def dipoles():
    mesh = sphere(4)
    areas = np.bincount(mesh.faces.ravel(), np.repeat(mesh.face_areas / 3, 3))
    return mesh.vertices, mesh.vertices * areas[:, None]


def test_it_is_one_inside_and_zero_outside(dipoles):
    points, moments = dipoles
    tree = _tree(points, moments, np.full(len(points), 1e-3))
    places = np.array([[0.0, 0, 0], [0.5, 0.2, 0], [1.5, 0, 0], [0, 0, -4]])
    assert tree.values(places) == pytest.approx([1, 1, 0, 0], abs=0.02)  # 0.01 of the tree, 0.005 of the triangles


def test_smoothing_lowers_it_at_the_center_as_the_formula_says(dipoles):
    points, moments = dipoles
    width = 0.5
    field = _tree(points, moments, np.full(len(points), width)).values(np.zeros((1, 3)))
    assert field[0] == pytest.approx((1 + width**2) ** -1.5, abs=0.01)


def test_it_falls_outwards_across_the_surface(dipoles):
    points, moments = dipoles
    gradient = _tree(points, moments, np.full(len(points), 0.1)).gradients()
    assert ((gradient * points).sum(axis=1) < 0).all()


def test_points_without_moment_and_fewer_than_a_leaf():
    tree = _tree(np.zeros((3, 3)), np.zeros((3, 3)), np.ones(3))
    assert tree.values(np.ones((2, 3))).tolist() == [0, 0]


def test_positions_of_points_have_the_field_of_the_points(dipoles):
    points, moments = dipoles
    tree = _tree(points, moments, np.full(len(points), 0.1))
    np.testing.assert_array_equal(tree.values(), tree.values(points))
