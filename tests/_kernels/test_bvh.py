"""The tree of boxes, on shapes whose answers are closed forms."""

import numpy as np
import pytest

TRIANGLE = np.array([[0.0, 0, 0], [4, 0, 0], [0, 3, 0]])


def test_boxes_hold_their_faces_and_their_children(kernel, limbs):
    V, F, margin = limbs.vertices, limbs.faces, 0.01
    order = kernel.spatial_order(V, F)
    assert np.array_equal(np.sort(order), np.arange(len(F)))
    corners, boxes = kernel.bounding_boxes(V, F, order, margin)
    assert np.array_equal(corners, V[F[order]].reshape(-1, 9))
    assert boxes[1] == pytest.approx(np.concatenate([V.min(axis=0) - margin, V.max(axis=0) + margin]), rel=1e-15)
    p = len(boxes) // 2
    for leaf in range(p):
        mine = corners[4 * leaf : 4 * leaf + 4].reshape(-1, 3)
        if len(mine):
            assert np.array_equal(
                boxes[p + leaf], np.concatenate([mine.min(axis=0) - margin, mine.max(axis=0) + margin])
            )
        else:
            assert (boxes[p + leaf] == 1e150).all()
    for node in range(1, p):
        first, second = boxes[2 * node], boxes[2 * node + 1]
        if second[0] < 1e150:
            first = np.concatenate([np.minimum(first, second)[:3], np.maximum(first, second)[3:]])
        assert np.array_equal(boxes[node], first)


def test_nodes_are_split_across_the_longest_axis(kernel):
    """Eight faces in a row along y, shuffled: each leaf of four is one half of the row."""
    places = np.random.default_rng(1).permutation(8)
    V = (TRIANGLE / 10 + 10 * places[:, None, None] * [0, 1, 0]).reshape(-1, 3)
    order = kernel.spatial_order(V, np.arange(24).reshape(8, 3))
    assert set(places[order[:4]]) == set(range(4))


def test_compiled_or_not_is_the_same(assert_same, limbs):
    V, F = limbs.vertices, limbs.faces
    assert_same(lambda kernel: [kernel.spatial_order(V, F)])
    assert_same(lambda kernel: kernel.bounding_boxes(V, F, kernel.spatial_order(V, F), 1e-12))
