"""Skeletons into files and back: round trips, by hand, with other programs, and every way to go wrong."""

import base64
import csv
import json
import re
import sys
import tracemalloc
import zlib
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lbskel.io
from lbskel import Skeleton
from lbskel.errors import FormatError, MissingDependency
from lbskel.io import FORMATS, read_skeleton, write_skeleton

NODES = np.array(
    [[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 3, 0], [0.5, 3.5, 0], [1.5, 4, 0], [7, 7, 7], [8, 8, 8], [9, 9, 9]]
)
# A triangle 0-1-2 with a tail to the end 5, an edge of its own 6-7, and the node 8 alone
EDGES = [[0, 1], [0, 2], [1, 2], [2, 3], [3, 4], [4, 5], [6, 7]]
MANY = Skeleton(
    NODES / 3,
    EDGES,
    np.arange(9) / 7,
    np.array([8, 0, 3, 3, 5, 1]),
    radius_kind="mean",
    mean_radii=np.arange(9) / 3,
    anchors=np.array([2, 7]),
    report={"stop": "volume", "steps": [1, 2.5, None], "fine": True, "nested": {"a": 0.1}},
)
TREE = Skeleton(NODES[:6], [[0, 2], [1, 2], [2, 3], [3, 4], [4, 5]], [1, 2, 3, 4, 5, 6])


def round_trip(tmp_path, name, skeleton):
    path = tmp_path / f"a.{name}"
    write_skeleton(path, skeleton, cut_cycles=True, force=True)
    return read_skeleton(path)


def as_sets(skeleton):
    """Nodes and edges without the numbers of the nodes."""
    nodes = [tuple(row) for row in np.column_stack([skeleton.nodes, skeleton.radii]).tolist()]
    edges = sorted(tuple(sorted((nodes[start], nodes[end]))) for start, end in skeleton.edges)
    return sorted(nodes), edges


def check_round_trip(back, skeleton, loses):
    assert back.cycle_rank == skeleton.cycle_rank
    assert back.n_components == skeleton.n_components
    if "radii" in loses:
        assert np.isnan(back.radii).all()
        assert len(back.radii) == len(back.nodes)
    if "order" in loses:
        assert as_sets(back) == as_sets(skeleton)
    else:
        np.testing.assert_array_equal(back.nodes, skeleton.nodes)
        np.testing.assert_array_equal(back.edges, skeleton.edges)
        if "radii" not in loses:
            np.testing.assert_array_equal(back.radii, skeleton.radii)
    if "node_of_vertex" in loses:
        assert len(back.node_of_vertex) == 0
    else:
        np.testing.assert_array_equal(back.node_of_vertex, skeleton.node_of_vertex)
    assert back.radius_kind == ("inscribed" if "radius_kind" in loses else skeleton.radius_kind)
    for name in ("mean_radii", "anchors"):
        kept = getattr(back, name)
        np.testing.assert_array_equal(kept, [] if "extras" in loses else getattr(skeleton, name))
    assert back.report == ({} if "report" in loses else skeleton.report)


@pytest.mark.parametrize("name", FORMATS)
def test_round_trip(tmp_path, name):
    check_round_trip(round_trip(tmp_path, name, MANY), MANY, FORMATS[name].loses)
    check_round_trip(round_trip(tmp_path, name, TREE), TREE, FORMATS[name].loses)
    alone = Skeleton([[1, 2, 3]], np.empty((0, 2)), [4])
    check_round_trip(round_trip(tmp_path, name, alone), alone, FORMATS[name].loses)


# Lengths of edges must not overflow, else which edge is the longest is no question; all below is kept, to the last bit
numbers = st.floats(-1e150, 1e150, allow_subnormal=True)


@st.composite
def skeletons(draw):
    k = draw(st.integers(1, 12))
    nodes = draw(st.lists(st.tuples(numbers, numbers, numbers), min_size=k, max_size=k))
    ends = st.integers(0, k - 1)
    edges = draw(st.lists(st.tuples(ends, ends), max_size=20))
    radii = draw(st.lists(st.floats(0, allow_infinity=False), min_size=k, max_size=k))
    return Skeleton(nodes, np.reshape(edges, (-1, 2)), radii, draw(st.lists(ends, max_size=8)))


