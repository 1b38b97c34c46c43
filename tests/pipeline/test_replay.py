"""The contraction of a skeleton run again: as many steps as the report has, and none without a report."""

import numpy as np
import pytest
from helpers import joined, moved

import lbskel
from lbskel.pipeline import replay as replaying
from lbskel.pipeline.preparation import prepare
from lbskel.pipeline.replay import replay, what_is_told
from lbskel.pipeline.viewing import view_scene
from lbskel.shapes import make, torus


def test_the_contraction_is_replayed_with_the_steps_that_were_reported():
    mesh = make("octopus", n_vertices=1500).mesh
    skeleton = lbskel.skeletonize(mesh)
    scene = view_scene(mesh, skeleton)
    (body,) = skeleton.report["components"]
    np.testing.assert_allclose(scene.area_ratios, [step["area_ratio"] for step in body["steps"]], rtol=1e-12)
    np.testing.assert_allclose(scene.volume_ratios, [step["volume_ratio"] for step in body["steps"]], rtol=1e-12)
    assert len(scene.positions) == len(body["steps"])
    areas = [scene.contracted.with_vertices(state).area / scene.contracted.area for state in scene.positions]
    np.testing.assert_allclose(areas, scene.area_ratios, rtol=1e-6)
    assert len(scene.contracted.vertices) == len(mesh.vertices)
    assert scene.contracted.area == pytest.approx(mesh.area)  # in the caller's coordinates
    np.testing.assert_allclose(scene.contracted.centroid, mesh.centroid, atol=1e-9)


def test_the_surface_that_is_contracted_is_oriented_as_the_given_one_and_as_its_mirror_image():
    mesh = make("tripod", n_vertices=800).mesh
    for given in (mesh, lbskel.Mesh(mesh.vertices * [1, -1, 1], mesh.faces[:, ::-1])):
        contracted = view_scene(given, lbskel.skeletonize(given)).contracted
        assert contracted.volume == pytest.approx(mesh.volume)


def test_several_bodies_are_replayed_as_one():
    ring = torus(1.0, 0.3, 24, 12)
    both = joined(ring, moved(ring, 4.0))
    skeleton = lbskel.skeletonize(both)
    scene = view_scene(both, skeleton)
    steps = [[step["area_ratio"] for step in body["steps"]] for body in skeleton.report["components"]]
    assert len(scene.positions) == max(map(len, steps))
    last = np.mean([own[-1] for own in steps])  # equal areas at the start
    assert scene.area_ratios[-1] == pytest.approx(last, rel=1e-9)
    measured = scene.contracted.with_vertices(scene.positions[-1]).area / scene.contracted.area
    assert measured == pytest.approx(last, rel=1e-6)


def test_an_operator_of_the_callers_is_not_replayed(rod):
    def own(mesh):
        return lbskel.laplacian(mesh, operator="robust")

    skeleton = lbskel.skeletonize(rod, operator=own)
    assert view_scene(rod, skeleton).contracted is None


@pytest.mark.parametrize("n_told", [0, 2])
def test_no_more_steps_are_made_than_were_told(monkeypatch, rod, n_told):
    made = []

    def counting(mesh, settings, *, on_step):
        made.append(contract(mesh, settings, on_step=on_step))

    contract = replaying.contract
    monkeypatch.setattr(replaying, "contract", counting)
    report = lbskel.skeletonize(rod).report
    (body,) = report["components"]
    report = {**report, "components": [{**body, "steps": body["steps"][:n_told]}]}
    _, positions, areas, _ = replay(prepare(rod), report)
    assert (len(positions), len(areas)) == (n_told, n_told)
    assert [len(each.steps) for each in made] == ([n_told] if n_told else [])


def test_what_is_not_told_is_none():
    assert what_is_told(lambda report: report["a"]["b"], {"a": {"b": 3}}) == 3
    assert what_is_told(lambda report: report["a"]["b"], {"a": 3}) is None
    assert what_is_told(lambda report: f"{report['a']:,}", {"a": "many"}) is None


@pytest.mark.parametrize("wrong", [{}, {"operator": None, "nosuch": 1}, {"operator": None, "energy": "nosuch"}, [3]])
def test_settings_that_are_none_are_not_replayed(rod, wrong):
    report = lbskel.skeletonize(rod).report
    assert replay(prepare(rod), {**report, "settings": wrong})[0] is None
