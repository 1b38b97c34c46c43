"""Region map: connected regions, adjacent for adjacent nodes, and near their nodes."""

import numpy as np
import pytest
from helpers import joined, moved, path_in

from lbskel import Skeleton, skeletonize
from lbskel.geometry.vertex_map import is_in_largest_piece
from lbskel.refinement.region_map import (
    complete_regions,
    edges_with_disjoint_regions,
    make_regions_connected,
    nearest_balls,
    reassign_to_nearest_node,
)
from lbskel.shapes import capsule, make


def path_along_z(positions, mesh):
    """A path along z; each vertex is mapped to the node nearest in z."""
    nodes = np.stack([np.zeros(len(positions)), np.zeros(len(positions)), positions], axis=1)
    nearest = np.abs(mesh.vertices[:, 2:] - positions).argmin(axis=1)
    edges = np.stack([np.arange(len(nodes) - 1), np.arange(1, len(nodes))], axis=1)
    return Skeleton(nodes, edges, np.full(len(nodes), 0.5), nearest)


def remapped(skeleton, node_of_vertex):
    return Skeleton(skeleton.nodes, skeleton.edges, skeleton.radii, node_of_vertex)


def distances(skeleton, mesh):
    return np.linalg.norm(mesh.vertices - skeleton.nodes[skeleton.node_of_vertex], axis=1)


def test_a_connected_map_is_unchanged():
    mesh = capsule(4.0, 0.5, 32)
    path = path_along_z(np.linspace(-2, 2, 9), mesh)
    assert is_in_largest_piece(path.node_of_vertex, mesh).all()
    assert len(edges_with_disjoint_regions(path, mesh)) == 0
    assert np.array_equal(make_regions_connected(path, mesh).node_of_vertex, path.node_of_vertex)


def test_single_vertices_in_other_regions_come_back():
    mesh = capsule(4.0, 0.5, 32)
    path = path_along_z(np.linspace(-2, 2, 9), mesh)
    inner = np.flatnonzero([len(set(path.node_of_vertex[mesh.faces[(mesh.faces == v).any(axis=1)]].ravel())) == 1
                            for v in range(len(mesh.vertices))])  # fmt: skip
    misplaced = np.array(path.node_of_vertex)
    misplaced[inner[::7]] = (misplaced[inner[::7]] + 4) % 9
    assert not is_in_largest_piece(misplaced, mesh).all()
    assert np.array_equal(make_regions_connected(remapped(path, misplaced), mesh).node_of_vertex, path.node_of_vertex)


@pytest.mark.parametrize("seed", range(5))
def test_any_map_becomes_connected(seed, tripod):
    rng = np.random.default_rng(seed)
    nodes = rng.normal(size=(12, 3))
    tree = Skeleton(
        nodes, [[i, rng.integers(i)] for i in range(1, 12)], np.ones(12), rng.integers(12, size=len(tripod.vertices))
    )
    joined_up = make_regions_connected(tree, tripod)
    assert is_in_largest_piece(joined_up.node_of_vertex, tripod).all()


def test_nodes_closer_than_vertices_have_connected_regions():
    shape = make("tripod", n_vertices=800)
    skeleton = skeletonize(shape.mesh)
    assert is_in_largest_piece(skeleton.node_of_vertex, shape.mesh).all()
    assert len(edges_with_disjoint_regions(skeleton, shape.mesh)) == 0
    # the nearest node is a lower bound; mapping every vertex to the next node adds 12 %
    nearest = np.linalg.norm(shape.mesh.vertices[:, None] - skeleton.nodes, axis=2).min(axis=1)
    assert distances(skeleton, shape.mesh).mean() < 1.02 * nearest.mean()


def test_disjoint_regions_of_adjacent_nodes_are_connected():
    mesh = capsule(4.0, 0.5, 32)
    path = path_along_z(np.linspace(-2, 2, 5), mesh)
    # 1 and 3 are joined too, and node 2 lies between them on the surface
    bypassed = Skeleton(path.nodes, [*path.edges.tolist(), [1, 3]], path.radii, path.node_of_vertex)
    assert edges_with_disjoint_regions(bypassed, mesh).tolist() == [[1, 3]]
    connected = make_regions_connected(bypassed, mesh)
    assert is_in_largest_piece(connected.node_of_vertex, mesh).all()
    assert len(edges_with_disjoint_regions(connected, mesh)) == 0


