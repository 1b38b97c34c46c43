"""SWC: parents before children, cycles broken and restored, files of other programs."""

import re

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.errors import FormatError
from lbskel.io import read_skeleton, write_skeleton


def swc_rows(path):
    """The rows of a file, each with id, type, position, radius and parent; checks the order of the ids."""
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    rows = [(int(i), int(kind), [float(c) for c in xyz], float(r), int(parent)) for i, kind, *xyz, r, parent in lines]
    assert [row[0] for row in rows] == list(range(1, len(rows) + 1))
    assert all(row[4] == -1 or 1 <= row[4] < row[0] for row in rows)
    return rows


def test_a_written_tree_line_by_line(tmp_path, tree):
    write_skeleton(tmp_path / "a.swc", tree)
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


def test_the_given_node_is_the_root_of_its_component(tmp_path, skeleton):
    write_skeleton(tmp_path / "a.swc", skeleton, root=4)
    roots = [row[2] for row in swc_rows(tmp_path / "a.swc") if row[4] == -1]
    assert roots == [skeleton.nodes[node].tolist() for node in (4, 6, 8)]


@pytest.mark.parametrize("root", [-1, 9])
def test_a_root_that_is_not_a_node_is_an_error(tmp_path, skeleton, root):
    with pytest.raises(FormatError, match=f"the root {root} is not a node; the nodes are 0 to 8"):
        write_skeleton(tmp_path / "a.swc", skeleton, root=root)


def test_each_cycle_is_cut_where_it_is_thinnest_and_restored_on_reading(tmp_path, unordered):
    # A ladder: squares 0-1-3-2 and 2-3-5-4, thinnest at nodes 1 and 4; the bridge 5-6 is thinner and must be kept
    nodes = [[0, 0, 0], [1.3, 0, 0], [0, 1, 0], [1.1, 1, 0], [0, 2, 0], [1.2, 2, 0], [50, 2, 0]]
    edges = [[0, 1], [0, 2], [1, 3], [2, 3], [2, 4], [3, 5], [4, 5], [5, 6]]
    radii = [9, 2, 8, 7, 3, 6, 1]
    ladder = Skeleton(nodes, edges, radii)
    write_skeleton(tmp_path / "a.swc", ladder)
    rows = swc_rows(tmp_path / "a.swc")
    node_of_id = {row[0]: nodes.index(row[2]) for row in rows}
    text = (tmp_path / "a.swc").read_text()
    cuts = re.findall(r"^# cut edge (\d+) (\d+)$", text, re.M)
    assert {frozenset(node_of_id[int(end)] for end in cut) for cut in cuts} == {frozenset({0, 1}), frozenset({4, 5})}
    assert "#" not in text[re.search("^1 ", text, re.M).start() :]  # no comment after the first node
    assert [row[3] for row in rows] == [radii[node_of_id[row[0]]] for row in rows]
    assert unordered(read_skeleton(tmp_path / "a.swc")) == unordered(ladder)


def test_a_file_of_another_program(read):
    skeleton = read(
        "a.swc",
        "# ORIGINAL_SOURCE unknown\n# a comment on a cut edge 3 4 that is none\n"
        " 30 3 0 0 2 .5 10 # late\n10 1 0 0 0 1 -1\n20 3 0 0 1 0.75 10 extra\n\n5 2 9 9 9 1 -1\n",
        read_skeleton,
    )
    np.testing.assert_array_equal(skeleton.nodes, [[0, 0, 2], [0, 0, 0], [0, 0, 1], [9, 9, 9]])
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(skeleton.radii, [0.5, 1, 0.75, 1])
    assert skeleton.radius_kind == "inscribed"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "the file is empty"),
        ("# nothing\n", "the skeleton has no nodes"),
        ("Dear reader,\n", "line 1: id, type, x, y, z, radius and parent expected, found 'Dear reader,'"),
        ("1 0 0 0 0 1 -1\n2 0 0 0 1\n", "line 2: id, type"),
        ("1 0 0 0 0 1 -1\n# c\n2 0 0 0 1 1 7\n", "line 3: its parent 7 does not exist"),
        ("1 0 0 0 0 1 -1\n1 0 0 0 1 1 1\n", "line 2: the id 1 occurs twice"),
        ("1.5 0 0 0 0 1 -1\n", "line 1: ids must be whole numbers"),
        ("1 0 0 0 0 1 nan\n", "line 1: parents must be whole numbers"),
        ("1 0 0 0 0 1 -1\n# cut edge 1 3\n", "a cut edge: its node 3 does not exist"),
        ("1 0 0 0 0 1 -1\n2 0 0 nan 0 1 1\n", "nodes 1 of the skeleton have NaN"),
    ],
)
def test_errors_name_the_line(rejects, content, message):
    rejects("a.swc", content, FormatError, message, read_skeleton)
