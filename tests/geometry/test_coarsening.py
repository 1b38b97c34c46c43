"""Coarsening: short edges are collapsed, topology and sums are kept, and skeletons stay as accurate."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import joined

from lbskel import PRESETS, Mesh, collapse, contract, ground_truth_distances, skeletonize
from lbskel.contraction.homology import find_tunnels, transfer_cochain
from lbskel.geometry.coarsening import Coarsened, coarsen
from lbskel.shapes import chain_of_tori, cylinder, flat_grid, make, sphere, torus

MIN_VERTICES = 16  # in place of the value that saves time
DEFAULT = PRESETS["curvature_flow"]
EVERY_VERTEX = replace(DEFAULT, collapse_length=0.0)


def unmerged(mesh):
    return Coarsened.unmerged(mesh, np.ones(len(mesh.vertices)))


def edge_lengths(mesh):
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    return np.linalg.norm(end - start, axis=1)


def closed_sums(cochain, mesh):
    """The sums of a cochain around the faces of a mesh."""
    start, end = mesh.half_edges.T
    signed = np.where(start < end, 1, -1)[:, None] * cochain[mesh.edge_of_half_edge]
    return signed.reshape(3, len(mesh.faces), -1).sum(axis=0)


@pytest.mark.parametrize("genus", [0, 1, 3])
def test_topology_and_sums_are_kept_without_a_limit_on_lengths(monkeypatch, genus):
    """With a limit beyond every edge, and almost none on the number of vertices, all edges collapse that may."""
    monkeypatch.setattr("lbskel.geometry.coarsening.MIN_VERTICES", MIN_VERTICES)
    mesh = chain_of_tori(genus, step=0.2) if genus else sphere(3)
    now = unmerged(mesh)
    for _ in range(30):
        now = coarsen(now, np.full(len(mesh.vertices), 1e9))
    merged_into = now.vertex_map.indices
    assert len(now.mesh.vertices) < 0.2 * len(mesh.vertices)
    assert len(now.mesh.vertices) >= MIN_VERTICES / 2
    found_anew = Mesh(now.mesh.vertices, now.mesh.faces)
    assert found_anew.is_closed_manifold
    assert now.mesh.is_closed_manifold
    assert found_anew.genus == now.mesh.genus == genus
    assert now.weights.sum() == len(mesh.vertices)
    assert (now.weights == np.bincount(merged_into)).all()
    assert (merged_into[now.kept] == np.arange(len(now.kept))).all()
    means = [np.bincount(merged_into, weights=x) / now.weights for x in mesh.vertices.T]
    # a mean of means is a mean, up to rounding
    assert np.abs(np.array(means).T - now.mesh.vertices).max() < 1e-12


def test_merged_positions_are_means_weighted_by_the_weights(monkeypatch):
    monkeypatch.setattr("lbskel.geometry.coarsening.MIN_VERTICES", MIN_VERTICES)
    mesh = sphere(2)
    weights = np.random.default_rng(0).uniform(0.1, 10.0, len(mesh.vertices))
    now = coarsen(Coarsened.unmerged(mesh, weights), np.full(len(mesh.vertices), 1e9))
    merged_into = now.vertex_map.indices
    assert now.weights == pytest.approx(np.bincount(merged_into, weights=weights))
    means = [np.bincount(merged_into, weights=weights * x) / now.weights for x in mesh.vertices.T]
    assert pytest.approx(now.mesh.vertices) == np.array(means).T


def test_nothing_is_merged_below_the_smallest_number_of_vertices():
    small = torus(1.0, 0.3, 20, 10)
    assert coarsen(unmerged(small), np.full(len(small.vertices), 1e9)).mesh is small


def test_edges_over_the_limit_are_kept():
    mesh = torus(1.0, 0.2, 48, 16)
    assert coarsen(unmerged(mesh), np.full(len(mesh.vertices), 0.9 * edge_lengths(mesh).min())).mesh is mesh
    flat = mesh.with_vertices(mesh.vertices * [1, 1, 0.01])
    limit = 0.5 * np.median(edge_lengths(flat))
    now = unmerged(flat)
    for _ in range(10):
        now = coarsen(now, np.full(len(flat.vertices), limit))
    assert len(now.mesh.vertices) < len(flat.vertices)
    # only rings around the tube, which must not close, and the last few per cent of a round are still short
    assert (edge_lengths(now.mesh) < limit).mean() < 0.1 < (edge_lengths(flat) < limit).mean()


def test_limits_are_those_of_the_original_vertices():
    """Where one half of a torus has no limit and the other half allows nothing, only the first is merged."""
    mesh = torus(1.0, 0.2, 48, 16)
    is_left = mesh.vertices[:, 0] < 0
    now = unmerged(mesh)
    for _ in range(3):
        now = coarsen(now, np.where(is_left, 1e9, 0.0))
    sizes = np.bincount(now.vertex_map.indices)
    assert (sizes[now.vertex_map.indices[~is_left]] == 1).all()
    assert len(now.kept) < 0.7 * len(mesh.vertices)
    assert set(np.flatnonzero(~is_left)) <= set(now.kept)


def test_patches_are_connected():
    mesh = make("octopus", n_vertices=1000).mesh
    contraction = contract(mesh)
    inner = contraction.vertex_map.indices[mesh.edges[:, 0]] == contraction.vertex_map.indices[mesh.edges[:, 1]]
    n_patches = len(np.unique(contraction.vertex_map.indices))
    patches = Mesh(mesh.vertices, np.column_stack([mesh.edges[inner], mesh.edges[inner][:, 0]])).component_of_vertex
    assert len(np.unique(patches)) == n_patches == len(contraction.coarse.vertices) < 0.3 * len(mesh.vertices)


def test_later_steps_have_fewer_vertices_and_the_map_leads_to_the_last():
    mesh = make("knot", n_vertices=2000).mesh
    contraction = contract(mesh)
    counts = [step.n_vertices for step in contraction.steps]
    assert counts[0] == len(mesh.vertices)
    assert counts[-1] < 0.25 * counts[0]
    assert np.array_equal(contraction.mesh.vertices, contraction.coarse.vertices[contraction.vertex_map.indices])
    assert contraction.mesh.faces is mesh.faces or np.array_equal(contraction.mesh.faces, mesh.faces)
    assert contract(mesh, EVERY_VERTEX).coarse.faces.tolist() == mesh.faces.tolist()


def test_handles_survive_where_vertices_are_merged():
    """The transferred cochain still sums to zero around every face, and no handle is lost."""
    mesh = chain_of_tori(2, step=0.2)
    contraction = contract(mesh)
    coarse = contraction.coarse
    assert len(coarse.vertices) < 0.7 * len(mesh.vertices)
    assert not closed_sums(
        transfer_cochain(find_tunnels(mesh).cochain(), mesh, coarse.edges, contraction.vertex_map), coarse
    ).any()
    graph = collapse(contraction)
    assert graph.handles_certified
    assert len(graph.edges) - len(graph.nodes) + 1 == 2
    assert graph.node_of_vertex.shape == (len(mesh.vertices),)


@pytest.mark.parametrize("name", ["limbs", "knot", "cube_frame"])
def test_the_skeleton_is_as_near_to_the_axis_as_with_every_vertex(name):
    shape = make(name, n_vertices=1500)
    every, fewer = (
        ground_truth_distances(skeletonize(shape.mesh, preset=preset), shape.truth)
        for preset in (EVERY_VERTEX, DEFAULT)
    )
    assert fewer.is_topology_right
    assert fewer.n_tips == every.n_tips == fewer.n_true_tips
    # in local radii: nodes move to their section centers, so the difference is in how junctions were reached
    assert fewer.accuracy < every.accuracy + 0.01
    assert fewer.coverage < every.coverage + 0.01


def page(angle, n=12):
    """A square of n by n vertices, one side of which is on the z-axis."""
    x, z, _ = flat_grid(n, n).vertices.T
    return Mesh(np.stack([x * np.cos(angle), x * np.sin(angle), z], axis=1), flat_grid(n, n).faces)


def book(n_pages):
    """Squares at a common edge, the z-axis, which has as many faces as there are pages."""
    pages = joined(*(page(2 * np.pi * k / n_pages) for k in range(n_pages)))
    _, index = np.unique(np.round(pages.vertices, 9), axis=0, return_inverse=True)
    V = np.zeros((index.max() + 1, 3))
    V[index.ravel()] = pages.vertices
    return Mesh(V, index.ravel()[pages.faces])


def betti_numbers(mesh):
    """Components, independent cycles and enclosed cavities, from the ranks of the boundary matrices."""
    start = mesh.half_edges[:, 0]
    m, half = len(mesh.faces), np.arange(3 * len(mesh.faces))
    d1 = np.zeros((len(mesh.vertices), len(mesh.edges)))
    d1[mesh.edges[:, 0], np.arange(len(mesh.edges))], d1[mesh.edges[:, 1], np.arange(len(mesh.edges))] = -1, 1
    d2 = np.zeros((len(mesh.edges), m))
    low = mesh.edges[mesh.edge_of_half_edge, 0]
    d2[mesh.edge_of_half_edge, half % m] = np.where(start == low, 1, -1)
    r1, r2 = np.linalg.matrix_rank(d1), np.linalg.matrix_rank(d2)
    return len(mesh.vertices) - r1, len(mesh.edges) - r1 - r2, m - r2


def torus_without_a_quad():
    whole = torus(1.0, 0.3, 40, 16)
    return Mesh(whole.vertices, whole.faces[2:])


@pytest.mark.parametrize(
    ("make_mesh", "expected"),
    [
        pytest.param(lambda: page(0.0, 20), (1, 0, 0), id="disk"),
        pytest.param(lambda: cylinder(0.3, 4.0, 16, 40), (1, 1, 0), id="tube"),
        pytest.param(torus_without_a_quad, (1, 2, 0), id="torus with a hole"),
        pytest.param(lambda: book(3), (1, 0, 0), id="three pages"),
        pytest.param(lambda: book(4), (1, 0, 0), id="four pages"),
    ],
)
def test_open_and_nonmanifold_meshes_keep_their_topology(monkeypatch, make_mesh, expected):
    """Without a limit on lengths and almost none on the number of vertices, all edges collapse that may."""
    monkeypatch.setattr("lbskel.geometry.coarsening.MIN_VERTICES", MIN_VERTICES)
    mesh = make_mesh()
    assert not mesh.is_closed_manifold
    assert betti_numbers(mesh) == expected
    now = unmerged(mesh)
    for _ in range(30):
        now = coarsen(now, np.full(len(mesh.vertices), 1e9))
    assert len(now.mesh.vertices) < 0.3 * len(mesh.vertices)
    assert betti_numbers(now.mesh) == expected
    assert len(now.mesh.used_vertices) == len(now.mesh.vertices)  # every vertex keeps a face
    assert len(np.unique(np.sort(now.mesh.faces, axis=1), axis=0)) == len(now.mesh.faces)
    assert now.weights.sum() == len(mesh.vertices)


def test_boundary_edges_collapse_in_either_direction(monkeypatch):
    """The only short edge is one of the boundary, whose one face has it from the higher vertex or from the lower."""
    monkeypatch.setattr("lbskel.geometry.coarsening.MIN_PROGRESS", 0.0)
    mesh = page(0.0, 20)
    boundary = mesh.half_edges[mesh.faces_per_edge[mesh.edge_of_half_edge] == 1]
    inner = boundary[~np.isin(boundary, [0, 19, 380, 399]).any(axis=1)]  # corners may be in one face only
    for start, end in (inner[inner[:, 0] < inner[:, 1]][0], inner[inner[:, 0] > inner[:, 1]][0]):
        limits = np.zeros(len(mesh.vertices))
        limits[[start, end]] = 1e9
        assert len(coarsen(unmerged(mesh), limits).mesh.vertices) == len(mesh.vertices) - 1


def test_open_meshes_are_contracted_with_fewer_vertices():
    mesh = cylinder(0.3, 4.0, 24, 60)
    contraction = contract(mesh)
    counts = [step.n_vertices for step in contraction.steps]
    assert counts[0] == len(mesh.vertices)
    assert counts[-1] < 0.6 * counts[0]
    assert len(contraction.coarse.used_vertices) == len(contraction.coarse.vertices)
