"""Neighboring faces, the sign of the angle between them, and parts made connected."""

import numpy as np
import pytest
from helpers import box_mesh, triangle_soup

from lbskel import Mesh
from lbskel.applications.face_graph import MIN_FACES, connect_parts, face_graph
from lbskel.shapes import sphere, torus


def test_a_box_is_convex_at_its_edges_and_flat_across_them():
    graph = face_graph(box_mesh([1, 2, 3]))
    assert len(graph.pairs) == 18
    assert np.sort(graph.turns) == pytest.approx([-np.pi / 2] * 12 + [0] * 6)
    assert graph.lengths.sum() == pytest.approx(4 * 6 + 2 * (np.hypot(1, 2) + np.hypot(2, 3) + np.hypot(1, 3)))


def test_the_inside_of_a_ring_is_concave_and_a_reversed_mesh_is_the_same():
    mesh = torus(1.0, 0.25, 32, 16)
    graph, reverse = face_graph(mesh), face_graph(Mesh(mesh.vertices, mesh.faces[:, ::-1]))
    assert graph.turns.max() == pytest.approx(2 * np.pi / 32, rel=0.1)  # at the hole; the tube turns 2 pi / 16 outwards
    assert graph.turns.min() == pytest.approx(-2 * np.pi / 16, rel=0.1)
    assert reverse.turns == pytest.approx(graph.turns)


def test_a_soup_of_triangles_has_the_neighbors_of_the_mesh(ring):
    graph, soup = face_graph(ring), face_graph(triangle_soup(ring))
    assert sorted(map(tuple, soup.pairs.tolist())) == sorted(map(tuple, graph.pairs.tolist()))


def test_an_edge_of_three_faces_joins_them_in_a_row():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    assert face_graph(mesh).pairs.tolist() == [[0, 1], [1, 2]]


def test_fragments_join_the_part_around_them_and_parts_stay():
    mesh = sphere(3)
    height = mesh.vertices[mesh.faces].mean(axis=1)[:, 2]
    labels = (height > 0.2).astype(np.int64)
    wanted, graph = labels.copy(), face_graph(mesh)
    labels[[np.argmax(height), np.argmin(height)]] = [0, 1]  # a hole at each pole
    rng = np.random.default_rng(0)
    assert np.array_equal(connect_parts(labels, graph, mesh.face_areas), wanted)
    mixed = connect_parts(rng.integers(0, 4, len(labels)), graph, mesh.face_areas)
    for label in np.unique(mixed):
        edges = graph.pairs[(mixed[graph.pairs] == label).all(axis=1)]
        assert np.array_equal(np.unique(edges), np.flatnonzero(mixed == label))
        assert Mesh(np.zeros((len(mixed), 3)), np.column_stack([edges, edges[:, 0]])).n_components == 1


def test_a_part_on_two_surfaces_keeps_a_piece_on_each():
    one = sphere(1)
    two = Mesh(np.concatenate([one.vertices, one.vertices + 5]), np.concatenate([one.faces, one.faces + 42]))
    labels = np.zeros(160, dtype=np.int64)
    assert connect_parts(labels, face_graph(two), two.face_areas).tolist() == labels.tolist()


def test_a_part_with_too_few_faces_for_a_tube_joins_a_neighbor_unless_it_is_alone():
    mesh = sphere(2)
    graph, areas = face_graph(mesh), mesh.face_areas
    labels = np.zeros(len(areas), dtype=np.int64)
    crumb = labels.copy()
    crumb[graph.pairs[0]] = 1
    assert connect_parts(crumb, graph, areas).tolist() == labels.tolist()
    limb = (mesh.vertices[mesh.faces].mean(axis=1)[:, 2] > 0.9).astype(np.int64)
    assert np.count_nonzero(limb) >= MIN_FACES
    assert connect_parts(limb, graph, areas).tolist() == limb.tolist()
    pyramid = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    whole = connect_parts(np.array([0, 1, 2, 3]), face_graph(pyramid), pyramid.face_areas)
    assert len(set(whole.tolist())) == 1
