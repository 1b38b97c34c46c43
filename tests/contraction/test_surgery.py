"""Surgery: a graph with the handles of the surface, whatever the positions, and the same every time.

``python -m benchmarks topology`` does the runs on difficult positions thousands of times, up to genus 9.
"""

import time

import numpy as np
import pytest

from lbskel import Mesh, MeshError, Skeleton, VertexMap, collapse, collapse_mesh, contract, skeletonize
from lbskel.contraction import surgery
from lbskel.contraction.complexes import Complex
from lbskel.contraction.homology import find_tunnels
from lbskel.geometry.deadline import Deadline, OutOfTime
from lbskel.shapes import capsule, chain_of_tori, cylinder, porous_block, sphere, torus

POSITIONS = {
    "scattered": lambda V, rng: rng.normal(size=V.shape),
    "shuffled": lambda V, rng: rng.permutation(V),
    "on a plane": lambda V, rng: rng.normal(size=V.shape) * [1, 1, 0],
    "on a line": lambda V, rng: rng.normal(size=V.shape) * [1, 0, 0],
    "on a grid": lambda V, rng: np.rint(rng.normal(size=V.shape)),
    "squeezed": lambda V, rng: V * 10.0 ** rng.uniform(-4, 1, size=3),
}
MESHES = {
    0: capsule(3.0, 0.4, 8),
    1: torus(1.0, 0.4, 14, 6),
    2: chain_of_tori(2, step=0.35),
    4: chain_of_tori(4, step=0.35),
}


def as_skeleton(graph):
    return Skeleton(graph.nodes, graph.edges, np.zeros(len(graph.nodes)), graph.node_of_vertex)


def scattered(mesh, seed):
    """The same connectivity with every vertex anywhere in a box: the hardest order of collapses."""
    return mesh.with_vertices(np.random.default_rng(seed).normal(size=mesh.vertices.shape))


def cycles_and_components(mesh, positions):
    graph = collapse_mesh(mesh.with_vertices(positions), mesh)
    skeleton = Skeleton(graph.nodes, graph.edges, np.zeros(len(graph.nodes)))
    assert set(graph.node_of_vertex) == set(range(len(graph.nodes)))
    return skeleton.cycle_rank, skeleton.n_components


@pytest.mark.parametrize("genus", [0, 1, 2, 4])
def test_cycles_are_handles_after_a_contraction(genus):
    mesh = chain_of_tori(genus) if genus else capsule(3.0, 0.4, 20)
    graph = collapse_mesh(contract(mesh).mesh, mesh)
    skeleton = as_skeleton(graph)
    assert (skeleton.n_components, skeleton.cycle_rank) == (1, genus)
    assert graph.handles_certified
    assert len(graph.node_of_vertex) == len(mesh.vertices)
    assert set(graph.node_of_vertex) == set(range(len(graph.nodes)))


def test_a_contraction_collapses_to_nodes_at_vertices_of_its_coarse_mesh():
    mesh = torus(1.0, 0.3, 40, 16)
    contraction = contract(mesh)
    assert len(contraction.coarse.vertices) < len(mesh.vertices)
    graph = collapse(contraction)
    assert np.array_equal(graph.nodes, contraction.coarse.vertices[graph.kept])
    assert len(graph.node_of_vertex) == len(mesh.vertices)
    # the vertices merged into a kept vertex of the coarse mesh belong to its node
    own = contraction.vertex_map.indices
    for node, vertex in enumerate(graph.kept):
        assert set(graph.node_of_vertex[own == vertex]) == {node}
    same = collapse_mesh(contraction.coarse, mesh, vertex_map=contraction.vertex_map)
    assert np.array_equal(graph.edges, same.edges)
    assert np.array_equal(graph.node_of_vertex, same.node_of_vertex)


def test_two_meshes_may_be_pairs_of_arrays():
    mesh = torus(1.0, 0.3, 12, 6)
    pair = (mesh.vertices, mesh.faces)
    assert collapse_mesh(pair, pair).edges.tolist() == collapse_mesh(mesh, mesh).edges.tolist()


