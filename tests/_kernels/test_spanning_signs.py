"""Signs along spanning trees, against those that the links were made of."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

rng = np.random.default_rng(6)
N = 60
LINKS = rng.integers(N, size=(70, 2))
TRUTH = rng.choice(np.array([-1, 1], dtype=np.int8), N)


def test_consistent_links_give_the_signs_and_the_parts(kernel):
    sign, part = kernel.spanning_signs(LINKS, TRUTH[LINKS].prod(axis=1, dtype=np.int8), N)
    graph = coo_array((np.ones(len(LINKS)), LINKS.T), shape=(N, N))
    np.testing.assert_array_equal(part, connected_components(graph, directed=False)[1])
    first = np.unique(part, return_index=True)[1]
    np.testing.assert_array_equal(sign, TRUTH * TRUTH[first][part])


def test_the_links_that_come_first_count(kernel):
    links, signs = np.array([[1, 2], [0, 2], [0, 1]]), np.array([-1, -1, -1], dtype=np.int8)
    assert kernel.spanning_signs(links, signs, 4)[0].tolist() == [1, 1, -1, 1]
    assert kernel.spanning_signs(links[::-1].copy(), signs, 4)[0].tolist() == [1, -1, -1, 1]
    with pytest.raises(ValueError, match="a sign for each link"):
        kernel.spanning_signs(links, signs[1:], 4)


def test_compiled_or_not_is_the_same(assert_same):
    signs = rng.choice(np.array([-1, 1], dtype=np.int8), len(LINKS))
    assert_same(lambda kernel: kernel.spanning_signs(LINKS, signs, N))
