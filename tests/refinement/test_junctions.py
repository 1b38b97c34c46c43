"""Junctions: placed where their branches point, and merged where all branches point to one place."""

import itertools

import numpy as np
import pytest
from helpers import STAR_RADIUS, graph_of_star, mesh_of_branches, nearest_rows, straight_graph

from lbskel import Mesh, Skeleton, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centering import recenter
from lbskel.refinement.centerlines import SectionCenters, find_section_centers
from lbskel.refinement.junctions import merge_junctions_by_axes, place_junctions
from lbskel.refinement.radii import inscribed_radii
from lbskel.shapes import chain_of_tori, make, sphere


def test_a_junction_of_skeletonize_is_where_the_true_axes_meet():
    shape = make("tripod", n_vertices=2000)
    truth = shape.truth
    junction = truth.nodes[truth.junctions[0]]
    skeleton = skeletonize(shape.mesh)
    found = skeleton.nodes[skeleton.junctions]
    assert len(found) == 1
    # sections of the arms are known to a hundredth of the radius, from where the axes are carried on for two radii
    assert np.linalg.norm(found[0] - junction) < 0.05 * truth.radii[truth.junctions[0]]


@pytest.mark.parametrize("shift", [[0.1, 0.05, 0.02], [0, 0, 0.15], [-0.08, 0, -0.08]])
def test_a_junction_goes_to_where_its_branches_meet(star, shift):
    skeleton = graph_of_star(star, np.array(shift))
    axes = place_junctions(skeleton, find_section_centers(skeleton, Surface(star)), Surface(star))
    # sections of oblique paths are off by a few hundredths
    assert np.linalg.norm(axes.positions[skeleton.junctions]) < 0.25 * np.linalg.norm(shift)


@pytest.mark.parametrize("degrees", [45.0, 11.5, 0.1])
def test_a_junction_keeps_its_position_only_where_its_branches_determine_none(degrees):
    """Two exact axes that cross one unit from a contracted position, at a steep or a nearly flat angle."""
    mesh, tilt = sphere(3), np.tan(np.radians(degrees))
    arms = [[-k / 10, sign * tilt * (1 + k / 10), 0] for sign in (-1, 1) for k in range(3, 8)]
    edges = [[0, 1], [0, 6], [0, 11], *([k, k + 1] for k in (1, 2, 3, 4, 6, 7, 8, 9))]
    skeleton = Skeleton([[0, 0, 0], *arms, [0, 0, 0.1]], edges, np.full(12, 0.1), np.zeros(1))
    axes = SectionCenters(np.arange(12) % 11 > 0, skeleton.nodes)
    placed = place_junctions(skeleton, axes, Surface(Mesh(3 * mesh.vertices, mesh.faces))).positions[0]
    # the eigenvalue of the lines along x, and a fiftieth of the sum of all eigenvalues
    of_lines, of_anchor = 2 * np.sin(np.radians(degrees)) ** 2, 0.02 * 4
    assert placed == pytest.approx([of_lines**2 / (of_lines**2 + of_anchor**2), 0, 0], abs=1e-9)


def test_two_junctions_whose_branches_all_point_to_one_place_are_merged(star):
    skeleton = graph_of_star(star, np.array([0.07, 0.07, 0.02]), np.array([-0.07, -0.07, 0.02]))
    assert len(skeleton.junctions) == 2
    merged = merge_junctions_by_axes(skeleton, find_section_centers(skeleton, Surface(star)), Surface(star))
    assert (len(merged.junctions), len(merged.tips), merged.cycle_rank) == (1, 5, 0)
    assert np.linalg.norm(merged.nodes[merged.junctions]) < 0.5 * STAR_RADIUS
    assert len(merged.node_of_vertex) == len(star.vertices)
    refined = recenter(merged, Surface(star))
    assert np.linalg.norm(refined.nodes[refined.junctions]) < 0.3 * STAR_RADIUS


def test_two_junctions_with_branches_of_their_own_are_not_merged():
    a, b = np.array([-0.3, 0, 0]), np.array([0.3, 0, 0])
    ends = {"p": a + [-0.2, 1, 0], "q": a + [-0.2, -1, 0], "r": b + [0.2, 1, 0], "s": b + [0.2, -1, 0]}
    mesh = mesh_of_branches(
        [([a, b], STAR_RADIUS), *(([a if k in "pq" else b, end], STAR_RADIUS) for k, end in ends.items())]
    )
    paths = [("a", "b"), ("a", "p"), ("a", "q"), ("b", "r"), ("b", "s")]
    skeleton = straight_graph(mesh, {"a": a, "b": b, **ends}, paths)
    assert merge_junctions_by_axes(skeleton, find_section_centers(skeleton, Surface(mesh)), Surface(mesh)) is skeleton


def test_merging_closes_no_loop():
    mesh = chain_of_tori(2, step=0.12)
    t = np.pi * np.arange(2, 39) / 20
    loops = [np.stack([x + np.cos(t + s), np.sin(t + s), 0 * t], axis=1) for x, s in ((0, 0), (2, np.pi))]
    nodes = np.concatenate([[[0.95, 0.0, 0.0], [1.05, 0.0, 0.0]], *loops])
    first = np.arange(2, 39)
    chains = [*itertools.pairwise(first), *itertools.pairwise(first + 37)]
    edges = [[0, 1], [0, 2], [0, 38], [1, 39], [1, 75], *chains]
    nearest = nearest_rows(mesh.vertices, nodes)
    skeleton = inscribed_radii(Skeleton(nodes, np.array(edges), np.zeros(len(nodes)), nearest), Surface(mesh))
    merged = merge_junctions_by_axes(skeleton, find_section_centers(skeleton, Surface(mesh)), Surface(mesh))
    assert (merged.cycle_rank, merged.n_components) == (2, 1)
