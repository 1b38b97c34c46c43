"""Skeletons of point clouds by the call that makes those of meshes."""

import re
import time
from dataclasses import replace

import numpy as np
import pytest

import lbskel
from lbskel import MeshError, PointCloud, Skeleton, UnknownChoice
from lbskel.pipeline import profiling, stages
from lbskel.pipeline.clouds import _with_joined_pieces
from lbskel.preprocess.point_cleaning import clean_points
from lbskel.shapes import capsule, make, torus


@pytest.fixture(scope="module")
def limbs():
    return make("limbs", n_vertices=3000)


@pytest.fixture(scope="module")
def cloud(limbs):
    return PointCloud(limbs.mesh.vertices)


@pytest.fixture(scope="module")
def skeleton(cloud):
    return lbskel.skeletonize(cloud)


def test_the_skeleton_of_a_cloud_is_near_the_true_one(skeleton, limbs):
    distances = lbskel.ground_truth_distances(skeleton, limbs.truth)
    assert distances.is_topology_right
    assert distances.n_tips == distances.n_true_tips == 6
    assert distances.accuracy < 0.08  # the bar of the benchmark of points
    assert distances.coverage < 0.11


def test_every_point_has_a_node_and_every_node_radii(skeleton, cloud):
    assert len(skeleton.node_of_vertex) == len(cloud.points)
    assert skeleton.radii.min() > 0
    inner = np.flatnonzero(skeleton.degrees == 2)
    node = inner[np.argmax(np.bincount(skeleton.node_of_vertex, minlength=len(skeleton.nodes))[inner])]
    chord = np.subtract(*skeleton.nodes[skeleton.neighbors[node]])
    offsets = cloud.points[skeleton.node_of_vertex == node] - skeleton.nodes[node]
    from_axis = np.linalg.norm(np.cross(offsets, chord), axis=1) / np.linalg.norm(chord)
    assert skeleton.mean_radii[node] == pytest.approx(from_axis.mean())


def test_anchors_and_roots_are_points_of_the_cloud(cloud):
    skeleton = lbskel.skeletonize(cloud, anchors=[17], root=17)
    (anchor,) = skeleton.anchors
    assert np.linalg.norm(skeleton.nodes[anchor] - cloud.points[17]) < 0.1  # within the spacing of the points
    assert skeleton.node_of_vertex[17] in (anchor, 0)
    with pytest.raises(MeshError, match="there is no point 9999"):
        lbskel.skeletonize(cloud, root=9999)
    with pytest.raises(MeshError, match="anchors must be a list of vertices or points"):
        lbskel.skeletonize(cloud, anchors=5)


def test_an_anchor_may_be_the_place_of_a_point_beside_the_surface(cloud):
    numbers = [0, 500, 1000, 1500, 2000]
    by_number, by_place = (lbskel.skeletonize(cloud, anchors=a) for a in (numbers, cloud.points[numbers]))
    assert len(by_place.anchors) == 5
    assert np.array_equal(by_place.nodes[by_place.anchors], by_number.nodes[by_number.anchors])
    with pytest.raises(MeshError, match="anchor 0 lies outside"):
        lbskel.skeletonize(cloud, anchors=[[9.0, 9.0, 9.0]])


def test_the_edges_that_join_all_parts_are_not_measured(cloud):
    both = PointCloud(np.concatenate([cloud.points, cloud.points + [4, 0, 0]]))
    skeleton = lbskel.skeletonize(both, join="all")
    assert (skeleton.n_components, len(skeleton.report["joining_edges"])) == (1, 1)
    assert skeleton.report["score"]["measures"]["inside_fraction"] == 1
    assert lbskel.score(skeleton, both).report() == skeleton.report["score"]
    assert lbskel.score(replace(skeleton, report={}), both).verdicts["inside_fraction"] != "pass"


def test_the_report_says_what_was_given_and_what_could_not_be_checked(skeleton, cloud):
    report = skeleton.report
    assert report["input"] == {"vertices": len(cloud.points), "faces": 0, "components": 1}
    assert any("could not be checked" in note for note in report["notes"])
    assert report["reconstruction"]["kept"] == len(cloud.points)
    assert "reconstruct" in report["seconds"]
    assert "score" not in report["seconds"]  # of the surface, which is none that was given


def test_the_length_below_which_limbs_grow_together_is_told():
    """In the units of the cloud: 10,000 points on an area of 8,000."""
    rng = np.random.default_rng(0)
    points = np.column_stack([200 * rng.random(10_000), np.zeros((10_000, 2))])
    angle, radius = rng.uniform(0, 2 * np.pi, 10_000), 20 / np.pi
    points[:, 1:] = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    report = lbskel.skeletonize(PointCloud(points)).report
    assert report["reconstruction"]["spacing"] == pytest.approx(np.sqrt(0.8), rel=0.05)
    (told,) = re.findall("nearer to each other than about ([0-9.]+), twice", " ".join(report["notes"]))
    assert float(told) == pytest.approx(2 * np.sqrt(0.8), rel=0.1)