@pytest.mark.parametrize("name", FORMATS)
@settings(max_examples=30, deadline=None, derandomize=True)
@given(skeleton=skeletons())
def test_round_trip_of_any_graph(tmp_path_factory, name, skeleton):
    back = round_trip(tmp_path_factory.getbasetemp(), name, skeleton)
    check_round_trip(back, skeleton, FORMATS[name].loses)


@pytest.mark.parametrize("name", [name for name in FORMATS if "radii" not in FORMATS[name].loses])
def test_radii_that_are_not_known(tmp_path, name):
    unknown = Skeleton(NODES[:2], [[0, 1]], [np.nan, 2.0])
    back = round_trip(tmp_path, name, unknown)
    np.testing.assert_array_equal(back.radii, [0.0 if name == "swc" else np.nan, 2.0])


def test_the_table_in_the_documentation_is_true():
    documentation = lbskel.io.__doc__
    columns = re.search(r"^skeletons +(.*?) +remarks", documentation, re.M).group(1).split()
    for name, entry in FORMATS.items():
        cells = re.search(rf"^{name} +((?:(?:kept|lost) *){{{len(columns)}}})", documentation, re.M).group(1).split()
        assert {column for column, cell in zip(columns, cells, strict=True) if cell == "lost"} == set(entry.loses)


# SWC


def swc_rows(path):
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return [(int(i), int(kind), [float(c) for c in xyz], float(r), int(parent)) for i, kind, *xyz, r, parent in lines]


def check_swc(path):
    rows = swc_rows(path)
    assert [row[0] for row in rows] == list(range(1, len(rows) + 1))
    assert all(row[4] == -1 or 1 <= row[4] < row[0] for row in rows)
    return rows


def test_swc_by_hand(tmp_path):
    write_skeleton(tmp_path / "a.swc", TREE)
    assert (tmp_path / "a.swc").read_text() == (
        "# radius_kind inscribed\n"
        "# id type x y z radius parent\n"
        "1 6 0.0 0.0 0.0 1.0 -1\n"
        "2 5 0.5 1.0 0.0 3.0 1\n"
        "3 6 1.0 0.0 0.0 2.0 2\n"
        "4 0 0.5 3.0 0.0 4.0 2\n"
        "5 0 0.5 3.5 0.0 5.0 4\n"
        "6 6 1.5 4.0 0.0 6.0 5\n"
    )


def test_swc_starts_at_the_root_asked_for(tmp_path):
    write_skeleton(tmp_path / "a.swc", MANY, cut_cycles=True, root=4)
    rows = check_swc(tmp_path / "a.swc")
    roots = [row[2] for row in rows if row[4] == -1]
    assert roots == [MANY.nodes[node].tolist() for node in (4, 6, 8)]
    for root in (-1, 9):
        with pytest.raises(FormatError, match=f"no node {root} to be the root; the nodes are 0 to 8"):
            write_skeleton(tmp_path / "b.swc", MANY, cut_cycles=True, root=root)


def test_swc_refuses_cycles_unless_told_to_cut_them(tmp_path):
    with pytest.raises(FormatError, match=r"a\.swc: the skeleton has 1 cycles .*cut_cycles=True \(--cut-cycles"):
        write_skeleton(tmp_path / "a.swc", MANY)
    assert not (tmp_path / "a.swc").exists()


def test_swc_cuts_the_longest_edge_of_each_cycle_and_reading_restores_it(tmp_path):
    # A ladder: squares 0-1-3-2 and 2-3-5-4; a bridge 5-6 longer than all, which must stay
    nodes = [[0, 0, 0], [1.3, 0, 0], [0, 1, 0], [1.1, 1, 0], [0, 2, 0], [1.2, 2, 0], [50, 2, 0]]
    edges = [[0, 1], [0, 2], [1, 3], [2, 3], [2, 4], [3, 5], [4, 5], [5, 6]]
    ladder = Skeleton(nodes, edges, np.ones(7))
    write_skeleton(tmp_path / "a.swc", ladder, cut_cycles=True)
    rows = check_swc(tmp_path / "a.swc")
    node_of_id = {row[0]: nodes.index(row[2]) for row in rows}
    cuts = re.findall(r"^# cut edge (\d+) (\d+)$", (tmp_path / "a.swc").read_text(), re.M)
    assert {frozenset(node_of_id[int(end)] for end in cut) for cut in cuts} == {frozenset({0, 1}), frozenset({4, 5})}
    kinds = {node_of_id[row[0]]: row[1] for row in rows}
    assert [kinds[node] for node in range(7)] == [0, 0, 5, 5, 0, 5, 6]  # of the skeleton, not of the tree
    assert as_sets(read_skeleton(tmp_path / "a.swc")) == as_sets(ladder)


