"""Components, umbrellas, descent to nodes and neighbor sums, on graphs whose answers are known."""

import numpy as np
import pytest

from lbskel.geometry.mesh import Mesh


def test_component_roots_are_the_smallest_vertices_of_regions_of_equal_label(kernel):
    edges = np.array([[6, 5], [5, 4], [4, 3], [1, 0], [2, 3], [0, 6]])
    labels = np.array([0, 0, 1, 1, 1, 0, 0])
    assert kernel.component_roots(edges, labels).tolist() == [0, 0, 2, 2, 2, 0, 0]


def test_a_negative_label_connects_nothing(kernel):
    edges = np.array([[0, 1], [1, 2], [2, 3]])
    assert kernel.component_roots(edges, np.array([-1, -1, 0, 0])).tolist() == [0, 1, 2, 2]


def umbrellas(kernel, faces):
    mesh = Mesh(np.random.default_rng(0).random((np.max(faces) + 1, 3)), faces)
    return kernel.count_umbrellas(mesh.faces, mesh.edge_of_half_edge, len(mesh.edges))


TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def test_umbrellas_of_a_manifold_are_its_vertices(kernel, limbs):
    assert umbrellas(kernel, TETRAHEDRON) == 4
    assert umbrellas(kernel, limbs.faces) == len(limbs.vertices)


def test_a_pinched_vertex_has_two_umbrellas(kernel):
    other = np.array([3, 4, 5, 6])[TETRAHEDRON]
    assert umbrellas(kernel, np.concatenate([TETRAHEDRON, other])) == 8  # of seven vertices


def test_umbrellas_need_faces_that_are_oriented_alike(kernel):
    faces = TETRAHEDRON.copy()
    faces[1] = faces[1, ::-1]
    assert umbrellas(kernel, faces) == -1


def test_descent_goes_on_to_the_nearest_node_of_a_path(kernel):
    nodes = np.array([[float(k), 0, 0] for k in range(6)])
    first, neighbors = np.array([0, 1, 3, 5, 7, 9, 10]), np.array([1, 0, 2, 1, 3, 2, 4, 3, 5, 4])
    vertices = np.array([[4.2, 1, 0], [-3, 0, 0], [2.5, 0, 0], [2.4, 0, 9]])
    found = kernel.descend_to_nearest_node(vertices, np.array([0, 5, 2, 5]), nodes, first, neighbors)
    assert found.tolist() == [4, 0, 2, 2]  # a tie stays where it is


def test_descent_ends_where_no_neighbor_is_nearer(kernel):
    nodes = np.array([[0.0, 0, 0], [5, 5, 0], [1, 0, 0]])  # the way to the nearest leads away first
    first, neighbors = np.array([0, 1, 3, 4]), np.array([1, 0, 2, 1])
    found = kernel.descend_to_nearest_node(np.array([[0.9, 0, 0]]), np.array([0]), nodes, first, neighbors)
    assert found.tolist() == [0]


def test_descent_refuses_maps_of_other_meshes(kernel):
    with pytest.raises(ValueError, match="a node for each vertex"):
        kernel.descend_to_nearest_node(
            np.zeros((2, 3)), np.zeros(1, dtype=np.int64), np.zeros((1, 3)), np.zeros(2, dtype=np.int64), np.arange(1)
        )


def test_neighbor_sums(kernel):
    values = np.array([[1.0, 10], [2, 20], [4, 40], [8, 80]])
    sums = kernel.neighbor_sums(np.array([[0, 1], [2, 1]]), values)
    assert sums.tolist() == [[2, 20], [5, 50], [2, 20], [0, 0]]


def test_compiled_or_not_is_the_same(assert_same, limbs):
    rng = np.random.default_rng(4)
    n, edges = len(limbs.vertices), limbs.edges
    labels, node_of_vertex = rng.integers(-1, 3, size=n), rng.integers(9, size=n)
    first, neighbors = (
        np.array([0, *range(1, 17, 2), 16]),
        np.array([1, *(k for j in range(1, 8) for k in (j - 1, j + 1)), 7]),
    )
    nodes, values = rng.normal(size=(9, 3)), rng.normal(size=(n, 2))
    assert_same(lambda kernel: [kernel.component_roots(edges, labels)])
    assert_same(lambda kernel: [kernel.count_umbrellas(limbs.faces, limbs.edge_of_half_edge, len(edges))])
    assert_same(lambda kernel: [kernel.neighbor_sums(edges, values)])
    assert_same(
        lambda kernel: [kernel.descend_to_nearest_node(limbs.vertices, node_of_vertex, nodes, first, neighbors)]
    )
