"""The benchmark of fans: its mesh, and a quick run."""

import json

import numpy as np

from benchmarks import fans


def test_a_tube_is_closed_by_a_fan_at_each_end():
    mesh = fans._closed_tube(50)
    assert mesh.is_closed_manifold
    assert mesh.volume > 0
    neighbors = np.bincount(mesh.edges.ravel())
    assert np.sort(neighbors)[-2:].tolist() == [50, 50]


def test_each_call_is_measured(tmp_path, monkeypatch):
    monkeypatch.setattr(fans, "SIDES", (30,))
    fans.run(True, tmp_path)
    rows = json.loads((tmp_path / "fans.json").read_text())["fans"]
    assert [row["call"] for row in rows] == list(fans.CALLS)
    assert not [row for row in rows if "error" in row]
