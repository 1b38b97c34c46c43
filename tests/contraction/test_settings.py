"""Settings: wrong values are refused with the right ones, and every preset and strategy contracts."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import DEGENERACY_STRATEGIES, PRESETS, WEIGHTS, ContractionSettings, Status, UnknownChoice, contract
from lbskel.contraction.energies import ENERGIES
from lbskel.operators import OPERATORS
from lbskel.shapes import capsule, torus


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"energy": "second_order"}, "curvature_flow"),
        ({"solver": "magic"}, "cholmod"),
        ({"operator": "laplace"}, "intrinsic_delaunay"),
        ({"initial_weight_rule": "magic"}, "diffusion_length"),
        ({"attraction": "magic"}, "ring_areas"),
        ({"degenerate_rows": "identities"}, "identity_zero"),
        ({"degenerate_rows": "identity"}, "least_squares"),
        ({"contraction_growth": 0.0}, "growth must be positive"),
        ({"volume_ratio": float("nan")}, "volume_ratio must be positive"),
        ({"max_steps": 0}, "max_steps must be positive"),
    ],
)
def test_wrong_settings_say_what_is_right(changes, words):
    with pytest.raises(UnknownChoice, match=words):
        ContractionSettings(**changes)


def test_strategies_name_operators_that_exist():
    assert {changes["operator"] for changes in DEGENERACY_STRATEGIES.values()} <= set(OPERATORS)


@pytest.mark.parametrize("strategy", DEGENERACY_STRATEGIES)
def test_every_strategy_contracts(strategy):
    chosen = ContractionSettings(energy="least_squares", max_steps=3, **DEGENERACY_STRATEGIES[strategy])
    contraction = contract(torus(1.0, 0.3, 40, 16), chosen)
    assert contraction.steps[-1].area_ratio < 0.9


OF_MESHES = [name for name in PRESETS if name != "cao2010"]  # that of points: tests/pipeline/test_point_contraction.py


@pytest.mark.parametrize("preset", OF_MESHES)
def test_every_preset_contracts(preset):
    contraction = contract(torus(1.0, 0.3, 40, 16), PRESETS[preset])
    assert contraction.status in (Status.VOLUME, Status.STALLED)
    assert contraction.steps[-1].volume_ratio < 1e-3


@pytest.mark.parametrize("preset", OF_MESHES)
def test_scale_and_shift_change_nothing(preset):
    mesh = capsule(3.0, 0.4, 20)
    reference = contract(mesh, PRESETS[preset])
    for scale, shift in ((1e-6, 0.0), (1e6, 0.0), (1.0, 1e4)):
        moved = contract(mesh.with_vertices(mesh.vertices * scale + shift), PRESETS[preset])
        assert len(moved.steps) == len(reference.steps)
        back = (moved.mesh.vertices - shift) / scale
        # the shift costs four of sixteen digits, and late systems have condition numbers of up to 1e6
        assert np.abs(back - reference.mesh.vertices).max() < 1e-6 * mesh.diagonal


def test_au2008_is_as_printed():
    """Cotangents without a clamp, no row treatment, W_L^0 = 1e-3 sqrt(mean face area), growth 2, volume ratio 1e-6."""
    chosen = PRESETS["au2008"]
    assert (chosen.operator, chosen.energy, chosen.degenerate_rows) == ("cotangent", "least_squares", "none")
    assert (chosen.attraction, chosen.contraction_growth, chosen.volume_ratio) == ("ring_areas", 2.0, 1e-6)
    assert chosen.max_contraction_weight is chosen.max_attraction is None
    mesh = torus(1.0, 0.3, 40, 16)
    steps = contract(mesh, chosen).steps
    mean_area = mesh.area / len(mesh.faces) / mesh.diameter_bound**2
    assert [step.weight for step in steps] == pytest.approx([(1e-3 * 2**k) ** 2 * mean_area for k in range(len(steps))])
    assert steps[-1].volume_ratio <= 1e-6


def test_presets_take_the_weights_of_their_name():
    for name in set(PRESETS) & set(WEIGHTS):
        assert replace(PRESETS[name], **WEIGHTS[name]) == PRESETS[name]


@pytest.mark.parametrize(
    "wrong",
    [
        {"max_steps": "3"},
        {"max_steps": 2.5},
        {"collapse_length": float("nan")},
        {"collapse_length": -1.0},
        {"initial_weight": float("inf")},
        {"contraction_growth": 1e101},
        {"degenerate_angle": None},
    ],
)
def test_numbers_that_are_none_of_their_kind_are_refused(wrong):
    with pytest.raises(UnknownChoice, match=f"{next(iter(wrong))} must be"):
        ContractionSettings(**wrong)


@pytest.mark.parametrize("name", ["max_contraction_weight", "max_attraction"])
def test_no_bound_is_none(name):
    with pytest.raises(UnknownChoice, match=f"{name} must be positive and at most 1e\\+100, not inf; None is no bound"):
        ContractionSettings(**{name: np.inf})
    assert getattr(ContractionSettings(**{name: None}), name) is None


@pytest.mark.parametrize(
    "changed", ["initial_weight", "contraction_growth", "max_attraction", "max_contraction_weight"]
)
@pytest.mark.parametrize("energy", ENERGIES)
def test_the_largest_numbers_do_not_overflow(ring, changed, energy):
    settings = ContractionSettings(energy=energy, max_steps=3, **{changed: 1e100})
    assert np.isfinite(contract(ring, settings).mesh.vertices).all()
