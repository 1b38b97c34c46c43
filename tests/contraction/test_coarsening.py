"""Coarsening: short edges go, topology and sums stay, and the skeleton is the one that all vertices give."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import Mesh, collapse, contract, ground_truth_distances, skeletonize
from lbskel.contraction.coarsening import Coarsened, coarsen
from lbskel.contraction.flow import PRESETS
from lbskel.contraction.homology import transfer_cochain, tunnel_cochain
from lbskel.shapes import chain_of_tori, make, sphere, torus

FEWEST = 16  # vertices left, in place of as many as are worth it
EVERY_VERTEX = replace(PRESETS["curvature_flow"], collapse_length=0.0)


def whole(mesh):
    everything = np.arange(len(mesh.vertices))
    return Coarsened(mesh, everything, everything, np.ones(len(mesh.vertices)))


def edge_lengths(mesh):
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    return np.linalg.norm(end - start, axis=1)


@pytest.mark.parametrize("genus", [0, 1, 3])
def test_topology_and_sums_stay_however_short_the_edges_may_not_be(monkeypatch, genus):
    """With a limit beyond every edge, and hardly one on the vertices, all collapse that may."""
    monkeypatch.setattr("lbskel.contraction.coarsening.FEWEST", FEWEST)
    mesh = chain_of_tori(genus, step=0.2) if genus else sphere(3)
    now = whole(mesh)
    for _ in range(30):
        now = coarsen(now, np.full(len(mesh.vertices), 1e9))
    assert len(now.mesh.vertices) < 0.2 * len(mesh.vertices)
    assert len(now.mesh.vertices) >= FEWEST / 2
    assert now.mesh.is_closed_manifold
    assert now.mesh.genus == genus
    assert now.weights.sum() == len(mesh.vertices)
    assert (now.weights == np.bincount(now.vertex_map)).all()
    assert (now.vertex_map[now.kept] == np.arange(len(now.kept))).all()
    means = [np.bincount(now.vertex_map, weights=x) / now.weights for x in mesh.vertices.T]
    # a mean of means is a mean: only rounding
    assert np.abs(np.array(means).T - now.mesh.vertices).max() < 1e-12


def test_edges_over_the_limit_stay():
    mesh = torus(1.0, 0.2, 48, 16)
    assert coarsen(whole(mesh), np.full(len(mesh.vertices), 0.9 * edge_lengths(mesh).min())).mesh is mesh
    flat = mesh.with_vertices(mesh.vertices * [1, 1, 0.01])
    limit = 0.5 * np.median(edge_lengths(flat))
    now = whole(flat)
    for _ in range(10):
        now = coarsen(now, np.full(len(flat.vertices), limit))
    assert len(now.mesh.vertices) < len(flat.vertices)
    # only rings around the tube, which may not close, and the last few per cent of a round are still short
    assert (edge_lengths(now.mesh) < limit).mean() < 0.1 < (edge_lengths(flat) < limit).mean()


def test_patches_are_connected():
    mesh = make("octopus", n_vertices=1000).mesh
    contraction = contract(mesh)
    inner = contraction.vertex_map.indices[mesh.edges[:, 0]] == contraction.vertex_map.indices[mesh.edges[:, 1]]
    n_patches = len(np.unique(contraction.vertex_map.indices))
    patches = Mesh(mesh.vertices, np.column_stack([mesh.edges[inner], mesh.edges[inner][:, 0]])).component_of_vertex
    assert len(np.unique(patches)) == n_patches == len(contraction.coarse.vertices) < 0.3 * len(mesh.vertices)


def test_later_steps_have_fewer_vertices_and_the_maps_lead_back():
    mesh = make("knot", n_vertices=2000).mesh
    contraction = contract(mesh)
    counts = [step.n_vertices for step in contraction.steps]
    assert counts[0] == len(mesh.vertices)
    assert counts[-1] < 0.25 * counts[0]
    assert np.array_equal(contraction.mesh.vertices, contraction.coarse.vertices[contraction.vertex_map.indices])
    assert contraction.mesh.faces is mesh.faces or np.array_equal(contraction.mesh.faces, mesh.faces)
    assert contract(mesh, EVERY_VERTEX).coarse.faces.tolist() == mesh.faces.tolist()


def test_a_cochain_is_carried_to_the_merged_vertices():
    """Round every face it sums to zero still, and no linking number is lost."""
    mesh = chain_of_tori(2, step=0.2)
    contraction = contract(mesh)
    coarse = contraction.coarse
    assert len(coarse.vertices) < 0.7 * len(mesh.vertices)
    cochain = transfer_cochain(tunnel_cochain(mesh), mesh, coarse, contraction.vertex_map.indices)
    start, end = coarse.half_edges.T
    signed = np.where(start < end, 1, -1)[:, None] * cochain[coarse.edge_of_half_edge]
    assert not signed.reshape(3, -1, 2).sum(axis=0).any()
    graph = collapse(contraction)
    assert graph.handles_certified
    assert len(graph.edges) - len(graph.kept) + 1 == 2
    assert graph.node_of_vertex.shape == (len(mesh.vertices),)


@pytest.mark.parametrize("name", ["limbs", "knot", "cube_frame"])
def test_the_skeleton_is_as_near_to_the_axis_as_with_every_vertex(name):
    shape = make(name, n_vertices=1500)
    every, fewer = (
        ground_truth_distances(skeletonize(shape.mesh, preset=preset), shape.truth)
        for preset in (EVERY_VERTEX, PRESETS["curvature_flow"])
    )
    assert fewer.is_topology_right
    assert fewer.n_tips == every.n_tips == fewer.n_true_tips
    # of the local radius: nodes are put to their sections, so that what differs is how junctions were reached
    assert fewer.accuracy < every.accuracy + 0.01
    assert fewer.coverage < every.coverage + 0.01


def test_meshes_that_are_no_closed_manifold_keep_every_vertex():
    mesh = torus(1.0, 0.3, 40, 16)
    opened = Mesh(mesh.vertices, mesh.faces[2:])
    contraction = contract(opened, replace(PRESETS["curvature_flow"], max_steps=4))
    assert {step.n_vertices for step in contraction.steps} == {len(mesh.vertices)}
