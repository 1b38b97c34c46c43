"""Short edges and independent collapses, on meshes whose answers are known."""

import numpy as np
import pytest

from lbskel.geometry.mesh import Mesh
from lbskel.shapes import torus

OCTAHEDRON = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


def test_all_edges_are_short_under_a_large_limit(kernel):
    edges, numbers, lengths = kernel.short_edges(OCTAHEDRON, FACES, np.full(6, 1.5), False)
    mesh = Mesh(OCTAHEDRON, FACES)
    assert {tuple(edge) for edge in edges.tolist()} == {tuple(edge) for edge in np.sort(mesh.edges, axis=1).tolist()}
    assert numbers.tolist() == list(range(12))
    assert lengths == pytest.approx(np.sqrt(2))


def test_in_both_directions_every_half_edge_counts(kernel):
    """An open mesh: the boundary edge from 1 to 0 occurs only from the higher vertex to the lower."""
    V, F = OCTAHEDRON[[0, 2, 4, 1]], np.array([[1, 0, 2], [1, 2, 3]])
    edges, numbers, lengths = kernel.short_edges(V, F, np.full(4, 1.5), True)
    assert sorted(edges.tolist()) == sorted(Mesh(V, F).half_edges.tolist())
    assert numbers.tolist() == list(range(6))
    assert lengths == pytest.approx(np.sqrt(2))
    one_way, _, _ = kernel.short_edges(V, F, np.full(4, 1.5), False)
    assert [0, 1] not in one_way.tolist()


THREE_PAGES = [[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 2, 5]]


@pytest.mark.parametrize(
    ("faces", "expected"),
    [
        pytest.param([[0, 1, 2]], False, id="a face alone"),
        pytest.param([[0, 1, 2], [0, 2, 4]], True, id="a boundary edge"),
        pytest.param([[0, 1, 2], [1, 0, 3], [0, 2, 4]], False, id="corner 3 would keep no face"),
        pytest.param([[0, 1, 2], [0, 2, 4], [1, 3, 4]], False, id="a cycle 0, 1, 4 around no face"),
        pytest.param([*THREE_PAGES, [1, 3, 6], [0, 4, 7]], True, id="three pages"),
        pytest.param([*THREE_PAGES, [1, 3, 6]], False, id="one of three pages is a face alone"),
        pytest.param([*THREE_PAGES, [1, 3, 5], [0, 4, 5]], False, id="a cycle 0, 1, 5 in three pages"),
    ],
)
def test_candidates_in_open_and_nonmanifold_meshes(kernel, faces, expected):
    """The edge from 0 to 1, in both directions and with the faces in both orders."""
    low, high, F = np.array([0]), np.array([1]), np.array(faces)
    assert kernel.independent_collapses(F, 8, low, high, 1).tolist() == [expected]
    assert kernel.independent_collapses(F[::-1, ::-1].copy(), 8, high, low, 1).tolist() == [expected]


def test_the_limits_at_both_ends_count(kernel):
    V = OCTAHEDRON * [1, 2, 1]
    limits = np.full(6, 10.0)
    limits[4] = 1.5
    every, _, _ = kernel.short_edges(V, FACES, np.full(6, 10.0), False)
    edges, numbers, lengths = kernel.short_edges(V, FACES, limits, False)
    assert len(every) == 12
    assert len(edges) == 12 - 2  # of those at vertex 4 the two to vertices 2 and 3 have length sqrt(5)
    assert np.array_equal(every[numbers], edges)
    assert lengths == pytest.approx(np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1))
    none, _, _ = kernel.short_edges(OCTAHEDRON, FACES, np.full(6, np.sqrt(2) * (1 - 1e-12)), False)
    assert len(none) == 0


def test_of_edges_that_touch_the_first_is_chosen(kernel):
    edges, _, _ = kernel.short_edges(OCTAHEDRON, FACES, np.full(6, 1.5), False)
    i, j = np.ascontiguousarray(edges[::-1].T)
    assert kernel.independent_collapses(FACES, 6, i, j, 3).tolist() == [True] + 11 * [False]


def test_an_edge_of_a_cycle_of_three_is_not_chosen(kernel):
    """The tube of this torus has three vertices around: collapsing one of these edges would close the tube."""
    ring = torus(1.0, 0.3, 12, 3)
    edges, _, _ = kernel.short_edges(ring.vertices, ring.faces, np.full(len(ring.vertices), 9.0), False)
    mesh_neighbors = [set() for _ in ring.vertices]
    for a, b in edges.tolist():
        mesh_neighbors[a].add(b)
        mesh_neighbors[b].add(a)
    common = np.array([len(mesh_neighbors[a] & mesh_neighbors[b]) for a, b in edges.tolist()])
    assert set(common) == {2, 3}
    for which in (common == 2, common == 3):
        i, j = np.ascontiguousarray(edges[which].T)
        chosen = kernel.independent_collapses(ring.faces, len(ring.vertices), i, j, 1)
        assert chosen.any() == (common[which] == 2).all()


@pytest.mark.parametrize("rounds", [1, 2, 4])
def test_chosen_edges_are_not_adjacent(kernel, limbs, rounds):
    V, F = limbs.vertices, limbs.faces
    edges, _, lengths = kernel.short_edges(V, F, np.full(len(V), 0.15), False)
    i, j = np.ascontiguousarray(edges[np.argsort(lengths, kind="stable")].T)
    chosen = kernel.independent_collapses(F, len(V), i, j, rounds)
    before = kernel.independent_collapses(F, len(V), i, j, rounds - 1)
    assert not (before & ~chosen).any()
    assert chosen.sum() > before.sum()
    is_adjacent = np.eye(len(V), dtype=bool)
    is_adjacent[limbs.edges[:, 0], limbs.edges[:, 1]] = is_adjacent[limbs.edges[:, 1], limbs.edges[:, 0]] = True
    for one in np.flatnonzero(chosen):
        for other in np.flatnonzero(chosen[:one]):
            assert not is_adjacent[np.ix_([i[one], j[one]], [i[other], j[other]])].any()


def test_in_one_round_an_edge_is_chosen_that_precedes_all_around_it(kernel, limbs):
    V, F = limbs.vertices, limbs.faces
    edges, _, lengths = kernel.short_edges(V, F, np.full(len(V), 0.15), False)
    edges = edges[np.argsort(lengths, kind="stable")]
    neighbors = [{k} for k in range(len(V))]
    for a, b in limbs.edges.tolist():
        neighbors[a].add(b)
        neighbors[b].add(a)
    is_candidate = np.array([len((neighbors[a] & neighbors[b]) - {a, b}) == 2 for a, b in edges.tolist()])
    first = np.full(len(V), len(edges))
    for number in np.flatnonzero(is_candidate)[::-1]:
        first[edges[number]] = number
    expected = [
        bool(is_candidate[number]) and min(first[k] for k in neighbors[a] | neighbors[b]) == number
        for number, (a, b) in enumerate(edges.tolist())
    ]
    i, j = np.ascontiguousarray(edges.T)
    assert kernel.independent_collapses(F, len(V), i, j, 1).tolist() == expected


def test_compiled_or_not_is_the_same(assert_same, limbs):
    V, F = limbs.vertices, limbs.faces
    limits = 0.1 + 0.1 * np.random.default_rng(0).random(len(V))
    assert_same(lambda kernel: kernel.short_edges(V, F, limits, False))

    def collapses(kernel):
        i, j = np.ascontiguousarray(kernel.short_edges(V, F, limits, False)[0].T)
        return [kernel.independent_collapses(F, len(V), i, j, 3)]

    assert_same(collapses)
