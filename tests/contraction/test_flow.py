"""Contraction: what each step may do, how it ends, and that it knows no units."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import PRESETS, ContractionSettings, Mesh, MeshError, UnknownChoice, contract
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.flow import Status
from lbskel.contraction.weights import ATTRACTIONS, WEIGHTS, mean_ring_area
from lbskel.operators import laplacian
from lbskel.shapes import capsule, chain_of_tori, cylinder, torus


def settings(**changes):
    return replace(PRESETS["curvature_flow"], **changes)


def test_a_torus_shrinks_to_its_circle():
    """Of every vertex, since a ring of the three that merging leaves may be three times as wide as one of many."""
    contraction = contract(torus(1.0, 0.2, 64, 24), settings(collapse_length=0.0))
    assert contraction.status is Status.VOLUME
    assert contraction.steps[-1].volume_ratio < PRESETS["curvature_flow"].volume_ratio
    V = contraction.mesh.vertices
    radius = np.hypot(V[:, 0], V[:, 1])
    # the flow draws a closed tube inwards by about r^2 / 2R, a tenth of the tube's radius here; and not out of plane
    assert np.abs(radius - 1.0).max() < 0.2 * 0.2
    assert np.abs(V[:, 2]).max() < 1e-3


@pytest.mark.parametrize("energy", ENERGIES)
@pytest.mark.parametrize("operator", ["intrinsic_delaunay", "robust"])
def test_area_and_box_never_grow(energy, operator):
    for mesh in (torus(1.0, 0.3, 40, 16), capsule(3.0, 0.4, 20)):
        steps = contract(mesh, settings(energy=energy, operator=operator)).steps
        areas, boxes = [1.0, *(s.area_ratio for s in steps)], [1.0, *(s.box_ratio for s in steps)]
        assert len(steps) >= 3
        assert np.all(np.diff(areas) < 0)
        assert np.all(np.diff(boxes) < 1e-9)


def test_the_number_of_steps_does_not_depend_on_the_density():
    # a fixed weight on Au's operator, which has no unit, would need four times the steps on the finer mesh
    coarse, fine = (len(contract(torus(1.0, 0.2, 32 * k, 12 * k)).steps) for k in (1, 4))
    assert abs(coarse - fine) <= 2


@pytest.mark.parametrize("preset", PRESETS)
def test_scale_and_shift_change_nothing(preset):
    mesh = capsule(3.0, 0.4, 20)
    reference = contract(mesh, PRESETS[preset])
    for scale, shift in ((1e-6, 0.0), (1e6, 0.0), (1.0, 1e4)):
        moved = contract(mesh.with_vertices(mesh.vertices * scale + shift), PRESETS[preset])
        assert len(moved.steps) == len(reference.steps)
        back = (moved.mesh.vertices - shift) / scale
        # the shift costs four of sixteen digits, and late systems are conditioned at up to 1e6
        assert np.abs(back - reference.mesh.vertices).max() < 1e-6 * mesh.diagonal


def test_open_meshes_end_by_their_area():
    contraction = contract(cylinder(0.3, 4.0, 24, 41))
    assert contraction.status is Status.AREA
    assert np.isnan(contraction.steps[-1].volume_ratio)
    assert contraction.steps[-1].area_ratio <= PRESETS["curvature_flow"].area_ratio


def test_a_step_that_makes_the_area_grow_is_undone():
    mesh = torus(1.0, 0.3, 40, 16)
    calls = []

    def exploding(now: Mesh):
        calls.append(now)
        result = laplacian(now, operator="robust")
        return replace(result, stiffness=-1e-3 * result.stiffness) if len(calls) > 2 else result

    contraction = contract(
        mesh, settings(operator=exploding, collapse_length=0.0)
    )  # of all vertices, or the box need not grow
    assert contraction.status in (Status.AREA_GREW, Status.BOX_GREW)
    assert len(contraction.steps) == 2
    assert contraction.mesh.area == pytest.approx(contraction.steps[-1].area_ratio * mesh.area)


def test_an_operator_with_nan_ends_the_contraction_and_keeps_the_last_step():
    mesh = torus(1.0, 0.3, 40, 16)
    calls = []

    def failing(now: Mesh):
        calls.append(now)
        result = laplacian(now, operator="robust")
        if len(calls) == 3:
            result.stiffness.data[0] = np.nan
        return result

    contraction = contract(mesh, settings(operator=failing))
    assert contraction.status is Status.NOT_SOLVED
    assert len(contraction.steps) == 2
    assert np.isfinite(contraction.mesh.vertices).all()


def test_clamped_angles_are_counted():
    mesh = torus(1.0, 0.3, 40, 16)
    steps = contract(mesh, replace(PRESETS["least_squares"], max_steps=12)).steps
    assert steps[0].n_clamped_angles == 0
    assert steps[-1].n_clamped_angles > 0


def test_every_step_is_told_with_its_mesh():
    told = []
    contraction = contract(torus(1.0, 0.3, 40, 16), on_step=lambda step, mesh: told.append((step, mesh)))
    assert tuple(step for step, _ in told) == contraction.steps
    assert told[-1][1].area / told[0][1].area == pytest.approx(
        contraction.steps[-1].area_ratio / contraction.steps[0].area_ratio
    )


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"energy": "second_order"}, "curvature_flow"),
        ({"solver": "magic"}, "cholmod"),
        ({"operator": "laplace"}, "intrinsic_delaunay"),
        ({"degenerate_rows": "identities"}, "identity_zero"),
        ({"degenerate_rows": "identity"}, "least_squares"),
        ({"contraction_growth": 0.0}, "growth must be positive"),
    ],
)
def test_wrong_settings_say_what_is_right(changes, words):
    with pytest.raises(UnknownChoice, match=words):
        ContractionSettings(**changes)


def test_a_mesh_without_area_is_refused():
    with pytest.raises(MeshError, match="no area"):
        contract(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]))


def test_without_the_guard_plain_cotangents_break_and_intrinsic_delaunay_does_not():
    mesh = chain_of_tori(2, step=0.15)  # marching cubes: slivers, as in the meshes that the method is known to break on
    plain, cured = (
        contract(
            mesh, settings(operator=operator, energy="least_squares", rollback=False, volume_ratio=1e-15, max_steps=14)
        )
        for operator in ("cotangent", "intrinsic_delaunay")
    )
    assert plain.broke_at is not None
    first = plain.steps[plain.broke_at - 1]
    assert first.fault in (Status.AREA_GREW, Status.BOX_GREW)
    assert all(step.fault is None for step in plain.steps[: plain.broke_at - 1])
    assert max(step.box_ratio for step in plain.steps) > 1.2  # well beyond what the guard lets pass
    assert cured.broke_at is None
    assert max(step.box_ratio for step in cured.steps) <= 1


def test_the_guard_undoes_the_step_that_breaks():
    mesh = chain_of_tori(2, step=0.15)
    chosen = settings(operator="clamped_cotangent", energy="least_squares", volume_ratio=1e-9)
    guarded, free = contract(mesh, chosen), contract(mesh, replace(chosen, rollback=False, max_steps=8))
    assert guarded.broke_at == len(guarded.steps) + 1
    assert guarded.broke_at == free.broke_at
    # the same energies up to there, one solved for displacements and one for positions, conditioned at up to 1e8
    assert guarded.steps[-1].area_ratio == pytest.approx(free.steps[len(guarded.steps) - 1].area_ratio, rel=1e-4)


@pytest.mark.parametrize("energy", ENERGIES)
def test_without_the_guard_early_steps_are_the_same(energy):
    mesh = torus(1.0, 0.3, 40, 16)
    chosen = settings(energy=energy, max_steps=2, collapse_length=0.0)  # vertices are never merged without the guard
    guarded, free = contract(mesh, chosen), contract(mesh, replace(chosen, rollback=False))
    # conditioned at 1e6 at most, a thousand roundings
    assert np.abs(guarded.mesh.vertices - free.mesh.vertices).max() < 1e-9


def test_an_operator_that_is_not_symmetric_is_refused_where_it_must_be_symmetric():
    mesh = capsule(3.0, 0.4, 20)
    with pytest.raises(UnknownChoice, match=r"'mean_value' is not symmetric.*least_squares"):
        contract(mesh, settings(operator="mean_value"))
    assert len(contract(mesh, settings(operator="mean_value", energy="least_squares")).steps) > 0


def test_treated_vertices_are_told_for_each_step_with_how_far_they_went():
    mesh = torus(1.0, 0.3, 40, 16)
    V = np.array(mesh.vertices)
    V[17] = V[16]
    chosen = settings(operator="cotangent", energy="least_squares", degenerate_rows="identity_zero", max_steps=3)
    given, seen = mesh.with_vertices(V), []
    contraction = contract(given, chosen, on_step=lambda step, now: seen.append(now.vertices))
    assert len(contraction.treated_vertices) == len(contraction.steps) == 3
    first, touched = contraction.steps[0], contraction.treated_vertices[0]
    assert first.n_fallback_rows == len(touched) >= first.n_replaced_rows >= 4
    assert {16, 17} <= set(touched.tolist())
    moves = np.linalg.norm(seen[0] - (V - given.centroid) / given.diameter_bound, axis=1)
    assert first.max_displacement == pytest.approx(moves[touched].max())
    for step, touched in zip(contraction.steps[1:], contraction.treated_vertices[1:], strict=True):
        assert step.n_fallback_rows == len(touched) == 0  # the identity rows have drawn the two apart
        assert step.max_displacement == 0


def test_the_largest_pull_and_hold_are_kept_to():
    mesh = torus(1.0, 0.3, 40, 16)
    free = contract(mesh, settings(energy="least_squares", max_steps=6)).steps
    capped = contract(
        mesh, settings(energy="least_squares", max_steps=6, max_contraction_weight=4.0, max_attraction=3.0)
    ).steps
    assert [step.weight for step in capped] == pytest.approx([min(step.weight, 16.0) for step in free])
    assert free[-1].weight > 16
    assert free[-1].attraction[1] > 9 >= max(step.attraction[1] for step in capped)
    curvature_flow = contract(mesh, settings(max_steps=6, max_contraction_weight=1.0)).steps
    # tau is W_L^2 times the mean ring area, on the mesh of extent 1
    assert curvature_flow[-1].weight == pytest.approx(mean_ring_area(mesh) / mesh.diameter_bound**2)


@pytest.mark.parametrize("weights", WEIGHTS)
@pytest.mark.parametrize("energy", ENERGIES)
def test_published_weights_do_not_depend_on_units(weights, energy):
    mesh = capsule(3.0, 0.4, 12)
    chosen = ContractionSettings(energy=energy, max_steps=4, **WEIGHTS[weights])
    one, thousand = (contract(mesh.with_vertices(scale * mesh.vertices), chosen) for scale in (1.0, 1000.0))
    assert [step.weight for step in one.steps] == pytest.approx([step.weight for step in thousand.steps])
    assert one.steps[0].area_ratio == pytest.approx(thousand.steps[0].area_ratio)


def test_published_weights_start_as_printed():
    mesh = capsule(3.0, 0.4, 12)
    average = mesh.area / mesh.diameter_bound**2 / len(mesh.faces)
    side = np.ptp(mesh.vertices, axis=0).max() / mesh.diameter_bound
    printed = {
        "au2008": 1e-3 * np.sqrt(average),
        "au2008_total_area": 1e-3 * np.sqrt(average * len(mesh.faces)),
        "au2008_demo": 1 / (10 * np.sqrt(average)),
        "cao2010": 1 / (10 * np.sqrt(average * (1.6 / side) ** 2)),
    }
    for name, pull in printed.items():
        chosen = ContractionSettings(energy="least_squares", max_steps=2, volume_ratio=1e-12, **WEIGHTS[name])
        steps = contract(mesh, chosen).steps
        growth = 3 if name == "cao2010" else 2
        assert [step.weight for step in steps] == pytest.approx([pull**2, (growth * pull) ** 2])


def test_holds_compare_areas_as_they_say():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -3, 0]], [[0, 1, 2], [0, 3, 1]])
    now = mesh.with_vertices([[0, 0, 0], [1, 0, 0], [0, 0.5, 0], [0, -0.75, 0]])
    # faces of 1/2 and 3/2 shrink to 1/4 and 3/8
    assert ATTRACTIONS["ring_areas"](mesh, now) == pytest.approx([2 / 0.625, 2 / 0.625, 2, 4])
    assert ATTRACTIONS["face_areas"](mesh, now) == pytest.approx([1 / 0.375, 1 / 0.375, 2, 4])
