"""Weights: published formulas, ring areas, and attraction by how much thinner the surface has become."""

import numpy as np
import pytest
from helpers import joined, moved

from lbskel import ContractionSettings, Mesh, contract
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.weights import (
    ATTRACTIONS,
    INITIAL_WEIGHT_RULES,
    LOCAL_FACTOR,
    WEIGHTS,
    mean_ring_area,
    ring_areas,
    ring_shrinkage,
)
from lbskel.shapes import capsule, torus


@pytest.fixture
def kite():
    """Two triangles of areas 1/2 and 3/2 at a common edge, and a vertex without a face."""
    return Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -3, 0], [9, 9, 9]], [[0, 1, 2], [0, 3, 1]])


@pytest.mark.parametrize("weights", WEIGHTS)
@pytest.mark.parametrize("energy", ENERGIES)
def test_published_weights_do_not_depend_on_units(weights, energy):
    mesh = capsule(3.0, 0.4, 12)
    chosen = ContractionSettings(energy=energy, max_steps=4, **WEIGHTS[weights])
    one, thousand = (contract(mesh.with_vertices(scale * mesh.vertices), chosen) for scale in (1.0, 1000.0))
    assert [step.weight for step in one.steps] == pytest.approx([step.weight for step in thousand.steps])
    assert one.steps[0].area_ratio == pytest.approx(thousand.steps[0].area_ratio)


def _mean_edge(mesh):
    """The mean over the vertices of the mean length of their edges, in diameter bounds."""
    count, sums = (np.bincount(mesh.edges.ravel(), weights) for weights in (None, np.repeat(mesh.edge_lengths, 2)))
    return (sums / count).mean() / mesh.diameter_bound


def test_published_weights_start_as_printed():
    mesh = capsule(3.0, 0.4, 12)
    average = mesh.area / mesh.diameter_bound**2 / len(mesh.faces)
    side = np.ptp(mesh.vertices, axis=0).max() / mesh.diameter_bound
    printed = {
        "local_radius": np.sqrt(INITIAL_WEIGHT_RULES["local_radius"](mesh, 0.5).mean() / mean_ring_area(mesh)),
        "diffusion_length": 0.02 / np.sqrt(mean_ring_area(mesh) / mesh.diameter_bound**2),
        "au2008": 1e-3 * np.sqrt(average),
        "au2008_total_area": 1e-3 * np.sqrt(average * len(mesh.faces)),
        "au2008_demo": 1 / (10 * np.sqrt(average)),
        "cao2010": side / (5 * 1.6 * _mean_edge(mesh)),
        "cao2010_meshes": 1 / (10 * np.sqrt(average * (1.6 / side) ** 2)),
    }
    assert set(printed) == set(WEIGHTS)
    for name, W_L in printed.items():
        chosen = ContractionSettings(energy="least_squares", max_steps=2, volume_ratio=1e-12, **WEIGHTS[name])
        steps = contract(mesh, chosen).steps
        growth = 3 if name.startswith("cao2010") else 2
        assert [step.weight for step in steps] == pytest.approx([W_L**2, (growth * W_L) ** 2])


def _mean_ring_edge(kite):
    """The mean over the used vertices of the mean length of their edges."""
    lengths = {vertex: [] for vertex in kite.used_vertices.tolist()}
    for (i, j), length in zip(kite.edges.tolist(), kite.edge_lengths.tolist(), strict=True):
        lengths[i].append(length)
        lengths[j].append(length)
    return np.mean([np.mean(own) for own in lengths.values()])


def test_rules_give_tau_which_is_w_l_squared_times_the_mean_ring_area(kite):
    # faces of 1/2 and 3/2, rings of 2, 2, 1/2 and 3/2
    mean_ring, c = 1.5, 0.1
    expected = {
        "diffusion_length": c**2,
        "average_area": c**2 * 1.0 * mean_ring,
        "total_area": c**2 * 2.0 * mean_ring,
        "inverse_area": c**2 / 1.0 * mean_ring,
        "inverse_area_in_box": (4 * c) ** 2 / 1.0 * mean_ring,
        "inverse_edge_in_box": (4 * c / _mean_ring_edge(kite)) ** 2 * mean_ring,
    }
    numbers = {name: rule(kite, c) for name, rule in INITIAL_WEIGHT_RULES.items() if name != "local_radius"}
    assert numbers == pytest.approx(expected)


def test_the_rule_of_local_radii_gives_tau_at_each_vertex():
    """On a thick and a thin ring side by side: up to the mean radius over the area, tau grows with the radius."""
    thick, thin = torus(1.0, 0.1, 60, 32), torus(0.2, 0.01, 120, 32)
    tau = INITIAL_WEIGHT_RULES["local_radius"](joined(thick, moved(thin, 3.0)), 0.5)
    n, mean = len(thick.vertices), (0.1 * 0.1 + 0.002 * 0.01) / 0.102  # areas are as the products of the two radii
    # polygons of 32 corners are thinner by the cosine of pi / 32, half a per cent
    assert tau[:n] == pytest.approx((0.5 * min(LOCAL_FACTOR * 0.1, mean)) ** 2, rel=0.03)
    assert tau[n:] == pytest.approx((0.5 * min(LOCAL_FACTOR * 0.01, mean)) ** 2, rel=0.03)
    assert tau[n:].max() < tau[:n].min()


def test_the_first_step_shrinks_a_tube_as_its_closed_form_says():
    """On a circle S has the value 1 / r^2 per area; with tau = (c r)^2 the radius becomes r / (1 + c^2)."""
    c = 0.5
    mesh = torus(1.0, 0.05, 160, 24)
    step = contract(mesh, ContractionSettings(initial_weight=c, max_steps=1)).steps[0]
    assert step.area_ratio == pytest.approx(1 / (1 + c**2), rel=0.02)


def test_ring_areas_count_the_triangles_at_a_vertex(kite):
    assert ring_areas(kite).tolist() == [2.0, 2.0, 0.5, 1.5, 0.0]
    assert mean_ring_area(kite) == 1.5


def test_attractions_compare_areas_as_they_say(kite):
    now = kite.with_vertices([[0, 0, 0], [1, 0, 0], [0, 0.5, 0], [0, -0.75, 0], [9, 9, 9]])
    # faces of 1/2 and 3/2 shrink to 1/4 and 3/8
    assert ATTRACTIONS["ring_areas"](kite, now) == pytest.approx([2 / 0.625, 2 / 0.625, 2, 4, 1])
    assert ATTRACTIONS["face_areas"](kite, now) == pytest.approx([1 / 0.375, 1 / 0.375, 2, 4, 1])
    half = kite.with_vertices(kite.vertices * 0.5)
    assert ATTRACTIONS["shortest_edges"](kite, half) == pytest.approx([4, 4, 4, 4, 1])


def test_attraction_stays_finite_where_an_area_vanishes(kite):
    flat = kite.with_vertices(kite.vertices * [1, 0, 1])
    for name in ("ring_areas", "face_areas"):
        assert ATTRACTIONS[name](kite, flat)[:4] == pytest.approx(np.full(4, 1e12))
    point = kite.with_vertices(kite.vertices * 0.0)
    assert ATTRACTIONS["shortest_edges"](kite, point)[:4] == pytest.approx(np.full(4, 1e12))
    assert ring_shrinkage(ring_areas(kite), kite).tolist() == [1, 1, 1, 1, 1]