def test_swc_of_another_program(tmp_path):
    (tmp_path / "a.swc").write_text(
        "# ORIGINAL_SOURCE unknown\n# a comment on a cut edge 3 4 that is none\n"
        " 30 3 0 0 2 .5 10 # late\n10 1 0 0 0 1 -1\n20 3 0 0 1 0.75 10 extra\n\n5 2 9 9 9 1 -1\n"
    )
    skeleton = read_skeleton(tmp_path / "a.swc")
    np.testing.assert_array_equal(skeleton.nodes, [[0, 0, 2], [0, 0, 0], [0, 0, 1], [9, 9, 9]])
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(skeleton.radii, [0.5, 1, 0.75, 1])


# The other formats, by hand and with other programs


def test_obj_by_hand(tmp_path):
    write_skeleton(tmp_path / "a.obj", TREE)
    lines = (tmp_path / "a.obj").read_text().splitlines()
    assert lines[:2] == ["v 0.0 0.0 0.0", "v 1.0 0.0 0.0"]
    assert sorted(lines[6:]) == ["l 1 3", "l 2 3", "l 3 4 5 6"] or sorted(lines[6:]) == ["l 1 3", "l 2 3", "l 6 5 4 3"]
    (tmp_path / "b.obj").write_text("v 0 0 0\nv 1 0 0\nl -2 -1\nv 2 0 0\nv 3 0 0\nl 2/1 3/2 4/3\nf 1 2 3\n")
    np.testing.assert_array_equal(read_skeleton(tmp_path / "b.obj").edges, [[0, 1], [1, 2], [2, 3]])


def test_ply_is_read_by_trimesh(tmp_path):
    trimesh = pytest.importorskip("trimesh", minversion="5.0")  # before, it took no edges from text
    write_skeleton(tmp_path / "a.ply", MANY)
    raw = trimesh.load(tmp_path / "a.ply").metadata["_ply_raw"]
    np.testing.assert_array_equal(np.ravel(raw["vertex"]["data"]["radius"]), MANY.radii)
    ends = [np.ravel(raw["edge"]["data"][name]) for name in ("vertex1", "vertex2")]
    np.testing.assert_array_equal(np.stack(ends, axis=1), MANY.edges)


def test_binary_ply_without_radii(tmp_path):
    header = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    )
    body = np.arange(9, dtype="<f4").tobytes() + np.array([[0, 1], [1, 2]], dtype="<i4").tobytes()
    (tmp_path / "a.ply").write_bytes(header.encode() + body)
    skeleton = read_skeleton(tmp_path / "a.ply")
    np.testing.assert_array_equal(skeleton.nodes, np.arange(9).reshape(3, 3))
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [1, 2]])
    assert np.isnan(skeleton.radii).all()


def test_json_is_strict_json_of_plain_names(tmp_path):
    odd = Skeleton(
        NODES[:2],
        [[0, 1]],
        [np.nan, 1],
        report={"a": np.float64(0.1), "b": np.arange(2), "c": float("inf"), 4: (np.int64(3), np.bool_(True))},
    )
    write_skeleton(tmp_path / "a.json", odd)

    def refuse(word):
        raise AssertionError(f"{word} is no JSON")

    entries = json.loads((tmp_path / "a.json").read_text(), parse_constant=refuse)
    assert set(entries) == {field.name for field in fields(Skeleton)}
    assert entries["radii"] == [None, 1.0]
    assert entries["report"] == {"a": 0.1, "b": [0, 1], "c": None, "4": [3, True]}
    np.testing.assert_array_equal(read_skeleton(tmp_path / "a.json").radii, [np.nan, 1])
    (tmp_path / "b.json").write_text('{"nodes": [[0, 0, 0], [1, 1, 1]], "edges": [[0, 1]]}')
    assert np.isnan(read_skeleton(tmp_path / "b.json").radii).all()


