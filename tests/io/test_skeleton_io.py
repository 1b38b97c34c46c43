"""Reading and writing skeletons: round trips in all formats, and the table of what each format loses."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lbskel.io
from lbskel import Skeleton
from lbskel.errors import FormatError
from lbskel.io import FORMATS, read_skeleton, write_skeleton

PAIR = [[0, 0, 0], [1, 0, 0]]


def round_trip(folder, name, skeleton):
    path = folder / f"a.{name}"
    write_skeleton(path, skeleton, force=True)
    return read_skeleton(path)


@pytest.mark.parametrize("name", FORMATS)
def test_round_trip(tmp_path, capfd, check_round_trip, skeleton, tree, name):
    for given_skeleton in (skeleton, tree, Skeleton([[1, 2, 3]], np.empty((0, 2)), [4])):
        check_round_trip(round_trip(tmp_path, name, given_skeleton), given_skeleton, FORMATS[name].loses)
    assert capfd.readouterr() == ("", "")


# Lengths of edges must not overflow, or the longest edge is undefined; smaller numbers are all kept to the last bit
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
@settings(max_examples=30)
@given(drawn=skeletons())
def test_round_trip_of_any_graph(tmp_path_factory, check_round_trip, name, drawn):
    check_round_trip(round_trip(tmp_path_factory.getbasetemp(), name, drawn), drawn, FORMATS[name].loses)


@pytest.mark.parametrize("name", [name for name in FORMATS if "radii" not in FORMATS[name].loses])
def test_unknown_radii(tmp_path, name):
    back = round_trip(tmp_path, name, Skeleton(PAIR, [[0, 1]], [np.nan, 2.0]))
    np.testing.assert_array_equal(back.radii, [0.0 if name == "swc" else np.nan, 2.0])


def test_the_table_in_the_documentation_matches_the_formats():
    documentation = lbskel.io.__doc__
    columns = re.search(r"^skeletons +(.*?) +remarks", documentation, re.M).group(1).split()
    for name, entry in FORMATS.items():
        cells = re.search(rf"^{name} +((?:(?:kept|lost) *){{{len(columns)}}})", documentation, re.M).group(1).split()
        assert {column for column, cell in zip(columns, cells, strict=True) if cell == "lost"} == set(entry.loses)


@pytest.mark.parametrize("name", FORMATS)
def test_paths_that_cannot_be_read_or_written(tmp_path, skeleton, tree, name):
    with pytest.raises(FormatError, match="no such file"):
        read_skeleton(tmp_path / f"a.{name}")
    (tmp_path / f"folder.{name}").mkdir()
    with pytest.raises(FormatError, match="is a folder"):
        read_skeleton(tmp_path / f"folder.{name}")
    with pytest.raises(FormatError, match="is a folder"):
        write_skeleton(tmp_path / f"folder.{name}", tree, force=True)
    with pytest.raises(FormatError, match="does not exist; create it first"):
        write_skeleton(tmp_path / "missing" / f"a.{name}", tree)
    write_skeleton(tmp_path / f"a.{name}", tree)
    with pytest.raises(FormatError, match="exists already"):
        write_skeleton(tmp_path / f"a.{name}", skeleton)
    assert len(read_skeleton(tmp_path / f"a.{name}").nodes) == 6
    write_skeleton(tmp_path / f"a.{name}", skeleton, force=True)
    assert len(read_skeleton(tmp_path / f"a.{name}").nodes) == 9


def test_unknown_extensions_list_the_known_ones(tmp_path, tree):
    known = "known for skeletons: swc, json, npz, ply, vtp, graphml, csv, obj"
    with pytest.raises(FormatError, match=f"unknown extension 'stl'; {known}"):
        write_skeleton(tmp_path / "a.stl", tree)
    with pytest.raises(FormatError, match=f"no extension; {known}"):
        read_skeleton(tmp_path / "a")


@pytest.mark.parametrize("name", FORMATS)
def test_skeletons_without_nodes_are_not_written(tmp_path, name):
    with pytest.raises(FormatError, match="the skeleton has no nodes"):
        write_skeleton(tmp_path / f"a.{name}", Skeleton(np.empty((0, 3)), np.empty((0, 2)), []))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("root", [1.5, True, 2, -1])
def test_a_root_of_swc_is_a_node(tmp_path, root):
    with pytest.raises(FormatError, match=rf"the root {root} is not a node; the nodes are 0 to 1"):
        write_skeleton(tmp_path / "a.swc", Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1, 1]), root=root)
    assert not any(tmp_path.iterdir())


def test_a_root_is_for_swc(tmp_path):
    with pytest.raises(FormatError, match="a root is for swc"):
        write_skeleton(tmp_path / "a.json", Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1, 1]), root=1)
