"""Contraction: what each step may do, how it ends, and that it knows no units."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import PRESETS, ContractionSettings, Mesh, MeshError, UnknownChoice, contract
from lbskel.contraction import Status
from lbskel.energies import ENERGIES
from lbskel.operators import laplacian
from lbskel.shapes import capsule, cylinder, torus


def settings(**changes):
    return replace(PRESETS["flow"], **changes)


def test_a_torus_shrinks_to_its_circle():
    contraction = contract(torus(1.0, 0.2, 64, 24))
    assert contraction.status is Status.VOLUME
    assert contraction.steps[-1].volume_ratio < PRESETS["flow"].volume_ratio
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
    assert contraction.steps[-1].area_ratio <= PRESETS["flow"].area_ratio


def test_a_step_that_makes_the_area_grow_is_undone():
    mesh = torus(1.0, 0.3, 40, 16)
    calls = []

    def exploding(now: Mesh):
        calls.append(now)
        result = laplacian(now, operator="robust")
        return replace(result, stiffness=-1e-3 * result.stiffness) if len(calls) > 2 else result

    contraction = contract(mesh, settings(operator=exploding))
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
    steps = contract(mesh, replace(PRESETS["au2008"], max_steps=12)).steps
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
        ({"energy": "second_order"}, "first_order"),
        ({"solver": "magic"}, "cholmod"),
        ({"operator": "laplace"}, "intrinsic_delaunay"),
        ({"degenerate": "identities"}, "identity_zero"),
        ({"degenerate": "identity"}, "least_squares"),
        ({"growth": 0.0}, "growth must be positive"),
    ],
)
def test_wrong_settings_say_what_is_right(changes, words):
    with pytest.raises(UnknownChoice, match=words):
        ContractionSettings(**changes)


def test_a_mesh_without_area_is_refused():
    with pytest.raises(MeshError, match="no area"):
        contract(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]))
