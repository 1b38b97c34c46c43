"""JSON and NPZ: every field of a skeleton, without NaN in JSON and without pickles in NPZ."""

import json
from dataclasses import fields

import numpy as np
import pytest

from lbskel import Skeleton
from lbskel.errors import FormatError
from lbskel.io import read_skeleton, write_skeleton

PAIR = [[0, 0, 0], [1, 0, 0]]


def test_json_is_strict_json_with_an_entry_for_every_field(tmp_path):
    odd = Skeleton(
        PAIR,
        [[0, 1]],
        [np.nan, 1],
        report={"a": np.float64(0.1), "b": np.arange(2), "c": float("inf"), 4: (np.int64(3), np.bool_(True))},
    )
    write_skeleton(tmp_path / "a.json", odd)

    def refuse(word):
        raise AssertionError(f"{word} is not JSON")

    entries = json.loads((tmp_path / "a.json").read_text(), parse_constant=refuse)
    assert set(entries) == {field.name for field in fields(Skeleton)}
    assert entries["radii"] == [None, 1.0]
    assert entries["report"] == {"a": 0.1, "b": [0, 1], "c": None, "4": [3, True]}
    np.testing.assert_array_equal(read_skeleton(tmp_path / "a.json").radii, [np.nan, 1])


def test_json_needs_only_nodes_and_edges(read):
    skeleton = read("a.json", '{"nodes": [[0, 0, 0], [1, 1, 1]], "edges": [[0, 1]]}', read_skeleton)
    assert np.isnan(skeleton.radii).all()
    assert (len(skeleton.node_of_vertex), skeleton.radius_kind, skeleton.report) == (0, "inscribed", {})


@pytest.mark.parametrize("name", ["json", "npz"])
def test_a_report_that_is_not_json_is_an_error(tmp_path, name):
    with pytest.raises(FormatError, match=r"the report of the skeleton cannot be written as JSON: .*object"):
        write_skeleton(tmp_path / f"a.{name}", Skeleton(PAIR[:1], np.empty((0, 2)), [1], report={"a": object()}))


def test_npz_has_no_pickles_and_the_same_bytes_every_time(tmp_path, skeleton):
    for name in ("a", "b"):
        write_skeleton(tmp_path / f"{name}.npz", skeleton)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    with np.load(tmp_path / "a.npz", allow_pickle=False) as archive:
        np.testing.assert_array_equal(archive["edges"], skeleton.edges)
        assert json.loads(str(archive["report"])) == skeleton.report


def test_npz_with_pickles_is_rejected(tmp_path):
    np.savez(tmp_path / "a.npz", nodes=np.array([[None, 0, 0]], dtype=object), edges=np.empty((0, 2)))
    with pytest.raises(FormatError, match=r"cannot be read as \.npz: ValueError: Object arrays"):
        read_skeleton(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
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
        ("a.json", "[" * 100_000, "cannot be read as .json: RecursionError"),
        ("a.npz", "Dear reader,\n", "not an archive of numpy arrays"),
        ("a.npz", "PK\3\4", "cannot be read as .npz"),
    ],
)
def test_errors_name_the_entry(rejects, name, content, message):
    rejects(name, content, FormatError, message, read_skeleton)
