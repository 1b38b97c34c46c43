"""The result of a contraction: which steps are faulty, which complete it, and how it prints."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import Contraction, ContractionSettings, Status, Step, contract
from lbskel.contraction.result import completion_status, step_fault
from lbskel.geometry.vertex_map import VertexMap
from lbskel.shapes import cylinder, torus
from lbskel.visualization import Scene
from lbskel.visualization.scene import encode_scene

STEP = Step(
    area_ratio=0.5,
    volume_ratio=0.3,
    box_ratio=0.9,
    weight=1.0,
    attraction=(1.0, 2.0),
    min_angle_deg=12.0,
    n_vertices=640,
    n_clamped_angles=0,
    n_fallback_rows=0,
    n_replaced_rows=0,
    max_displacement=0.0,
    residual=1e-12,
    seconds=0.1,
)
SETTINGS = ContractionSettings(volume_ratio=1e-4, area_ratio=5e-3)


@pytest.mark.parametrize(
    ("area", "box", "fault"),
    [
        (0.4, 0.8, None),
        (0.5, 0.9, None),
        (0.5 * (1 + 1e-12), 0.9, None),  # rounding
        (0.5001, 0.9, Status.AREA_GREW),
        (0.4, 0.9 * 1.009, None),  # held vertices may widen the box a little
        (0.4, 0.9 * 1.02, Status.BOX_GREW),
    ],
)
def test_a_step_is_faulty_if_the_area_or_the_box_has_grown_over_it(area, box, fault):
    assert step_fault(replace(STEP, area_ratio=area, box_ratio=box), STEP) is fault


def test_the_first_step_is_compared_with_the_start():
    assert step_fault(replace(STEP, area_ratio=1.001), None) is Status.AREA_GREW
    assert step_fault(replace(STEP, box_ratio=1.02), None) is Status.BOX_GREW
    assert step_fault(STEP, None) is None


@pytest.mark.parametrize(
    ("volume", "area", "status"),
    [
        (1e-5, 0.01, Status.VOLUME),
        (1e-5, 0.4, None),  # a signed volume may pass through zero early
        (2e-4, 0.01, None),
        (2e-4, 0.001, None),  # the area is the criterion of open meshes only
        (np.nan, 0.004, Status.AREA),
        (np.nan, 0.006, None),
    ],
)
def test_a_contraction_is_complete_at_its_target(volume, area, status):
    step = replace(STEP, volume_ratio=volume, area_ratio=area)
    assert completion_status(step, STEP, SETTINGS) is status


def test_a_contraction_has_stalled_where_a_small_area_no_longer_falls():
    small = replace(STEP, area_ratio=0.05)
    assert completion_status(replace(small, area_ratio=0.05 * 0.9995), small, SETTINGS) is Status.STALLED
    assert completion_status(replace(small, area_ratio=0.05 * 0.99), small, SETTINGS) is None
    assert completion_status(replace(STEP, area_ratio=0.5 * 0.9995), STEP, SETTINGS) is None
    assert completion_status(small, None, SETTINGS) is None


def result_of(steps, status):
    mesh = torus(1.0, 0.3, 8, 6)
    return Contraction(mesh, mesh, VertexMap.identity(48), tuple(steps), status)


def test_the_first_failed_step_is_the_faulty_one_or_the_one_after_the_last():
    faulty = replace(STEP, fault=Status.AREA_GREW)
    assert result_of([STEP, faulty, STEP, faulty], Status.VOLUME).first_failed_step == 2
    assert result_of([STEP, STEP], Status.AREA_GREW).first_failed_step == 3
    assert result_of([STEP, STEP], Status.NOT_SOLVED).first_failed_step == 3
    for status in (Status.VOLUME, Status.AREA, Status.STALLED, Status.STEPS, Status.TIME_LIMIT):
        assert result_of([STEP, STEP], status).first_failed_step is None


def test_the_mesh_has_the_faces_of_the_source_on_the_contracted_positions():
    source = torus(1.0, 0.3, 40, 16)
    contraction = contract(source)
    assert len(contraction.coarse.vertices) < len(source.vertices)
    assert np.array_equal(contraction.mesh.faces, source.faces)
    expected = contraction.coarse.vertices[contraction.vertex_map.indices]
    assert np.array_equal(contraction.mesh.vertices, expected)


def test_print_shows_a_line_for_each_step_and_how_it_ended():
    contraction = contract(torus(1.0, 0.3, 40, 16))
    header, *lines, last = str(contraction).splitlines()
    assert header.split()[:2] == ["step", "vertices"]
    assert len(lines) == len(contraction.steps)
    final = contraction.steps[-1]
    assert lines[-1].split()[:4] == [
        str(len(lines)),
        str(final.n_vertices),
        f"{final.area_ratio:.4f}",
        f"{final.volume_ratio:.1e}",
    ]
    for text in (last, repr(contraction)):
        assert f"{len(lines)} steps" in text
        assert contraction.status.value in text
        assert f"area {final.area_ratio:.4f}, volume {final.volume_ratio:.1e}" in text
    assert repr(contraction).startswith("Contraction(")


def test_print_leaves_out_the_volume_of_an_open_mesh_and_names_faults():
    opened = contract(cylinder(0.3, 4.0, 24, 41))
    assert "volume" not in repr(opened)
    assert "nan" not in str(opened)
    faulty = result_of([STEP, replace(STEP, fault=Status.AREA_GREW)], Status.STEPS)
    assert str(faulty).splitlines()[2].endswith("the area began to grow")


def test_print_works_before_the_first_step():
    assert repr(result_of([], Status.TIME_LIMIT)) == f"Contraction(0 steps: {Status.TIME_LIMIT.value})"
    assert str(result_of([], Status.TIME_LIMIT)).splitlines()[-1] == f"0 steps: {Status.TIME_LIMIT.value}"


def test_the_page_numbers_the_start_and_the_last_step(monkeypatch, ring):
    monkeypatch.setattr(Contraction, "_plot", lambda self, **scene: encode_scene(Scene(**scene))[0])
    contraction = contract(ring)
    n = len(contraction.steps)
    assert n > 1
    shown = contraction.plot()["steps"]
    assert [label.split(":")[0] for label in shown["labels"]] == [f"step 0 of {n}", f"step {n} of {n}"]
    assert shown["areas"] == [1.0, *(step.area_ratio for step in contraction.steps)]
    assert (shown["numbers"], len(shown["curve_x"])) == ([0, n], n + 1)
    assert "steps" not in replace(contraction, steps=()).plot()
