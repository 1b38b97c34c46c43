"""The complex of faces and edges: what may be removed of it, and which edges must stay."""

import numpy as np

from lbskel.contraction.complexes import (
    Complex,
    closing_edges,
    free_edges,
    has_face,
    keys_of,
    open_surfaces,
    remove_free_edges,
    unique_rows,
)

N = 6
# a triangle 0 1 2 with a face beside it, and a triangle 2 3 4 without one; 5 hangs from 4
EDGES = np.array([[0, 1], [0, 2], [1, 2], [2, 3], [2, 4], [3, 4], [4, 5]])


def complex_of(faces, cochain=(0,) * 7):
    return Complex(np.array(faces).reshape(-1, 3), EDGES, np.array(cochain)[:, None], np.zeros(len(EDGES), dtype=bool))


def pairs(keys):
    return {divmod(int(key), N) for key in keys}


def test_edges_with_a_face_are_its_three_sides():
    remaining = complex_of([[0, 1, 2]])
    assert EDGES[has_face(remaining, N)].tolist() == [[0, 1], [0, 2], [1, 2]]
    assert pairs(free_edges(remaining, N)) == {(0, 1), (0, 2), (1, 2)}
    assert pairs(keys_of(EDGES[:2], N)) == {(0, 1), (0, 2)}


def test_the_longest_free_edge_goes_with_its_face_and_is_remembered():
    P = np.array([[0, 0, 0], [1, 0, 0], [0, 3, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]], dtype=float)
    remaining = complex_of([[0, 1, 2]])
    after = remove_free_edges(remaining, free_edges(remaining, N), P, N)
    assert len(after.faces) == 0
    assert after.edges[after.is_removed].tolist() == [[1, 2]]
    assert np.array_equal(after.edges, EDGES)


def test_an_edge_of_a_triangle_with_a_sum_closes_a_tunnel():
    """Of 2 3 4 the edge 2 4 has the value 5, the others 2 and 3, so that their sum is zero, or one more."""
    assert pairs(closing_edges(complex_of([], [1, 1, 0, 2, 5, 3, 7]), N)) == set()
    assert pairs(closing_edges(complex_of([], [1, 1, 0, 2, 6, 3, 7]), N)) == {(2, 3), (2, 4), (3, 4)}
    assert pairs(closing_edges(complex_of([], [0, 1, 0, 2, 5, 3, 7]), N)) == {(0, 1), (0, 2), (1, 2)}


def test_every_part_of_a_closed_surface_loses_one_face():
    tetrahedron = np.array([[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]])
    remaining = Complex(np.concatenate([tetrahedron, tetrahedron + 4]), *(np.empty((0, 2), dtype=np.int64),) * 3)
    assert np.array_equal(open_surfaces(remaining, 8).faces, np.concatenate([tetrahedron[1:], tetrahedron[1:] + 4]))


def test_faces_are_kept_once_in_order():
    faces = np.array([[1, 2, 3], [0, 1, 2], [1, 2, 3], [0, 1, 3]])
    assert unique_rows(faces).tolist() == [[0, 1, 2], [0, 1, 3], [1, 2, 3]]
