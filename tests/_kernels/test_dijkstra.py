"""Shortest paths, against scipy's and on graphs whose answers are known."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra


def graph_of(edges, lengths, n):
    graph = coo_array((lengths, np.asarray(edges, dtype=np.int32).T), shape=(n, n))
    return (graph + graph.T).tocsr()


def search_of(kernel, graph):
    return kernel.ShortestPaths(graph.indptr.astype(np.int64), graph.indices.astype(np.int64), graph.data)


@pytest.fixture
def graph(limbs):
    return graph_of(
        limbs.edges, np.linalg.norm(np.diff(limbs.vertices[limbs.edges], axis=1)[:, 0], axis=1), len(limbs.vertices)
    )


SOURCES = np.array([0, 17, 230])


def kinds_of(graph):
    """Goals from node 400 on, and nodes that no path may enter."""
    kinds = np.ones(graph.shape[0], dtype=np.int8)
    kinds[400:], kinds[300:340] = 2, 0
    return kinds


def test_distances_are_those_of_scipy(kernel, graph):
    expected = dijkstra(graph, indices=SOURCES)
    assert search_of(kernel, graph).distances(SOURCES) == pytest.approx(expected, rel=1e-12)


def test_least_sums_are_the_smallest_of_value_and_distance(kernel, graph):
    values = np.random.default_rng(0).uniform(0, 1, graph.shape[0])
    values[7] = np.inf
    expected = (dijkstra(graph) + values[:, None]).min(axis=0)
    found = search_of(kernel, graph).least_sums(values)
    assert (found < values).any()
    assert (found == values).any()
    assert found == pytest.approx(expected, rel=1e-12)


def test_the_nearest_goal_is_that_of_scipy(kernel, graph):
    distance, path = search_of(kernel, graph).nearest_goal(SOURCES, kinds_of(graph))
    allowed = np.delete(np.arange(graph.shape[0]), np.arange(300, 340))
    expected = dijkstra(graph[allowed][:, allowed], indices=np.searchsorted(allowed, SOURCES)).min(axis=0)
    assert distance == pytest.approx(expected[allowed >= 400].min(), rel=1e-12)
    assert path[0] >= 400 > path[1:].max()
    assert path[-1] in SOURCES
    steps = np.asarray(graph[path[1:], path[:-1]]).ravel()
    assert (steps > 0).all()
    assert steps.sum() == pytest.approx(distance, rel=1e-12)


@pytest.fixture
def ladder():
    """Two paths from 0 to 3: over 1, of length 3, and over 2, of length 5; node 4 is reached from nowhere."""
    return graph_of([[0, 1], [1, 3], [0, 2], [2, 3]], [1.0, 2, 2, 3], 5)


def test_a_search_leaves_nothing_behind(kernel, ladder):
    search = search_of(kernel, ladder)
    start, goal = np.array([0]), np.array([1, 1, 1, 2, 1], dtype=np.int8)
    blocked = np.array([1, 0, 1, 2, 1], dtype=np.int8)
    for _ in range(2):
        distance, path = search.nearest_goal(start, goal)
        assert (distance, path.tolist()) == (3, [3, 1, 0])
        distance, path = search.nearest_goal(start, blocked)
        assert (distance, path.tolist()) == (5, [3, 2, 0])
        assert search.distances(np.array([0, 3])).tolist() == [[0, 1, 2, 3, np.inf], [3, 2, 3, 0, np.inf]]


def test_no_path_is_infinitely_long(kernel, ladder):
    distance, path = search_of(kernel, ladder).nearest_goal(np.array([0]), np.array([1, 1, 1, 1, 2], dtype=np.int8))
    assert distance == np.inf
    assert path.tolist() == []


def test_a_start_may_be_a_goal_and_the_nearest_start_counts(kernel, ladder):
    search = search_of(kernel, ladder)
    distance, path = search.nearest_goal(np.array([0, 3]), np.array([2, 1, 1, 1, 1], dtype=np.int8))
    assert (distance, path.tolist()) == (0, [0])
    distance, path = search.nearest_goal(np.array([0, 3]), np.array([1, 2, 1, 1, 1], dtype=np.int8))
    assert (distance, path.tolist()) == (1, [1, 0])


def test_every_node_has_a_kind(kernel, ladder):
    with pytest.raises(ValueError, match="a kind for each node"):
        search_of(kernel, ladder).nearest_goal(np.array([0]), np.ones(4, dtype=np.int8))


def test_compiled_or_not_is_the_same(assert_same, graph):
    assert_same(lambda kernel: [search_of(kernel, graph).distances(SOURCES)])
    assert_same(lambda kernel: search_of(kernel, graph).nearest_goal(SOURCES, kinds_of(graph)))


def offset_search(kernel, mesh, thickness):
    """Searches in a mesh whose vertices move towards the origin."""
    graph = graph_of(mesh.edges, np.ones(len(mesh.edges)), len(mesh.vertices))
    adjacency = graph.indptr.astype(np.int64), graph.indices.astype(np.int64)
    inward = -mesh.vertices / np.linalg.norm(mesh.vertices, axis=1, keepdims=True)
    return kernel.OffsetPaths(*adjacency, np.array(mesh.vertices), inward, thickness, 0.0)


def test_paths_between_vertices_moved_inwards_are_those_of_scipy(kernel, limbs):
    thickness = np.linspace(0.1, 0.3, len(limbs.vertices))
    search = offset_search(kernel, limbs, thickness)
    for depth in (0.0, 0.08, 1.0):
        moved = (
            limbs.vertices * (1 - np.minimum(thickness / 2, depth) / np.linalg.norm(limbs.vertices, axis=1))[:, None]
        )
        lengths = np.linalg.norm(np.diff(moved[limbs.edges], axis=1)[:, 0], axis=1)
        graph = graph_of(limbs.edges, lengths, len(moved))
        path = search.path(3, 400, depth)
        assert path[[0, -1]].tolist() == [3, 400]
        steps = np.asarray(graph[path[1:], path[:-1]]).ravel()
        assert steps.sum() == pytest.approx(dijkstra(graph, indices=3)[400], rel=1e-12)


def test_offset_paths_compiled_or_not_are_the_same(assert_same, limbs):
    thickness = np.linspace(0.1, 0.3, len(limbs.vertices))
    assert_same(lambda kernel: [offset_search(kernel, limbs, thickness).path(3, goal, 0.1) for goal in (50, 400)])
