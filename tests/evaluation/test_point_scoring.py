"""The score on points: good skeletons pass, and each fault is found by its measure."""

from dataclasses import replace

import numpy as np
import pytest

import lbskel
from lbskel import MeshError, PointCloud, Skeleton
from lbskel._kernels.point_tree import PointTree
from lbskel.evaluation.point_scoring import SCORED_NEIGHBORS, score_points
from lbskel.shapes import make, torus


def _cross():
    """A cross of four tubes, of radius 0.06 and length 1: 6,000 points without the hidden ones, and its skeleton."""
    rng = np.random.default_rng(4)
    along, angle = rng.uniform(0, 1, 6000), rng.uniform(0, 2 * np.pi, 6000)
    arm = rng.integers(4, size=6000)
    axes = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    sides = np.array([[0.0, 1, 0], [0, 1, 0], [1, 0, 0], [1, 0, 0]])
    around = 0.06 * (np.cos(angle)[:, None] * sides[arm] + np.sin(angle)[:, None] * [0, 0, 1])
    points = along[:, None] * axes[arm] + around
    points = points[along > 0.06]
    ts = np.linspace(0.05, 0.95, 19)
    nodes = np.concatenate([[[0, 0, 0]], *(ts[:, None] * axis for axis in axes)])
    starts = 1 + 19 * np.arange(4)
    edges = [(0, s) for s in starts] + [(s + i, s + i + 1) for s in starts for i in range(18)]
    node = np.linalg.norm(points[:, None] - nodes, axis=2).argmin(axis=1)
    return PointCloud(points), Skeleton(nodes, np.array(edges), np.full(len(nodes), 0.06), node)


CLOUD, CROSS = _cross()


def _without(nodes):
    kept = np.setdiff1d(np.arange(len(CROSS.nodes)), nodes)
    new = np.full(len(CROSS.nodes), -1)
    new[kept] = np.arange(len(kept))
    edges = new[CROSS.edges]
    return Skeleton(CROSS.nodes[kept], edges[(edges >= 0).all(axis=1)], CROSS.radii[kept])


def test_a_good_skeleton_passes():
    score = score_points(CROSS, CLOUD)
    assert score.verdict == "pass"
    assert score.extremities == 4
    assert score.centeredness_error < 0.05
    assert score.extra_cycles is None
    assert "extra_cycles" in score.not_measured
    assert "not measured, without a surface: medial accuracy 95, medial coverage 98, uncovered parts" in str(score)


@pytest.mark.parametrize(
    ("skeleton", "fault"),
    [
        (_without(np.arange(1, 20)), "missed_limb_fraction"),
        (replace(CROSS, edges=np.delete(CROSS.edges, 30, axis=0)), "extra_components"),
        (replace(CROSS, nodes=CROSS.nodes + [0, 0, 0.03]), "centeredness_error"),
    ],
)
def test_a_fault_is_found(skeleton, fault):
    assert score_points(skeleton, CLOUD).verdicts[fault] == "fail"


def test_a_branch_through_empty_space_is_found():
    ts, n = np.linspace(0.05, 0.95, 19)[:, None], len(CROSS.nodes)
    bridge = CROSS.nodes[19] * (1 - ts) + CROSS.nodes[57] * ts
    edges = [[19, n], *([n + i, n + i + 1] for i in range(18)), [n + 18, 57]]
    skeleton = Skeleton(
        np.concatenate([CROSS.nodes, bridge]), np.concatenate([CROSS.edges, edges]), np.full(n + 19, 0.1)
    )
    assert score_points(skeleton, CLOUD).verdicts["inside_fraction"] == "fail"


def test_an_edge_through_empty_space_is_found():
    skeleton = replace(CROSS, edges=np.concatenate([CROSS.edges, [[19, 57]]]))
    score = score_points(skeleton, CLOUD)
    assert score.nodes_inside_fraction == 1
    assert score.verdicts["inside_fraction"] == "fail"


def test_nodes_beyond_those_that_are_sampled_are_judged_too():
    rng = np.random.default_rng(2)
    fine = lbskel.resample(CROSS, n_nodes=3000)
    is_aside = rng.random(len(fine.nodes)) < 0.3
    aside = replace(fine, nodes=fine.nodes + 0.4 * is_aside[:, None] * [0, 0, 1], node_of_vertex=np.empty(0, np.int64))
    assert score_points(aside, CLOUD).verdicts["nodes_inside_fraction"] == "fail"


def test_a_node_far_away_is_outside():
    score = score_points(Skeleton(np.array([[50.0, 0, 0]]), np.empty((0, 2)), np.ones(1)), CLOUD)
    assert (score.nodes_inside_fraction, score.inside_fraction, score.coverage) == (0, 0, 0)


def test_copies_of_points_change_nothing():
    copied = PointCloud(np.repeat(CLOUD.points, 20, axis=0))
    skeleton = replace(CROSS, node_of_vertex=np.empty(0, dtype=np.int64))
    assert score_points(skeleton, copied) == score_points(skeleton, CLOUD)


def test_a_skeleton_that_joins_two_parts_is_partly_outside():
    n, shift = len(CROSS.nodes), np.array([10.0, 0, 0])
    both = PointCloud(np.concatenate([CLOUD.points, CLOUD.points + shift]))
    edges = np.concatenate([CROSS.edges, CROSS.edges + n, [[0, n]]])
    score = score_points(Skeleton(np.concatenate([CROSS.nodes, CROSS.nodes + shift]), edges, np.ones(2 * n)), both)
    assert score.verdicts["inside_fraction"] == "fail"