@pytest.mark.parametrize("name", ["json", "npz"])
def test_a_report_that_cannot_be_written_is_named(tmp_path, name):
    with pytest.raises(FormatError, match=r"the report of the skeleton is not ready for JSON: .*object"):
        write_skeleton(tmp_path / f"a.{name}", Skeleton(NODES[:1], np.empty((0, 2)), [1], report={"a": object()}))


def test_npz_is_an_archive_without_pickles_and_the_same_every_time(tmp_path):
    for name in ("a", "b"):
        write_skeleton(tmp_path / f"{name}.npz", MANY)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    with np.load(tmp_path / "a.npz", allow_pickle=False) as archive:
        np.testing.assert_array_equal(archive["edges"], EDGES)
        assert json.loads(str(archive["report"])) == MANY.report


def test_csv_is_what_a_csv_reader_expects(tmp_path):
    write_skeleton(tmp_path / "hand.csv", TREE)
    with open(tmp_path / "hand.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["radius"]) for row in rows] == [1, 2, 3, 4, 5, 6]
    assert [int(row["id"]) for row in rows] == list(range(6))
    with open(tmp_path / "hand_edges.csv", newline="") as file:
        edges = [(int(row["source"]), int(row["target"])) for row in csv.DictReader(file)]
    np.testing.assert_array_equal(edges, TREE.edges)
    (tmp_path / "hand.csv").unlink()
    with pytest.raises(FormatError, match=r"hand_edges\.csv: exists already"):
        write_skeleton(tmp_path / "hand.csv", TREE)
    assert not (tmp_path / "hand.csv").exists()


def test_csv_of_another_program(tmp_path):
    (tmp_path / "a.csv").write_text('name,radius,z, y,x,id\r\n"one, two",,3,2,1,700\r\nb,0.5,6,5,4,-3\r\n')
    (tmp_path / "a_edges.csv").write_text("target,weight,source\r\n-3,1,700\r\n")
    skeleton = read_skeleton(tmp_path / "a.csv")
    np.testing.assert_array_equal(skeleton.nodes, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(skeleton.radii, [np.nan, 0.5])
    np.testing.assert_array_equal(skeleton.edges, [[0, 1]])


def test_graphml_of_networkx(tmp_path):
    networkx = pytest.importorskip("networkx")
    write_skeleton(tmp_path / "a.graphml", MANY)
    graph = networkx.read_graphml(tmp_path / "a.graphml", node_type=int)
    assert sorted(graph.edges()) == [tuple(edge) for edge in EDGES]
    assert graph.nodes[3]["radius"] == MANY.radii[3]
    assert graph.edges[3, 4]["length"] == MANY.edge_lengths[4]
    other = networkx.DiGraph()
    for name, x in (("b", 1), ("a", 2)):
        other.add_node(name, x=x, y=0.5, z=0)
    other.add_edge("a", "b")
    networkx.write_graphml(other, tmp_path / "b.graphml")
    skeleton = read_skeleton(tmp_path / "b.graphml")
    np.testing.assert_array_equal(skeleton.nodes, [[1, 0.5, 0], [2, 0.5, 0]])
    np.testing.assert_array_equal(skeleton.edges, [[0, 1]])
    assert np.isnan(skeleton.radii).all()


def test_graphml_without_networkx_gives_the_pip_line(tmp_path, monkeypatch):
    write_skeleton(tmp_path / "a.graphml", TREE)
    monkeypatch.setitem(sys.modules, "networkx", None)
    with pytest.raises(MissingDependency, match=r"pip install 'lbskel\[graph\]'"):
        read_skeleton(tmp_path / "a.graphml")
    with pytest.raises(MissingDependency, match=r"pip install 'lbskel\[graph\]'"):
        write_skeleton(tmp_path / "b.graphml", TREE)
    assert not (tmp_path / "b.graphml").exists()


def vtk_reader(path):
    xml = pytest.importorskip("vtkmodules.vtkIOXML")
    reader = xml.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader


def test_vtp_is_read_by_vtk(tmp_path):
    write_skeleton(tmp_path / "a.vtp", MANY)
    data = vtk_reader(tmp_path / "a.vtp").GetOutput()
    from vtkmodules.util.numpy_support import vtk_to_numpy

    np.testing.assert_array_equal(vtk_to_numpy(data.GetPoints().GetData()), MANY.nodes)
    for name in ("radius", "MaximumInscribedSphereRadius"):
        np.testing.assert_array_equal(vtk_to_numpy(data.GetPointData().GetArray(name)), MANY.radii)
    field = data.GetFieldData()
    np.testing.assert_array_equal(vtk_to_numpy(field.GetArray("node_of_vertex")), MANY.node_of_vertex)
    assert field.GetAbstractArray("radius_kind").GetValue(0) == "mean"
    assert data.GetNumberOfVerts() == 1
    offsets, points = (
        vtk_to_numpy(part()) for part in (data.GetLines().GetOffsetsArray, data.GetLines().GetConnectivityArray)
    )
    for path, branch in zip(np.split(points, offsets[1:-1]), MANY.branches, strict=True):
        np.testing.assert_array_equal(path, branch)


@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZMA"])
@pytest.mark.parametrize("header", ["UInt32", "UInt64"])
@pytest.mark.parametrize("order", ["LittleEndian", "BigEndian"])
def test_vtp_of_vtk_in_every_encoding(tmp_path, mode, compressor, header, order):
    write_skeleton(tmp_path / "a.vtp", MANY)
    reader = vtk_reader(tmp_path / "a.vtp")
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    for encoded in (False, True):
        writer = vtkXMLPolyDataWriter()
        writer.SetInputConnection(reader.GetOutputPort())
        getattr(writer, f"SetDataModeTo{mode}")()
        getattr(writer, f"SetCompressorTypeTo{compressor}")()
        getattr(writer, f"SetHeaderTypeTo{header}")()
        getattr(writer, f"SetByteOrderTo{order}")()
        writer.SetEncodeAppendedData(encoded)
        writer.SetBlockSize(64)  # bytes: several blocks, of which the last is not full
        writer.SetFileName(str(tmp_path / "b.vtp"))
        assert writer.Write() == 1
        back = read_skeleton(tmp_path / "b.vtp")
        if mode == "Ascii":  # in which vtk writes 11 digits
            np.testing.assert_allclose(back.nodes, MANY.nodes, rtol=1e-10)
            np.testing.assert_array_equal(back.edges, MANY.edges)
        else:
            check_round_trip(back, MANY, FORMATS["vtp"].loses)


def test_vtp_of_several_pieces_in_single_precision(tmp_path):
    piece = (
        '<Piece NumberOfPoints="2"><Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">'
        "0 0 0 1 1 1</DataArray></Points>{radii}<Lines>"
        '<DataArray type="Int32" Name="connectivity" format="ascii">1 0</DataArray>'
        '<DataArray type="Int32" Name="offsets" format="ascii">2</DataArray></Lines></Piece>'
    )
    named = '<DataArray type="Float32" Name="MaximumInscribedSphereRadius" format="ascii">0.5 0.25</DataArray>'
    pieces = piece.format(radii="") + piece.format(radii=f"<PointData>{named}</PointData>")
    (tmp_path / "a.vtp").write_text(f'<VTKFile type="PolyData"><PolyData>{pieces}</PolyData></VTKFile>')
    skeleton = read_skeleton(tmp_path / "a.vtp")
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [2, 3]])
    np.testing.assert_array_equal(skeleton.radii, [np.nan, np.nan, 0.5, 0.25])


