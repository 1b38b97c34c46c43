"""Surgery: a graph with the tunnels of the surface, whatever the positions, and the same every time."""

import numpy as np
import pytest

from lbskel import Mesh, Skeleton, collapse, collapse_mesh, contract
from lbskel.shapes import capsule, chain_of_tori, cylinder, sphere, torus


def as_skeleton(graph):
    return Skeleton(graph.nodes, graph.edges, np.zeros(len(graph.nodes)), graph.node_of_vertex)


def scattered(mesh, seed):
    """The same connectivity with every vertex anywhere in a box: the hardest order of collapses."""
    return mesh.with_vertices(np.random.default_rng(seed).normal(size=mesh.vertices.shape))


@pytest.mark.parametrize("genus", [0, 1, 2, 4])
def test_cycles_are_handles_after_a_contraction(genus):
    mesh = chain_of_tori(genus) if genus else capsule(3.0, 0.4, 20)
    contracted = contract(mesh).mesh
    graph = collapse_mesh(contracted, mesh)
    skeleton = as_skeleton(graph)
    assert (skeleton.n_components, skeleton.cycle_rank) == (1, genus)
    assert graph.handles_certified
    assert len(graph.node_of_vertex) == len(mesh.vertices)
    assert set(graph.node_of_vertex) == set(range(len(graph.kept)))


@pytest.mark.parametrize("seed", range(20))
def test_no_tunnel_is_lost_and_no_loop_left_on_random_positions(seed):
    for mesh in (torus(1.0, 0.4, 14, 6), sphere(2)):
        graph = collapse_mesh(scattered(mesh, seed), mesh)
        skeleton = as_skeleton(graph)
        assert (skeleton.n_components, skeleton.cycle_rank) == (1, mesh.genus)


def test_random_positions_at_higher_genus():
    mesh = chain_of_tori(3)
    graph = collapse_mesh(scattered(mesh, 1), mesh)
    assert (as_skeleton(graph).n_components, as_skeleton(graph).cycle_rank) == (1, 3)


def test_the_tunnel_that_is_kept_is_the_right_one():
    # a flat torus contracted the wrong way: the long way round is short in space, yet it is what has to stay
    n, m = 30, 8
    mesh = torus(1.0, 0.3, n, m)
    squeezed = mesh.with_vertices(mesh.vertices * [0.01, 0.01, 5.0])
    graph = collapse_mesh(squeezed, mesh)
    skeleton = as_skeleton(graph)
    assert skeleton.cycle_rank == 1
    [loop] = skeleton.branches
    rings = np.arange(n * m).reshape(n, m)  # around the hole from row to row, around the tube along each

    def turns(way):
        """How often a closed way over the surface goes round the loop: over its first edge, there less back."""
        there = graph.node_of_vertex[way]
        steps = list(zip(there.tolist(), np.roll(there, -1).tolist(), strict=True))
        return steps.count((loop[0], loop[1])) - steps.count((loop[1], loop[0]))

    assert {abs(turns(rings[:, column])) for column in range(m)} == {1}
    assert {turns(rings[row]) for row in range(n)} == {0}


def test_regions_are_connected():
    mesh = chain_of_tori(2)
    graph = collapse_mesh(contract(mesh).mesh, mesh)
    same = graph.node_of_vertex[mesh.edges[:, 0]] == graph.node_of_vertex[mesh.edges[:, 1]]
    inner = Skeleton(mesh.vertices, mesh.edges[same], np.zeros(len(mesh.vertices)))
    # each node's vertices hang together by edges between them, so there are as many pieces as nodes
    assert inner.n_components == len(graph.kept)


def test_open_meshes_collapse_without_a_guard():
    mesh = cylinder(0.3, 4.0, 24, 41)
    contracted = contract(mesh).mesh
    graph = collapse_mesh(contracted, mesh)
    assert not graph.handles_certified
    assert as_skeleton(graph).n_components == 1


def test_twice_gives_the_same_bytes():
    mesh = torus(1.0, 0.3, 40, 16)
    contracted = contract(mesh).mesh
    first, second = collapse_mesh(contracted, mesh), collapse_mesh(contracted, mesh)
    assert first.edges.tobytes() == second.edges.tobytes()
    assert first.kept.tobytes() == second.kept.tobytes()


def test_unused_vertices_have_no_node():
    mesh = torus(1.0, 0.3, 12, 6)
    more = Mesh(np.concatenate([mesh.vertices, [[9, 9, 9]]]), mesh.faces)
    graph = collapse_mesh(more, more)
    assert graph.node_of_vertex[-1] == -1
    assert (graph.node_of_vertex[:-1] >= 0).all()


def test_a_contraction_collapses_to_nodes_at_vertices_of_its_coarse_mesh():
    mesh = torus(1.0, 0.3, 40, 16)
    contraction = contract(mesh)
    assert len(contraction.coarse.vertices) < len(mesh.vertices)
    graph = collapse(contraction)
    assert np.array_equal(graph.nodes, contraction.coarse.vertices[graph.kept])
    assert len(graph.node_of_vertex) == len(mesh.vertices)
    # a node is the position of one of the vertices that were merged into it
    own = contraction.vertex_map.pull_back(np.arange(len(contraction.coarse.vertices)))
    assert np.array_equal(np.unique(graph.node_of_vertex[np.isin(own, graph.kept)]), np.arange(len(graph.nodes)))
    same = collapse_mesh(contraction.coarse, mesh, vertex_map=contraction.vertex_map)
    assert np.array_equal(graph.edges, same.edges)
    assert np.array_equal(graph.node_of_vertex, same.node_of_vertex)


def test_two_meshes_may_be_pairs_of_arrays():
    mesh = torus(1.0, 0.3, 12, 6)
    pair = (mesh.vertices, mesh.faces)
    assert collapse_mesh(pair, pair).edges.tolist() == collapse_mesh(mesh, mesh).edges.tolist()
