"""The tunnel cochain: zero around faces and limbs, not zero around tunnels; transfer to graphs."""

import itertools

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from lbskel import Mesh
from lbskel.contraction.homology import find_tunnels, transfer_cochain
from lbskel.geometry.deadline import Deadline, OutOfTime
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.vertex_map import VertexMap
from lbskel.shapes import chain_of_tori, lattice, porous_block, sphere, torus


def tunnel_cochain(mesh):
    return find_tunnels(mesh).cochain()


def loop_sum(mesh, cochain, loop):
    """The sum of a cochain along a closed path of vertices."""
    total = np.zeros(cochain.shape[1], dtype=np.int64)  # modulo 2^64
    key = {tuple(edge): row for row, edge in enumerate(mesh.edges.tolist())}
    for a, b in zip(loop, np.roll(loop, -1), strict=True):
        total += cochain[key[min(a, b), max(a, b)]] * (1 if a < b else -1)
    return total


def test_the_two_loops_of_a_torus():
    n, m = 24, 10
    mesh = torus(1.0, 0.3, n, m)
    cochain = tunnel_cochain(mesh)
    assert cochain.shape == (len(mesh.edges), 1)
    around_the_tube = np.arange(m)
    around_the_hole = np.arange(n) * m
    assert not loop_sum(mesh, cochain, around_the_tube).any()
    assert loop_sum(mesh, cochain, around_the_hole).any()


@pytest.mark.parametrize(
    ("mesh", "genus"),
    [(chain_of_tori(1), 1), (chain_of_tori(5, step=0.2), 5), (lattice(3), 28), (lattice(5), 176)],
    ids=["ring", "chain", "lattice", "large lattice"],
)
def test_sums_around_faces_are_zero_and_the_rank_is_the_genus(mesh, genus):
    tunnels = find_tunnels(mesh)
    assert tunnels.genus == mesh.genus == genus
    m = len(mesh.faces)
    sign = np.where(mesh.half_edges[:, 0] < mesh.half_edges[:, 1], 1, -1)[:, None]
    independent = np.concatenate(list(tunnels.independent_cochains(1000)), axis=1)
    assert independent.shape == (len(mesh.edges), genus)
    assert np.linalg.matrix_rank(independent[tunnels.form.basis.generators]) == genus
    for cochain in (tunnels.cochain(), independent):
        assert not (sign * cochain[mesh.edge_of_half_edge]).reshape(3, m, -1).sum(axis=0).any()


def test_the_mouths_of_a_lattice_are_tunnels_and_its_bars_are_not():
    """A bar is a prism around the x axis, a mouth a square of four bars."""
    mesh = lattice(2, spacing=5)
    cochain = tunnel_cochain(mesh)
    around = np.array([[2, 0.5, 0], [2, 0, 0.5], [2, -0.5, 0], [2, 0, -0.5]])
    mouth = [[x, y, 0.5] for x, y in itertools.product(range(6), range(6)) if 0 in (x, y) or 5 in (x, y)]
    loop = cKDTree(mesh.vertices).query(around)[1]
    assert not loop_sum(mesh, cochain, loop).any()
    points = np.array(mouth)
    points = points[np.argsort(np.arctan2(*(points - 2.5).T[:2]))]
    assert loop_sum(mesh, cochain, walk(mesh, cKDTree(mesh.vertices).query(points)[1])).any()


def walk(mesh, stops):
    """The vertices of shortest paths from each stop to the next and back to the first."""
    lengths = np.linalg.norm(np.diff(mesh.vertices[mesh.edges], axis=1)[:, 0], axis=1)
    graph = weighted_graph(mesh.edges, lengths, len(mesh.vertices))
    path = []
    for a, b in zip(stops, np.roll(stops, -1), strict=True):
        parent = dijkstra(graph, directed=False, indices=b, return_predecessors=True)[1]
        while a != b:
            path.append(int(a))
            a = parent[a]
    return path


def test_noise_of_single_voxels_is_certified():
    mesh = porous_block(12, grain=0.0)
    assert mesh.genus > 40
    assert find_tunnels(mesh) is not None


def test_a_sphere_has_no_tunnel():
    mesh = sphere(2)
    assert tunnel_cochain(mesh).tolist() == [[0]] * len(mesh.edges)


def test_the_cochain_does_not_depend_on_the_orientation():
    mesh = torus(1.0, 0.3, 24, 10)
    inside_out = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    assert inside_out.volume < 0
    assert not loop_sum(inside_out, tunnel_cochain(inside_out), np.arange(10)).any()


@pytest.mark.parametrize("noise", [0.5, 1.5])
def test_tunnels_are_found_under_noise_that_makes_the_surface_intersect_itself(noise):
    n, m = 32, 12
    mesh = torus(1.0, 0.3, n, m)
    edge = np.linalg.norm(np.diff(mesh.vertices[mesh.edges], axis=1), axis=2).mean()
    for seed in range(6):  # without smoothing 6 of the 12 have no answer and 3 a wrong one
        heights = noise * edge * np.random.default_rng(seed).normal(size=mesh.vertices.shape)
        cochain = tunnel_cochain(mesh.with_vertices(mesh.vertices + heights))
        assert not loop_sum(mesh, cochain, np.arange(m)).any()
        assert loop_sum(mesh, cochain, np.arange(n) * m).any()


def test_random_positions_give_no_cochain_or_one_of_the_right_shape():
    mesh = torus(1.0, 0.3, 12, 6)
    scattered = mesh.with_vertices(np.random.default_rng(0).normal(size=mesh.vertices.shape))
    tunnels = find_tunnels(scattered)
    assert tunnels is None or tunnels.cochain().shape == (len(mesh.edges), 1)


def test_a_loop_around_the_hole_twice_has_twice_the_sum():
    n, m = 24, 10
    mesh = torus(1.0, 0.3, n, m)
    cochain = tunnel_cochain(mesh)
    once = loop_sum(mesh, cochain, np.arange(n) * m)
    assert once.any()
    assert np.array_equal(loop_sum(mesh, cochain, np.tile(np.arange(n) * m, 2)), 2 * once)
    assert np.array_equal(loop_sum(mesh, cochain, (np.arange(n) * m)[::-1]), -once)


def test_sums_along_loops_do_not_change_by_the_transfer_to_a_coarser_mesh():
    """Rings of two rows are merged in pairs: the loops around tube and hole keep their sums."""
    n, m = 24, 10
    fine, coarse = torus(1.0, 0.3, n, m), torus(1.0, 0.3, n // 2, m)
    row, column = np.divmod(np.arange(n * m), m)
    vertex_map = VertexMap(row // 2 * m + column)
    cochain = tunnel_cochain(fine)
    moved = transfer_cochain(cochain, fine, coarse.edges, vertex_map)
    assert moved.shape == (len(coarse.edges), 1)
    sign = np.where(coarse.half_edges[:, 0] < coarse.half_edges[:, 1], 1, -1)[:, None]
    assert not (sign * moved[coarse.edge_of_half_edge]).reshape(3, -1).sum(axis=0).any()
    assert not loop_sum(coarse, moved, np.arange(m)).any()
    around_the_hole = loop_sum(fine, cochain, np.arange(n) * m)
    assert np.array_equal(loop_sum(coarse, moved, np.arange(n // 2) * m), around_the_hole)


def test_tunnels_are_not_looked_for_after_a_deadline():
    mesh = torus(1.0, 0.3, 16, 8)
    with pytest.raises(OutOfTime):
        find_tunnels(mesh, deadline=Deadline(0.0))