def test_vertices_without_a_node_get_one_near_them_along_the_skeleton():
    """Only the vertices at the ends of a rod have nodes, the first and the last; the others have been added."""
    mesh = capsule(4.0, 0.5, 32)
    path = path_along_z(np.linspace(-2, 2, 9), mesh)
    known = np.where(np.abs(mesh.vertices[:, 2]) > 2, path.node_of_vertex, -1)
    assert 0 < (known < 0).mean() < 1
    assert set(known[known >= 0]) == {0, 8}
    assert np.array_equal(complete_regions(path, known, mesh), path.node_of_vertex)


def test_known_nodes_are_kept_and_others_follow_them_not_the_distance():
    """Two rods side by side, each with a path of its own; one vertex in each is known, at the far end of the path."""
    rod = capsule(4.0, 0.5, 16)
    n = len(rod.vertices)
    mesh = joined(rod, moved(rod, 1.2))
    one = path_along_z(np.linspace(-2, 2, 9), rod)
    nodes = np.concatenate([one.nodes + [0.9, 0, 0], one.nodes + [0.3, 0, 0]])  # each nearer to the other rod
    both = Skeleton(nodes, np.concatenate([one.edges, one.edges + 9]), np.ones(18))
    known = np.full(2 * n, -1)
    known[0], known[n] = 8, 17
    found = complete_regions(both, known, mesh)
    assert (found[0], found[n]) == (8, 17)
    assert (found[1:n] < 9).all()
    assert (found[n + 1 :] >= 9).all()
    connected = np.delete(is_in_largest_piece(found, mesh), [0, n])
    assert connected.all()


def test_a_known_vertex_within_another_region_is_kept():
    """One vertex in the middle is known to belong to the first node, and one beside it is not known."""
    rod = capsule(4.0, 0.5, 16)
    path = path_along_z(np.linspace(-2, 2, 9), rod)
    known = np.array(path.node_of_vertex)
    inner = np.flatnonzero(known == 4)
    known[inner[0]], known[inner[-1]] = 0, -1
    found = complete_regions(path, known, rod)
    assert (found[inner[0]], found[inner[-1]]) == (0, 4)


def test_where_no_edges_lead_to_a_known_vertex_the_nearest_node_counts():
    rod = capsule(4.0, 0.5, 16)
    mesh = joined(rod, moved(rod, 5.0))
    path = path_along_z(np.linspace(-2, 2, 9), mesh)
    known = np.array(path.node_of_vertex)
    known[len(rod.vertices) :] = -1
    assert np.array_equal(complete_regions(path, known, mesh), path.node_of_vertex)


def test_a_node_of_two_components_keeps_the_vertices_of_both():
    mesh = capsule(4.0, 0.5, 16)
    two = joined(mesh, moved(mesh, 5.0))
    path = path_along_z(np.linspace(-2, 2, 5), two)
    assert np.array_equal(make_regions_connected(path, two).node_of_vertex, path.node_of_vertex)


def test_the_nearest_ball_has_the_smallest_gap():
    mesh = capsule(4.0, 0.5, 16)
    two_balls = Skeleton([[0, 0, -2], [0, 0, 2]], [[0, 1]], [0.5, 1.5])
    # equal gaps where the distances differ by one: (z + 2) - (2 - z) = -1 at z = -0.5, on the axis
    expected = (mesh.vertices[:, 2] > -0.6).astype(int)
    is_clear = np.abs(mesh.vertices[:, 2] + 0.5) > 0.2  # the border is curved
    assert np.array_equal(nearest_balls(two_balls, mesh.vertices)[is_clear], expected[is_clear])


def test_vertices_are_handed_on_to_the_nearest_node_along_the_skeleton():
    mesh = capsule(4.0, 0.5, 32)
    path = path_in(mesh, np.stack([np.zeros(9), np.zeros(9), np.linspace(-2, 2, 9)], axis=1))
    nearest = path.node_of_vertex
    misplaced = Skeleton(path.nodes, path.edges, path.radii, np.clip(nearest + 3, 0, 8))
    assert np.array_equal(reassign_to_nearest_node(misplaced, mesh).node_of_vertex, nearest)