def test_a_ball_in_a_tube_around_few_points_is_no_larger_than_the_limb():
    """By the distances to the surface of the tube, the radii were 2.4 of the true one."""
    corners = capsule(4.0, 0.5)
    points = corners.vertices[np.random.default_rng(0).permutation(len(corners.vertices))[:50]]
    skeleton = lbskel.skeletonize(PointCloud(points))
    assert skeleton.report["reconstruction"]["points_in_tubes"] > 30
    assert np.median(skeleton.radii) < 0.55


def test_a_loop_is_kept():
    assert lbskel.skeletonize(torus(1.0, 0.3).vertices).cycle_rank == 1


def test_outliers_have_nodes_but_are_no_anchors():
    points = np.concatenate([torus(1.0, 0.3).vertices, [[0, 0, 4.0]]])
    skeleton = lbskel.skeletonize(points)
    assert skeleton.cycle_rank == 1
    assert len(skeleton.node_of_vertex) == len(points)
    with pytest.raises(MeshError, match="is an outlier"):
        lbskel.skeletonize(points, anchors=[len(points) - 1])


def test_preparations_of_clouds_are_named(cloud):
    with pytest.raises(UnknownChoice, match="auto, scan, none"):
        lbskel.skeletonize(cloud, preprocess="cad")


def two_pieces(offset, gap):
    """Two straight skeletons of five nodes each, thickest at the last end, and a tube of points around both."""
    first = np.stack([np.zeros(5), np.zeros(5), np.arange(5.0)], axis=1)
    nodes = np.concatenate([first, first + offset])
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 4]])
    turns, heights = np.meshgrid(np.arange(0, 2 * np.pi, 0.5), np.arange(0, 4.1, 0.25))
    ring = np.stack([0.5 * np.cos(turns), 0.5 * np.sin(turns), heights], axis=-1).reshape(-1, 3)
    between = ring[:, :2].repeat(2, axis=0), np.linspace(4.0, 4.0 + gap, 2 * len(ring))
    bridge = np.column_stack(between) if gap else np.empty((0, 3))
    points = np.concatenate([ring, ring + offset, bridge])
    node = np.linalg.norm(points[:, None] - nodes, axis=2).argmin(axis=1)
    report = {"pieces_joined": 0}
    skeleton = Skeleton(nodes, np.concatenate([edges, edges + 5]), np.append(np.full(9, 0.5), 0.6), node, report=report)
    return skeleton, clean_points(points)


def test_pieces_of_a_limb_whose_points_go_on_are_joined():
    joined = _with_joined_pieces(*two_pieces([0, 0, 6.0], 2.0))
    assert (joined.n_components, joined.report["pieces_joined"]) == (1, 1)
    assert joined.length == pytest.approx(4 + 4 + 2)


def test_pieces_with_a_gap_between_their_points_stay_apart():
    skeleton, points = two_pieces([0, 0, 6.0], 0.0)
    assert _with_joined_pieces(skeleton, points).n_components == 2


def test_limbs_side_by_side_stay_apart_though_their_points_are_neighbors():
    skeleton, points = two_pieces([1.2, 0, 0], 0.0)
    assert _with_joined_pieces(skeleton, points).n_components == 2


def test_the_root_that_was_asked_for_stays(cloud, skeleton):
    tip = skeleton.nodes[skeleton.tips[skeleton.tips > 0][0]]
    point = int(np.linalg.norm(cloud.points - tip, axis=1).argmin())
    assert lbskel.skeletonize(cloud, root=point).nodes[0] == pytest.approx(tip, abs=0.1)  # the spacing of the points


def test_pieces_are_joined_only_where_it_is_asked_for(cloud, monkeypatch):
    asked = []
    monkeypatch.setattr("lbskel.pipeline.clouds._with_joined_pieces", lambda given, *_, **__: asked.append(1) or given)
    lbskel.skeletonize(cloud, join="none")
    assert not asked
    lbskel.skeletonize(cloud)
    assert asked


def test_reading_counts_and_what_was_left_out_is_said(cloud, monkeypatch):
    def read_slowly(shape):
        time.sleep(0.2)
        return shape

    monkeypatch.setattr(stages, "as_shape", read_slowly)
    monkeypatch.setattr(profiling, "GRACE_SECONDS", 0.0)
    report = lbskel.skeletonize(cloud, time_limit=1e-3).report
    assert report["seconds"]["read"] >= 0.2
    assert report["score"]["verdict"] == "not measured"
    assert any("these stages were left out: score points (no measures)" in note for note in report["notes"])


@pytest.mark.parametrize("options", [{}, {"preset": "cao2010", "preprocess": "scan"}])
def test_outliers_do_not_count_in_mean_radii(options):
    points = capsule(6.0, 0.5, 24).vertices
    far = np.concatenate([points, [[50.0, 0.0, 0.0]]])
    skeleton = lbskel.skeletonize(PointCloud(far), radius_kind="mean", **options)
    assert any("1 outlier was left out" in note for note in skeleton.report["notes"])
    assert skeleton.radii.max() < 0.6
