"""Areas, corner products and integrals of triangles, against closed forms."""

import numpy as np
import pytest

RIGHT = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])  # sides 3, 4 and 5
ONE = np.array([[0, 1, 2]])


def test_corner_products_of_a_right_triangle(kernel):
    products, squares, areas = kernel.corner_products(RIGHT, ONE)
    assert products.tolist() == [[0, 9, 16]]  # |a| |b| cos: 3 * 5 * 3/5 and 4 * 5 * 4/5
    assert squares.tolist() == [[25, 16, 9]]
    assert areas.tolist() == [12]


def test_cotangents_are_those_of_the_angles(kernel):
    angles = np.array([0.3, 1.1, np.pi - 1.4])
    V = np.array([[0, 0, 0], [np.sin(angles[2]), 0, 0], np.sin(angles[1]) * np.array([np.cos(0.3), np.sin(0.3), 0])])
    products, _, areas = kernel.corner_products(V, ONE)  # law of sines
    assert products[0] / areas[0] == pytest.approx(1 / np.tan(angles), rel=1e-12)


@pytest.mark.parametrize(
    ("V", "expected"),
    [
        (RIGHT, [3, 1.5, 1.5]),  # the circumcenter is the midpoint of the hypotenuse
        ([[0, 0, 0], [2, 0, 0], [1, np.sqrt(3), 0]], 3 * [1 / np.sqrt(3)]),
        ([[0, 0, 0], [4, 0, 0], [2, 1, 0]], [0.5, 0.5, 1]),  # obtuse: a half at that corner, quarters at the others
        (
            [[0, 0, 0], [2, 0, 0], [1, 2, 0]],
            [0.6875, 0.6875, 0.625],
        ),  # the last is a kite from (1, 2) to the circumcenter (1, 3/4)
    ],
)
def test_mixed_voronoi_areas(kernel, V, expected):
    areas = kernel.mixed_voronoi_areas(*kernel.corner_products(np.array(V, dtype=float), ONE), 1e8)
    assert areas[0] == pytest.approx(expected, rel=1e-12)


def test_a_corner_beyond_the_limit_adds_nothing_to_the_other_areas(kernel):
    V = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1e-3, 0]])  # cotangents 1000, 0 and 0.001
    products, squares, areas = kernel.corner_products(V, ONE)
    full = kernel.mixed_voronoi_areas(products, squares, areas, 1e4)[0]
    cut = kernel.mixed_voronoi_areas(products, squares, areas, 1e2)[0]
    assert full.sum() == pytest.approx(areas[0] / 2)
    assert cut[0] == full[0]
    assert (full - cut)[1:] == pytest.approx(np.full(2, squares[0, 0] * products[0, 0] / (8 * areas[0])))
    assert kernel.mixed_voronoi_areas(*kernel.corner_products(V[[0, 1, 1]], ONE), 1e8).tolist() == [[0, 0, 0]]


@pytest.mark.parametrize("sign", [1, -1])
def test_integrals_of_a_cube(kernel, box, sign):
    V, F = box
    areas, center, volume = kernel.integrals(V + [10, 20, 30], np.ascontiguousarray(F[:, ::sign]))
    assert areas.tolist() == [0.5] * 12
    assert center == pytest.approx([10.5, 20.5, 30.5])
    assert volume == pytest.approx(sign)


def test_the_centroid_is_weighted_by_area(kernel):
    V = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [9, 0, 0], [10, 0, 0], [9, 1, 0]])
    areas, center, volume = kernel.integrals(V, np.array([[0, 1, 2], [3, 4, 5]]))
    assert areas.tolist() == [2, 0.5]
    assert center == pytest.approx((2 * np.array([2, 2, 0]) / 3 + 0.5 * np.array([28, 1, 0]) / 3) / 2.5)
    assert volume == 0


def test_without_area_the_centroid_is_the_mean_of_the_vertices(kernel):
    _, center, volume = kernel.integrals(np.array([[0.0, 0, 0], [2, 0, 0], [4, 0, 3]]), np.array([[0, 1, 1]]))
    assert center == pytest.approx([2, 0, 1])
    assert volume == 0


def test_compiled_or_not_is_the_same(assert_same, limbs):
    V, F = limbs.vertices, limbs.faces
    assert_same(lambda kernel: kernel.corner_products(V, F))
    assert_same(lambda kernel: [kernel.mixed_voronoi_areas(*kernel.corner_products(V, F), 1e8)])
    assert_same(lambda kernel: kernel.integrals(V, F))
