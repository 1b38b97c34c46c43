"""Assembly: bodies in one skeleton, in the caller's coordinates and units, with a node for every vertex."""

import json
from dataclasses import dataclass, field
from threading import Lock

import numpy as np
import pytest
from helpers import joined, moved

import lbskel
from lbskel import Skeleton
from lbskel.pipeline.assembly import assemble
from lbskel.pipeline.preparation import prepare
from lbskel.shapes import cylinder


def line(body):
    """Two nodes, all vertices mapped by their height, radii 0.1 and mean radii 0.2 in unit coordinates."""
    nodes = np.array([[0.0, 0.0, -0.1], [0.0, 0.0, 0.1]]) + body.mesh.centroid
    upper = (body.mesh.vertices[:, 2] > body.mesh.centroid[2]).astype(int)
    return Skeleton(nodes, [[0, 1]], [0.1, 0.1], upper, mean_radii=[0.2, 0.2], anchors=[1])


def test_the_caller_s_units_come_back(rod):
    """A factor of 8 on the mesh is one of 8 on nodes, radii and mean radii."""
    one, eight = (prepare(rod.with_vertices(scale * rod.vertices)) for scale in (1.0, 8.0))
    small, large = (assemble([line(prepared.bodies[0])], prepared) for prepared in (one, eight))
    assert np.abs(large.nodes - 8 * small.nodes).max() < 1e-13
    assert large.radii == pytest.approx(8 * small.radii, rel=1e-14)
    assert large.mean_radii == pytest.approx(8 * small.mean_radii, rel=1e-14)
    assert small.radii == pytest.approx(0.1 * one.frame.scale)
    assert small.mean_radii == pytest.approx(0.2 * one.frame.scale)


def test_bodies_follow_one_another(rod, ring):
    mesh = joined(rod, moved(ring, 4.0))
    prepared = prepare(mesh, preprocess=None)
    whole = assemble([line(body) for body in prepared.bodies], prepared)
    assert whole.edges.tolist() == [[0, 1], [2, 3]]
    assert whole.anchors.tolist() == [1, 3]
    of_rod, of_ring = np.split(whole.node_of_vertex, [len(rod.vertices)])
    assert sorted([sorted(set(of_rod)), sorted(set(of_ring))]) == [[0, 1], [2, 3]]


def test_vertices_of_no_body_go_to_the_nearest_node(rod):
    crumb = lbskel.Mesh(rod.vertices[rod.vertices[:, 2].argmax()] + np.eye(3) * 0.01, [[0, 1, 2]])
    prepared = prepare(joined(rod, crumb), preprocess=None)
    whole = assemble([line(body) for body in prepared.bodies], prepared)
    assert whole.node_of_vertex[-3:].tolist() == [1, 1, 1]


def test_vertices_in_long_triangles_of_a_simplified_mesh_have_nodes_near_them():
    rod = cylinder(0.5, 20.0, 16, 80)
    skeleton = lbskel.skeletonize(rod, preprocess="simplify:target_faces=150")
    distances = np.linalg.norm(rod.vertices - skeleton.nodes[skeleton.node_of_vertex], axis=1)
    assert distances.max() < 2 * 0.5  # by way of the corners, up to eleven radii


def test_regions_of_a_smoothed_mesh_stay_connected(rod):
    rough = lbskel.Mesh(rod.vertices + 0.03 * np.random.default_rng(0).normal(size=rod.vertices.shape), rod.faces)
    skeleton = lbskel.skeletonize(rough, preprocess="smooth_noise:iterations=20")
    assert skeleton.report["score"]["measures"]["connected_regions"] == 1.0


def test_the_report_is_plain_json(ring):
    report = lbskel.skeletonize(ring).report
    assert json.loads(json.dumps(report, allow_nan=False)).keys() == report.keys()
    [body] = report["components"]
    assert (body["genus"], body["cycle_rank"], body["handles_certified"]) == (1, 1, True)
    assert report["passed"] is (report["score"]["verdict"] != "fail")
    operator = lbskel.operators.operator_named("cotangent")
    assert lbskel.skeletonize(ring, operator=operator).report["settings"]["operator"] == "cotangent"


def test_an_operator_that_cannot_be_copied_is_reported_by_its_name(ring):
    @dataclass(frozen=True)
    class Locked:
        lock: object = field(default_factory=Lock, repr=False)

        def __call__(self, mesh):
            return lbskel.laplacian(mesh, operator="robust")

    report = lbskel.skeletonize(ring, operator=Locked()).report
    assert report["settings"]["operator"].endswith("Locked()")


def test_a_skeleton_for_each_body_is_needed(rod):
    prepared = prepare(rod)
    with pytest.raises(lbskel.MeshError, match="one skeleton for each of 1 bodies, not 0"):
        assemble([], prepared)
