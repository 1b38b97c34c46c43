"""Vertex maps: composition, transfer in both directions, and completion."""

import numpy as np
import pytest

from lbskel import Mesh, MeshError
from lbskel.geometry.vertex_map import VertexMap, is_in_largest_piece

MAP = VertexMap([2, 0, -1, 2])


def test_indices_are_read_only_and_a_copy():
    given = np.array([1, 0])
    vertex_map = VertexMap(given)
    given[:] = 5
    assert vertex_map.indices.tolist() == [1, 0]
    with pytest.raises(ValueError, match="read-only"):
        vertex_map.indices[0] = 3


def test_identity():
    assert VertexMap.identity(3).indices.tolist() == [0, 1, 2]
    assert VertexMap.identity(3).is_identity
    assert not VertexMap([0, 2, 1]).is_identity
    assert len(MAP) == 4
    assert MAP.is_mapped.tolist() == [True, True, False, True]


def test_composition_applies_this_map_first():
    following = VertexMap([7, -1, 5])
    assert MAP.compose(following).indices.tolist() == [5, 7, -1, 5]
    assert VertexMap.identity(4).compose(MAP).indices.tolist() == MAP.indices.tolist()
    assert MAP.compose(VertexMap.identity(3)).indices.tolist() == MAP.indices.tolist()


def test_composition_is_associative():
    rng = np.random.default_rng(0)
    first, second, third = (VertexMap(rng.integers(-1, 10, size=10)) for _ in range(3))
    one, other = first.compose(second).compose(third), first.compose(second.compose(third))
    assert np.array_equal(one.indices, other.indices)


def test_values_are_pulled_back_from_targets_to_sources():
    assert MAP.pull_back(np.array([10, 11, 12])).tolist() == [12, 10, -1, 12]


def test_of_several_sources_the_first_is_pushed_forward():
    assert MAP.push_forward(np.array([10, 11, 12, 13]), 4).tolist() == [11, -1, 10, -1]


def test_one_source_of_each_target_is_its_last():
    sources = MAP.one_source_per_target(4)
    assert sources.tolist() == [1, -1, 3, -1]
    assert MAP.indices[sources[sources >= 0]].tolist() == [0, 2]


def test_completion_takes_the_nearest_target():
    sources = np.array([[0.0, 0, 0], [1, 0, 0], [2.2, 0, 0], [9, 0, 0]])
    targets = np.array([[5.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    assert MAP.complete(sources, targets).indices.tolist() == [2, 0, 2, 2]
    whole = VertexMap([0, 0])
    assert whole.complete(sources[:2], targets) is whole


def test_the_largest_piece_of_a_target_has_the_most_vertices_and_of_equal_ones_the_smallest_vertex():
    strip = Mesh([[k, k % 2, 0] for k in range(10)], [[k, k + 1, k + 2] for k in range(8)])  # edges span 1 or 2
    targets = np.array([0, 1, 1, 0, 0, 1, 1, -1, -1, 0])
    assert np.flatnonzero(~is_in_largest_piece(targets, strip)).tolist() == [0, 5, 6, 9]
    assert np.flatnonzero(~is_in_largest_piece(targets, strip, np.array([1]))).tolist() == [5, 6]
    with pytest.raises(ValueError, match="a target for each vertex"):
        is_in_largest_piece(targets[:-1], strip)


@pytest.mark.parametrize("indices", [[0.7, 1.9], np.array([0.0, np.nan])])
def test_a_map_has_whole_numbers(indices):
    with pytest.raises(MeshError, match="indices of a vertex map must be whole numbers"):
        VertexMap(indices)
    assert VertexMap([0.0, 1.0]).indices.tolist() == [0, 1]
