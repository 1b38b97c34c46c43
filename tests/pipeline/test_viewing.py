"""What a page shows of a mesh and its skeleton."""

from dataclasses import replace

import numpy as np
import pytest

import lbskel
from lbskel import Mesh, PointCloud, Skeleton
from lbskel.pipeline import viewing
from lbskel.pipeline.viewing import view_scene
from lbskel.shapes import make, torus


@pytest.fixture(scope="module")
def hand():
    mesh = make("octopus", n_vertices=1500).mesh
    return mesh, lbskel.skeletonize(mesh)


def test_faces_belong_to_the_branch_of_their_nodes(hand):
    mesh, skeleton = hand
    scene = view_scene(mesh, skeleton)
    for number, branch in enumerate(skeleton.branches):
        if skeleton.degrees[branch[-1]] == 1:
            near_tip = skeleton.node_of_vertex[mesh.faces] == branch[-1]
            assert (scene.part_of_face[near_tip.all(axis=1)] == number).all()
    assert set(scene.part_of_face) == set(range(len(skeleton.branches)))


def test_nodes_off_their_center_are_marked(hand):
    mesh, skeleton = hand
    path = next(branch for branch in skeleton.branches if len(branch) > 12)
    node = path[len(path) // 2]
    assert node not in view_scene(mesh, skeleton).off_center
    nodes = skeleton.nodes.copy()
    ahead = nodes[path[len(path) // 2 + 1]] - nodes[node]
    across = np.cross(ahead, [0.3, 0.5, 0.8])
    nodes[node] += 0.5 * skeleton.radii[node] * across / np.linalg.norm(across)
    bent = Skeleton(nodes, skeleton.edges, skeleton.radii, skeleton.node_of_vertex)
    assert node in view_scene(mesh, bent).off_center


def test_a_hole_that_was_closed_is_marked():
    ring = torus(1.0, 0.3, 24, 12)
    middle = ring.vertices[ring.faces].mean(axis=1)
    holed = Mesh(ring.vertices, ring.faces[np.linalg.norm(middle - middle[0], axis=1) > 0.15])
    skeleton = lbskel.skeletonize(holed)
    mended = view_scene(holed, skeleton).mended
    assert len(mended)
    assert np.linalg.norm(mended - middle[0], axis=1).max() < 0.3
    assert len(view_scene(ring, lbskel.skeletonize(ring)).mended) == 0


def test_score_and_report_are_told(hand):
    mesh, skeleton = hand
    score, report = view_scene(mesh, skeleton).tables
    assert score.caption == f"Score: {skeleton.report['score']['verdict']}"
    rows = {row[0]: row for row in score.rows}
    assert rows["coverage"][1] == skeleton.report["score"]["measures"]["coverage"]
    assert ("faces given", len(mesh.faces)) in report.rows
    assert any("steps, until the volume fell" in str(value) for _, value in report.rows)


def test_a_skeleton_without_report_or_map_has_a_scene(hand):
    mesh, skeleton = hand
    scene = view_scene(mesh, Skeleton(skeleton.nodes, skeleton.edges, skeleton.radii))
    assert (scene.contracted, scene.part_of_face, list(scene.tables)) == (None, None, [])
    assert len(scene.columns["length"]) == len(skeleton.branches)


@pytest.mark.parametrize("as_cloud", [False, True])
def test_a_skeleton_in_other_units_is_refused(hand, as_cloud):
    mesh, skeleton = hand
    shape = PointCloud(mesh.vertices + 1.0) if as_cloud else Mesh(mesh.vertices + 1.0, mesh.faces)
    in_other_units = Skeleton(1000 * (skeleton.nodes + 1.0), skeleton.edges, skeleton.radii)
    with pytest.raises(lbskel.MeshError, match="in the same units"):
        view_scene(shape, in_other_units)


def test_a_cloud_has_the_contraction_of_its_surface(rod, tmp_path):
    cloud = PointCloud(rod.vertices)
    skeleton = lbskel.view(cloud, tmp_path / "rod.html")
    scene = view_scene(cloud, skeleton)
    assert scene.contracted is not None
    assert len(scene.positions) == len(skeleton.report["components"][0]["steps"])
    assert scene.part_of_face is None


def test_view_takes_the_options_and_the_skeleton(rod, tmp_path):
    made = lbskel.view(rod, tmp_path / "a.html", n_nodes=7, simplify="none", preprocess=None)
    assert len(made.nodes) == 7
    assert lbskel.view(rod, tmp_path / "b.html", skeleton=made, preprocess=None) is made
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()
    with pytest.raises(lbskel.UnknownChoice, match=r"^min_lop, n_nodes: the skeleton is given"):
        lbskel.view(rod, tmp_path / "c.html", skeleton=made, n_nodes=7, min_lop=3, simplify="none")


@pytest.mark.parametrize("lost", ["settings", "components", "seconds", "score"])
def test_what_an_incomplete_report_lacks_is_not_shown(rod, lost):
    skeleton = lbskel.skeletonize(rod)
    report = {name: value for name, value in skeleton.report.items() if name != lost}
    if lost in ("settings", "score"):
        report[lost] = {}
    scene = view_scene(rod, replace(skeleton, report=report))
    assert (scene.contracted is None) == (lost in ("settings", "components"))
    shown = [table.caption.split(":")[0] for table in scene.tables]
    assert shown == {"settings": ["Score", "Report"], "score": ["Report"]}.get(lost, ["Score"])


def test_a_page_that_cannot_be_written_is_refused_before_the_skeleton_is_made(monkeypatch, rod, tmp_path):
    monkeypatch.setattr(viewing, "skeletonize", None)
    (tmp_path / "a.html").touch()
    for path, message in (("a.html", "exists already"), ("none/a.html", "does not exist"), ("", "is a folder")):
        with pytest.raises(lbskel.FormatError, match=message):
            lbskel.view(rod, tmp_path / path)
