"""Treatments of rows at degenerate triangles: what they do to L, and where the vertices go."""

import numpy as np
import pytest

from lbskel import ContractionSettings, contract, laplacian
from lbskel.contraction.degenerate_rows import MAX_ROW_SUM, ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES, ContractionStepInput
from lbskel.shapes import torus


def shifted_torus():
    """A torus of 200 vertices whose center is not the origin."""
    mesh = torus(1.0, 0.3, 20, 10)
    return mesh.with_vertices(mesh.vertices + [5.0, 0.0, 0.0])


def step_input(mesh, treatment, rows, weight):
    ones = np.ones(len(mesh.vertices))
    return ContractionStepInput(
        laplacian(mesh), mesh.vertices, weight, ones, ones, lambda L: ROW_TREATMENTS[treatment](L, rows)
    )


def test_identity_rows_keep_positions_and_zero_rows_pull_to_the_origin():
    mesh = shifted_torus()
    rows = np.arange(0, 200, 7)
    displacements = {}
    for treatment in ("identity", "identity_zero"):
        system = ENERGIES["least_squares"](step_input(mesh, treatment, rows, 1e9))
        assert system.replaced_rows.tolist() == rows.tolist()
        displacements[treatment] = np.linalg.solve(system.A.toarray(), system.B)[rows]
    # at so large a weight the identity rows hold nearly exactly, v' = v or v' = 0; the other rows add a little
    assert np.linalg.norm(mesh.vertices[rows] + displacements["identity_zero"], axis=1).max() < 0.05 * 5
    assert np.abs(displacements["identity"]).max() < 0.05 * 5


def test_row_sums_are_bounded_and_other_rows_unchanged():
    mesh = shifted_torus()
    V = np.array(mesh.vertices)
    V[17] = V[16] + 1e-6 * (V[17] - V[16])  # cotangents of about a million
    L = (2 * laplacian(mesh.with_vertices(V)).stiffness).tocsr()
    treatment = ROW_TREATMENTS["row_sums"](L, np.empty(0, dtype=int))
    bounded = treatment.apply(L)
    assert 0 < len(treatment.changed_rows) < 20
    assert bounded.diagonal()[treatment.changed_rows] == pytest.approx(MAX_ROW_SUM)
    others = np.setdiff1d(np.arange(200), treatment.changed_rows)
    assert abs(bounded[others] - L[others]).max() == 0
    # a scaled row keeps its direction
    assert (bounded @ V)[treatment.changed_rows] == pytest.approx(
        treatment.factors[treatment.changed_rows, None] * (L @ V)[treatment.changed_rows]
    )


def test_the_right_hand_side_is_the_position_of_a_held_vertex_and_zero_elsewhere():
    L = (2 * laplacian(shifted_torus()).stiffness).tocsr()
    V, rows = shifted_torus().vertices, np.array([3, 50])
    held = ROW_TREATMENTS["identity"](L, rows).right_hand_side(V)
    assert np.array_equal(held[rows], V[rows])
    assert not np.delete(held, rows, axis=0).any()
    for treatment in ("none", "identity_zero", "row_sums"):
        assert not ROW_TREATMENTS[treatment](L, rows).right_hand_side(V).any()


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
    assert counts["none"] == counts["row_sums"] == 0  # cotangents clamped at 57 sum to a few hundred at most
    assert counts["identity"] == counts["identity_zero"] >= 4
