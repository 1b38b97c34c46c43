"""The adapter of pymeshlab: remeshing, what is kept of creases, and its import when it is used."""

import ast
import sys
from pathlib import Path

import igl
import numpy as np
import pytest
from helpers import box_mesh

import lbskel
from lbskel import Mesh, MissingDependency
from lbskel.preprocess.pymeshlab_adapter import FILTERS, remesh_isotropic
from lbskel.shapes import sphere


def test_edges_get_the_target_length():
    pytest.importorskip("pymeshlab")
    ball = sphere(3)
    V, F = remesh_isotropic(ball.vertices, ball.faces, target_length=0.3, feature_angle=180.0)
    mesh = Mesh(V, F)
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    assert np.linalg.norm(end - start, axis=1).mean() == pytest.approx(0.3, rel=0.1)
    assert mesh.genus == 0


def test_sharp_edges_are_kept_only_up_to_the_feature_angle():
    pytest.importorskip("pymeshlab")
    box = box_mesh([1, 1, 1])
    fine = igl.upsample(box.vertices, box.faces, 4)
    kept, rounded = (remesh_isotropic(*fine, target_length=0.1, feature_angle=angle)[0] for angle in (30.0, 180.0))

    def largest_distance_of_a_corner(vertices):
        return np.linalg.norm(vertices[:, None] - box.vertices, axis=2).min(axis=0).max()

    assert largest_distance_of_a_corner(kept) == 0.0
    assert largest_distance_of_a_corner(rounded) > 0.05  # half an edge


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymeshlab", None)
    ball = sphere(1)
    with pytest.raises(MissingDependency, match="pymeshlab"):
        FILTERS["remesh_isotropic"](ball.vertices, ball.faces, target_length=0.3)


def test_no_other_module_imports_pymeshlab():
    importers = set()
    for path in Path(lbskel.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) else []
            if any(name and name.split(".")[0] == "pymeshlab" for name in names):
                importers.add(path.name)
    assert importers == {"pymeshlab_adapter.py"}
