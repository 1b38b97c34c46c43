"""Comparisons of settings on one mesh: what is measured, what is written, what is refused."""

import json

import pytest
from helpers import joined, moved

from lbskel import PRESETS, Mesh, MeshError, laplacian
from lbskel.contraction.flow import Status
from lbskel.pipeline.comparison import CASES, AreaNormalized, record, representative, run_case
from lbskel.shapes import chain_of_tori, flat_grid, torus


def test_cases_have_every_strategy_by_both_energies_where_rows_are_not_needed():
    assert set(PRESETS) <= set(CASES)
    strategies = {case.split(";")[0] for case in CASES if ";" in case}
    assert {"none", "clamped cotangents", "mollified", "intrinsic Delaunay", "robust"} <= strategies
    for case, settings in CASES.items():
        if ";" in case:
            assert case.endswith(settings.energy.replace("_", " "))
    assert "identity row, held; curvature flow" not in CASES


def test_an_outcome_has_the_guarded_skeleton_and_the_free_steps():
    mesh = chain_of_tori(2, step=0.2)
    settings = CASES["clamped cotangents; least squares"]
    result = run_case(mesh, settings)
    assert result.free.first_failed_step is not None
    assert len(result.meshes) == len(result.free.steps) >= result.free.first_failed_step
    row = record(result, reference=run_case(mesh, CASES["curvature_flow"]).skeleton)
    assert row["steps"] == row["broke at"] - 1  # what the guard leaves
    assert row["how"] in ("area grew", "box grew")
    assert row["status"] in (Status.AREA_GREW.value, Status.BOX_GREW.value)
    assert row["contracted"] is False
    assert row["largest box"] == max(row["boxes"]) > 1
    assert row["from default"] > 0
    json.dumps(row, allow_nan=False)


def test_the_default_is_no_distance_from_itself_and_breaks_nowhere(ring):
    result = run_case(ring, CASES["curvature_flow"])
    row = record(result, reference=result.skeleton)
    assert row["from default"] < 1e-12
    assert row["broke at"] is None
    assert row["topology right"]


def test_a_case_that_is_not_defined_says_why_and_shows_its_steps_all_the_same(rod):
    row = record(run_case(rod, CASES["mean value; curvature flow"]))
    assert "not symmetric" in row["error"]
    scaled = record(run_case(rod, CASES["mean value, to scale; curvature flow"]))
    assert "the operator area-normalized mean_value is not symmetric" in scaled["error"]
    assert "tips" not in row
    assert row["free steps"] > 0  # general elimination needs no symmetry


def test_open_meshes_are_compared_too(rod):
    opened = Mesh(rod.vertices, rod.faces[10:])
    row = record(run_case(opened, CASES["curvature_flow"]))
    assert row["volumes"][0] is None
    json.dumps(row, allow_nan=False)


def test_in_a_sheet_no_distance_is_told_in_radii_of_zero():
    result = run_case(flat_grid(8, 6), CASES["curvature_flow"])
    row = record(result, reference=result.skeleton)
    assert row["contracted"]
    assert "from default" not in row
    json.dumps(row, allow_nan=False)


def test_the_largest_component_is_compared_and_large_ones_are_simplified(ring, rod):
    both = joined(moved(ring, 10.0), rod)
    assert representative(both).area == pytest.approx(max(ring.area, rod.area))
    assert len(representative(torus(1.0, 0.3, 60, 30), most_faces=500).faces) <= 500


def test_a_mesh_without_area_is_refused():
    with pytest.raises(MeshError, match="no area"):
        representative(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]))


def test_in_area_scale_density_does_not_matter():
    factors = []
    for k in (1, 2):
        mesh = torus(1.0, 0.3, 24 * k, 10 * k)
        scaled = AreaNormalized("mean_value_symmetric")(mesh).stiffness
        raw = laplacian(mesh, operator="mean_value_symmetric").stiffness
        factors.append((raw.diagonal().mean(), scaled.diagonal().mean()))
    (raw, scaled), (finer_raw, finer_scaled) = factors
    assert finer_raw > 1.8 * raw
    assert finer_scaled == pytest.approx(scaled, rel=0.05)  # as the shapes of the triangles go
    cotangent = laplacian(mesh).stiffness
    assert abs(AreaNormalized("cotangent")(mesh).stiffness - cotangent).max() < 1e-12  # its mass is the area
