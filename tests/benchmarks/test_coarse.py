"""The benchmark of coarse meshes: what is right, and a quick run where manifold3d is installed."""

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import coarse
from lbskel import Skeleton
from lbskel.preprocess import automatic, subdivision
from lbskel.shapes import sphere


def test_a_skeleton_is_right_with_its_tips_cycles_and_length():
    tee = Skeleton([[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0]], [[0, 1], [1, 2], [1, 3]], [1] * 4)
    part = coarse.Part("tee", sphere(1), 3, 0, 3.1)
    assert coarse._is_right(tee, part)
    assert not coarse._is_right(tee, part._replace(length=4.0))
    assert not coarse._is_right(tee, part._replace(n_tips=2))
    assert not coarse._is_right(replace(tee, edges=tee.edges[1:]), part)


@pytest.mark.parametrize("name", coarse.BOUNDS)
def test_every_bound_is_a_number_of_its_module(name):
    modules = {"automatic": automatic, "subdivision": subdivision}
    for target in coarse.BOUNDS[name]:
        module, constant = target.split(".")
        assert isinstance(getattr(modules[module], constant), float)


def test_a_quick_run_writes_its_tables(tmp_path):
    pytest.importorskip("manifold3d")
    coarse.run(True, tmp_path)
    found = json.loads((tmp_path / "coarse.json").read_text())
    assert [row["bounds"] for row in found["bounds"]] == ["as they are", "MAX_COARSE_AREA 0.05"]
    assert all(np.isfinite([row["of the faces"], row["of the area"]]).all() for row in found["meshes"])
    assert "## Shares that are coarse" in (tmp_path / "coarse.md").read_text()