# Every way to go wrong


def vtp(points="0 0 0 1 1 1", connectivity="0 1", offsets="2", **attributes):
    head = "".join(f' {name}="{value}"' for name, value in attributes.items())
    return (
        f'<VTKFile type="PolyData"{head}><PolyData><Piece><Points><DataArray type="Float64" format="ascii">{points}'
        f'</DataArray></Points><Lines><DataArray type="Int64" Name="connectivity" format="ascii">{connectivity}'
        f'</DataArray><DataArray type="Int64" Name="offsets" format="ascii">{offsets}</DataArray></Lines></Piece>'
        "</PolyData></VTKFile>"
    )


PLY = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
PLY_EDGE = "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0\n1 1 1\n"
GRAPHML = (
    '<graphml xmlns="http://graphml.graphdrawing.org/xmlns"><key id="x" for="node" attr.name="x" attr.type="double"/>'
    '<graph><node id="n"><data key="x">1</data></node></graph></graphml>'
)

WRONG = [
    ("a.swc", "", "the file is empty"),
    ("a.swc", "# nothing\n", "the skeleton has no nodes"),
    ("a.swc", "Dear reader,\n", "line 1: id, type, x, y, z, radius and parent expected, found 'Dear reader,'"),
    ("a.swc", "1 0 0 0 0 1 -1\n2 0 0 0 1\n", "line 2: id, type"),
    ("a.swc", "1 0 0 0 0 1 -1\n# c\n2 0 0 0 1 1 7\n", "line 3: its parent 7 does not exist"),
    ("a.swc", "1 0 0 0 0 1 -1\n1 0 0 0 1 1 1\n", "line 2: the id 1 was given before"),
    ("a.swc", "1.5 0 0 0 0 1 -1\n", "line 1: ids must be whole numbers"),
    ("a.swc", "1 0 0 0 0 1 nan\n", "line 1: parents must be whole numbers"),
    ("a.swc", "1 0 0 0 0 1 -1\n# cut edge 1 3\n", "a cut edge: its node 3 does not exist"),
    ("a.swc", "1 0 0 0 0 1 -1\n2 0 0 nan 0 1 1\n", "nodes 1 of the skeleton have NaN"),
    ("a.obj", "l 1 2\n", "no line begins with v"),
    ("a.obj", "v 0 0 0\nv 1 1 1\nl 1 3\n", "name a node outside 0..1"),
    ("a.obj", "v 0 0 0\nv 1 1 1\nl 0 1\n", "name a node outside 0..1"),
    ("a.obj", "v 0 0 0\nv 1 1 1\nl 1 two\n", "line 3: 2 vertex indices expected"),
    ("a.obj", "v 0 0 0\nv 1 1 1\nv 2 2 0\nf 1 2 3\n", "a mesh and no skeleton"),
    ("a.ply", "Dear reader,\n", "it must begin with ply"),
    ("a.ply", PLY + PLY_EDGE + "0 2\n", "name a node outside 0..1"),
    ("a.ply", PLY + PLY_EDGE + "0 1.5\n", "edges must be whole numbers"),
    ("a.ply", PLY + PLY_EDGE.replace("vertex2", "end") + "0 1\n", "properties vertex1, vertex2"),
    ("a.ply", PLY + PLY_EDGE, "element edge of 1: more is promised"),
    ("a.ply", PLY.replace("2", "0") + "end_header\n", "no nodes"),
    (
        "a.ply",
        PLY + "element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 1 1",
        "a mesh and no skeleton",
    ),
    ("a.graphml", "Dear reader,\n", "not readable as .graphml"),
    ("a.graphml", GRAPHML, "node 'n' lacks x, y or z"),
    ("a.json", "{\n  nodes\n", "line 2: not JSON"),
    ("a.json", "[]", "no entries named nodes and edges"),
    ("a.json", '{"nodes": [[0, 0, 0]]}', "no entries named nodes and edges"),
    ("a.json", '{"nodes": [], "edges": []}', "no nodes"),
    ("a.json", '{"nodes": [[0, 0]], "edges": []}', r"nodes: the shape must be \(n, 3\), not \(1, 2\)"),
    ("a.json", '{"nodes": [0, 0, 0], "edges": []}', r"nodes: the shape must be \(n, 3\), not \(3,\)"),
    ("a.json", '{"nodes": [[0, 0, "x"]], "edges": []}', "nodes: not an array of numbers"),
    ("a.json", '{"nodes": [[0, 0, 0], [0]], "edges": []}', "nodes: not an array of numbers"),
    ("a.json", '{"nodes": [[0, 0, null]], "edges": []}', "nodes 0 of the skeleton have NaN"),
    ("a.json", '{"nodes": [[0, 0, 1' + "0" * 400 + ']], "edges": []}', "nodes: not an array of numbers"),
    ("a.json", '{"nodes": [[0, 0, 0]], "edges": [[0, 1]]}', "name a node outside 0..0"),
    ("a.json", '{"nodes": [[0, 0, 0]], "edges": [[0, 0.5]]}', "row 0: edges must be whole numbers"),
    ("a.json", '{"nodes": [[0, 0, 0]], "edges": [], "radii": [1, 2]}', "as many radii, not 2"),
    (
        "a.json",
        '{"nodes": [[0, 0, 0]], "edges": [], "node_of_vertex": [1]}',
        "node_of_vertex of the skeleton name a node",
    ),
    ("a.json", '{"nodes": [[0, 0, 0]], "edges": [], "radius_kind": 1}', "radius_kind: must be a str, not int"),
    ("a.json", '{"nodes": [[0, 0, 0]], "edges": [], "report": []}', "report: must be a dict, not list"),
    ("a.json", "[" * 100_000, "not readable as .json: RecursionError"),
    ("a.npz", "Dear reader,\n", "not an archive of numpy arrays"),
    ("a.npz", "PK\3\4", "not readable as .npz"),
    ("a.csv", "Dear reader,\n", "line 1: must name the columns id,x,y,z,radius"),
    ("a.csv", "id,x,y,z,radius\n0,0,0,0,1\n1,0,,0,1\n", "line 3: numbers expected for id,x,y,z,radius"),
    ("a.csv", "id,x,y,z,radius\n0,0,0\n", "line 2: numbers expected"),
    ("a.csv", "id,x,y,z,radius\n0,0,0,0,1\n0,0,0,0,1\n", "line 3: the id 0 was given before"),
    ("a.csv", "id,x,y,z,radius\n0,0,0,0,1\n", r"its edges, .*a_edges\.csv: no such file"),
    ("a.vtp", "Dear reader,\n", "not XML"),
    ("a.vtp", "<VTKFile/>", "not a VTP file"),
    ("a.vtp", vtp(points="0 0 0 1"), "no three coordinates"),
    ("a.vtp", vtp(points="0 0 zero"), "not readable as .vtp"),
    ("a.vtp", vtp(connectivity="0 2"), r"a line names a point outside 0\.\.1"),
    ("a.vtp", vtp(connectivity="0 -1"), r"a line names a point outside 0\.\.1"),
    ("a.vtp", vtp(offsets="1"), "the ends of the lines do not fit"),
    ("a.vtp", vtp(offsets="3 2"), "the ends of the lines do not fit"),
    ("a.vtp", vtp().replace('"Float64"', '"Float128"'), "unknown type of array 'Float128'"),
    ("a.vtp", vtp().replace('"ascii"', '"morse"', 1), "unknown format 'morse'"),
    (
        "a.vtp",
        vtp(compressor="vtkLZ4DataCompressor").replace('"ascii">0 0 0', '"binary">'),
        "unknown compressor 'vtkLZ4",
    ),
    (
        "a.vtp",
        vtp(header_type="UInt64").replace('"ascii">0 0 0 1 1 1', '"binary">////fwAAAAA='),
        "2147483655 bytes is promised",
    ),
]


