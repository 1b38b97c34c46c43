"""Interactive pages: their content, determinism, and what is refused."""

from __future__ import annotations

import base64
import json
import re
import sys

import numpy as np
import pytest
from helpers import flat_tube, planar_fork

from lbskel import FormatError, Mesh, MeshError, MissingDependency, PointCloud, Skeleton
from lbskel.visualization import page


def traces(path):
    """The traces of a page, with the numbers that plotly encodes in base64."""
    text = path.read_text()
    start = text.rindex("Plotly.newPlot(")  # plotly's own program, which comes first, may have the words too
    start = text.index("[{", start)
    return json.JSONDecoder().raw_decode(text, start)[0]


def numbers(encoded):
    """An array that plotly wrote as a list or in base64."""
    if isinstance(encoded, dict):
        return np.frombuffer(base64.b64decode(encoded["bdata"]), dtype=encoded["dtype"]).astype(float)
    return np.asarray(encoded, dtype=float)


def test_two_runs_give_the_same_bytes(tmp_path):
    for path in (tmp_path / "a.html", tmp_path / "b.html"):
        page(flat_tube(), planar_fork(), path)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_an_existing_page_is_replaced_only_by_force(tmp_path):
    path = tmp_path / "there"
    path.write_text("old content")
    with pytest.raises(FormatError, match="exists already"):
        page(flat_tube(), None, path)
    assert path.read_text() == "old content"
    page(flat_tube(), None, path, force=True)
    assert path.stat().st_size > 1000
    assert [file.name for file in tmp_path.iterdir()] == ["there"]


def test_without_plotly_the_error_names_the_pip_command(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "plotly.graph_objects", None)
    with pytest.raises(MissingDependency, match=r"plotly.*pip install 'lbskel\[view\]'"):
        page(flat_tube(), None, tmp_path / "tube.html")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "skeleton",
    [
        Skeleton(np.empty((0, 3)), np.empty((0, 2)), []),
        Skeleton([[1, 2, 3]], np.empty((0, 2)), [0.5]),
        Skeleton([[1, 2, 3], [2, 2, 3]], [[0, 1]], [np.nan, np.nan]),
        Skeleton([[1, 2, 3], [2, 2, 3], [2, 3, 3]], [[0, 1], [1, 2]], [0.5, np.nan, 0.5]),
    ],
    ids=["empty", "one node", "no radii", "one radius unknown"],
)
def test_skeletons_with_little_to_draw_have_a_page(tmp_path, skeleton):
    page(None, skeleton, tmp_path / "page.html")
    assert "scatter3d" in (tmp_path / "page.html").read_text()


def test_a_page_needs_no_other_file_and_names_counts_and_radii(tmp_path):
    page(flat_tube(), planar_fork(), tmp_path / "tube.html", title="A tube")
    text = (tmp_path / "tube.html").read_text()
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=", text)
    assert "mesh3d" in text
    assert "3 edges, 0 cycles" in text
    assert "node 1\\u003cbr\\u003e(2, 0, 0)\\u003cbr\\u003einscribed radius 0.5" in text
    assert "3 tips" in text
    assert "A tube" in text
    assert len(text) < 8e6


def test_nothing_to_show_is_refused(tmp_path):
    with pytest.raises(MeshError, match="needs a mesh"):
        page(None, None, tmp_path / "a.html")
    assert not list(tmp_path.iterdir())


def test_coordinates_are_those_of_the_view_divided_by_the_size(tmp_path):
    """The tube of length 4 along x is centered and divided by its half length, wherever it is."""
    for shift in (0.0, 2.0**20):
        V, F = flat_tube().vertices.round(3) + [shift, 0, 0], flat_tube().faces
        nodes = planar_fork().nodes + [shift, 0, 0]
        page(Mesh(V, F), Skeleton(nodes, planar_fork().edges, planar_fork().radii), tmp_path / "a.html", force=True)
        mesh, edges, points = traces(tmp_path / "a.html")[:3]
        np.testing.assert_allclose(numbers(mesh["x"]), (V[:, 0] - shift - 2) / 2, atol=1e-6)
        np.testing.assert_allclose(numbers(mesh["y"]), V[:, 1] / 2, atol=1e-6)
        np.testing.assert_allclose(numbers(points["x"]), (nodes[:, 0] - shift - 2) / 2, atol=1e-6)
        x = numbers(edges["x"]).reshape(-1, 3)
        np.testing.assert_allclose(x[:, :2], (nodes[planar_fork().edges, 0] - shift - 2) / 2, atol=1e-6)
        assert np.isnan(x[:, 2]).all()  # a gap after each edge
        assert f"({nodes[1, 0]:.6g}, 0, 0)" in points["text"][1]  # the label has the caller's coordinates


def test_edges_have_the_mean_radius_of_their_ends_and_tips_are_marked(tmp_path):
    page(None, planar_fork(), tmp_path / "a.html")
    edges, points, tips, junctions = traces(tmp_path / "a.html")
    np.testing.assert_allclose(numbers(edges["line"]["color"]).reshape(-1, 3)[:, 0], [0.35, 0.4, 0.4])
    np.testing.assert_allclose(numbers(points["marker"]["color"]), [0.2, 0.5, 0.3, 0.3])
    assert (tips["name"], junctions["name"]) == ("3 tips", "1 junctions")
    np.testing.assert_allclose(numbers(tips["x"]), numbers(points["x"])[planar_fork().tips])
    np.testing.assert_allclose(numbers(junctions["x"]), numbers(points["x"])[1])


def test_point_clouds_are_shown_as_points(tmp_path):
    page(PointCloud(flat_tube().vertices), None, tmp_path / "a.html")
    (cloud,) = traces(tmp_path / "a.html")
    assert (cloud["type"], cloud["mode"]) == ("scatter3d", "markers")
    assert len(numbers(cloud["x"])) == 578
