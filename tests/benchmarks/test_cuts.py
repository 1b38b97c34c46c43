"""Cuts: tubes with two centers each, and what other bounds on open ends do to them."""

import json

import numpy as np
import pytest

from benchmarks import cuts
from lbskel.preprocess.holes import find_open_ends


def test_every_tube_is_open_at_two_places():
    for _, mesh, centers in cuts._tubes(1):
        ends = find_open_ends(mesh)[:, :3]
        assert (mesh.n_components, len(ends)) == (1, 2)
        assert np.linalg.norm(ends[:, None] - centers, axis=2).min(axis=0) == pytest.approx([0, 0], abs=0.3)


def test_the_benchmark_counts_what_is_right_with_each_bound(tmp_path, monkeypatch):
    monkeypatch.setattr(cuts, "BOUNDS", {"as they are": {}, "all": {"open_ends.MIN_CUT_SHARE": 1e9}})
    cuts.run(True, tmp_path)
    usual, none = json.loads((tmp_path / "cuts.json").read_text())["bounds"]
    assert (usual["oblique"], usual["flared"]) == ("5/5", "4/4")
    assert usual["ends of trees lost"].startswith("0/")
    assert none["oblique"] in ("0/5", "1/5")  # no cut is an end; one tip lies 0.46 of a radius from its cut
    assert "## Tubes and ends that are right" in (tmp_path / "cuts.md").read_text()


@pytest.mark.parametrize("name", cuts.BOUNDS)
def test_every_bound_is_one_of_the_code(name):
    for target in cuts.BOUNDS[name]:
        module, constant = target.split(".")
        assert hasattr(__import__(f"lbskel.refinement.{module}", fromlist=[constant]), constant)
