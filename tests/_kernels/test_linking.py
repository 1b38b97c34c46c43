"""Sums along trees and around vertices, against sums written out; crossings of segments with known positions."""

import numpy as np

from lbskel.geometry.bvh import build_aabb_tree

PARENT = np.array([2, 2, -9999, 0, 0, 4])
ORDER = np.array([2, 0, 1, 3, 4, 5])
VALUES = np.array([1, 2, 4, 8, 16, 2**64 - 32], dtype=np.uint64)


def test_sums_to_and_from_the_root(kernel):
    to_root = kernel.sums_to_root(ORDER, PARENT, VALUES)
    assert to_root.astype(np.int64).tolist() == [-7, 2, -1, 8, -16, -32]
    from_root = kernel.sums_from_root(ORDER, PARENT, VALUES)
    assert from_root.astype(np.int64).tolist() == [5, 6, 4, 13, 21, -11]


def test_sums_are_modulo_two_to_the_64(kernel):
    large = np.full(6, 2**63, dtype=np.uint64)
    assert kernel.sums_to_root(ORDER, PARENT, large)[[1, 4]].tolist() == [2**63, 0]
    assert kernel.sums_from_root(ORDER, PARENT, large)[[0, 3]].tolist() == [0, 2**63]


def tetrahedron():
    """The twins of the half-edges of a tetrahedron, and the vertex that each leaves."""
    F = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    sides = np.concatenate([F[:, [1, 2]], F[:, [2, 0]], F[:, [0, 1]]])
    row = {tuple(side): k for k, side in enumerate(sides.tolist())}
    return np.array([row[b, a] for a, b in sides.tolist()]), sides[:, 0]


def test_sums_around_each_vertex_begin_with_zero_and_grow_by_the_values(kernel):
    twins, origin = tetrahedron()
    values = np.arange(1, 13, dtype=np.uint64)
    sums = kernel.sums_around_vertices(twins, values)
    following = (twins + 4) % 12
    for vertex in range(4):
        at = np.flatnonzero(origin == vertex)
        assert sums[at[0]] == 0
        others = [side for side in at if following[side] != at[0]]
        assert [sums[following[side]] - sums[side] for side in others] == [values[following[side]] for side in others]


def crossings(kernel, queries, segments, groups=None):
    """Crossings of segments, found by a tree of their boxes."""
    points = np.array(segments, dtype=float).reshape(-1, 3)
    ends = np.arange(len(points)).reshape(-1, 2)
    tree = build_aabb_tree(points, np.column_stack([ends, ends[:, 1]]))
    groups = np.array(groups if groups is not None else [7] * len(ends))
    found = kernel.crossings_above(
        np.array(queries, dtype=float).reshape(-1, 6),
        np.tile([-1, 3], (len(queries), 1)),
        np.ascontiguousarray(tree.corners[:, :6]),
        groups[tree.order],
        tree.bounds,
    )
    return sorted(zip(found[0].tolist(), tree.order[found[1]].tolist(), found[2].tolist(), strict=True))


EAST = [[-1, 0, 0], [1, 0, 0]]
NORTHWARDS_ABOVE = [[0.1, -1, 1], [0.1, 1, 1]]


def test_a_segment_that_passes_above_crosses_to_the_left_or_the_right(kernel):
    southwards = NORTHWARDS_ABOVE[::-1]
    below = [[0.1, -1, -1], [0.1, 1, -1]]
    beside = [[2, -1, 1], [2, 1, 1]]
    steep = [[0, -1, -4], [0, 3, 4]]  # below at its start, below where it crosses
    segments = [NORTHWARDS_ABOVE, southwards, below, beside, steep]
    assert crossings(kernel, [EAST], segments) == [(0, 0, 1), (0, 1, -1)]
    assert crossings(kernel, [EAST[::-1]], segments) == [(0, 0, -1), (0, 1, 1)]


def test_segments_of_a_skipped_group_are_left_out(kernel):
    assert crossings(kernel, [EAST], [NORTHWARDS_ABOVE] * 2, [3, 4]) == [(0, 1, 1)]


def test_all_crossings_of_many_segments_are_found(kernel, assert_same):
    rng = np.random.default_rng(0)
    lower, upper = rng.uniform(size=(2, 60, 2, 3)) + np.array([0, 2.0])[:, None, None, None] * [0, 0, 1]

    def sides(p, q, r):
        return np.sign(np.linalg.det(np.stack([q - p, r - p], axis=-2)))

    expected = []
    for i, (p, q) in enumerate(lower[:, :, :2]):
        for j, (r, s) in enumerate(upper[:, :, :2]):
            if sides(p, q, r) != sides(p, q, s) and sides(r, s, p) != sides(r, s, q):
                expected.append((i, j, int(sides(p, q, s))))
    assert len(expected) > 400  # more than the arrays hold at first
    assert crossings(kernel, lower, upper) == expected
    assert_same(lambda kernel: np.array(crossings(kernel, lower, upper)).T)
