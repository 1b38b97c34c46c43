"""The preset of Cao et al. 2010: points through the loop of meshes, and the options that it has."""

import json

import numpy as np
import pytest

import lbskel
from lbskel import PRESETS, MeshError, PointCloud, Skeleton, Status, UnknownChoice
from lbskel.geometry.point_stars import PointStars
from lbskel.pipeline.point_contraction import _node_at, _with_radii
from lbskel.shapes import make, torus


@pytest.fixture(scope="module")
def cloud():
    return PointCloud(make("limbs", n_vertices=1000).mesh.vertices)


@pytest.fixture(scope="module")
def contraction(cloud):
    return lbskel.contract(cloud, PRESETS["cao2010"])


def test_the_first_weight_is_that_of_the_paper(contraction, cloud):
    stars = contraction.source
    assert isinstance(stars, PointStars)
    pairs = stars.ring_edges
    lengths = np.linalg.norm(cloud.points[pairs[:, 0]] - cloud.points[pairs[:, 1]], axis=1)
    means = np.bincount(pairs[:, 0], lengths) / np.bincount(pairs[:, 0])
    scale = 1.6 / np.ptp(cloud.points, axis=0).max()
    weights = np.sqrt([step.weight for step in contraction.steps])
    assert weights[0] == pytest.approx(1 / (5 * means.mean() * scale))
    assert weights[1:] == pytest.approx(3 * weights[:-1])


def test_each_step_solves_the_equations_of_the_paper(contraction, cloud):
    moved = []
    lbskel.contract(cloud, PRESETS["cao2010"], on_step=lambda step, mesh: moved.append(mesh))
    first, second = (np.array(mesh.vertices) for mesh in moved[:2])
    F, n = contraction.source.faces, len(cloud.points)
    L = np.zeros((n, n))
    for center, a, b in F.tolist():
        for at, other in ((b, a), (a, b)):
            u, v = first[center] - first[at], first[other] - first[at]
            L[center, other] += u @ v / np.linalg.norm(np.cross(u, v))
    L -= np.diag(L.sum(axis=1))
    pairs = contraction.source.ring_edges

    def shortest(P):
        sizes = np.full(n, np.inf)
        np.minimum.at(sizes, pairs[:, 0], np.linalg.norm(P[pairs[:, 0]] - P[pairs[:, 1]], axis=1))
        return sizes

    start = (cloud.points - contraction.source.centroid) / contraction.source.diameter_bound
    W_H = shortest(start) / shortest(first)
    A = contraction.steps[1].weight * L.T @ L + np.diag(W_H**2)
    assert second == pytest.approx(np.linalg.solve(A, W_H[:, None] ** 2 * first), abs=1e-7)


def test_the_contraction_ends_before_the_step_that_no_longer_shrinks_the_rings(contraction):
    assert contraction.status in (Status.RINGS, Status.BOX_GREW)
    assert 2 <= len(contraction.steps) <= 20


def test_the_skeleton_is_the_collapsed_graph(cloud, contraction):
    graph = lbskel.collapse(contraction)
    skeleton = lbskel.skeletonize(cloud, preset="cao2010")
    assert len(skeleton.nodes) == len(graph.nodes)
    assert len(skeleton.edges) == len(graph.edges)
    assert len(skeleton.node_of_vertex) == len(cloud.points)
    assert skeleton.radii.min() > 0
    assert any("could not be checked" in note for note in skeleton.report["notes"])
    assert json.loads(json.dumps(skeleton.report))["components"][0]["status"] == contraction.status.value


def test_duplicates_are_merged_and_mapped():
    points = torus(1.0, 0.2, 48, 12).vertices
    skeleton = lbskel.skeletonize(np.concatenate([points, points[:7]]), preset="cao2010", root=3)
    assert skeleton.cycle_rank == 1
    np.testing.assert_array_equal(skeleton.node_of_vertex[-7:], skeleton.node_of_vertex[:7])
    assert skeleton.node_of_vertex[3] == 0


def test_of_a_mesh_the_vertices_are_contracted():
    mesh = torus(1.0, 0.2, 48, 12)
    skeleton = lbskel.skeletonize(mesh, preset="cao2010", n_nodes=20)
    assert len(skeleton.nodes) == 20
    assert "faces of the mesh were not used" in skeleton.report["notes"][0]


@pytest.mark.parametrize("option", [{"tip_position": "surface"}, {"min_branch_ratio": 2.0}, {"anchors": [3]}])
def test_options_that_take_a_surface_are_refused(option):
    with pytest.raises(UnknownChoice, match="leave it out"):
        lbskel.skeletonize(torus(1.0, 0.2, 24, 8).vertices, preset="cao2010", **option)


def test_loops_that_were_opened_on_purpose_are_not_missed():
    cloud = PointCloud(torus(1.0, 0.3, 40, 20).vertices)
    skeleton = lbskel.skeletonize(cloud, preset="cao2010", min_loop=1000.0)
    assert (skeleton.cycle_rank, skeleton.report["loops_opened"]) == (0, 1)
    assert skeleton.report["score"]["measures"]["tunnels_missed"] == 0
    assert lbskel.score(skeleton, cloud).report() == skeleton.report["score"]


def test_its_operator_is_none_of_meshes():
    mesh = torus(1.0, 0.2, 24, 8)
    with pytest.raises(lbskel.MeshError, match="give a PointCloud"):
        lbskel.operators.apply_operator("local_delaunay", mesh)


def test_a_component_without_points_has_its_inscribed_radii_as_mean_ones():
    apart = Skeleton([[0, 0, 0], [1, 0, 0], [5, 0, 0], [6, 0, 0]], [[0, 1], [2, 3]], np.zeros(4), [0, 1])
    found = _with_radii(apart, PointCloud([[0, 0, 0.5], [1, 0, 0.5]]), np.ones(2, dtype=bool))
    assert found.mean_radii[:2].tolist() == [0.5, 0.5]
    assert found.mean_radii[2:].tolist() == found.radii[2:].tolist()


def test_what_was_left_out_under_a_time_limit_is_said(cloud):
    report = lbskel.skeletonize(cloud, preset="cao2010", time_limit=1e-3).report
    [note] = [note for note in report["notes"] if "these stages were left out" in note]
    assert "contract (" in note
    assert "score (no measures)" in note


def test_the_root_is_at_a_point_or_nearest_to_a_position():
    skeleton = Skeleton(np.eye(3), [[0, 1], [1, 2]], np.ones(3), [0, 2, 1])
    assert [_node_at(np.array([0, 0, 1.0]), skeleton), _node_at(1, skeleton)] == [2, 2]


@pytest.mark.parametrize("root", ["x", [1, 2], [0, 0, np.nan], True, 2.5, [1, [2]]])
def test_a_root_that_is_no_point_is_refused(cloud, root):
    with pytest.raises(MeshError, match="a root must be the index of a point"):
        lbskel.skeletonize(cloud, preset="cao2010", root=root)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"simplify": "bogus"}, "unknown way to simplify 'bogus'"),
        ({"memory_limit": -1}, "memory_limit must be a positive number of megabytes, not -1"),
        ({"anchors": 3}, "anchors must be a list of vertices or points"),
        ({"root": 10**9}, "there is no point 1000000000"),
    ],
)
def test_options_without_meaning_are_refused(cloud, wrong, message):
    with pytest.raises((MeshError, UnknownChoice), match=message):
        lbskel.skeletonize(cloud, preset="cao2010", **wrong)