@pytest.mark.parametrize(("name", "content", "message"), WRONG)
def test_says_what_is_wrong_and_where(tmp_path, name, content, message):
    (tmp_path / name).write_text(content)
    with pytest.raises(FormatError, match=message) as raised:
        read_skeleton(tmp_path / name)
    assert str(raised.value).startswith(str(tmp_path / name))


def test_a_block_of_vtp_that_inflates_to_more_than_it_says_is_cut(tmp_path):
    block = zlib.compress(np.array([[0, 0, 0], [1, 1, 1]], dtype="<f8").tobytes() + bytes(30_000_000))
    head = np.array([1, 48, 48, len(block)], dtype="<u4").tobytes()
    text = vtp(compressor="vtkZLibDataCompressor").replace(
        '"ascii">0 0 0 1 1 1', f'"binary">{base64.b64encode(head).decode()}{base64.b64encode(block).decode()}'
    )
    (tmp_path / "a.vtp").write_text(text)
    tracemalloc.start()
    try:
        skeleton = read_skeleton(tmp_path / "a.vtp")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(skeleton.nodes, [[0, 0, 0], [1, 1, 1]])
    assert peak < 2_000_000  # bytes; the file has about 40,000 and would become 30 million


def test_the_edges_of_a_csv_are_checked_too(tmp_path):
    (tmp_path / "a.csv").write_text("id,x,y,z,radius\n4,0,0,0,1\n")
    for text, message in (
        ("source,target\n4,5\n", "line 2: there is no node with the id 5"),
        ("source,target\n4,x\n", "line 2: numbers expected for source,target"),
        ("source,target\n4,4.5\n", "line 2: edges must be whole numbers"),
        ("from,to\n4,4\n", "line 1: must name the columns source,target"),
    ):
        (tmp_path / "a_edges.csv").write_text(text)
        with pytest.raises(FormatError, match=rf"a\.csv: its edges, .*a_edges\.csv: {message}"):
            read_skeleton(tmp_path / "a.csv")


