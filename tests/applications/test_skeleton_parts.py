"""The parts of a skeleton's nodes, on graphs made by hand."""

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.applications.skeleton_parts import parts_of_nodes


def star(ends, radius_of, n=21):
    """Straight branches of n - 1 nodes from a junction, node 0; radii by the distance from it."""
    nodes, edges = [np.zeros(3)], []
    for end in ends:
        last = 0
        for s in np.linspace(0, 1, n)[1:]:
            nodes.append(s * np.asarray(end, dtype=float))
            edges.append([last, len(nodes) - 1])
            last = len(nodes) - 1
    nodes = np.array(nodes)
    number = np.concatenate([[0], np.repeat(np.arange(len(ends)), n - 1)])
    radii = np.array([radius_of(k, np.linalg.norm(p)) for k, p in zip(number, nodes, strict=True)])
    return Skeleton(nodes, edges, radii), number


def parts(skeleton):
    return parts_of_nodes(skeleton, skeleton.radii)


def test_a_thick_trunk_has_the_ball_of_the_junction_and_limbs_begin_outside():
    skeleton, branch = star([[0, 0, -4], [3, 0, 1], [-3, 0, 1]], lambda k, s: 0.2 if k and s > 0.5 else 0.5)
    found, s = parts(skeleton), np.linalg.norm(skeleton.nodes, axis=1)
    assert len(np.unique(found)) == 3
    for limb in (1, 2):
        outside = (branch == limb) & (s > 0.5)
        assert len(np.unique(found[outside])) == 1
        assert not np.isin(found[outside], found[~outside]).any()
    assert len(np.unique(found[(branch == 0) | (s <= 0.5)])) == 1


def test_a_body_thicker_than_all_its_limbs_is_a_part_of_its_own():
    ends = [[np.cos(a), np.sin(a), 0.3 * (-1) ** k] for k, a in enumerate(np.linspace(0, 2 * np.pi, 6)[:-1])]
    skeleton, _ = star(3 * np.array(ends), lambda k, s: 1.0 - s if s < 0.8 else 0.2)
    assert len(np.unique(parts(skeleton))) == 6


def test_a_rail_goes_on_through_a_junction_but_not_where_it_bends():
    for bend, n_parts in ((0.0, 2), (1.0, 3)):
        rail = [[2, 0, 0], [-2 * np.cos(bend), -2 * np.sin(bend), 0], [0, 0, 2]]
        skeleton, _ = star(rail, lambda k, s: 0.1 if k == 2 else 0.15)
        assert len(np.unique(parts(skeleton))) == n_parts


def test_three_legs_of_one_thickness_are_three_parts_that_share_the_ball():
    skeleton, branch = star([[2, 0, 0], [-1, 1.7, 0], [-1, -1.7, 0]], lambda k, s: 0.3)
    found = parts(skeleton)
    assert all(len(np.unique(found[1:][branch[1:] == leg])) == 1 for leg in range(3))
    assert len(np.unique(found)) == 3


@pytest.mark.parametrize(("ball", "n_parts"), [(0.5, 3), (0.3, 1)])
def test_a_path_is_divided_where_its_thickness_jumps(ball, n_parts):
    """A bar of radius 0.2 with balls at its ends: 0.3 is no jump, 0.5 is."""
    x = np.linspace(0, 4, 81)
    to_ball = np.minimum(x, 4 - x)
    radii = np.where(to_ball < ball, np.maximum(ball - 0.5 * to_ball, 0.2), 0.2)
    radii[np.minimum(x, 4 - x) > 0.9 * ball] = 0.2
    path = Skeleton(np.stack([x, 0 * x, 0 * x], axis=1), np.stack([np.arange(80), np.arange(1, 81)], axis=1), radii)
    assert len(np.unique(parts(path))) == n_parts
    cone = Skeleton(path.nodes, path.edges, 1.0 - 0.2 * x)
    assert len(np.unique(parts(cone))) == 1


def test_a_claw_is_not_divided_where_it_begins_to_taper():
    """A finger of radius 0.3 with a claw, whose sides have an angle of 29 degrees to the axis; and a thinner finger."""
    x = np.linspace(0, 4, 81)
    nodes, edges = np.stack([x, 0 * x, 0 * x], axis=1), np.stack([np.arange(80), np.arange(1, 81)], axis=1)
    claw = Skeleton(nodes, edges, np.clip(0.55 * (4.0 - x), 0.01, 0.3))
    assert len(np.unique(parts(claw))) == 1
    longer = np.append(x, x[1:] + 4)
    nodes = np.stack([longer, 0 * longer, 0 * longer], axis=1)
    edges = np.stack([np.arange(160), np.arange(1, 161)], axis=1)
    thin = Skeleton(nodes, edges, np.clip(0.55 * (4.0 - longer), 0.1, 0.3))
    assert len(np.unique(parts(thin))) == 2


def test_junctions_whose_balls_meet_are_one_and_single_nodes_are_parts():
    nodes = [[0, 0, 0], [0.5, 0, 0], [-2, 1, 0], [-2, -1, 0], [2.5, 1, 0], [2.5, -1, 0], [9, 9, 9]]
    edges = [[0, 1], [0, 2], [0, 3], [1, 4], [1, 5]]
    found = parts(Skeleton(nodes, edges, [0.4, 0.4, 0.1, 0.1, 0.1, 0.1, 1.0]))
    assert found[0] == found[1]
    assert len(np.unique(found)) == 6
    assert parts(Skeleton(nodes[:1], [], [1.0])).tolist() == [0]


def test_a_finger_is_compared_with_the_largest_of_the_balls_that_meet():
    # a palm of two balls: wrist and thumb on the larger one, three fingers on the other, one almost as thick as that
    palm, ends = [[0.0, 0, 0], [0.9, 0, 0]], [[-3, 0, 0], [0, 3, 0], [3, 1, 0], [3, 0, 0], [3, -1, 0]]
    nodes, edges, radii = list(palm), [[0, 1]], [1.0, 0.6]
    for begin, end, radius in zip((0, 0, 1, 1, 1), ends, (0.3, 0.3, 0.3, 0.5, 0.3), strict=True):
        last = begin
        for share in np.linspace(0, 1, 11)[1:]:
            nodes.append(np.add(palm[begin], share * np.subtract(end, palm[begin])))
            edges.append([last, len(nodes) - 1])
            radii.append(radius)
            last = len(nodes) - 1
    found = parts(Skeleton(nodes, edges, radii))
    tips = found[[11, 21, 31, 41, 51]]
    assert len(np.unique(tips)) == 5
    assert not np.isin(found[:2], tips).any()


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 2, 0)])
def test_a_pelvis_as_thick_as_legs_and_torso_belongs_to_the_torso(order):
    legs_and_torso = [[1, 0, -3], [-1, 0, -3], [0, 0, 5]]
    radii = [0.49, 0.48, 0.45]
    ends = [legs_and_torso[each] for each in order]
    skeleton, branch = star(ends, lambda k, s: 0.5 if s == 0 else radii[order[k]])
    found = parts(skeleton)
    assert len(np.unique(found)) == 3
    assert found[0] == found[1:][branch[1:] == order.index(2)][-1]
