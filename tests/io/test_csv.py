"""CSV: two files, of nodes and of edges."""

import csv

import numpy as np
import pytest

from lbskel.errors import FormatError
from lbskel.io import read_skeleton, write_skeleton


def test_a_csv_reader_reads_both_files(tmp_path, tree):
    write_skeleton(tmp_path / "hand.csv", tree)
    with open(tmp_path / "hand.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["radius"]) for row in rows] == [1, 2, 3, 4, 5, 6]
    assert [int(row["id"]) for row in rows] == list(range(6))
    with open(tmp_path / "hand_edges.csv", newline="") as file:
        edges = [(int(row["source"]), int(row["target"])) for row in csv.DictReader(file)]
    np.testing.assert_array_equal(edges, tree.edges)


def test_an_existing_file_of_edges_is_not_replaced(tmp_path, tree):
    (tmp_path / "hand_edges.csv").write_text("mine")
    with pytest.raises(FormatError, match=r"hand_edges\.csv: exists already"):
        write_skeleton(tmp_path / "hand.csv", tree)
    assert not (tmp_path / "hand.csv").exists()
    assert (tmp_path / "hand_edges.csv").read_text() == "mine"


def test_columns_in_any_order_and_ids_of_any_value(tmp_path):
    (tmp_path / "a.csv").write_text('name,radius,z, y,x,id\r\n"one, two",,3,2,1,700\r\nb,0.5,6,5,4,-3\r\n')
    (tmp_path / "a_edges.csv").write_text("target,weight,source\r\n-3,1,700\r\n")
    skeleton = read_skeleton(tmp_path / "a.csv")
    np.testing.assert_array_equal(skeleton.nodes, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(skeleton.radii, [np.nan, 0.5])
    np.testing.assert_array_equal(skeleton.edges, [[0, 1]])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("Dear reader,\n", "line 1: must name the columns id,x,y,z,radius"),
        ("id,x,y,z,radius\n0,0,0,0,1\n1,0,,0,1\n", "line 3: numbers expected for id,x,y,z,radius"),
        ("id,x,y,z,radius\n0,0,0\n", "line 2: numbers expected"),
        ("id,x,y,z,radius\n0,0,0,0,1\n0,0,0,0,1\n", "line 3: the id 0 occurs twice"),
        ("id,x,y,z,radius\n0,0,0,0,1\n", r"its edges, .*a_edges\.csv: no such file"),
    ],
)
def test_errors_of_the_nodes_name_the_line(rejects, content, message):
    rejects("a.csv", content, FormatError, message, read_skeleton)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("source,target\n4,5\n", "line 2: there is no node with the id 5"),
        ("source,target\n4,x\n", "line 2: numbers expected for source,target"),
        ("source,target\n4,4.5\n", "line 2: edges must be whole numbers"),
        ("from,to\n4,4\n", "line 1: must name the columns source,target"),
    ],
)
def test_errors_of_the_edges_name_their_file_and_line(tmp_path, rejects, text, message):
    (tmp_path / "a_edges.csv").write_text(text)
    content = "id,x,y,z,radius\n4,0,0,0,1\n"
    rejects("a.csv", content, FormatError, rf"its edges, .*a_edges\.csv: {message}", read_skeleton)