def test_an_archive_with_pickles_is_refused(tmp_path):
    np.savez(tmp_path / "a.npz", nodes=np.array([[None, 0, 0]], dtype=object), edges=np.empty((0, 2)))
    with pytest.raises(FormatError, match=r"not readable as \.npz: ValueError: Object arrays"):
        read_skeleton(tmp_path / "a.npz")


@pytest.mark.parametrize("name", FORMATS)
def test_names_that_are_no_skeleton_files(tmp_path, name):
    with pytest.raises(FormatError, match="no such file"):
        read_skeleton(tmp_path / f"a.{name}")
    (tmp_path / f"folder.{name}").mkdir()
    with pytest.raises(FormatError, match="is a folder"):
        read_skeleton(tmp_path / f"folder.{name}")
    with pytest.raises(FormatError, match="is a folder"):
        write_skeleton(tmp_path / f"folder.{name}", TREE, force=True)
    with pytest.raises(FormatError, match="does not exist; create it first"):
        write_skeleton(tmp_path / "missing" / f"a.{name}", TREE)
    write_skeleton(tmp_path / f"a.{name}", TREE)
    with pytest.raises(FormatError, match="exists already"):
        write_skeleton(tmp_path / f"a.{name}", MANY, cut_cycles=True)
    assert len(read_skeleton(tmp_path / f"a.{name}").nodes) == 6
    write_skeleton(tmp_path / f"a.{name}", MANY, cut_cycles=True, force=True)
    assert len(read_skeleton(tmp_path / f"a.{name}").nodes) == 9


