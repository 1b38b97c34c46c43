"""Half-edges by edge against numpy's sort, and glued copies: twins of twins, front to back around an edge."""

import numpy as np


def ends(F):
    """(3 m,) start and end of each half-edge."""
    return F[:, [1, 2, 0]].ravel(), F[:, [2, 0, 1]].ravel()


def test_half_edges_are_in_the_order_of_their_lower_and_higher_vertices(kernel, limbs):
    F, n = limbs.faces, len(limbs.vertices)
    F = np.concatenate([F, F[::7, [1, 0, 2]], F[::9]])  # edges of up to six faces
    order, begins = kernel.half_edges_by_edge(F, n)
    start, end = ends(F)
    key = np.minimum(start, end) * n + np.maximum(start, end)
    assert np.array_equal(order, np.argsort(key, kind="stable"))
    assert np.array_equal(begins, np.append(np.unique(key[order], return_index=True)[1], 3 * len(F)))


def test_copies_of_a_closed_surface_are_glued_to_none_but_themselves(kernel, limbs):
    F = limbs.faces
    twins = kernel.glue_copies(F, *kernel.half_edges_by_edge(F, len(limbs.vertices)))
    half_edges = np.arange(6 * len(F))
    assert np.array_equal(twins[twins], half_edges)
    assert np.array_equal(twins < 3 * len(F), half_edges < 3 * len(F))
    start, end = ends(np.concatenate([F, F[:, [0, 2, 1]]]))
    assert np.array_equal(start[twins], end)


def test_a_single_face_is_glued_to_its_copy(kernel):
    F = np.array([[0, 2, 1]])
    twins = kernel.glue_copies(F, *kernel.half_edges_by_edge(F, 3))
    assert twins.tolist() == [3, 5, 4, 0, 2, 1]


def test_faces_around_an_edge_are_glued_in_the_order_given(kernel):
    """Three faces at the edge from vertex 0 to 1, the second of which runs along it backwards."""
    F = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    order, begins = kernel.half_edges_by_edge(F, 5)
    assert order[: begins[1]].tolist() == [2, 5, 8]
    twins = kernel.glue_copies(F, order, begins)
    copy = 9 + np.array([0, 2, 1, 3, 5, 4, 6, 8, 7])
    assert [twins[2], twins[copy[5]], twins[8]] == [5, copy[8], copy[2]]
    order[:2] = [5, 2]
    assert kernel.glue_copies(F, order, begins)[copy[5]] == copy[2]


def test_compiled_or_not_is_the_same(assert_same, limbs):
    F, n = np.concatenate([limbs.faces, limbs.faces[::5]]), len(limbs.vertices)
    assert_same(lambda kernel: kernel.half_edges_by_edge(F, n))
    assert_same(lambda kernel: [kernel.glue_copies(F, *kernel.half_edges_by_edge(F, n))])
