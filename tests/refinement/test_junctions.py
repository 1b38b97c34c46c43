"""Junctions: placed where their branches point, and merged where all branches point to one place."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from helpers import STAR_RADIUS, graph_of_star, mesh_of_branches, nearest_rows, straight_graph

from lbskel import Mesh, Skeleton, ground_truth_distances, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement import junctions
from lbskel.refinement.branch_lines import MIN_SHARE, BranchLines
from lbskel.refinement.centering import recenter
from lbskel.refinement.centerlines import SectionCenters, find_section_centers
from lbskel.refinement.junctions import (
    MAX_MERGE_LENGTH,
    MAX_TRUNK_LENGTH,
    MIN_BALL_RATIO,
    _largest_sines,
    _where_balls_stop_growing,
    _with_ball,
    merge_junctions_by_axes,
    place_junctions,
)
from lbskel.refinement.radii import inscribed_radii
from lbskel.shapes import SHAPES, capsule, chain_of_tori, make, mesh_solid, sphere
from lbskel.shapes.hard import acute_fork, oblique_cross, prongs, torso
from lbskel.skeleton.editing import contract_nodes


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


def test_the_junction_of_a_narrow_fork_is_on_its_trunk_beyond_sections_of_both_limbs():
    """The limbs, of radius 0.1, part 0.5 from the place where their axes meet; the trunk has radius 0.13."""
    skeleton = skeletonize(acute_fork(degrees=24.0).mesh)
    assert len(skeleton.junctions) == 1
    assert np.linalg.norm(skeleton.nodes[skeleton.junctions[0]]) < 0.13


def test_limbs_that_cross_a_bar_at_a_small_angle_meet_in_one_place():
    skeleton = skeletonize(oblique_cross(degrees=40.0).mesh)
    assert np.linalg.norm(skeleton.nodes[skeleton.junctions], axis=1).max() < 0.1 * 0.25  # a tenth of the bar's radius


def test_the_junctions_of_a_bar_with_single_sections_are_on_its_axis():
    """Between two parallel prongs of radius 0.12, one section is the bar's own; contraction draws it to the wall."""
    skeleton = skeletonize(prongs().mesh)
    assert len(skeleton.junctions) == 3
    assert np.abs(skeleton.nodes[skeleton.junctions, 2]).max() < 0.5 * 0.12


@pytest.mark.parametrize("n_vertices", [800, 3000])
def test_the_rings_of_a_figure_eight_meet_in_one_junction(n_vertices):
    """They overlap over three radii, along a branch between the ends of both, which bend there."""
    shape = make("figure_eight", n_vertices=n_vertices)
    skeleton = skeletonize(shape.mesh)
    assert len(skeleton.junctions) == 1
    assert skeleton.cycle_rank == 2
    distances = ground_truth_distances(skeleton, shape.truth)
    assert distances.accuracy < 0.015  # 0.035 with two junctions


@pytest.mark.parametrize(("degrees", "n_vertices"), [(30, 6000), (45, 3900), (60, 6000)])
def test_the_palm_of_a_bent_hand_has_one_junction(degrees, n_vertices):
    """Tangents of its bent limbs pass the palm at places that are apart; straight lines point to one."""
    hand = SHAPES["hand"]()
    along, aside = np.argsort(-np.ptp(hand.centers, axis=0))[:2]
    radius, middle = np.ptp(hand.centers[:, along]) / np.radians(degrees), np.ptp(hand.centers, axis=0) / 2
    P = hand.centers - hand.centers.min(axis=0) - middle
    angles, heights = P[:, along] / radius, radius + P[:, aside]
    centers = np.array(hand.centers)
    centers[:, along], centers[:, aside] = heights * np.sin(angles), heights * np.cos(angles)
    skeleton = skeletonize(mesh_solid(replace(hand, centers=centers), n_vertices=n_vertices))
    assert (len(skeleton.junctions), len(skeleton.tips)) == (1, 6)


