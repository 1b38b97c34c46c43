"""GraphML, with networkx as the other program and without networkx."""

import sys

import numpy as np
import pytest

from lbskel.errors import FormatError, MissingDependency
from lbskel.io import read_skeleton, write_skeleton

NODE_WITHOUT_Y = (
    '<graphml xmlns="http://graphml.graphdrawing.org/xmlns"><key id="x" for="node" attr.name="x" attr.type="double"/>'
    '<graph><node id="n"><data key="x">1</data></node></graph></graphml>'
)


def test_networkx_reads_a_written_skeleton(tmp_path, skeleton):
    networkx = pytest.importorskip("networkx")
    write_skeleton(tmp_path / "a.graphml", skeleton)
    graph = networkx.read_graphml(tmp_path / "a.graphml", node_type=int)
    assert sorted(graph.edges()) == [tuple(edge) for edge in skeleton.edges.tolist()]
    assert graph.nodes[3]["radius"] == skeleton.radii[3]
    assert graph.edges[3, 4]["length"] == skeleton.edge_lengths[4]
    assert graph.graph["radius_kind"] == "mean"


def test_a_directed_graph_with_other_ids_and_no_radii(tmp_path):
    networkx = pytest.importorskip("networkx")
    graph = networkx.DiGraph()
    for name, x in (("b", 1), ("c", 2), ("a", 3)):
        graph.add_node(name, x=x, y=0.5, z=0)
    graph.add_edge("a", "c")
    networkx.write_graphml(graph, tmp_path / "a.graphml")
    skeleton = read_skeleton(tmp_path / "a.graphml")
    np.testing.assert_array_equal(skeleton.nodes, [[1, 0.5, 0], [2, 0.5, 0], [3, 0.5, 0]])
    np.testing.assert_array_equal(skeleton.edges, [[1, 2]])
    assert np.isnan(skeleton.radii).all()


def test_without_networkx_the_error_gives_the_pip_command(tmp_path, tree, monkeypatch):
    pytest.importorskip("networkx")
    write_skeleton(tmp_path / "a.graphml", tree)
    monkeypatch.setitem(sys.modules, "networkx", None)
    with pytest.raises(MissingDependency, match=r"pip install 'lbskel\[graph\]'"):
        read_skeleton(tmp_path / "a.graphml")
    with pytest.raises(MissingDependency, match=r"pip install 'lbskel\[graph\]'"):
        write_skeleton(tmp_path / "b.graphml", tree)
    assert not (tmp_path / "b.graphml").exists()


@pytest.mark.parametrize(
    ("content", "message"),
    [("Dear reader,\n", "cannot be read as .graphml"), (NODE_WITHOUT_Y, "node 'n' lacks x, y or z")],
)
def test_errors_say_what_is_wrong(rejects, content, message):
    pytest.importorskip("networkx")
    rejects("a.graphml", content, FormatError, message, read_skeleton)