@pytest.mark.parametrize("seed", range(20))
def test_no_handle_is_lost_and_no_loop_left_on_random_positions(seed):
    for mesh in (torus(1.0, 0.4, 14, 6), sphere(2)):
        skeleton = as_skeleton(collapse_mesh(scattered(mesh, seed), mesh))
        assert (skeleton.n_components, skeleton.cycle_rank) == (1, mesh.genus)


def test_random_positions_at_higher_genus():
    mesh = chain_of_tori(3)
    skeleton = as_skeleton(collapse_mesh(scattered(mesh, 1), mesh))
    assert (skeleton.n_components, skeleton.cycle_rank) == (1, 3)


@pytest.mark.parametrize("genus", MESHES)
@pytest.mark.parametrize("kind", POSITIONS)
def test_every_handle_is_kept_on_any_positions(genus, kind):
    mesh = MESHES[genus]
    assert mesh.genus == genus
    for seed in range(3):
        positions = POSITIONS[kind](mesh.vertices, np.random.default_rng(seed))
        assert cycles_and_components(mesh, positions) == (genus, 1)


@pytest.mark.parametrize(("kind", "seed"), [("squeezed", 11), ("on a line", 15), ("on a grid", 46), ("scattered", 78)])
def test_surgery_goes_on_where_no_edge_may_collapse_and_none_is_free(kind, seed):
    # these come down to a torus of a few vertices, each of whose edges would close the tunnel
    mesh = torus(1.0, 0.6, 20, 16)
    positions = POSITIONS[kind](mesh.vertices, np.random.default_rng(seed))
    assert cycles_and_components(mesh, positions) == (1, 1)


@pytest.mark.parametrize("genus", [0, 1])
def test_surgery_ends_where_all_vertices_are_one_point(genus):
    assert cycles_and_components(MESHES[genus], np.zeros(MESHES[genus].vertices.shape)) == (genus, 1)


@pytest.mark.parametrize(("genus", "noise"), [(1, 0.5), (2, 1.0)])
def test_skeletons_of_surfaces_that_intersect_themselves_keep_their_handles(genus, noise):
    mesh = MESHES[genus]
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    height = noise * np.linalg.norm(end - start, axis=1).mean()
    heights = height * np.random.default_rng(0).normal(size=mesh.vertices.shape)
    skeleton = skeletonize(mesh.with_vertices(mesh.vertices + heights))
    assert (skeleton.n_components, skeleton.cycle_rank) == (1, genus)


def test_the_loop_that_is_kept_is_the_one_around_the_tunnel():
    # a torus contracted the wrong way: the long way around is short in space, yet it is the loop that must stay
    n, m = 30, 8
    mesh = torus(1.0, 0.3, n, m)
    squeezed = mesh.with_vertices(mesh.vertices * [0.01, 0.01, 5.0])
    graph = collapse_mesh(squeezed, mesh)
    skeleton = as_skeleton(graph)
    assert skeleton.cycle_rank == 1
    [loop] = skeleton.branches
    rings = np.arange(n * m).reshape(n, m)  # around the hole from row to row, around the tube along each

    def turns(closed_path):
        """How often a closed path over the surface runs around the loop: forward less backward over its first edge."""
        nodes = graph.node_of_vertex[closed_path]
        steps = list(zip(nodes.tolist(), np.roll(nodes, -1).tolist(), strict=True))
        return steps.count((loop[0], loop[1])) - steps.count((loop[1], loop[0]))

    assert {abs(turns(rings[:, column])) for column in range(m)} == {1}
    assert {turns(rings[row]) for row in range(n)} == {0}


def test_regions_are_connected():
    mesh = chain_of_tori(2)
    graph = collapse_mesh(contract(mesh).mesh, mesh)
    same = graph.node_of_vertex[mesh.edges[:, 0]] == graph.node_of_vertex[mesh.edges[:, 1]]
    inner = Skeleton(mesh.vertices, mesh.edges[same], np.zeros(len(mesh.vertices)))
    # the vertices of each node are connected by edges among them, so there are as many components as nodes
    assert inner.n_components == len(graph.nodes)


def test_open_meshes_collapse_without_a_certificate():
    mesh = cylinder(0.3, 4.0, 24, 41)
    graph = collapse_mesh(contract(mesh).mesh, mesh)
    assert not graph.handles_certified
    assert as_skeleton(graph).n_components == 1