@pytest.mark.parametrize("degrees", [45.0, 4.2, 3.9, 0.1])
def test_a_junction_keeps_its_position_only_where_its_branches_determine_none(degrees):
    """Two exact axes that cross one unit from a contracted position, at a steep or a nearly flat angle."""
    mesh, tilt = sphere(3), np.tan(np.radians(degrees))
    arms = [[-k / 10, sign * tilt * (1 + k / 10), 0] for sign in (-1, 1) for k in range(3, 8)]
    edges = [[0, 1], [0, 6], [0, 11], *([k, k + 1] for k in (1, 2, 3, 4, 6, 7, 8, 9))]
    skeleton = Skeleton([[0, 0, 0], *arms, [0, 0, 0.1]], edges, np.full(12, 0.1), np.zeros(1))
    axes = SectionCenters(np.arange(12) % 11 > 0, skeleton.nodes)
    placed = place_junctions(skeleton, axes, Surface(Mesh(30 * mesh.vertices, mesh.faces))).positions[0]
    share = 2 * np.sin(np.radians(degrees)) ** 2 / 4  # of the eigenvalue along x in the sum of all eigenvalues
    assert placed == pytest.approx([float(share > MIN_SHARE), 0, 0], abs=1e-9)


def test_two_junctions_whose_branches_all_point_to_one_place_are_merged(star):
    skeleton = graph_of_star(star, np.array([0.07, 0.07, 0.02]), np.array([-0.07, -0.07, 0.02]))
    assert len(skeleton.junctions) == 2
    merged = merge_junctions_by_axes(skeleton, find_section_centers(skeleton, Surface(star)), Surface(star))
    assert (len(merged.junctions), len(merged.tips), merged.cycle_rank) == (1, 5, 0)
    assert np.linalg.norm(merged.nodes[merged.junctions]) < 0.5 * STAR_RADIUS
    assert merged.radii[merged.junctions] == pytest.approx(Surface(star).distance(merged.nodes[merged.junctions]))
    assert len(merged.node_of_vertex) == len(star.vertices)
    refined = recenter(merged, Surface(star))
    assert np.linalg.norm(refined.nodes[refined.junctions]) < 0.3 * STAR_RADIUS


@pytest.mark.parametrize("x", [0.05, 0.3, 0.9, 1.3])
def test_two_junctions_are_merged_where_the_ball_is_about_as_large_as_the_larger_of_theirs(x):
    """In a rod of radius 1, one on its axis and one halfway to its side; the place is in it, or beside it."""
    rod, place = Surface(capsule(6.0, 1.0, 64)), np.array([x, 0, 2])
    skeleton = Skeleton(np.array([[0.0, 0, -1], [0.5, 0, 0]]), np.array([[0, 1]]), np.zeros(2))
    found, way = _with_ball(skeleton, np.array([0, 1]), place, rod), skeleton.nodes[0] - place
    share = (found - place) @ way / (way @ way)
    assert found == pytest.approx(place + share * way)
    # the ball has radius 1 - x, but for the chords between 64 sides
    assert rod.distance(found[None])[0] >= MIN_BALL_RATIO * rod.distance(skeleton.nodes[:1])[0]
    assert max(1 - 0.1 / x, 0) - 0.01 <= share < 1


def test_two_junctions_with_branches_of_their_own_are_not_merged():
    a, b = np.array([-0.3, 0, 0]), np.array([0.3, 0, 0])
    ends = {"p": a + [-0.2, 1, 0], "q": a + [-0.2, -1, 0], "r": b + [0.2, 1, 0], "s": b + [0.2, -1, 0]}
    mesh = mesh_of_branches(
        [([a, b], STAR_RADIUS), *(([a if k in "pq" else b, end], STAR_RADIUS) for k, end in ends.items())]
    )
    paths = [("a", "b"), ("a", "p"), ("a", "q"), ("b", "r"), ("b", "s")]
    skeleton = straight_graph(mesh, {"a": a, "b": b, **ends}, paths)
    assert merge_junctions_by_axes(skeleton, find_section_centers(skeleton, Surface(mesh)), Surface(mesh)) is skeleton


