"""Commands on point clouds: check, score, compare, preprocess, each with a file of points."""

import json

import numpy as np
import pytest

from lbskel import read_points
from lbskel.cli.main import main
from lbskel.io import POINT_READERS, POINT_WRITERS
from lbskel.shapes import torus


@pytest.fixture(scope="module")
def cloud(tmp_path_factory):
    path = tmp_path_factory.mktemp("clouds") / "ring.xyz"
    np.savetxt(path, torus(1.0, 0.3, 60, 20).vertices)
    return path


def test_a_cloud_is_checked(cloud, capsys):
    assert main(["check", str(cloud), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["points"] == 1200


def test_a_plane_is_advised_against(tmp_path, capsys):
    np.savetxt(tmp_path / "flat.xyz", np.random.default_rng(0).random((50, 3)) * [1, 1, 0])
    assert main(["check", str(tmp_path / "flat.xyz")]) == 1
    assert "in a plane" in capsys.readouterr().out


def test_a_skeleton_is_scored_on_its_cloud_and_drawn(cloud, tmp_path, capsys):
    out = str(tmp_path / "ring.json")
    assert main(["skeletonize", str(cloud), "-o", out, "--picture", str(tmp_path / "ring.png"), "--quiet"]) == 0
    assert (tmp_path / "ring.png").stat().st_size > 5000
    assert main(["score", out, str(cloud)]) == 0
    assert "extra cycles" in capsys.readouterr().out.splitlines()[-2]


@pytest.mark.parametrize("extension", POINT_WRITERS)
def test_a_cloud_is_thinned_with_its_map(cloud, tmp_path, extension):
    assert extension in POINT_READERS
    out, map_file = tmp_path / f"thin.{extension}", tmp_path / "map.npy"
    given = ["preprocess", str(cloud), "-o", str(out), "--preprocess", "voxel:cell=0.3", "--map", str(map_file)]
    assert main(given) == 0
    thin, to_thin = read_points(out).points, np.load(map_file)
    assert np.linalg.norm(thin[to_thin] - read_points(cloud).points, axis=1).max() < 0.3 * np.sqrt(3)


def test_a_surface_is_no_thinner_cloud(cloud, tmp_path, capsys):
    assert main(["preprocess", str(cloud), "-o", str(tmp_path / "a.stl"), "--preprocess", "voxel:cell=0.3"]) == 2
    assert ".ply, .xyz, .npy" in capsys.readouterr().err
