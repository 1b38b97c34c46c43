"""Degenerate triangles: what each treatment does to rows, and what follows for the vertices."""

import numpy as np
import pytest

from lbskel import ContractionSettings, contract, laplacian
from lbskel.contraction.degenerate_rows import MAX_ROW_SUM, ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES, ContractionStepInput, rectangular
from lbskel.contraction.flow import Status
from lbskel.contraction.settings import DEGENERACY_STRATEGIES, PRESETS
from lbskel.operators import OPERATORS
from lbskel.shapes import torus


def away_from_the_origin():
    mesh = torus(1.0, 0.3, 20, 10)
    return mesh.with_vertices(mesh.vertices + [5.0, 0.0, 0.0])


def pull_of(mesh, treatment, rows, weight):
    ones = np.ones(len(mesh.vertices))
    return ContractionStepInput(
        laplacian(mesh), mesh.vertices, weight, ones, ones, lambda L: ROW_TREATMENTS[treatment](L, rows)
    )


def test_identity_rows_hold_and_literal_ones_pull_to_the_origin():
    mesh = away_from_the_origin()
    rows = np.arange(0, 200, 7)
    moves = {}
    for treatment in ("identity", "identity_zero"):
        system = ENERGIES["least_squares"](pull_of(mesh, treatment, rows, 1e9))
        assert system.replaced.tolist() == rows.tolist()
        moves[treatment] = np.linalg.solve(system.A.toarray(), system.B)[rows]
    # with so great a weight the identity rows are met nearly exactly: v' = v, or v' = 0; the rest pulls by a little
    assert np.linalg.norm(mesh.vertices[rows] + moves["identity_zero"], axis=1).max() < 0.05 * 5
    assert np.abs(moves["identity"]).max() < 0.05 * 5


def test_sums_of_rows_are_capped_and_others_left():
    mesh = away_from_the_origin()
    V = np.array(mesh.vertices)
    V[17] = V[16] + 1e-6 * (V[17] - V[16])  # cotangents of about a million
    L = (2 * laplacian(mesh.with_vertices(V)).stiffness).tocsr()
    treatment = ROW_TREATMENTS["row_sums"](L, np.empty(0, dtype=int))
    capped = treatment.matrix(L)
    assert 0 < len(treatment.rows) < 20
    assert capped.diagonal()[treatment.rows] == pytest.approx(MAX_ROW_SUM)
    others = np.setdiff1d(np.arange(200), treatment.rows)
    assert abs(capped[others] - L[others]).max() == 0
    # a row scaled down has the direction that it had: of a million, a hundredth
    assert (capped @ V)[treatment.rows] == pytest.approx(
        treatment.factors[treatment.rows, None] * (L @ V)[treatment.rows]
    )


@pytest.mark.parametrize("treatment", ROW_TREATMENTS)
def test_the_rectangular_system_has_the_same_solution(treatment):
    pull = pull_of(away_from_the_origin(), treatment, np.arange(0, 200, 7), 3.0)
    K, b = rectangular(pull)
    system = ENERGIES["least_squares"](pull)
    # conditioned at about 1e3, so that the normal equations keep nine digits
    assert np.linalg.lstsq(K.toarray(), b)[0] == pytest.approx(np.linalg.solve(system.A.toarray(), system.B), abs=1e-9)


@pytest.mark.parametrize("energy", ENERGIES)
@pytest.mark.parametrize("treatment", ["none", "identity", "identity_zero"])
def test_positions_and_displacements_are_one_solution(energy, treatment):
    mesh = away_from_the_origin()
    system = ENERGIES[energy](pull_of(mesh, treatment, np.arange(0, 200, 7), 3.0))
    # within rounding of positions of size 6
    assert system.positions - system.A @ mesh.vertices == pytest.approx(system.B, abs=1e-10)


def test_degenerate_triangles_get_identity_rows_and_are_counted():
    mesh = torus(1.0, 0.3, 40, 16)
    V = np.array(mesh.vertices)
    V[17] = V[16]  # an edge of no length, and two faces of no area
    counts = {}
    for treatment in ROW_TREATMENTS:
        chosen = ContractionSettings(
            operator="clamped_cotangent", energy="least_squares", degenerate_rows=treatment, max_steps=1
        )
        counts[treatment] = contract(mesh.with_vertices(V), chosen).steps[0].n_replaced_rows
    assert counts["none"] == counts["row_sums"] == 0  # cotangents clamped at 57 sum to no more than a few hundred
    assert counts["identity"] == counts["identity_zero"] >= 4


@pytest.mark.parametrize("strategy", DEGENERACY_STRATEGIES)
def test_every_strategy_contracts(strategy):
    chosen = ContractionSettings(energy="least_squares", max_steps=3, **DEGENERACY_STRATEGIES[strategy])
    contraction = contract(torus(1.0, 0.3, 40, 16), chosen)
    assert contraction.steps[-1].area_ratio < 0.9


def test_strategies_name_operators_that_exist():
    assert {changes["operator"] for changes in DEGENERACY_STRATEGIES.values()} <= set(OPERATORS)


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_contracts(preset):
    contraction = contract(torus(1.0, 0.3, 40, 16), PRESETS[preset])
    assert contraction.status in (Status.VOLUME, Status.STALLED)
    assert contraction.steps[-1].volume_ratio < 1e-3
