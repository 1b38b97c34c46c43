"""What ``import lbskel`` brings with it, in a fresh interpreter: nothing heavy and nothing optional."""

import json
from importlib.metadata import version

import pytest

import lbskel

HEAVY = ["matplotlib", "meshio", "networkx", "plotly", "pymeshlab", "trimesh", "vtk"]

LOADED = "import json, sys; {}; print(json.dumps(sorted(sys.modules)))"


@pytest.fixture(scope="module")
def loaded(python):
    """The modules that are there after ``import lbskel``."""
    result = python("-c", LOADED.format("import lbskel"))
    assert result.stderr == ""
    return set(json.loads(result.stdout))


def test_the_probe_sees_what_is_imported(loaded):
    assert {"lbskel.pipeline.stages", "lbskel.io.swc", "numpy", "scipy.sparse"} <= loaded


@pytest.mark.parametrize("name", HEAVY)
def test_import_does_not_bring(name, loaded):
    assert name not in loaded


def test_a_skeleton_needs_nothing_optional(python, tmp_path):
    """Every package outside the plain dependencies is hidden; a mesh from arrays becomes a skeleton in a file."""
    code = f"""
import sys
for name in {[name for name in HEAVY if name != "trimesh"]!r}:
    sys.modules[name] = None
import lbskel
from lbskel.shapes import torus
skeleton = lbskel.skeletonize(torus(1.0, 0.25, 16, 8))
lbskel.write_skeleton(sys.argv[1], skeleton)
print(lbskel.read_skeleton(sys.argv[1]).cycle_rank)
"""
    result = python("-c", code, tmp_path / "ring.json")
    assert (result.stdout, result.stderr) == ("1\n", "")


def test_the_version_is_the_one_installed():
    assert lbskel.__version__ == version("lbskel")
