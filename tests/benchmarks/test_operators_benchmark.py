"""The benchmark of the operators: its shapes, its cases, its tables; and the harness that all benchmarks use."""

import json
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks.harness import (
    fitted_order,
    interleaved,
    machine,
    markdown_table,
    median_ratio,
    peak_growth,
    run_in_subprocess,
    save_json,
)
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


def test_orders_and_ratios():
    h = np.array([0.4, 0.2, 0.1, 0.05])
    assert abs(fitted_order(h, 3 * h**1.5) - 1.5) < 1e-12
    assert median_ratio([2.0, 9.0, 4.0], [1.0, 3.0, 4.0]) == 2.0


def test_calls_take_turns_and_get_what_was_prepared():
    order = []
    calls = {"a": lambda: order.append("a"), "b": lambda given: order.append(given)}
    seconds = interleaved(calls, 2, prepare={"b": lambda: "b"})
    assert order == ["a", "b"] * 3
    assert {name: len(taken) for name, taken in seconds.items()} == {"a": 2, "b": 2}


def _fails(what):
    raise ValueError(what)


def test_a_child_gives_its_value_its_error_or_its_end():
    assert run_in_subprocess(max, 3, 7)["value"] == 7
    assert run_in_subprocess(_fails, "so it is")["error"] == "ValueError: so it is"
    assert "ended with code" in run_in_subprocess(exit_at_once)["error"]
    assert run_in_subprocess(time.sleep, 600, timeout=0.1)["error"] == "over 0.1 s"


def _starts_another(written):
    return subprocess.Popen(["sh", "-c", f"sleep 120; echo still here > '{written}'"]).pid


@pytest.mark.skipif(not Path("/proc").exists(), reason="processes are looked up in /proc")
def test_what_a_child_has_started_ends_with_it(tmp_path):
    status = Path(f"/proc/{run_in_subprocess(_starts_another, tmp_path / 'written')['value']}/stat")
    while is_running(status):
        time.sleep(0.01)
    assert not (tmp_path / "written").exists()


def is_running(status):
    """Whether a process has not ended, by its file of status; one that nobody has waited for is in state Z."""
    try:
        return status.read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def exit_at_once():
    import os

    os._exit(3)


def peak_of_ones():
    return peak_growth(lambda: np.ones(5_000_000).sum())


def test_memory_at_its_peak():
    found = run_in_subprocess(peak_of_ones, timeout=60)["value"]  # a process that holds no freed memory
    assert found is None or 35 < found < 60  # 40 MB, and what the interpreter takes besides


def test_tables_and_json(tmp_path):
    table = markdown_table([{"a": 1, "b": 0.12345}, {"a": True, "c": None}])
    assert table.splitlines() == ["| a | b | c |", "| --- | --- | --- |", "| 1 | 0.123 | - |", "| yes | - | - |"]
    save_json(tmp_path / "x.json", {"rows": [np.float64(2.5), np.arange(2)]}, packages=["no_such_package"])
    written = json.loads((tmp_path / "x.json").read_text())
    assert written["rows"] == [2.5, [0, 1]]
    assert written["machine"]["versions"]["no_such_package"] == "not installed"
    assert machine()["versions"]["numpy"] == np.__version__


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
