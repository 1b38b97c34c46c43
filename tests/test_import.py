"""What ``import lbskel`` brings with it, in a fresh interpreter: nothing heavy and nothing optional."""

import ast
import importlib
import json
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

import lbskel

HEAVY = ["matplotlib", "meshio", "networkx", "plotly", "pymeshlab", "trimesh", "vtk"]

LOADED = "import json, sys; {}; print(json.dumps(sorted(sys.modules)))"


@pytest.fixture(scope="module")
def loaded_by(python):
    """The modules that are there after a line."""

    def run(line):
        result = python("-c", LOADED.format(line))
        assert result.stderr == ""
        return set(json.loads(result.stdout))

    return run


def test_import_brings_no_other_package(loaded_by):
    before, after = loaded_by("pass"), loaded_by("import lbskel")
    packages = {name.split(".")[0] for name in after - before} - set(sys.stdlib_module_names)
    assert packages == {"lbskel"}


def test_a_mesh_needs_little(loaded_by):
    assert not loaded_by("import lbskel; lbskel.Mesh") & {"lbskel.pipeline", "lbskel.contraction", "cvxopt"}


def test_the_whole_pipeline_brings_nothing_heavy(loaded_by):
    loaded = loaded_by("import lbskel; lbskel.skeletonize")
    assert {"lbskel.pipeline.stages", "lbskel.io.swc", "numpy", "scipy.sparse"} <= loaded
    assert not loaded & {*HEAVY, "scipy.optimize"}  # the latter takes a seventh of the time of this import


def test_every_public_name_is_found_where_type_checkers_find_it(python):
    """The imports under TYPE_CHECKING, and what is found at run time, in a fresh interpreter."""
    tree = ast.parse(Path(lbskel.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imports = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    assert sorted(alias.name for node in imports for alias in node.names) == sorted(lbskel.__all__)
    for node in imports:
        module = importlib.import_module(node.module)
        for alias in node.names:
            assert getattr(lbskel, alias.name) is getattr(module, alias.name)
    assert set(lbskel.__all__) <= set(dir(lbskel))
    result = python("-c", "from lbskel import *; import lbskel; print(skeletonize is lbskel.skeletonize)")
    assert (result.stdout, result.stderr) == ("True\n", "")


def test_packages_are_attributes_and_others_are_not(python):
    result = python("-c", "import lbskel; print(lbskel.shapes.torus); lbskel.nosuch")
    assert "torus" in result.stdout
    assert "AttributeError: module 'lbskel' has no attribute 'nosuch'" in result.stderr


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
