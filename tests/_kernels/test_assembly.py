"""Assembly of symmetric matrices, against scipy's sum of triplets."""

import numpy as np
from scipy.sparse import coo_array, csc_array


def test_the_matrix_is_the_sum_of_its_triplets(kernel, limbs):
    F, n = limbs.faces, len(limbs.vertices)
    entries = np.random.default_rng(0).normal(size=F.shape)
    diagonal = np.arange(n) % 7.0
    matrix = csc_array(kernel.assemble_symmetric(F, entries, diagonal), shape=(n, n))
    i, j = F[:, [1, 2, 0]].ravel(), F[:, [2, 0, 1]].ravel()
    expected = coo_array((entries.ravel(), (i, j)), shape=(n, n)).toarray()
    assert np.allclose(matrix.toarray(), expected + expected.T + np.diag(diagonal), rtol=0, atol=1e-14)
    assert (matrix.toarray() == matrix.toarray().T).all()


def test_rows_ascend_and_zeros_are_left_out(kernel):
    F = np.array([[0, 1, 2], [2, 1, 3]])
    entries = np.array([[1.0, 0.0, 2.0], [0.0, 3.0, -1.0]])  # edge 12 has 1 in one face and -1 in the other
    values, rows, starts = kernel.assemble_symmetric(F, entries, np.array([5.0, 0.0, 0.0, 0.0]))
    assert starts.tolist() == [0, 2, 3, 4, 5]
    assert rows.tolist() == [0, 1, 0, 3, 2]
    assert values.tolist() == [5.0, 2.0, 2.0, 3.0, 3.0]


def test_compiled_or_not_is_the_same(assert_same, limbs):
    entries = np.random.default_rng(6).normal(size=limbs.faces.shape)
    entries[0] = 0
    assert_same(lambda kernel: kernel.assemble_symmetric(limbs.faces, entries, np.arange(len(limbs.vertices)) % 7.0))


def test_entries_of_an_edge_from_a_vertex_to_itself_are_on_the_diagonal_twice(kernel):
    F = np.array([[0, 0, 1]])  # the edges opposite its corners are 01, 10 and 00
    values, rows, starts = kernel.assemble_symmetric(F, np.array([[1.0, 2.0, 5.0]]), np.array([0.5, -1.0]))
    assert starts.tolist() == [0, 2, 4]
    assert rows.tolist() == [0, 1, 0, 1]
    assert values.tolist() == [10.5, 3.0, 3.0, -1.0]
