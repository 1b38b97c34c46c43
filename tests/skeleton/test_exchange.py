"""Skeletons as objects of other packages."""

import sys
from itertools import pairwise

import numpy as np
import pytest
from helpers import planar_fork

from lbskel import MissingDependency, Skeleton


def theta():
    """Two junctions that three branches join, a limb, a ring, and a lone node."""
    nodes = np.random.default_rng(0).random((10, 3))
    edges = [[0, 2], [2, 1], [0, 3], [3, 1], [0, 1], [1, 4], [5, 6], [6, 7], [7, 5]]
    return Skeleton(nodes, edges, np.arange(10) / 10)


def test_every_edge_has_the_branch_that_contains_it():
    skeleton = theta()
    found = skeleton.branch_of_edge()
    for edge, number in zip(skeleton.edges.tolist(), found, strict=True):
        path = skeleton.branches[number].tolist()
        assert any(sorted(pair) == edge for pair in pairwise(path))
    assert len(Skeleton([[0, 0, 0]], np.empty((0, 2)), [1]).branch_of_edge()) == 0


def test_networkx_has_attributes_of_nodes_and_edges():
    graph = Skeleton([[0, 0, 0], [3, 4, 0], [9, 9, 9]], [[1, 0]], [0.5, 0.25, 1]).to_networkx()
    assert dict(graph.nodes(data=True)) == {
        0: {"pos": (0.0, 0.0, 0.0), "radius": 0.5},
        1: {"pos": (3.0, 4.0, 0.0), "radius": 0.25},
        2: {"pos": (9.0, 9.0, 9.0), "radius": 1.0},
    }
    assert list(graph.edges(data=True)) == [(0, 1, {"length": 5.0, "radius": 0.375, "branch": 0})]
    kinds = {type(value) for _, data in graph.nodes(data=True) for value in (*data["pos"], data["radius"])}
    assert kinds == {float}
    assert {type(data["branch"]) for *_, data in graph.edges(data=True)} == {int}


def test_the_radius_of_an_edge_does_not_overflow():
    graph = Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1.6e308, 1.6e308]).to_networkx()
    assert graph.edges[0, 1]["radius"] == 1.6e308


def test_pandas_has_a_row_for_each_node():
    skeleton = planar_fork()
    table = skeleton.to_pandas()
    assert table.index.name == "node"
    assert np.array_equal(table[["x", "y", "z"]], skeleton.nodes)
    assert np.array_equal(table["radius"], skeleton.radii)
    assert (table["degree"] == 3).sum() == 1
    assert set(table.loc[table["degree"] != 3, "branch"]) == {0, 1, 2}
    assert set(table.loc[table["degree"] == 3, "branch"]) == {-1}
    assert theta().to_pandas()["component"].nunique() == 4


def test_trimesh_has_the_branches_as_lines():
    skeleton = theta()
    path = skeleton.to_trimesh()
    assert len(path.entities) == len(skeleton.branches)
    assert path.length == pytest.approx(skeleton.length)


def test_pyvista_has_the_branches_as_lines():
    pytest.importorskip("pyvista", reason="pip install pyvista")
    skeleton = theta()
    data = skeleton.to_pyvista()
    assert data.n_lines == len(skeleton.branches)
    assert data.compute_cell_sizes(area=False, volume=False)["Length"].sum() == pytest.approx(skeleton.length)
    assert np.array_equal(data.point_data["radius"], skeleton.radii)
    assert np.array_equal(data.points, skeleton.nodes)


@pytest.mark.parametrize(
    ("package", "method", "extra"),
    [("networkx", "to_networkx", "graph"), ("pandas", "to_pandas", "tables"), ("pyvista", "to_pyvista", "pyvista")],
)
def test_a_missing_package_is_reported(monkeypatch, package, method, extra):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingDependency, match=rf"{method}\(\) needs {package}.*pip install 'lbskel\[{extra}\]'"):
        getattr(planar_fork(), method)()
