"""The benchmark of coarse meshes: its parts, and a quick run."""

import json

import numpy as np
import pytest

from benchmarks import coarse
from lbskel import Skeleton


def test_parts_are_closed_and_have_faces_as_long_as_their_boxes():
    parts = {name: mesh for name, mesh, _, _ in coarse._parts(False) if "900" not in name}
    assert all(mesh.is_closed_manifold for mesh in parts.values())
    assert [parts[f"frame of {n} holes"].genus for n in (9,)] == [9]
    comb = parts["comb of 5 teeth"]
    assert np.ptp(comb.vertices, axis=0).tolist() == [34, 8, 2]
    assert comb.volume == pytest.approx(34 * 2 * 2 + 5 * 6 * 2 * 2)


def test_a_skeleton_is_right_with_its_graph_and_length():
    tee = Skeleton(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0], [9, 0, 0], [9, 0.5, 0]], [[0, 1], [1, 2], [1, 3], [4, 5]], [1] * 6
    )
    assert coarse._is_right(tee, (3, 1, 0), 3.1)
    assert not coarse._is_right(tee, (3, 1, 0), 4.0)
    assert not coarse._is_right(tee, (2, 0, 0), 3.0)


def test_a_quick_run_writes_its_tables(tmp_path, monkeypatch):
    monkeypatch.setattr(coarse, "RUNGS", ())
    monkeypatch.setattr(coarse, "HOLES", ())
    coarse.run(True, tmp_path)
    usual, other = json.loads((tmp_path / "coarse.json").read_text())["bounds"]
    assert (usual["bounds"], other["bounds"]) == ("as they are", "MAX_COARSE_AREA 0.05")
    assert usual["parts"].endswith("/2")
    assert "## Shares that are coarse" in (tmp_path / "coarse.md").read_text()
