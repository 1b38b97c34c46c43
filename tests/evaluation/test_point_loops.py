"""Skeletons with a cut that is known, on points of tubes around them."""

import numpy as np
import pytest

import lbskel
from lbskel import PointCloud, Skeleton
from lbskel.evaluation.point_scoring import score_points
from lbskel.shapes import marching_cubes, solid_of


def _tube(nodes, radius, n, *, is_closed=False, seed=0):
    """Points around a curve, and the skeleton that is the curve."""
    rng, k = np.random.default_rng(seed), len(nodes)
    edges = np.stack([np.arange(k), np.arange(1, k + 1) % k], axis=1)[: k if is_closed else k - 1]
    edge, share = rng.integers(len(edges), size=n), rng.random((n, 1))
    start, end = nodes[edges[edge]].transpose(1, 0, 2)
    axis = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    around = rng.normal(size=(n, 3))
    around -= (around * axis).sum(axis=1, keepdims=True) * axis
    points = start + share * (end - start) + radius * around / np.linalg.norm(around, axis=1, keepdims=True)
    return points, Skeleton(nodes, edges, np.full(k, radius))


def _arc(turn, n=60):
    angle = np.linspace(0, turn, n, endpoint=turn < 2 * np.pi)
    return np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)


RING_POINTS, RING = _tube(_arc(2 * np.pi), 0.2, 5000, is_closed=True)


def _missed(skeleton, points):
    return score_points(skeleton, PointCloud(points)).tunnels_missed


def test_a_ring_misses_nothing():
    assert _missed(RING, RING_POINTS) == 0


@pytest.mark.parametrize("n_cut", [1, 5])
def test_a_ring_that_is_cut_fails(n_cut):
    edges = RING.edges[: len(RING.edges) - n_cut]
    used = np.unique(edges)
    cut = Skeleton(RING.nodes[used], np.searchsorted(used, edges), RING.radii[used])
    score = score_points(cut, PointCloud(RING_POINTS))
    assert (score.tunnels_missed, score.verdict) == (1, "fail")


def test_a_ring_of_few_noisy_points_that_is_cut():
    points, ring = _tube(_arc(2 * np.pi), 0.2, 1500, is_closed=True)
    points += np.random.default_rng(1).normal(size=points.shape) * 0.02
    assert _missed(ring, points) == 0
    assert _missed(Skeleton(ring.nodes, ring.edges[:-1], ring.radii), points) == 1


def test_a_ring_that_is_cut_anywhere():
    points, ring = _tube(_arc(2 * np.pi), 0.2, 10_000, is_closed=True)
    cuts = [Skeleton(ring.nodes, np.delete(ring.edges, edge, axis=0), ring.radii) for edge in range(0, 60, 5)]
    assert [_missed(cut, points) for cut in cuts] == [1] * 12


def test_limbs_that_cross_and_touch_are_no_ring():
    line, turn = np.linspace(-1.5, 1.5, 40), np.linspace(0, 1.5 * np.pi, 60)[1:-1]
    along = np.stack([line, 0 * line, 0 * line - 0.2], axis=1)
    across = np.stack([0 * line, line, 0 * line + 0.2], axis=1)
    back = np.stack([1.5 + 1.5 * np.sin(turn), -1.5 + 1.5 * np.cos(turn), np.linspace(-0.2, 0.2, 58)], axis=1)
    nodes = np.concatenate([along, back, across])
    points, knot = _tube(nodes, 0.2, 12000)
    assert _missed(knot, points) == 0


def test_a_horseshoe_whose_ends_are_a_radius_apart_passes():
    points, shoe = _tube(_arc(2 * np.pi - 0.2), 0.2, 5000)  # open at its ends
    assert _missed(shoe, points) == 0


def test_legs_that_touch_are_no_ring():
    line = np.linspace(0, 2, 40)
    bend = np.linspace(0, np.pi, 14)[1:-1]
    nodes = np.concatenate(
        [
            np.stack([line[::-1], np.full(40, 0.21), 0 * line], axis=1),
            np.stack([-0.21 * np.sin(bend), 0.21 * np.cos(bend), 0 * bend], axis=1),
            np.stack([line, np.full(40, -0.21), 0 * line], axis=1),
        ]
    )  # 0.02 apart, less than the points
    points, legs = _tube(nodes, 0.2, 6000)
    assert _missed(legs, points) == 0


