"""Trunks: found where one tube passes through a junction, and limbs that leave it where their lines meet its axis."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import mesh_of_branches

from lbskel import Skeleton, ground_truth_distances, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.branch_lines import BranchLines, branch_lines
from lbskel.refinement.centerlines import SectionCenters
from lbskel.refinement.junctions import merge_junctions_by_axes
from lbskel.refinement.trunks import find_trunk, judge_pairs, split_junctions_along_trunks
from lbskel.shapes import Shape, make, mesh_solid, solid_of
from lbskel.skeleton.pruning import merge_junctions

THICK, THIN = 1.0, 0.4  # radii of the trunk, along x, and of limbs


@pytest.fixture(scope="module")
def surface():
    """A trunk with a limb up at x = -1, one down at x = 1, and one aside at x = 1.3."""
    limbs = [[-1, 0, 3], [1, 0, -3], [1.3, 3, 0]]
    return Surface(
        mesh_of_branches([([[-6, 0, 0], [6, 0, 0]], THICK), *(([[x, 0, 0], [x, y, z]], THIN) for x, y, z in limbs)])
    )


def lines_at(starts, directions, junctions=None):
    """Lines whose sections next to the junction are at the starts."""
    directions = np.array(directions, dtype=float)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    starts, n = np.array(starts, dtype=float), len(starts)
    at = np.zeros(n, dtype=np.int64) if junctions is None else np.array(junctions)
    return BranchLines(at, np.arange(n), np.ones(n, dtype=bool), starts, starts - 0.5 * directions, directions)


TRUNK = ([[-2.5, 0, 0], [2.5, 0, 0]], [[1, 0, 0], [-1, 0, 0]])
LIMBS = ([[-1, 0, 1.6], [1, 0, -1.6], [1.3, 1.6, 0]], [[0, 0, -1], [0, 0, 1], [0, -1, 0]])


def whole(*limbs):
    """The lines of the trunk and of some limbs."""
    return lines_at(*(TRUNK[k] + [LIMBS[k][limb] for limb in limbs] for k in (0, 1)))


def test_limbs_have_one_place_where_they_overlap_and_places_of_their_own_elsewhere(surface):
    trunk = find_trunk(whole(0, 1, 2), THICK, surface)
    assert sorted(trunk.ends) == [0, 1]
    assert trunk.limbs.tolist() == [2, 3, 4]
    order = 1 if trunk.ends[0] == 0 else -1
    assert trunk.places[::order] == pytest.approx(np.array([[-1, 0, 0], [1.15, 0, 0]]), abs=1e-9)
    assert trunk.places[trunk.numbers] == pytest.approx(np.array([[-1, 0, 0], [1.15, 0, 0], [1.15, 0, 0]]), abs=1e-9)


@pytest.mark.parametrize("x", [0.75, 0.85])
def test_limbs_overlap_up_to_the_sum_of_their_radii(x):
    """Both have radius 0.4, so that the sum is less than the radius of the trunk."""
    ends = [[0, 0, 3], [x, 0, -3]]
    solid = mesh_of_branches(
        [([[-6, 0, 0], [6, 0, 0]], THICK), *(([[end[0], 0, 0], end], THIN) for end in ends)], step=0.05
    )
    starts, directions = TRUNK[0] + [[0, 0, 1.6], [x, 0, -1.6]], TRUNK[1] + [[0, 0, -1], [0, 0, 1]]
    trunk = find_trunk(lines_at(starts, directions), THICK, Surface(solid))
    assert len(trunk.places) == (1 if x < 0.8 else 2)


@pytest.mark.parametrize("ball", [1.6, 1.7])
def test_a_palm_is_no_trunk(surface, ball):
    """The ball at the junction is 1.6 or 1.7 times as large as the tube; that between is 1 / MIN_THICKNESS."""
    assert (find_trunk(whole(0, 1), ball, surface) is None) == (ball > 1 / 0.6)


@pytest.mark.parametrize("degrees", [20.0, 22.0])
def test_a_trunk_may_bend_as_far_as_the_lines_of_a_junction_may_miss_it(surface, degrees):
    """At one end; the sine of 21.1 degrees is MAX_SINE."""
    tilt = np.tan(np.radians(degrees))
    starts, directions = TRUNK[0] + [LIMBS[0][0]], [[1, 0, tilt], *TRUNK[1][1:], LIMBS[1][0]]
    lines = lines_at(starts, directions)
    lines = replace(lines, means=lines.starts)  # so that the way between the two is along x
    assert (find_trunk(lines, THICK, surface) is None) == (degrees > 21.1)


def test_two_branches_side_by_side_are_no_trunk(surface):
    """Their directions are opposite, but neither continues the other."""
    for z in (0.45, 0.4):  # 1.1 from the middle, by which the way between them is 22 or 20 degrees askew
        starts = [[-0.6, 0, z], [0.6, 0, -z], LIMBS[0][2]]
        assert (find_trunk(lines_at(starts, [*TRUNK[1], LIMBS[1][2]]), 0.8, surface) is None) == (z > 0.42)


def test_a_limb_along_the_trunk_has_no_place_on_it(surface):
    assert find_trunk(lines_at(TRUNK[0] + [[-1, 0, 1.6]], TRUNK[1] + [[2.8, 0, -1]]), THICK, surface) is None
    assert find_trunk(lines_at(TRUNK[0] + [[-1, 0, 1.6]], TRUNK[1] + [[2.4, 0, -1]]), THICK, surface) is not None


@pytest.mark.parametrize("begin", [0.9, 1.1])
def test_a_limb_leaves_near_the_gap_between_the_sections_of_the_trunk(surface, begin):
    """The limb leaves at x = -1; the sections of the trunk begin up to two radii beyond that."""
    lines = whole(0)
    starts = np.array(lines.starts)
    starts[0, 0] = begin
    assert (find_trunk(replace(lines, starts=starts), THICK, surface) is None) == (begin > 1)


def test_a_tube_that_crosses_the_trunk_has_one_place():
    """Two thick limbs in one line that crosses the trunk at 60 degrees, bent by 20 degrees where they enter it."""
    across = np.array([np.cos(np.pi / 3), 0, np.sin(np.pi / 3)])
    crossing = Surface(mesh_of_branches([([[-6, 0, 0], [6, 0, 0]], THICK), ([-6 * across, 6 * across], THICK)]))
    turn = np.radians(20)
    bent = np.array([np.cos(np.pi / 3 + turn), 0, np.sin(np.pi / 3 + turn)])
    lines = lines_at(TRUNK[0] + [3 * across, -3 * across], TRUNK[1] + [-bent, bent])
    trunk = find_trunk(replace(lines, means=lines.starts), THICK, crossing)
    assert trunk.places == pytest.approx(np.zeros((1, 3)), abs=1e-9)
    thin = mesh_of_branches([([[-6, 0, 0], [6, 0, 0]], THICK), ([-6 * across, 6 * across], THIN)])
    # thin limbs are two: where their lines pass the axis, they have room beside each other
    assert len(find_trunk(replace(lines, means=lines.starts), THICK, Surface(thin)).places) == 2


def junction_with(limbs, surface, *, at=0.0):
    """A junction on the trunk, with branches of five sections: both sides of the trunk, and limbs."""
    starts, ways = np.array([*TRUNK[0], *LIMBS[0]]), -np.array([*TRUNK[1], *LIMBS[1]], dtype=float)
    nodes, edges = [[at, 0, 0]], []
    for row in (0, 1, *(2 + limb for limb in limbs)):
        arm = starts[row] + 0.3 * np.arange(5)[:, None] * ways[row]
        edges += [(0, len(nodes)), *((len(nodes) + k, len(nodes) + k + 1) for k in range(4))]
        nodes += arm.tolist()
    skeleton = Skeleton(nodes, edges, surface.distance(np.array(nodes)), np.zeros(len(surface.mesh.vertices)))
    return skeleton, SectionCenters(skeleton.degrees == 2, skeleton.nodes)


def test_a_junction_is_split_along_its_trunk_in_the_order_of_its_limbs(surface):
    skeleton, centers = junction_with((1, 0, 2), surface)
    split, around = split_junctions_along_trunks(skeleton, centers, surface)
    assert (len(split.tips), split.n_components, split.cycle_rank) == (5, 1, 0)
    places = split.nodes[split.junctions]
    left, right = split.junctions[np.argsort(places[:, 0])]
    assert split.nodes[[left, right]] == pytest.approx(np.array([[-1, 0, 0], [1.15, 0, 0]]), abs=1e-9)
    assert split.degrees[[left, right]].tolist() == [3, 4]
    beside = [sorted(split.nodes[split.neighbors[end]].round(6).tolist()) for end in (left, right)]
    assert beside[0] == sorted([[-2.5, 0, 0], [-1, 0, 1.6], [1.15, 0, 0]])
    assert beside[1] == sorted([[2.5, 0, 0], [1, 0, -1.6], [1.3, 1.6, 0], [-1, 0, 0]])
    assert split.radii == pytest.approx(surface.distance(split.nodes))
    assert np.array_equal(around.positions, split.nodes)
    assert not around.is_known[split.junctions].any()
    assert np.array_equal(around.is_known[: len(skeleton.nodes)], centers.is_known)
    assert len(split.mean_radii) == 0


def test_a_junction_that_moves_to_its_first_place_has_the_ball_there():
    """The trunk tapers, so that the ball at the junction is not that at the places of its limbs."""
    trunk = ([[-6, 0, 0], [6, 0, 0]], [1.3, 0.9])
    limbs = [([[x, 0, 0], [x, 0, z]], THIN) for x, z in ((-1, 4), (1, -4))]
    surface = Surface(mesh_of_branches([trunk, *limbs]))
    skeleton, centers = junction_with((0, 1), surface)
    split = split_junctions_along_trunks(replace(skeleton, radius_kind="mean"), centers, surface)[0]
    assert len(split.junctions) == 2
    assert (split.radii, split.radius_kind) == (pytest.approx(surface.distance(split.nodes)), "inscribed")


def test_two_junctions_side_by_side_are_both_split():
    """The one edge between them then leads from a new junction of the one to a new junction of the other."""
    ways = {-1.6: [0, 0, 1], -0.2: [0, 0, -1], 0.4: [0, 1, 0], 1.8: [0, -1, 0]}
    limbs = [(np.array([x, 0.0, 0]), np.array(way)) for x, way in ways.items()]
    surface = Surface(
        mesh_of_branches(
            [([[-7, 0, 0], [7, 0, 0]], THICK), *(([at.tolist(), (at + 4 * way).tolist()], THIN) for at, way in limbs)]
        )
    )
    arms = [[[x, 0, 0] for x in -np.arange(1, 6.5, 0.5)], [[x, 0, 0] for x in np.arange(1, 6.5, 0.5)]]
    arms += [[at + t * way for t in np.arange(1.2, 3.8, 0.25)] for at, way in limbs]
    nodes, edges = [[-0.3, 0, 0], [0.3, 0, 0]], [(0, 1)]
    for junction, arm in zip((0, 1, 0, 0, 1, 1), arms, strict=True):
        first = len(nodes)
        edges += [(junction, first), *((first + k, first + k + 1) for k in range(len(arm) - 1))]
        nodes += np.array(arm).tolist()
    skeleton = Skeleton(nodes, edges, surface.distance(np.array(nodes)), np.zeros(len(surface.mesh.vertices)))
    split = split_junctions_along_trunks(skeleton, SectionCenters(skeleton.degrees == 2, skeleton.nodes), surface)[0]
    assert (len(split.tips), split.n_components, split.cycle_rank) == (6, 1, 0)
    assert split.degrees[split.junctions].tolist() == [3, 3, 3, 3]
    assert sorted(split.nodes[split.junctions, 0]) == pytest.approx(list(ways), abs=1e-6)


def test_a_junction_whose_limbs_overlap_is_not_split(surface):
    skeleton, centers = junction_with((1, 2), surface)
    assert split_junctions_along_trunks(skeleton, centers, surface)[0] is skeleton
    alone = junction_with((1,), surface)  # no junction of three branches is split
    assert split_junctions_along_trunks(*alone, surface)[0] is alone[0]


def test_a_junction_in_a_swelling_is_split_to_where_the_limbs_leave():
    """The trunk is thicker at the junction than where its limbs leave."""
    ends = [[-1, 0, 3], [1, 0, -3]]
    trunk = ([[-6, 0, 0], [-1, 0, 0], [0, 0, 0], [1, 0, 0], [6, 0, 0]], [THICK, THICK, 1.2, THICK, THICK])
    surface = Surface(mesh_of_branches([trunk, *(([[end[0], 0, 0], end], THIN) for end in ends)]))
    skeleton, centers = junction_with((0, 1), surface)
    split = split_junctions_along_trunks(skeleton, centers, surface)[0]
    assert split.degrees[split.junctions].tolist() == [3, 3]


def test_a_branch_without_a_line_stays_with_the_nearest_place(surface):
    skeleton, centers = junction_with((0, 1, 2), surface)
    tip = [[0.9, -0.9, 0]]
    with_spur = Skeleton(
        np.concatenate([skeleton.nodes, tip]),
        [*skeleton.edges.tolist(), [0, len(skeleton.nodes)]],
        np.append(skeleton.radii, 0.1),
        skeleton.node_of_vertex,
    )
    known = SectionCenters(np.append(centers.is_known, False), with_spur.nodes)
    split, _ = split_junctions_along_trunks(with_spur, known, surface)
    assert split.nodes[split.neighbors[len(skeleton.nodes)][0]] == pytest.approx([1.15, 0, 0], abs=1e-9)


def pair_with(first, second, surface):
    """Two junctions on the trunk, at x = -0.5 and 0.5, each with one side of the trunk and some limbs."""
    starts, ways = np.array([*TRUNK[0], *LIMBS[0]]), -np.array([*TRUNK[1], *LIMBS[1]], dtype=float)
    nodes, edges = [[-0.5, 0, 0], [0.5, 0, 0]], [(0, 1)]
    for junction, rows in ((0, (0, *(2 + limb for limb in first))), (1, (1, *(2 + limb for limb in second)))):
        for row in rows:
            arm = starts[row] + 0.3 * np.arange(5)[:, None] * ways[row]
            edges += [(junction, len(nodes)), *((len(nodes) + k, len(nodes) + k + 1) for k in range(4))]
            nodes += arm.tolist()
    skeleton = Skeleton(nodes, edges, surface.distance(np.array(nodes)), np.zeros(len(surface.mesh.vertices)))
    return skeleton, SectionCenters(skeleton.degrees == 2, skeleton.nodes)


@pytest.mark.parametrize(
    ("first", "second", "sine"), [((0,), (1,), np.inf), ((1,), (0,), 0.0), ((1,), (2,), 0.0), ((0,), (1, 2), np.inf)]
)
def test_a_pair_is_right_where_its_limbs_leave_the_trunk_apart_and_in_its_order(surface, first, second, sine):
    skeleton, centers = pair_with(first, second, surface)
    lines = branch_lines(skeleton, centers)
    [inner] = [k for k, branch in enumerate(skeleton.branches) if set(branch[[0, -1]].tolist()) == {0, 1}]
    assert judge_pairs(skeleton, lines, np.array([inner]), np.array([0.2]), surface).tolist() == [sine]
    merged = merge_junctions_by_axes(skeleton, centers, surface)
    assert len(merged.junctions) == (2 if np.isinf(sine) else 1)


def test_a_pair_without_a_trunk_is_judged_as_before(surface):
    skeleton, centers = pair_with((0,), (1,), surface)
    lines = branch_lines(skeleton, centers)
    [inner] = [k for k, branch in enumerate(skeleton.branches) if set(branch[[0, -1]].tolist()) == {0, 1}]
    thick = replace(skeleton, radii=np.full(len(skeleton.nodes), 2.0))  # the ball of a palm
    assert judge_pairs(thick, lines, np.array([inner]), np.array([0.2]), surface).tolist() == [0.2]


@pytest.mark.parametrize(("ball", "sine"), [(1.0, np.inf), (1.15, 0.2)])
def test_a_pair_on_a_tube_that_bends_between_its_junctions_is_right(surface, ball, sine):
    skeleton, centers = pair_with((0,), (1,), surface)
    lines = branch_lines(skeleton, centers)
    [inner] = [k for k, branch in enumerate(skeleton.branches) if set(branch[[0, -1]].tolist()) == {0, 1}]
    directions, tilt = np.array(lines.directions), np.radians(40)
    of_trunk = np.flatnonzero(np.abs(directions[:, 0]) > 0.9)
    directions[of_trunk] = np.cos(tilt) * directions[of_trunk] + [0, 0, np.sin(tilt)]
    bent = replace(lines, directions=directions)
    assert find_trunk(bent, ball, surface) is None
    around = replace(skeleton, radii=np.full(len(skeleton.nodes), ball))
    assert judge_pairs(around, bent, np.array([inner]), np.array([0.2]), surface).tolist() == [sine]
    single = bent.take(np.arange(len(directions)) != of_trunk[1])  # a tube that ends at the second junction
    assert judge_pairs(around, single, np.array([inner]), np.array([0.2]), surface).tolist() == [0.2]


@pytest.mark.parametrize("apart", [1.0, 1.6])
def test_limbs_along_a_trunk_have_junctions_of_their_own(apart):
    """Four limbs of 0.45 trunk radii, neighbors on opposite sides of it, are farther apart than the radius."""
    radius, heights = 0.25, apart * 0.25 * 1.05 * (np.arange(4) - 1.5)
    branches = [(np.column_stack([np.append(np.append(-1.6, heights), 1.6), np.zeros((6, 2))]), radius)]
    for number, x in enumerate(heights):
        way = np.array([0.2 * (-1) ** number, np.cos(2.0 * number), np.sin(2.0 * number)])
        branches.append(([[x, 0, 0], [x, 0, 0] + 1.2 * way], 0.45 * radius))
    solid = solid_of(branches)
    shape = Shape(mesh_solid(solid, n_vertices=5000), solid.truth, "limbs")
    skeleton = skeletonize(shape.mesh)
    distances = ground_truth_distances(skeleton, shape.truth)
    assert (distances.n_tips, len(merge_junctions(skeleton).junctions)) == (6, 4)
    assert distances.accuracy < 0.05


def test_a_figure_eight_keeps_one_junction():
    skeleton = skeletonize(make("figure_eight", n_vertices=2000).mesh)
    assert skeleton.degrees[skeleton.junctions].tolist() == [4]