def test_unknown_extensions_list_the_known_ones(tmp_path):
    known = "known for skeletons: swc, json, npz, ply, vtp, graphml, csv, obj"
    with pytest.raises(FormatError, match=f"unknown extension 'stl'; {known}"):
        write_skeleton(tmp_path / "a.stl", TREE)
    with pytest.raises(FormatError, match=f"no extension; {known}"):
        read_skeleton(tmp_path / "a")


@pytest.mark.parametrize("name", FORMATS)
def test_skeletons_without_nodes_or_with_nowhere_are_not_written(tmp_path, name):
    with pytest.raises(FormatError, match="the skeleton has no nodes"):
        write_skeleton(tmp_path / f"a.{name}", Skeleton(np.empty((0, 3)), np.empty((0, 2)), []))
    with pytest.raises(FormatError, match="nodes 1 of the skeleton have NaN"):
        write_skeleton(tmp_path / f"a.{name}", Skeleton([[0, 0, 0], [0, np.inf, 0]], [[0, 1]], [1, 1]))
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_printed(tmp_path, capfd):
    for name in FORMATS:
        round_trip(tmp_path, name, MANY)
    for name, content, _ in WRONG:
        (tmp_path / name).write_text(content)
        (tmp_path / "a_edges.csv").unlink(missing_ok=True)
        with pytest.raises(FormatError):
            read_skeleton(tmp_path / name)
    assert capfd.readouterr() == ("", "")