def test_a_rung_that_is_missing_is_found():
    up, across = np.linspace(-3, 3, 61), np.linspace(-0.9, 0.9, 19)
    left, right = (np.stack([np.full(61, x), y, 0 * y], axis=1) for x, y in ((-1, -up), (1, up)))
    top, bottom = (np.stack([x, np.full(19, y), 0 * x], axis=1) for x, y in ((-across, 3), (across, -3)))
    frame, skeleton = _tube(np.concatenate([left, bottom, right, top]), 0.15, 9000, is_closed=True)
    rung, _ = _tube(np.stack([across, 0 * across, 0 * across], axis=1), 0.15, 1000)
    is_open = (np.abs(frame[:, 0]) < 1) & (np.hypot(frame[:, 1], frame[:, 2]) < 0.15)
    assert _missed(skeleton, np.concatenate([frame[~is_open], rung])) == 1


def test_a_skeleton_in_two_parts_is_told_by_its_components():
    edges = np.delete(RING.edges, [10, 40], axis=0)
    score = score_points(Skeleton(RING.nodes, edges, RING.radii), PointCloud(RING_POINTS))
    assert (score.extra_components, score.tunnels_missed) == (1, 0)


def test_the_cut_of_a_skeleton_of_ours_is_found():
    points = lbskel.shapes.torus(1.0, 0.3).vertices
    skeleton = lbskel.skeletonize(PointCloud(points))
    assert skeleton.report["score"]["measures"]["tunnels_missed"] == 0
    cut = Skeleton(skeleton.nodes, skeleton.edges[1:], skeleton.radii, skeleton.node_of_vertex)
    assert lbskel.score(cut, points).tunnels_missed == 1


def test_a_loop_that_was_opened_on_purpose_is_not_missed():
    points = lbskel.shapes.torus(1.0, 0.3).vertices
    skeleton = lbskel.skeletonize(PointCloud(points), min_loop=100.0)
    assert skeleton.cycle_rank == 0
    assert skeleton.report["score"]["measures"]["tunnels_missed"] == 0


def test_the_border_of_points_nearest_to_another_limb_is_no_ring():
    rng = np.random.default_rng(0)
    wall = np.stack([rng.uniform(-2, 2, 8000), rng.uniform(-2, 2, 8000), np.zeros(8000)], axis=1)
    grid = np.arange(81).reshape(9, 9)
    x, y = np.meshgrid(np.linspace(-2, 2, 9), np.linspace(-2, 2, 9), indexing="ij")
    plate = np.stack([x.ravel(), y.ravel(), np.full(81, -0.5)], axis=1)
    # a limb from the corner of the plate, far around, to the other side of the wall
    limb = np.array([[-2.0, -2, -9], [-9, -2, -9], [-9, 0, 9], [0, 0, 9], [0, 0, 0.1]])
    along = [np.stack([start[:-1].ravel(), end[1:].ravel()], axis=1) for start, end in ((grid, grid), (grid.T, grid.T))]
    to_limb = [[0, 81], [81, 82], [82, 83], [83, 84], [84, 85]]
    skeleton = Skeleton(np.concatenate([plate, limb]), np.concatenate([*along, to_limb]), np.full(86, 0.5))
    assert _missed(skeleton, wall) == 0


def test_the_border_between_limbs_that_part_slowly_is_no_ring():
    rng, turn = np.random.default_rng(0), np.linspace(0, 5, 51)
    angle, height = rng.uniform(-0.2, 5, 9000), rng.uniform(-0.6, 0.6, 9000)
    band = np.stack([np.cos(angle), np.sin(angle), height], axis=1)
    reach = np.where(np.arange(51) % 2, 0.8, 1.2)  # of branches that bend to and fro, and so are long
    upper = np.stack([reach * np.cos(turn), reach * np.sin(turn), np.full(51, 0.3)], axis=1)
    nodes = np.concatenate([upper[::-1], upper * [1, 1, -1]])  # joined at one end of the border
    edges = np.stack([np.arange(101), np.arange(1, 102)], axis=1)
    assert _missed(Skeleton(nodes, edges, np.full(102, 0.3)), band) == 0


def test_webs_between_fingers_are_no_cuts():
    """Their links lie around a part of the middle of their nodes, but beside it."""
    angles = np.radians([-60.0, -20.0, 20.0, 60.0])
    fingers = [([np.zeros(3), 6 * np.array([np.sin(angle), 0, np.cos(angle)])], 0.5) for angle in angles]
    hand = marching_cubes(solid_of([([[0, 0, 0]], 2.0), ([[0, 0, 0], [0, 0, -6]], 1.2), *fingers], blend=0.05), 0.15)
    for seed in (0, 3, 5):
        rng = np.random.default_rng(seed)
        faces = rng.choice(len(hand.faces), 8000, p=hand.face_areas / hand.area)
        points = np.einsum("nk,nki->ni", rng.dirichlet(np.ones(3), 8000), hand.vertices[hand.faces[faces]])
        skeleton = lbskel.skeletonize(PointCloud(points))
        assert (len(skeleton.tips), skeleton.cycle_rank, _missed(skeleton, points)) == (5, 0, 0)
