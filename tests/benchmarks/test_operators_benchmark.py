"""The benchmark of the operators: its shapes, its cases, its tables."""

import numpy as np

from benchmarks.operators_convergence import (
    CASES,
    flipped_sphere,
    folded,
    measure,
    tables,
    uneven_cylinder,
    uneven_sphere,
    uneven_torus,
)
from benchmarks.operators_properties import THEORY, shapes
from benchmarks.operators_properties import measure as measure_properties
from benchmarks.operators_properties import tables as tables_of_properties
from benchmarks.operators_speed import DIRECT, LIBIGL, calls, mesh_of
from lbskel.operators import OPERATORS


def test_shapes_of_the_property_table_are_what_they_are_called():
    found = shapes()
    assert found["good"].is_closed_manifold
    assert found["irregular"].is_closed_manifold
    assert found["irregular"].volume > 0
    assert not found["non-manifold"].is_edge_manifold
    assert not found["open"].is_closed
    assert np.bincount(found["irregular"].faces.ravel()).max() >= 9


def test_the_property_table_confirms_theory_on_a_plane():
    rows = measure_properties(["open"])
    assert [row["operator"] for row in rows] == list(OPERATORS)
    text = tables_of_properties(rows)["Properties kept, over all shapes"]
    assert "- none." in text
    assert "| cotangent | kept | kept | kept | kept | lost on 1 |" in text
    assert "| graph | kept | kept | kept | lost on 1 | kept |" in text


def test_curved_shapes_have_the_curvature_they_claim():
    for mesh, H in (uneven_torus(2), uneven_cylinder(2)):
        inner = np.setdiff1d(np.arange(len(mesh.vertices)), mesh.edges[mesh.faces_per_edge == 1])
        found = OPERATORS["cotangent"](mesh).mean_curvature_normals(mesh.vertices)
        # on uneven meshes single vertices are off, their mean is not
        assert np.linalg.norm((found - H)[inner].mean(axis=0)) < 0.02
        assert abs((found * H)[inner].sum() / (H * H)[inner].sum() - 1) < 0.02
    assert uneven_sphere(1).is_closed_manifold


def test_flipped_edges_are_as_many_as_asked_for_and_fold_nothing():
    sound, flipped = uneven_sphere(1), flipped_sphere(1)
    before, after = ({frozenset(edge) for edge in mesh.edges.tolist()} for mesh in (sound, flipped))
    assert len(before - after) == round(0.15 * len(before))
    assert flipped.is_closed_manifold
    assert abs(flipped.volume / sound.volume - 1) < 0.05
    assert (np.einsum("fx,fx->f", flipped.face_normals, flipped.vertices[flipped.faces].mean(axis=1)) > 0).all()


def test_the_folded_torus_is_closed():
    L, _ = folded(OPERATORS["cotangent"], 8)
    assert L.stiffness.shape == (64, 64)
    assert np.abs(L.stiffness.sum(axis=1)).max() < 1e-12
    assert abs(L.mass.sum() - 1) < 1e-12
    assert abs(L.stiffness - L.stiffness.T).max() < 1e-12


def test_orders_of_three_operators():
    cases = ("sphere spectrum", "torus spectrum", "sphere Poisson", "sphere harmonic")
    rows = measure(range(4), ("graph", "cotangent", "intrinsic_delaunay"), cases)
    orders = {(row["case"], row["operator"], row["error"]): row["order"] for row in rows}
    for case in ("sphere spectrum", "torus spectrum"):
        for name in ("cotangent", "intrinsic_delaunay"):
            assert 1.8 < orders[case, name, "eigenvalues"] < 2.25, (case, name)  # three sizes scatter about 2
    assert abs(orders["torus spectrum", "graph", "eigenvalues"]) < 0.2
    assert 1.8 < orders["sphere Poisson", "cotangent", "L2"] < 2.25
    assert orders["sphere harmonic", "cotangent", "maximum"] < 0.5
    assert orders["sphere harmonic", "heat_kernel, t ~ h", "maximum"] > 0.7
    filled = [title for title, table in tables(rows).items() if table.count("\n") > 2]
    assert filled == ["Orders", *(CASES[case][0] for case in cases)]


def test_calls_of_the_speed_table():
    mesh = mesh_of(2000)
    assert abs(len(mesh.faces) - 2000) < 50
    assert mesh.is_closed_manifold
    found = calls()
    assert set(OPERATORS) < set(found) <= {*OPERATORS, *DIRECT}
    for name in (LIBIGL, "cotangent", "robust_laplacian: mesh_laplacian"):
        found[name](mesh)


def test_every_operator_has_its_row_of_theory():
    assert list(THEORY) == list(OPERATORS)