def test_two_runs_give_the_same_bytes():
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


def test_certificates_are_left_out_where_half_the_time_does_not_suffice(monkeypatch):
    mesh = torus(1.0, 0.3, 16, 8)

    def late(mesh, *, deadline):
        assert 4e8 < deadline.seconds_left < 6e8
        raise OutOfTime

    contraction = contract(mesh)
    monkeypatch.setattr(surgery, "find_tunnels", late)
    graph = collapse(contraction, deadline=Deadline(time.perf_counter() + 1e9))
    assert not graph.handles_certified
    assert len(graph.node_of_vertex) == len(mesh.vertices)


def test_regions_meet_on_one_side_of_each_tunnel():
    """The sum of the cochain from one region's first vertex to another's is the same across every edge between them."""
    mesh = porous_block(10, filled=0.6)
    cochain = find_tunnels(mesh).cochain()[:, 0]
    region = collapse(contract(mesh)).node_of_vertex
    start, end = np.concatenate([mesh.edges, mesh.edges[:, ::-1]]).T
    value = np.concatenate([cochain, -cochain])
    sums, is_known = np.zeros(len(region), dtype=np.int64), np.zeros(len(region), dtype=bool)
    is_known[np.unique(region, return_index=True)[1]] = True
    while not is_known.all():
        reached = np.flatnonzero((region[start] == region[end]) & is_known[start] & ~is_known[end])
        assert len(reached)
        sums[end[reached]] = sums[start[reached]] + value[reached]
        is_known[end[reached]] = True
    across = sums[start] + value - sums[end]
    assert not across[region[start] == region[end]].any()
    pairs = {(*pair, total) for *pair, total in zip(region[start], region[end], across, strict=True)}
    assert len(pairs) == len({pair[:2] for pair in pairs})


@pytest.mark.parametrize(("removed", "target"), [(3, 0), (0, 3)])
def test_a_collapse_keeps_the_sum_around_a_loop(removed, target):
    """The loop 0 1 2 3 has the sum 2 + 7 + 11 - 5 before; of an edge of it collapsed, the triangle has the same."""
    edges, cochain = np.array([[0, 1], [0, 3], [1, 2], [2, 3]]), np.array([[2], [5], [7], [11]])
    square = Complex(np.empty((0, 3), dtype=np.int64), edges, cochain, np.zeros(4, dtype=bool))
    after, in_conflict = surgery._collapse_edges(square, np.array([removed]), np.array([target]), np.array([1]), 4)
    assert not in_conflict.any()
    value = {tuple(edge): int(number) for edge, number in zip(after.edges.tolist(), after.cochain[:, 0], strict=True)}
    around = [(1, 2), (2, target), (target, 1)]
    assert sum(value[pair] if pair[0] < pair[1] else -value[pair[::-1]] for pair in around) == 2 + 7 + 11 - 5


def test_the_vertex_that_stays_takes_the_lines_of_the_one_merged_into_it():
    """Two triangles whose costs are written out: squared distances to lines, and a tenth of products of lengths.

    Vertex 3 goes into 2 first (cost 3.2, any other at least 4.8). With its lines at 2, the next is 0 into 2 (7.5, any
    other at least 10.0); without them it would be 2 into 0 (4.3, any other at least 6.1).
    """
    strip = Mesh([[4, 4, 0], [3, 1, 0], [2, 5, 0], [0, 6, 0]], [[0, 1, 2], [1, 3, 2]])
    graph = collapse_mesh(strip, strip)
    assert graph.kept.tolist() == [1, 2]
    assert graph.node_of_vertex.tolist() == [1, 0, 1, 1]


def test_another_source_is_refused(ring, rod):
    with pytest.raises(MeshError, match=r"the contracted mesh \(Mesh\(152 .* must have the faces of its source"):
        collapse_mesh(rod, ring)
    with pytest.raises(MeshError, match="must have the faces of its source"):
        collapse_mesh(Mesh(ring.vertices, ring.faces[:-1]), ring)
    for indices in (np.zeros(3), np.full(len(ring.vertices), len(rod.vertices))):
        with pytest.raises(MeshError, match=r"the vertex map of \d+ vertices does not lead from the source"):
            collapse_mesh(rod, ring, vertex_map=VertexMap(indices))