def test_an_edge_that_joins_two_bodies_of_one_part_is_measured():
    """The surface through the points may break where they go on."""
    is_joining = np.arange(len(CROSS.edges)) == 5
    joined = score_points(CROSS, CLOUD, is_joining=is_joining)
    assert (joined.extra_components, joined.verdict) == (0, "pass")
    cut = replace(CROSS, edges=CROSS.edges[~is_joining])
    assert score_points(cut, CLOUD).extra_components == 1


def test_a_part_of_the_cloud_without_a_skeleton_is_told():
    """A ring, which has no ends, beside one with a skeleton."""
    ring = torus(1.0, 0.3, 170, 68).vertices
    skeleton = lbskel.skeletonize(ring)
    alone = Skeleton(skeleton.nodes, skeleton.edges, skeleton.radii)
    both = PointCloud(np.concatenate([ring, torus(0.5, 0.15, 40, 20).vertices + [3, 0, 0]]))
    score = score_points(alone, both)
    assert (score.extra_components, score.verdicts["extra_components"]) == (-1, "fail")


def test_a_line_of_a_scan_is_no_part_of_the_cloud():
    """A circle of points beyond the end of an arm, which are nearer to each other than to the arm."""
    angle = np.linspace(0, 2 * np.pi, 150, endpoint=False)
    line = np.stack([np.full(150, 1.05), 0.06 * np.cos(angle), 0.06 * np.sin(angle)], axis=1)
    scan = PointCloud(np.concatenate([CLOUD.points, line]))
    assert score_points(replace(CROSS, node_of_vertex=np.empty(0, dtype=np.int64)), scan).extra_components == 0


def test_noise_makes_no_ends():
    """Its deviation is 0.4 of the radius, so that the nearest points are half as far as the surface."""
    noise = 0.024 * np.random.default_rng(3).normal(size=CLOUD.points.shape)
    score = score_points(CROSS, PointCloud(CLOUD.points + noise))
    assert (score.extremities, score.extremities_missed) == (4, 0)
    assert score_points(_without(np.arange(1, 20)), PointCloud(CLOUD.points + noise)).extremities_missed == 1


def test_outliers_change_nothing():
    rng = np.random.default_rng(1)
    far = PointCloud(np.concatenate([CLOUD.points, rng.uniform(-1, 1, (100, 3))]))
    assert score_points(replace(CROSS, node_of_vertex=np.empty(0, dtype=np.int64)), far).verdict == "pass"


def test_many_outliers_that_are_neighbors_of_each_other_are_no_part():
    rng = np.random.default_rng(1)
    far = PointCloud(np.concatenate([CLOUD.points, rng.uniform([-1, -1, 1], [1, 1, 3], (150, 3))]))  # 2.7 % of all
    score = score_points(replace(CROSS, node_of_vertex=np.empty(0, dtype=np.int64)), far)
    assert (score.verdict, score.extremities) == ("pass", 4)


def test_a_sparse_part_of_the_surface_is_no_outlier():
    """A ring as large with an eighteenth of the points, which are 4.2 times as far apart."""
    dense, sparse = torus(1.0, 0.3, 170, 68).vertices, torus(1.0, 0.3, 40, 16).vertices + [4, 0, 0]
    n, angle = 60, np.linspace(0, 2 * np.pi, 60, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    edges = np.stack([np.arange(n), np.roll(np.arange(n), -1)], axis=1)
    both = Skeleton(np.concatenate([circle, circle + [4, 0, 0]]), np.concatenate([edges, edges + n]), np.ones(2 * n))
    cloud = PointCloud(np.concatenate([dense, sparse]))
    assert score_points(both, cloud).verdict == "pass"


def test_a_loop_has_no_ends():
    cloud = PointCloud(torus(1.0, 0.2).vertices)
    score = lbskel.score(lbskel.skeletonize(cloud), cloud)
    assert (score.verdict, score.extremities) == ("pass", 0)


def test_the_score_of_a_cloud_is_that_of_its_report():
    points = make("limbs", n_vertices=2500).mesh.vertices
    skeleton = lbskel.skeletonize(PointCloud(points))
    assert lbskel.score(skeleton, points).report() == skeleton.report["score"]
    with pytest.raises(MeshError, match="the mesh has"):
        lbskel.score(skeleton, points[:-10])


def test_known_neighbors_change_nothing():
    known = PointTree(CLOUD.points).neighbors(SCORED_NEIGHBORS)[1]
    assert score_points(CROSS, CLOUD, known) == score_points(CROSS, CLOUD)


def test_a_point_alone_beside_few_points_is_no_part():
    angles = np.linspace(0, 2 * np.pi, 13)[:-1]
    rings = [np.stack([np.cos(angles), np.sin(angles), 0 * angles + z], axis=1) for z in np.arange(0, 4, 0.6)]
    cloud = PointCloud(np.concatenate([*rings, [[30, 0, 0]]]))
    axis = Skeleton([[0, 0, 0], [0, 0, 2], [0, 0, 3.6]], [[0, 1], [1, 2]], np.ones(3))
    assert lbskel.score(axis, cloud).extra_components == 0
