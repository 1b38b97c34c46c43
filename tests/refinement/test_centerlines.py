"""Centerlines: cross-sections that belong to one branch only."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from helpers import STAR_RADIUS, graph_of_star, joined, loop_in, moved, nearest_rows, path_in
from scipy.spatial.transform import Rotation

from lbskel import Skeleton, ground_truth_distances, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centerlines import _is_continuous, _reaches, _tangents, find_section_centers
from lbskel.shapes import capsule, make, torus


def test_sections_are_known_along_the_arms_and_not_where_they_meet(star):
    skeleton = graph_of_star(star, np.zeros(3))
    axes = find_section_centers(skeleton, Surface(star))
    distances = np.linalg.norm(skeleton.nodes, axis=1)
    assert axes.is_known[(distances > 0.4) & (skeleton.degrees == 2)].all()
    assert not axes.is_known[distances < 0.8 * STAR_RADIUS].any()
    assert np.array_equal(skeleton.branch_of_node < 0, skeleton.degrees >= 3)


def test_sections_beyond_a_jump_in_size_are_rejected():
    k = np.arange(12)
    nodes = np.concatenate([np.stack([k / 4, 0 * k, 0 * k], axis=1), [[-1, 0, 0], [0, 1, 0]]])
    skeleton = Skeleton(nodes, [*itertools.pairwise(k), (0, 12), (0, 13)], np.full(14, 0.3), np.zeros(1))
    is_own, wide = skeleton.degrees == 2, np.where(k < 3, 0.5, 0.3)
    assert np.flatnonzero(_is_continuous(skeleton, is_own, np.full(14, 0.3))).tolist() == [*range(1, 11)]
    assert np.flatnonzero(_is_continuous(skeleton, is_own, np.append(wide, [0, 0]))).tolist() == [*range(3, 11)]


def test_sections_of_a_rough_branch_are_no_jumps_in_size():
    """A section that is a fourth wider than the one before is a jump, unless one before that is as wide."""
    k = np.arange(12)
    nodes = np.concatenate([np.stack([k / 4, 0 * k, 0 * k], axis=1), [[-1, 0, 0], [0, 1, 0]]])
    skeleton = Skeleton(nodes, [*itertools.pairwise(k), (0, 12), (0, 13)], np.full(14, 0.3), np.zeros(1))
    wide_at_2, rough = np.full(14, 0.3), np.full(14, 0.3)
    wide_at_2[2] = rough[[1, 3, 5]] = 0.375
    for radii, first in ((wide_at_2, 3), (rough, 1)):
        known = np.flatnonzero(_is_continuous(skeleton, skeleton.degrees == 2, radii))
        assert known.tolist() == [*range(first, 11)]


def test_a_small_section_in_the_middle_of_a_branch_does_not_reject_the_others():
    k = np.arange(12)
    nodes = np.concatenate([np.stack([k / 4, 0 * k, 0 * k], axis=1), [[-1, 0, 0], [0, 1, 0]]])
    skeleton = Skeleton(nodes, [*itertools.pairwise(k), (0, 12), (0, 13)], np.full(14, 0.3), np.zeros(1))
    radii = np.full(14, 0.3)
    radii[5] = 0.2
    assert np.flatnonzero(_is_continuous(skeleton, skeleton.degrees == 2, radii)).tolist() == [*range(1, 11)]


def test_the_reach_of_sections_holds_the_faces_of_a_branch_in_any_pose(star):
    skeleton = graph_of_star(star, np.zeros(3))
    at = np.flatnonzero(skeleton.degrees == 2)
    reaches = _reaches(skeleton, at, Surface(star))
    turn = Rotation.from_rotvec([0.3, 0.7, -0.5]).as_matrix()
    turned = replace(skeleton, nodes=skeleton.nodes @ turn.T)
    mesh = star.with_vertices(star.vertices @ turn.T)
    assert _reaches(turned, at, Surface(mesh)) == pytest.approx(reaches, rel=1e-12)
    branch_of_face = skeleton.branch_of_node[skeleton.node_of_vertex][star.faces[:, 0]]
    for node, reach in zip(at[::5], reaches[::5], strict=True):
        own = star.vertices[star.faces[branch_of_face == skeleton.branch_of_node[node]]]
        farthest = np.linalg.norm(own - skeleton.nodes[node], axis=-1).max()
        assert farthest <= reach < 3 * farthest


def test_the_centers_of_a_rod_are_on_its_axis_and_ends_have_none():
    mesh = capsule(4.0, 0.5, 48)
    path = path_in(mesh, np.stack([np.full(9, 0.2), np.zeros(9), np.linspace(-2, 2, 9)], axis=1))
    centers = find_section_centers(path, Surface(mesh))
    assert centers.is_known.tolist() == [False, *[True] * 7, False]
    assert np.abs(centers.positions[1:-1, :2]).max() < 0.01
    assert np.array_equal(centers.positions[[0, -1]], path.nodes[[0, -1]])


def test_a_section_whose_centroid_is_far_from_its_node_is_rejected():
    """Nodes outside a rod of radius 0.5: the section is farther away than its radius."""
    mesh = capsule(4.0, 0.5, 48)
    z = np.linspace(-1, 1, 9)
    assert not find_section_centers(
        path_in(mesh, np.stack([0.7 + 0 * z, 0 * z, z], axis=1)), Surface(mesh)
    ).is_known.any()
    assert find_section_centers(path_in(mesh, np.stack([0.4 + 0 * z, 0 * z, z], axis=1)), Surface(mesh)).is_known.any()


def test_sections_across_a_bare_loop_are_known_everywhere():
    mesh = torus(1.0, 0.3, 64, 24)
    angle = np.linspace(0, 2 * np.pi, 6, endpoint=False)
    loop = loop_in(mesh, np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1))
    centers = find_section_centers(loop, Surface(mesh))
    assert centers.is_known.all()
    # the tangent at a node is that of the circle, so the section is exactly radial
    assert np.abs(centers.positions @ [0, 0, 1]).max() < 1e-9
    assert np.abs(np.cross(centers.positions, loop.nodes)).max() < 1e-9


def test_a_section_of_another_branch_is_not_a_branchs_own():
    """Two rods side by side; the vertices of the first are mapped to the nodes in the second."""
    rod = capsule(4.0, 0.5, 24)
    two = joined(rod, moved(rod, 3.0))
    z = np.linspace(-2, 2, 9)
    first, second = (np.stack([x + 0 * z, 0 * z, z], axis=1) for x in (0.0, 3.0))
    edges = [*itertools.pairwise(range(9)), *itertools.pairwise(range(9, 18))]
    nearest = nearest_rows(two.vertices, np.concatenate([first, second]))
    own = Skeleton(np.concatenate([first, second]), edges, np.full(18, 0.5), nearest)
    swapped = Skeleton(own.nodes, own.edges, own.radii, (nearest + 9) % 18)
    assert find_section_centers(own, Surface(two)).is_known.sum() == 14
    assert not find_section_centers(swapped, Surface(two)).is_known.any()


def test_tangents_are_those_over_half_a_radius():
    """Nodes a fiftieth of a radius apart, which leave the axis by a fiftieth in turn: edges lean by 45 degrees."""
    x = np.arange(200) / 50
    nodes = np.column_stack([x, (-1.0) ** np.arange(200) / 100, 0 * x])
    path = Skeleton(nodes, [*itertools.pairwise(range(200))], np.ones(200))
    assert _tangents(path)[:, 0].min() > np.cos(np.radians(3))
    sparse = Skeleton(nodes[:8] * [100, 0, 0], [*itertools.pairwise(range(8))], np.ones(8))
    assert (_tangents(sparse) == [1, 0, 0]).all()  # nodes farther apart than half a radius


def test_fingers_that_are_fused_in_a_coarse_mesh_end_at_their_tips():
    """Sections across two fingers at once lie between them; at 1,900 vertices the gap is narrower than an edge."""
    shape = make("hand", n_vertices=1895)
    assert ground_truth_distances(skeletonize(shape.mesh), shape.truth).coverage < 0.05
