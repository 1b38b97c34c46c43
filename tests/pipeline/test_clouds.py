"""Skeletons of point clouds by the call that makes those of meshes."""

import numpy as np
import pytest

import lbskel
from lbskel import MeshError, PointCloud, UnknownChoice
from lbskel.shapes import make, torus


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
    distances = np.linalg.norm(cloud.points - skeleton.nodes[skeleton.node_of_vertex], axis=1)
    node = int(np.argmax(np.bincount(skeleton.node_of_vertex)))
    assert skeleton.mean_radii[node] == pytest.approx(distances[skeleton.node_of_vertex == node].mean())


def test_anchors_and_roots_are_points_of_the_cloud(cloud):
    skeleton = lbskel.skeletonize(cloud, anchors=[17], root=17)
    (anchor,) = skeleton.anchors
    assert np.linalg.norm(skeleton.nodes[anchor] - cloud.points[17]) < 0.1  # within the spacing of the points
    assert skeleton.node_of_vertex[17] in (anchor, 0)
    with pytest.raises(MeshError, match="there is no point 9999"):
        lbskel.skeletonize(cloud, root=9999)


def test_the_report_says_what_was_given_and_what_could_not_be_checked(skeleton, cloud):
    report = skeleton.report
    assert report["input"] == {"vertices": len(cloud.points), "faces": 0, "components": 1}
    assert any("could not be checked" in note for note in report["notes"])
    assert report["reconstruction"]["kept"] == len(cloud.points)
    assert "reconstruct" in report["seconds"]
    assert "score" not in report["seconds"]  # of the surface, which is none that was given


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
