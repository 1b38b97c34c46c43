"""First hits of rays and winding numbers, on shapes whose answers are closed forms."""

import numpy as np
import pytest

from lbskel.geometry.bvh import build_aabb_tree
from lbskel.shapes import torus


def first_hits(kernel, V, F, origins, directions):
    tree = build_aabb_tree(V, F)
    rays = (np.array(each, dtype=np.float64) for each in (origins, directions))
    return kernel.first_hits(tree.corners, tree.order, tree.bounds, *rays)


def winding_numbers(kernel, V, F, points):
    tree = build_aabb_tree(V, F)
    return kernel.winding_numbers(tree.corners, tree.bounds, np.array(points, dtype=np.float64))


def test_distances_are_in_lengths_of_the_direction(kernel, square):
    origins = [[0.3, 0.6, 2]] * 5
    directions = [[0, 0, -1], [0, 0, -4], [0, 0, 1], [0.1, 0.1, -2], [1, 0, 0]]
    faces, distance = first_hits(kernel, *square, origins, directions)
    assert distance == pytest.approx([2, 0.5, np.inf, 1, np.inf], rel=1e-14)
    assert (faces >= 0).tolist() == [True, True, False, True, False]


def test_the_face_hit_is_the_one_that_holds_the_point(kernel, square):
    V, F = square
    centers = V[F].mean(axis=1)
    faces, distance = first_hits(kernel, V, F, centers + [0, 0, 3], np.tile([0, 0, -1.0], (len(F), 1)))
    assert faces.tolist() == list(range(len(F)))
    assert (distance == 3).all()


def test_a_ray_does_not_hit_what_lies_behind_it(kernel):
    """A slanted triangle, in the plane z = x, whose box holds the origin."""
    V = np.array([[0.0, 0, 0], [2, 0, 2], [0, 2, 0]])
    faces, distance = first_hits(kernel, V, np.array([[0, 1, 2]]), [[0.5, 0.25, 1]] * 2, [[0, 0, 1], [0, 0, -1]])
    assert faces.tolist() == [-1, 0]
    assert distance.tolist() == [np.inf, 0.5]


def test_the_nearest_of_several_faces_is_hit_first(kernel, square):
    V, F = square
    layers = np.concatenate([V + [0, 0, height] for height in (0.0, 3.0, 1.0, 2.0)])
    faces, distance = first_hits(
        kernel,
        layers,
        np.concatenate([F + k * len(V) for k in range(4)]),
        [[0.3, 0.6, 2.5], [0.3, 0.6, 2.5], [0.3, 0.6, -1]],
        [[0, 0, -1], [0, 0, 1], [0, 0, 1]],
    )
    assert distance.tolist() == [0.5, 0.5, 1]
    assert (faces // len(F)).tolist() == [3, 1, 0]


def test_no_ray_passes_between_two_faces(kernel, square):
    """Rays through vertices and along edges."""
    V, F = square
    targets = V[(V[:, 0] > 0) & (V[:, 0] < 1) & (V[:, 1] > 0) & (V[:, 1] < 1)]
    targets = np.concatenate([targets, targets + [0.03, 0, 0], targets + [0.07, 0.07, 0]])
    ways = np.array([0.3, -0.2, -1.0]) + np.zeros_like(targets)
    faces, distance = first_hits(kernel, V, F, targets - 2 * ways, ways)
    assert (faces >= 0).all()
    assert distance == pytest.approx(np.full(len(targets), 2.0))


def test_a_ray_needs_an_origin_and_a_direction(kernel, square):
    with pytest.raises(ValueError, match="a direction for each origin"):
        first_hits(kernel, *square, np.zeros((2, 3)), np.ones((1, 3)))


@pytest.mark.parametrize("sign", [1, -1])
def test_winding_numbers_of_a_torus(kernel, sign):
    ring = torus(1.0, 0.25, 24, 12)
    points = [[1, 0, 0], [0, 0, 0], [0, -1, 0.1], [0, 0, 5], [0, 1, -0.4], [9, 9, 9], [0.8, 0.6, 0]]
    found = winding_numbers(kernel, ring.vertices, np.ascontiguousarray(ring.faces[:, ::sign]), points)
    assert found.tolist() == [sign, 0, sign, 0, 0, 0, sign]


def test_winding_numbers_of_surfaces_inside_each_other_add_up(kernel, box):
    V, F = box
    shells = np.concatenate([V, 3 * V - 1, 5 * V - 2])
    faces = np.concatenate([F, F + 8, F[:, ::-1] + 16])
    points = [[0.5, 0.4, 0.3], [1.5, 0.5, 0.4], [2.5, 0.3, 0.2], [3.5, 0.5, 0.5]]
    assert winding_numbers(kernel, shells, faces, points).tolist() == [1, 0, -1, 0]


def test_points_under_edges_and_vertices_are_counted_once(kernel, box):
    V, F = box
    points = [[0.5, 0.5, 0.5], [0.25, 0.25, 0.5], [0.5, 0.25, -1.0], [0.5, 0.5, -1.0], [0.25, 0.25, -2.0]]
    assert winding_numbers(kernel, V, F, points).tolist() == [1, 1, 0, 0, 0]


def test_compiled_or_not_is_the_same(assert_same, limbs):
    V, F = limbs.vertices, limbs.faces
    directions = np.random.default_rng(1).normal(size=(40, 3))
    assert_same(lambda kernel: first_hits(kernel, V, F, 0.1 * directions[::-1], directions))
    assert_same(lambda kernel: [winding_numbers(kernel, V, F, 0.3 * directions)])