@pytest.mark.parametrize(("height", "n_junctions"), [(0.9, 1), (1.1, 2)])
def test_a_pelvis_whose_legs_point_beyond_the_chest_stays(height, n_junctions, monkeypatch):
    """Chest and pelvis have radius 1 and are 3 apart; arms and legs point to one place so high above the chest."""
    monkeypatch.setattr(junctions, "judge_pairs", lambda skeleton, lines, inner, sines, surface: sines)
    place = np.array([0, 0, height])
    arms, legs = ([[x, 0, z] for x in (-8, 8)] for z in (0, -9))
    limbs = [place + np.linspace(0.5, 1, 6)[:, None] * (np.array(tip) - place) for tip in (*arms, *legs)]
    nodes = np.concatenate([[[0, 0, 0], [0, 0, -3]], *limbs])
    edges = [(0, 1)] + [(k // 2, 2 + 6 * k) for k in range(4)] + [(j, j + 1) for j in range(2, 26) if j % 6 != 1]
    ball = sphere(2)
    mesh = ball.with_vertices(20 * ball.vertices)
    skeleton = Skeleton(nodes, edges, np.ones(26), np.zeros(len(mesh.vertices), dtype=np.int64))
    centers = SectionCenters(np.arange(26) > 1, nodes)
    assert len(merge_junctions_by_axes(skeleton, centers, Surface(mesh)).junctions) == n_junctions


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


def synthetic(arms, surface, junction=(0, 0, 0)):
    """A junction with arms of known sections, given as arrays of points from the junction outwards."""
    nodes, edges, is_known = [np.asarray(junction, dtype=float)], [], [False]
    for arm in arms:
        last = 0
        for number, point in enumerate(arm):
            nodes.append(point)
            edges.append((last, len(nodes) - 1))
            is_known.append(number < len(arm) - 1)  # a tip has no section
            last = len(nodes) - 1
    skeleton = Skeleton(nodes, edges, np.ones(len(nodes)), np.zeros(len(surface.mesh.vertices)))
    return skeleton, SectionCenters(np.array(is_known), skeleton.nodes)


def ray(start, direction, n=5):
    return np.asarray(start) + 0.1 * np.arange(n)[:, None] * np.asarray(direction, dtype=float)


def test_lines_count_by_the_inverse_square_of_their_distance(rod_along_z):
    """Two lines along z, at x = 0.05 from a section at 1, and at x = -0.05 from one at -2."""
    arms = [ray([0.05, 0, 1], [0, 0, 1]), ray([-0.05, 0, -2], [0, 0, -1]), ray([0, 0.1, 0], [0, 1, 0], n=1)]
    skeleton, centers = synthetic(arms, rod_along_z)
    placed = place_junctions(skeleton, centers, rod_along_z).positions[0]
    weights = 1 / np.array([1 + 0.05**2, 2**2 + 0.05**2])
    x = weights @ [0.05, -0.05] / weights.sum()
    assert placed == pytest.approx([x, 0, 0], abs=1e-9)  # along z the lines say nothing


def test_a_junction_moves_by_its_ball_at_most_where_its_branches_do_not_agree(rod_along_z):
    """Two lines cross one unit away, but two nearly always do."""
    arms = [ray([0.3, 0, 1.3], [1, 0, 1], n=3), ray([-0.3, 0, 1.3], [-1, 0, 1], n=3), ray([0, 0.1, 0], [0, 1, 0], n=1)]
    skeleton, centers = synthetic(arms, rod_along_z)
    placed = place_junctions(skeleton, centers, rod_along_z).positions[0]
    assert np.linalg.norm(placed) == pytest.approx(rod_along_z.distance(np.zeros((1, 3)))[0], rel=1e-9)
    assert placed[2] > 0.99 * np.linalg.norm(placed)


def test_a_junction_goes_to_the_middle_where_its_branches_meet_near_the_surface(rod_along_z):
    """Two lines cross at x = 0.3 in a rod of radius 0.5, so that the ball there has less than half of the radius."""
    arms = [ray([0.4, 0, 0.1], [1, 0, 1], n=3), ray([0.4, 0, -0.1], [1, 0, -1], n=3), ray([0, 0.1, 0], [0, 1, 0], n=1)]
    skeleton, centers = synthetic(arms, rod_along_z)
    off = replace(skeleton, nodes=np.concatenate([[[0.2, 0, 0]], skeleton.nodes[1:]]))
    placed = place_junctions(off, SectionCenters(centers.is_known, off.nodes), rod_along_z).positions[0]
    # steps of a quarter of the radius, halved when none leads on, end within a few hundredths of the axis
    assert np.linalg.norm(placed[:2]) < 0.03
    assert abs(placed[2]) < 0.1


@pytest.mark.parametrize(("growth", "z"), [(0.0, 0.5), (0.05, 0.5), (0.08, 1.0)])
def test_a_junction_leaves_its_ball_where_three_branches_agree_and_balls_grow(growth, z):
    """The branches meet one unit above the junction, in a cone whose ball at the junction has a radius of 0.5."""
    cone = Surface(mesh_of_branches([([[0, 0, -4], [0, 0, 4]], [0.5 - 4 * growth, 0.5 + 4 * growth])]))
    arms = [ray([0.2 * np.cos(a), 0.2 * np.sin(a), 1.2], [np.cos(a), np.sin(a), 1], n=3) for a in (0, 2, 4)]
    skeleton, centers = synthetic(arms, cone)
    placed = place_junctions(skeleton, centers, cone).positions[0]
    assert placed == pytest.approx([0, 0, z], abs=0.02)


def test_a_junction_stops_inside_before_a_larger_ball_outside():
    """Beyond the surface of a ball of radius 1, distances from it grow too."""
    [place] = _where_balls_stop_growing(*np.array([[[0.5, 0, 0]], [[3.0, 0, 0]]]), np.array([0.3]), Surface(sphere(3)))
    assert place == pytest.approx([0.8, 0, 0])


def test_a_junction_stops_where_balls_grow_no_more():
    """The branches meet two units above it, beyond a cone that widens for one unit to a rod."""
    solid = mesh_of_branches([([[0, 0, -2], [0, 0, 1], [0, 0, 4]], [0.2, 0.5, 0.5])])
    arms = [ray([0.2 * np.cos(a), 0.2 * np.sin(a), 2.2], [np.cos(a), np.sin(a), 1], n=3) for a in (0, 2, 4)]
    skeleton, centers = synthetic(arms, Surface(solid))
    placed = place_junctions(skeleton, centers, Surface(solid)).positions[0]
    assert placed == pytest.approx([0, 0, 1], abs=0.1)  # its stops are 0.1 apart


@pytest.mark.parametrize("sign", [1, -1])
def test_the_legs_of_a_torso_and_of_its_mirror_image_have_a_pelvis(sign):
    """Nearly parallel legs, bent where they join the trunk, seem to meet in the head."""
    shape = torso(degrees=12.0)
    mesh = Mesh(shape.mesh.vertices * [sign, 1, 1], shape.mesh.faces[:, ::sign])
    distances = ground_truth_distances(skeletonize(mesh), shape.truth)  # of which both halves are the same
    assert distances.accuracy < 0.04


@pytest.mark.parametrize(("x", "is_followed"), [(0.04, True), (0.3, False)])
def test_a_junction_does_not_leave_its_ball_for_a_smaller_one(rod_along_z, x, is_followed):
    """Three branches agree on a place beside the axis of a rod of radius 0.5, on which the junction is."""
    arms = [ray([x, 0, sign], [0, 0, sign]) for sign in (1, -1)] + [ray([x, 0.1, 0], [0, 1, 0], n=3)]
    skeleton, centers = synthetic(arms, rod_along_z)
    placed = place_junctions(skeleton, centers, rod_along_z).positions[0]
    assert placed == pytest.approx([x if is_followed else 0, 0, 0], abs=1e-6)


@pytest.mark.parametrize("miss", [0.0, 0.05, 0.5])
def test_a_junction_goes_to_the_middle_as_far_as_its_branches_leave_its_place_open(rod_along_z, miss):
    """Two lines along z pass on both sides of a third in the plane x = 0.2, halfway to the side of the rod."""
    up, down = (ray([0.2 + sign * min(miss, 0.2), 0, sign], [0, 0, sign]) for sign in (1, -1))
    skeleton, centers = synthetic([up, down, ray([0.2, 0.1, 0], [0, 1, 0], n=3)], rod_along_z, [0.2, 0, 0])
    x, y, z = place_junctions(skeleton, centers, rod_along_z).positions[0]
    # six distances from the lines, two of them not zero, give three coordinates; the middle is known to 0.03
    assert x == pytest.approx(max(0.2 - miss * np.sqrt(2 / (6 - 3)), 0.0), abs=0.01 if miss < 0.2 else 0.04)
    assert max(abs(y), abs(z)) < 0.04


def test_sections_that_a_junction_has_passed_are_dropped(rod_along_z):
    """One arm along z, and two that cross it at z = 0.33; its sections at 0.1, 0.2 and 0.3 are passed."""
    along = [[0, 0, 0.1 * k] for k in range(1, 9)]
    left, right = (ray([sign * 0.1, 0, 0.43], [sign, 0, 1], n=4) for sign in (-1, 1))
    skeleton, centers = synthetic([along, left, right], rod_along_z)
    placed = place_junctions(skeleton, centers, rod_along_z)
    assert placed.positions[0] == pytest.approx([0, 0, 0.33], abs=0.01)
    assert placed.is_known[1:9].tolist() == [False, False, False, True, True, True, True, False]
    assert placed.is_known[9:].tolist() == centers.is_known[9:].tolist()


def test_a_junction_with_one_known_branch_keeps_its_position(rod_along_z):
    arms = [ray([0.1, 0, 1], [0, 0, 1]), *(ray([0, y, 0], [0, 1, 0], n=1) for y in (-0.1, 0.1))]
    skeleton, centers = synthetic(arms, rod_along_z)
    assert np.array_equal(place_junctions(skeleton, centers, rod_along_z).positions[0], np.zeros(3))


@pytest.mark.parametrize(("on_trunk", "limit"), [(False, MAX_MERGE_LENGTH), (True, MAX_TRUNK_LENGTH)])
def test_junctions_that_are_far_apart_are_not_merged(star, monkeypatch, on_trunk, limit):
    """The same lines as where they are merged, but with smaller inscribed radii."""
    if not on_trunk:
        monkeypatch.setattr(junctions, "judge_pairs", lambda skeleton, lines, inner, sines, surface: sines)
    near = graph_of_star(star, np.array([0.07, 0.07, 0.02]), np.array([-0.07, -0.07, 0.02]))
    length = np.linalg.norm(np.diff(near.nodes[near.junctions], axis=0))
    thin = replace(near, radii=np.full(len(near.nodes), 0.98 * length / limit))
    thick = replace(near, radii=np.full(len(near.nodes), 1.02 * length / limit))
    centers = find_section_centers(near, Surface(star))
    assert len(merge_junctions_by_axes(thin, centers, Surface(star)).junctions) == 2
    assert len(merge_junctions_by_axes(thick, centers, Surface(star)).junctions) == 1


@pytest.mark.parametrize("n_new", [1, 3])
def test_two_junctions_on_a_cycle_are_not_merged(star, n_new):
    """All their branches point to one place, but a second path between the two would be lost, or become a loop."""
    tree = graph_of_star(star, np.array([0.07, 0.07, 0.02]), np.array([-0.07, -0.07, 0.02]))
    [between] = [branch for branch in tree.branches if (tree.degrees[branch[[0, -1]]] >= 3).all()]
    target = np.arange(len(tree.nodes))
    target[between[:-1]] = between[0]
    tree = contract_nodes(tree, target)  # one edge between the two
    new = len(tree.nodes) + np.arange(n_new)
    one, other = tree.junctions
    cycle = replace(
        tree,
        nodes=np.concatenate([tree.nodes, np.linspace([0.01, 0.01, 0.08], [-0.01, -0.01, 0.08], n_new)]),
        edges=np.concatenate([tree.edges, [*itertools.pairwise([one, *new, other])]]),
        radii=np.append(tree.radii, np.full(n_new, tree.radii.max())),
    )
    centers = find_section_centers(tree, Surface(star))
    assert len(merge_junctions_by_axes(tree, centers, Surface(star)).junctions) == 1
    longer = SectionCenters(
        np.append(centers.is_known, np.zeros(n_new, dtype=bool)),
        np.append(centers.positions, cycle.nodes[new], axis=0),
    )
    merged = merge_junctions_by_axes(cycle, longer, Surface(star))
    assert (len(merged.junctions), merged.cycle_rank) == (2, 1)


@pytest.mark.parametrize(("direction", "points_there"), [([-1.0, 0, 0], True), ([0, 0, 1.0], False)])
def test_a_line_that_passes_beside_a_place_does_not_point_to_it(direction, points_there):
    """Two lines run to the origin, and a third starts beside it."""
    starts = np.array([[0, 0, 0.5], [0, 0, -0.5], [0.05, 0, 0]])
    directions = np.array([[0, 0, -1.0], [0, 0, 1.0], direction])
    number = np.arange(3)
    lines = BranchLines(0 * number, number, number >= 0, starts, starts, directions)
    sines = _largest_sines(lines, 0 * number, np.zeros((1, 3)))
    assert np.isfinite(sines).tolist() == [points_there]
