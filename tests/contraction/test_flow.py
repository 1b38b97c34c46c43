"""Contraction: what a step may do, when it ends, roll-back, and the operator that is chosen."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array

from lbskel import PRESETS, Laplacian, Mesh, MeshError, Status, UnknownChoice, contract, laplacian
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.weights import WEIGHTS, mean_ring_area
from lbskel.errors import OperatorError
from lbskel.shapes import capsule, chain_of_tori, cylinder, torus


def settings(**changes):
    return replace(PRESETS["curvature_flow"], **changes)


def switching_operator(change, first_call):
    """The robust operator, changed from a certain call on, counted from 1."""
    calls = []

    def operator(mesh: Mesh):
        calls.append(mesh)
        result = laplacian(mesh, operator="robust")
        return change(result) if len(calls) >= first_call else result

    return operator


def test_a_torus_shrinks_to_its_circle():
    """Without merging: a ring of the three vertices that merging leaves may be three times as wide as one of many."""
    contraction = contract(torus(1.0, 0.2, 64, 24), settings(collapse_length=0.0))
    assert contraction.status is Status.VOLUME
    assert contraction.steps[-1].volume_ratio < PRESETS["curvature_flow"].volume_ratio
    V = contraction.mesh.vertices
    radius = np.hypot(V[:, 0], V[:, 1])
    # the flow draws a closed tube inwards by about r^2 / 2R, a tenth of the tube's radius here, and not out of plane
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
    # a fixed weight on Au's dimensionless operator would need four times the steps on the finer mesh
    coarse, fine = (len(contract(torus(1.0, 0.2, 32 * k, 12 * k)).steps) for k in (1, 4))
    assert abs(coarse - fine) <= 2


def test_a_scaled_mesh_is_contracted_like_the_mesh():
    mesh = torus(1.0, 0.2)
    larger = mesh.with_vertices(1024 * mesh.vertices)  # a power of 2: no rounding
    contraction, scaled = contract(mesh), contract(larger)
    assert np.array_equal(scaled.mesh.faces, contraction.mesh.faces)
    assert scaled.mesh.vertices == pytest.approx(1024 * contraction.mesh.vertices, rel=1e-9)


def test_open_meshes_end_by_their_area():
    contraction = contract(cylinder(0.3, 4.0, 24, 41))
    assert contraction.status is Status.AREA
    assert np.isnan(contraction.steps[-1].volume_ratio)
    assert contraction.steps[-1].area_ratio <= PRESETS["curvature_flow"].area_ratio


def test_closed_meshes_without_a_consistent_orientation_end_by_their_area():
    mesh = torus(1.0, 0.3, 40, 16)
    mixed = Mesh(mesh.vertices, np.where(np.arange(len(mesh.faces))[:, None] % 2, mesh.faces, mesh.faces[:, ::-1]))
    contraction = contract(mixed)
    assert contraction.status is Status.AREA
    assert np.isnan([step.volume_ratio for step in contraction.steps]).all()


def test_consistently_oriented_tubes_that_share_an_edge_end_by_their_volume():
    mesh = torus(1.0, 0.3, 40, 16)
    n, (a, b) = len(mesh.vertices), mesh.edges[0]
    other = np.arange(n) + n
    other[[a, b]] = a, b
    shift = 3 * np.array([1.0, 0, 0])
    two = Mesh(np.concatenate([mesh.vertices, mesh.vertices + shift]), np.concatenate([mesh.faces, other[mesh.faces]]))
    assert two.is_closed
    assert not two.is_edge_manifold
    assert np.isfinite(contract(two, settings(max_steps=1)).steps[0].volume_ratio)


def test_ratios_are_relative_to_the_start():
    mesh = torus(1.0, 0.3, 40, 16)
    contraction = contract(mesh, settings(max_steps=3))
    step = contraction.steps[-1]
    assert step.area_ratio == pytest.approx(contraction.mesh.area / mesh.area)
    assert step.volume_ratio == pytest.approx(contraction.mesh.volume / mesh.volume)
    # the box of the coarse mesh, whose merged vertices are the same points
    assert step.box_ratio == pytest.approx(contraction.mesh.diagonal / mesh.diagonal)


@pytest.mark.parametrize(("energy", "factor"), [("curvature_flow", 3.0), ("least_squares", 9.0)])
def test_the_contraction_weight_grows_by_the_same_factor_each_step(energy, factor):
    """On tau, or on W_L, whose square is in the system; with every vertex, since the mean is over those left."""
    chosen = settings(energy=energy, contraction_growth=3.0, max_steps=4, collapse_length=0.0)
    steps = contract(torus(1.0, 0.3, 40, 16), chosen).steps
    weights = np.array([step.weight for step in steps])
    assert len(steps) == 4
    assert weights[1:] / weights[:-1] == pytest.approx([factor] * 3)


def test_mass_is_the_ring_areas_at_the_start_over_three():
    """H = M_0 A_0 / A_t, on the mesh of diameter bound 1: before the first step M_0 alone, which sums to the area."""
    mesh = torus(1.0, 0.3, 40, 16)
    H = contract(mesh, settings(max_steps=1)).steps[0].attraction
    assert H[0] < mesh.area / mesh.diameter_bound**2 / len(mesh.vertices) < H[1]


def test_a_step_that_makes_the_area_grow_is_undone():
    mesh = torus(1.0, 0.3, 40, 16)
    # S - c M has a negative value c on what S leaves in place: the mesh grows by a few per cent
    growing = switching_operator(
        lambda result: replace(result, stiffness=(0.2 * result.stiffness - 50 * result.mass).tocsc()), 3
    )
    contraction = contract(mesh, settings(operator=growing, collapse_length=0.0, **WEIGHTS["diffusion_length"]))
    assert contraction.status is Status.AREA_GREW
    assert len(contraction.steps) == 2
    assert contraction.first_failed_step == 3
    assert contraction.mesh.area == pytest.approx(contraction.steps[-1].area_ratio * mesh.area)
    assert contraction.mesh.area < mesh.area


def test_an_operator_with_nan_ends_the_contraction_and_keeps_the_last_step():
    def with_nan(result):
        result.stiffness.data[0] = np.nan
        return result

    contraction = contract(torus(1.0, 0.3, 40, 16), settings(operator=switching_operator(with_nan, 3)))
    assert contraction.status is Status.NOT_SOLVED
    assert len(contraction.steps) == 2
    assert np.isfinite(contraction.mesh.vertices).all()


def test_an_operator_that_is_no_longer_defined_ends_the_contraction():
    def undefined(result):
        raise MeshError("not on this mesh")

    mesh = torus(1.0, 0.3, 40, 16)
    contraction = contract(mesh, settings(operator=switching_operator(undefined, 3)))
    assert contraction.status is Status.NOT_FINITE
    assert len(contraction.steps) == 2
    with pytest.raises(MeshError, match="not on this mesh"):
        contract(mesh, settings(operator=switching_operator(undefined, 1)))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda result: result.stiffness, "not a Laplacian"),
        (lambda result: (result.stiffness, result.mass), "not a Laplacian"),
        (lambda result: replace(result, stiffness=-result.stiffness), "sign"),
        (lambda result: Laplacian(csc_array((3, 3)), csc_array((3, 3))), "shape"),
    ],
)
def test_an_operator_that_returns_something_else_is_refused(change, words):
    with pytest.raises(OperatorError, match=words):
        contract(torus(1.0, 0.3, 20, 10), settings(operator=switching_operator(change, 1)))


def test_the_default_operator_is_the_one_that_is_stable_and_defined_on_the_mesh():
    closed, opened = torus(1.0, 0.3, 40, 16), cylinder(0.3, 4.0, 24, 11)
    pinched = Mesh(np.concatenate([closed.vertices, closed.vertices[:1]]), closed.faces)
    pinched = Mesh(pinched.vertices, np.concatenate([pinched.faces, pinched.faces[:1], pinched.faces[:1]]))
    assert pinched.is_closed
    assert not pinched.is_edge_manifold
    for mesh, name in ((closed, "intrinsic_delaunay"), (opened, "robust"), (pinched, "robust")):
        other = "robust" if name == "intrinsic_delaunay" else "cotangent"
        default, expected, different = (
            contract(mesh, settings(operator=operator, max_steps=3)).mesh.vertices for operator in (None, name, other)
        )
        assert np.array_equal(default, expected)
        assert not np.array_equal(default, different)


def klein_bottle(n=24, m=16):
    """The figure-8 immersion, a closed edge-manifold surface with no orientation."""
    u, v = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(m) / m, indexing="ij")
    r = 2 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    z = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    i, j = np.divmod(np.arange(n * m), m)
    right = np.where(i + 1 < n, j, -j % m)
    above_right = np.where(i + 1 < n, (j + 1) % m, -(j + 1) % m)
    a, b = i * m + j, (i + 1) % n * m + right
    c, d = (i + 1) % n * m + above_right, i * m + (j + 1) % m
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(np.stack([r * np.cos(u), r * np.sin(u), z], axis=-1).reshape(-1, 3), faces)


def test_a_closed_mesh_that_cannot_be_oriented_is_contracted_by_the_robust_operator():
    mesh = klein_bottle()
    assert mesh.is_closed
    assert mesh.is_edge_manifold
    default, robust = (contract(mesh, settings(operator=operator, max_steps=3)) for operator in (None, "robust"))
    assert np.array_equal(default.mesh.vertices, robust.mesh.vertices)
    assert len(default.steps) == 3


def test_clamped_angles_are_counted():
    mesh = torus(1.0, 0.3, 40, 16)
    steps = contract(mesh, replace(PRESETS["least_squares"], max_steps=12)).steps
    assert steps[0].n_clamped_angles == 0
    assert steps[-1].n_clamped_angles > 0


def test_the_smallest_angle_is_that_before_the_step_in_degrees():
    mesh = Mesh([[0, 0, 0], [2, 0, 0], [2, 1, 0]], [[0, 1, 2]])
    assert contract(mesh, settings(max_steps=1)).steps[0].min_angle_deg == pytest.approx(np.degrees(np.arctan(0.5)))


def test_on_step_gets_every_step_with_its_mesh_at_diameter_bound_1():
    received = []
    mesh = torus(10.0, 3.0, 40, 16)
    contraction = contract(mesh, on_step=lambda step, now: received.append((step, now)))
    assert tuple(step for step, _ in received) == contraction.steps
    for step, now in received:
        assert now.area * mesh.diameter_bound**2 == pytest.approx(step.area_ratio * mesh.area)
        assert np.array_equal(now.faces, mesh.faces)


def test_no_step_begins_after_the_time_limit():
    mesh = torus(1.0, 0.3, 40, 16)
    contraction = contract(mesh, time_limit=1e-9)
    assert contraction.status is Status.TIME_LIMIT
    assert contraction.steps == ()
    assert contraction.mesh.vertices == pytest.approx(mesh.vertices)
    # without merging nothing but the first step looks at the limit, and does so before its operator is built
    unused = switching_operator(lambda result: pytest.fail("a step began"), 1)
    assert contract(mesh, settings(operator=unused, collapse_length=0.0), time_limit=1e-9).steps == ()


@pytest.mark.parametrize(
    ("time_limit", "n_begun", "n_kept"),
    [
        (35.0, 3, 3),  # 5 s are left after three steps, and the third took 10
        (30.0, 3, 3),  # nothing is left
        (5.0, 1, 0),  # the first takes longer than there is
        (15.0, 1, 1),
    ],
)
def test_a_step_that_would_end_after_the_time_limit_does_not_begin_or_is_not_kept(
    monkeypatch, time_limit, n_begun, n_kept
):
    """With a clock that stands still but for the operator, which takes 10 s."""
    now, begun = [0.0], []
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])

    def slow(mesh: Mesh):
        begun.append(mesh)
        now[0] += 10.0
        return laplacian(mesh, operator="robust")

    contraction = contract(torus(1.0, 0.3, 40, 16), settings(operator=slow, max_steps=4), time_limit=time_limit)
    assert contraction.status is Status.TIME_LIMIT
    assert (len(begun), len(contraction.steps)) == (n_begun, n_kept)


def test_a_mesh_may_be_a_pair_of_arrays():
    mesh = torus(1.0, 0.3, 40, 16)
    pair = contract((mesh.vertices.tolist(), mesh.faces.tolist()))
    assert np.array_equal(pair.mesh.vertices, contract(mesh).mesh.vertices)


def test_a_mesh_without_area_is_refused():
    with pytest.raises(MeshError, match="no area"):
        contract(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]))


def test_without_roll_back_plain_cotangents_break_and_intrinsic_delaunay_does_not():
    mesh = chain_of_tori(2, step=0.15)  # marching cubes: slivers, as in the meshes that the method is known to break on
    plain, stable = (
        contract(
            mesh, settings(operator=operator, energy="least_squares", rollback=False, volume_ratio=1e-15, max_steps=14)
        )
        for operator in ("cotangent", "intrinsic_delaunay")
    )
    assert plain.first_failed_step is not None
    first = plain.steps[plain.first_failed_step - 1]
    assert first.fault in (Status.AREA_GREW, Status.BOX_GREW)
    assert all(step.fault is None for step in plain.steps[: plain.first_failed_step - 1])
    assert max(step.box_ratio for step in plain.steps) > 1.2  # well beyond what roll-back allows
    assert stable.first_failed_step is None
    assert max(step.box_ratio for step in stable.steps) <= 1


def test_roll_back_undoes_the_step_that_breaks():
    mesh = chain_of_tori(2, step=0.15)
    chosen = settings(operator="clamped_cotangent", energy="least_squares", volume_ratio=1e-9)
    guarded, free = contract(mesh, chosen), contract(mesh, replace(chosen, rollback=False, max_steps=8))
    assert guarded.first_failed_step == len(guarded.steps) + 1
    assert guarded.first_failed_step == free.first_failed_step
    # the same energies before, solved once for displacements and once for positions; condition numbers up to 1e8
    assert guarded.steps[-1].area_ratio == pytest.approx(free.steps[len(guarded.steps) - 1].area_ratio, rel=1e-4)


@pytest.mark.parametrize("energy", ENERGIES)
def test_without_roll_back_early_steps_are_the_same(energy):
    mesh = torus(1.0, 0.3, 40, 16)
    chosen = settings(energy=energy, max_steps=2, collapse_length=0.0)  # without roll-back vertices are never merged
    guarded, free = contract(mesh, chosen), contract(mesh, replace(chosen, rollback=False))
    # condition numbers of 1e6 at most, a thousand roundings
    assert np.abs(guarded.mesh.vertices - free.mesh.vertices).max() < 1e-9


def test_an_operator_that_is_not_symmetric_is_refused_where_it_must_be_symmetric():
    mesh = capsule(3.0, 0.4, 20)
    for changes in ({}, {"solver": "superlu"}, {"solver": "cg_jacobi"}):
        with pytest.raises(UnknownChoice, match=r"'mean_value' is not symmetric.*least_squares"):
            contract(mesh, settings(operator="mean_value", **changes))
    assert len(contract(mesh, settings(operator="mean_value", energy="least_squares")).steps) > 0


def test_a_contraction_ends_before_the_step_in_which_its_operator_replaces_rows():
    """Triangles get thin after some steps; until then the matrix of cotangents is symmetric."""
    contraction = contract(capsule(3.0, 0.4, 20), settings(operator="cotangent_identity"))
    assert contraction.status is Status.NOT_SYMMETRIC
    assert len(contraction.steps) > 0
    assert contraction.first_failed_step == len(contraction.steps) + 1


def test_treated_vertices_are_recorded_for_each_step_with_their_largest_displacement():
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


def test_treated_vertices_are_those_of_the_source_where_vertices_were_merged():
    mesh = torus(1.0, 0.3, 40, 16)

    def last_vertex_treated(now: Mesh):
        return replace(laplacian(now, operator="robust"), treated_vertices=np.array([len(now.vertices) - 1]))

    contraction = contract(mesh, settings(operator=last_vertex_treated))
    n_coarse = len(contraction.coarse.vertices)
    assert n_coarse < len(mesh.vertices)
    [treated] = contraction.treated_vertices[-1]
    assert contraction.vertex_map.indices[treated] == n_coarse - 1


def test_bounds_on_the_weights_are_kept():
    mesh = torus(1.0, 0.3, 40, 16)
    free = contract(mesh, settings(energy="least_squares", max_steps=6)).steps
    capped = contract(
        mesh, settings(energy="least_squares", max_steps=6, max_contraction_weight=4.0, max_attraction=3.0)
    ).steps
    assert [step.weight for step in capped] == pytest.approx([min(step.weight, 16.0) for step in free])
    assert free[-1].weight > 16
    assert free[-1].attraction[1] > 9
    assert max(step.attraction[1] for step in capped) == pytest.approx(9)
    curvature_flow = contract(mesh, settings(max_steps=6, max_contraction_weight=1.0)).steps
    # tau is W_L^2 times the mean ring area, on the mesh of diameter bound 1
    assert curvature_flow[-1].weight == pytest.approx(mean_ring_area(mesh) / mesh.diameter_bound**2)


def test_a_preset_is_taken_by_its_name():
    mesh = capsule(3.0, 0.4, 20)
    named, given = contract(mesh, "au2008"), contract(mesh, PRESETS["au2008"])
    assert (named.coarse.vertices == given.coarse.vertices).all()
    with pytest.raises(UnknownChoice, match="preset"):
        contract(mesh, "au2009")


@pytest.mark.parametrize("limit", [-1.0, float("nan"), "5"])
def test_time_limits_that_are_no_seconds_are_refused(limit):
    with pytest.raises(UnknownChoice, match="time_limit must be a number of seconds"):
        contract(torus(1.0, 0.2), time_limit=limit)
