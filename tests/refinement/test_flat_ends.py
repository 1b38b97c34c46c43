"""Flat ends: forks in the corners of a slab are removed, limbs with a gap between them are kept."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers import nearest_rows, slab

from lbskel import ContractionSettings, Mesh, Skeleton, ground_truth_distances, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.flat_ends import _sees, first_parts, prune_flat_ends
from lbskel.shapes import make, with_local_noise
from lbskel.shapes.hard import HARD_SHAPES


def forked(mesh, start, fork, corners):
    """A straight skeleton along x from a start to a fork, with a branch to each of some corners."""
    spine = np.column_stack([np.linspace(start, fork, 9), np.zeros((9, 2))])
    shares = np.linspace(0, 1, 5)[1:, None]
    branches = [spine[-1] + shares * ([*corner, 0] - spine[-1]) for corner in corners]
    nodes = np.concatenate([spine, *branches])
    starts = [9 + 4 * k for k in range(len(corners))]
    edges = [[k, k + 1] for k in range(8)]
    edges += [edge for first in starts for edge in ([8, first], *([k, k + 1] for k in range(first, first + 3)))]
    return Skeleton(nodes, edges, np.ones(len(nodes)), nearest_rows(mesh.vertices, nodes))


@pytest.mark.parametrize(("fork", "ratio", "n_tips"), [(2.0, 0.98, 3), (2.5, 0.98, 3), (2.0, 1.02, 2), (1.5, 1.02, 3)])
def test_a_corner_reaches_one_half_width_along_the_part_and_across_it(fork, ratio, n_tips):
    mesh = slab(8.0, 4.0, 0.4)
    skeleton = forked(mesh, -3.0, fork, [(3.6, 1.6), (3.6, -1.6)])
    pruned = prune_flat_ends(skeleton, Surface(mesh), min_branch_ratio=ratio)
    assert (len(skeleton.tips), len(pruned.tips)) == (3, n_tips)
    if n_tips == 2:
        assert pruned.nodes[pruned.tips][:, 0] == pytest.approx([-3, 2])  # the whole fork is gone
        assert (pruned.nodes[pruned.node_of_vertex[mesh.vertices[:, 0] > 3]] == [2, 0, 0]).all()


@pytest.mark.parametrize(("notch", "n_tips"), [(0.0, 2), (0.2, 2), (2.0, 3)])
def test_a_gap_separates_limbs(notch, n_tips):
    mesh = slab(8.0, 4.0, 0.4, notch)
    skeleton = forked(mesh, -3.0, 1.0, [(3.6, 1.6), (3.6, -1.6)])
    assert len(prune_flat_ends(skeleton, Surface(mesh), min_branch_ratio=2.0).tips) == n_tips


@pytest.mark.parametrize(
    ("begin", "end"),
    [((2.18, 1.625, 0), (2.18, -1.375, 0)), ((3.5, 1.55, 0), (1, -1.9, 0)), ((1, -1.9, 0), (3.5, 1.55, 0))],
)
def test_a_line_of_sight_ends_at_a_gap_in_its_middle_or_elsewhere(begin, end):
    """A wedge |y| < x - 2 is cut out. The first line is outside at one sample, next to its middle, the others aside."""
    surface = Surface(slab(8.0, 4.0, 0.4, 2.0))
    assert not _sees(np.array([begin], dtype=float), np.array([end], dtype=float), surface)[0]
    assert _sees(np.array([begin], dtype=float), np.array([[-3.0, begin[1], 0]]), surface)[0]


def test_a_path_ends_at_its_first_node_beyond_the_reach():
    nodes, way = np.arange(6.0)[:, None] * [1, 0, 0], np.arange(6)
    parts = first_parts(nodes, [way, way[::-1], way, way[2:]], np.array([2.5, 2.0, 0.0, 9.0]))
    assert [part.tolist() for part in parts] == [[0, 1, 2, 3], [5, 4, 3], [0, 1], [2, 3, 4, 5]]


def test_a_branch_to_the_side_of_a_flat_part_is_a_corner_too():
    mesh = slab(8.0, 4.0, 0.4)
    skeleton = forked(mesh, -3.0, 0.0, [(3.0, 0.0), (0.0, 1.5)])
    assert len(prune_flat_ends(skeleton, Surface(mesh), min_branch_ratio=1.5).tips) == 2


def test_corners_are_found_where_contraction_has_left_the_nodes_outside():
    """All nodes are above a slab, by half of its thickness."""
    mesh = slab(8.0, 4.0, 0.4)
    inside = forked(mesh, -3.0, 2.0, [(3.6, 1.6), (3.6, -1.6)])
    above = replace(inside, nodes=inside.nodes + [0, 0, 0.4])
    assert len(prune_flat_ends(above, Surface(mesh), min_branch_ratio=1.5).tips) == 2


def test_limbs_of_round_shapes_are_kept(tripod):
    shape = make("limbs", n_vertices=1200)
    for mesh, truth in ((tripod, make("tripod").truth), (shape.mesh, shape.truth)):
        nearest = nearest_rows(mesh.vertices, truth.nodes)
        skeleton = Skeleton(truth.nodes, truth.edges, truth.radii, nearest)
        assert prune_flat_ends(skeleton, Surface(mesh), min_branch_ratio=1.5) is skeleton


def test_a_bent_ribbon_twenty_times_as_wide_as_thick_has_two_ends():
    assert len(skeletonize(HARD_SHAPES["ribbon"](ratio=20.0, n_vertices=3000).mesh).tips) == 2


def test_a_bent_ribbon_has_two_ends():
    shape = HARD_SHAPES["ribbon"]()
    skeleton = skeletonize(shape.mesh)
    assert (len(skeleton.tips), len(skeleton.junctions)) == (2, 0)
    # the axis of a section is its center; most of what is left is the end, where a branch stops half a width early
    assert ground_truth_distances(skeleton, shape.truth).accuracy < 0.05


def test_the_mirror_image_of_a_bent_ribbon_has_two_ends():
    """In these steps, contraction leaves a fork whose next node is 1.2 times as far away as its corners reach."""
    shape = HARD_SHAPES["ribbon"](ratio=7.0, length=3.0)
    mirrored = Mesh(shape.mesh.vertices * [-1, 1, 1], shape.mesh.faces[:, ::-1])
    assert len(skeletonize(mirrored, preset=ContractionSettings(contraction_growth=1.5)).tips) == 2


@pytest.mark.parametrize(("given", "seed"), [({"ratio": 3.0, "twist": 2.0}, 0), ({}, 1)])
def test_noise_does_not_bend_the_ends_of_a_flat_limb(given, seed):
    """Of the branches in two corners of an end, one may be as short as a spur and the other not."""
    shape = HARD_SHAPES["twisted ellipse"](**given)
    skeleton = skeletonize(with_local_noise(shape.mesh, 0.05, seed=seed))
    distances = ground_truth_distances(skeleton, shape.truth)
    assert (distances.n_tips, len(skeleton.junctions)) == (2, 0)
    assert distances.accuracy_95 < 0.05  # 0.02 without noise; an end that is bent into a corner is 0.7 off


def test_a_thin_leaf_has_no_branch_aside():
    shape = HARD_SHAPES["leaf"]()
    assert ground_truth_distances(skeletonize(shape.mesh), shape.truth).accuracy < 0.01


@pytest.mark.parametrize(("extents", "max_edge"), [((0.2, 3, 6), 10), ((0.2, 3, 9), 0.45), ((0.2, 2, 12), 0.6)])
def test_a_thin_plate_has_two_ends_on_its_axis(extents, max_edge):
    """Contraction leaves forks that are deeper than one half width before the ends."""
    plate = trimesh.creation.box(extents)
    skeleton = skeletonize(trimesh.remesh.subdivide_to_size(plate.vertices, plate.faces, max_edge))
    assert len(skeleton.tips) == 2
    assert np.abs(skeleton.nodes[skeleton.tips][:, 1]).max() < 0.25 * extents[1] / 2  # corners are at the half width
