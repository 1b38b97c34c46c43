"""Interactive pages: what they contain, determinism, and what is refused."""

import re
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from helpers import LITTLE_SKELETONS, flat_tube, planar_fork, unpacked

from lbskel import FormatError, MeshError, MissingDependency, PointCloud, Skeleton
from lbskel.shapes import torus
from lbskel.visualization import Scene, Table, page, page_content


def text_of(scene):
    return unpacked(page_content(scene))


def layers(text):
    return re.findall(r'data-layer="(\w+)"', text)


def test_two_runs_give_the_same_bytes():
    assert page_content(Scene(flat_tube(), planar_fork())) == page_content(Scene(flat_tube(), planar_fork()))


def test_an_existing_page_is_replaced_only_by_force(tmp_path):
    path = tmp_path / "there"
    path.write_text("old content")
    with pytest.raises(FormatError, match="exists already"):
        page(Scene(flat_tube()), path)
    assert path.read_text() == "old content"
    page(Scene(flat_tube()), path, force=True)
    assert path.read_bytes() == page_content(Scene(flat_tube()))
    assert [file.name for file in tmp_path.iterdir()] == ["there"]


def test_without_plotly_the_error_names_the_pip_command(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "lbskel.visualization.interactive.find_spec", lambda name: None if name == "plotly" else find_spec(name)
    )
    with pytest.raises(MissingDependency, match=r"plotly.*pip install 'lbskel\[view\]'"):
        page(Scene(flat_tube()), tmp_path / "tube.html")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("skeleton", LITTLE_SKELETONS.values(), ids=LITTLE_SKELETONS)
def test_skeletons_with_little_to_draw_have_a_page(skeleton):
    assert "skeleton" in layers(text_of(Scene(skeleton=skeleton)))


def test_a_page_needs_no_other_file_and_is_below_8_mb():
    mesh = torus(1.0, 0.3, 600, 300)  # 360,000 faces
    states = [mesh.vertices * scale for scale in np.linspace(0.9, 0.1, 40)]
    ratios = [scale**2 for scale in np.linspace(0.9, 0.1, 40)]
    parts = np.arange(len(mesh.faces)) % 5
    scene = Scene(
        mesh,
        planar_fork(),
        "A ring",
        parts,
        contracted=mesh,
        positions=states,
        area_ratios=ratios,
        volume_ratios=ratios,
    )
    content = page_content(scene)
    assert len(content) < 8e6
    assert not re.search(rb'<(script|link|img|iframe)[^>]*(src|href)=(?!"data:)', content)
    assert b"The mesh is simplified for display: " in content
    assert b"A mesh of 180,000 vertices and 360,000 faces. Its skeleton has 4 nodes" in content


def test_a_page_of_a_hundred_thousand_nodes_is_below_8_mb():
    """With the columns of a branch table, beside a mesh that is as large as it can be in a page."""
    random = np.random.default_rng(0)
    nodes, thin = random.random((100_000, 3)), 1e-3 * random.random(100_000)
    parents = np.maximum(np.arange(100_000) - random.integers(1, 3, 100_000), 0)
    skeleton = Skeleton(nodes, np.column_stack([np.arange(1, 100_000), parents[1:]]), thin)
    columns = {f"measure {k}": random.random(len(skeleton.branches)) for k in range(18)}
    assert len(page_content(Scene(torus(1.0, 0.3, 300, 150), skeleton, columns=columns))) < 8e6


def test_only_what_there_is_can_be_shown():
    both = layers(text_of(Scene(flat_tube(), planar_fork())))
    assert both == ["mesh", "skeleton", "tips", "junctions", "balls"]
    assert layers(text_of(Scene(PointCloud(flat_tube().vertices)))) == ["mesh"]
    extras = Scene(
        flat_tube(),
        planar_fork(),
        part_of_face=np.zeros(len(flat_tube().faces), dtype=int),
        parts_name="limbs <and> trunk",
        contracted=flat_tube(),
        positions=[flat_tube().vertices / 2],
        area_ratios=[0.25],
        volume_ratios=[0.125],
        off_center=np.array([1]),
        mended=flat_tube().vertices[:3],
    )
    text = text_of(extras)
    assert layers(text) == [*both, "parts", "contracted", "off_center", "mended"]
    assert "limbs &lt;and&gt; trunk" in text
    assert 'max="1"' in text


def test_only_inscribed_balls_are_called_so():
    assert "> inscribed balls<" in text_of(Scene(skeleton=planar_fork()))
    text = text_of(Scene(skeleton=replace(planar_fork(), radius_kind="mean")))
    assert "inscribed balls" not in text
    assert "> balls of mean radii<" in text


@pytest.mark.parametrize("parts_first", [False, True])
def test_parts_are_shown_at_first_where_they_are_what_was_asked_for(parts_first):
    parts = np.zeros(len(flat_tube().faces), dtype=int)
    text = text_of(Scene(flat_tube(), part_of_face=parts, parts_first=parts_first))
    checked = dict(re.findall(r'data-layer="(\w+)"( checked|)>', text))
    assert checked == {"mesh": "" if parts_first else " checked", "parts": " checked" if parts_first else ""}


def test_tables_and_notes_are_on_the_page():
    scene = Scene(
        flat_tube(), notes=["A <note>."], tables=[Table("Score: pass", ["measure", "value"], [["coverage", 0.9]])]
    )
    text = text_of(scene)
    assert "<p>A &lt;note&gt;.</p>" in text
    assert '<th scope="row">coverage</th><td>0.9</td>' in text


def test_nothing_to_show_is_refused(tmp_path):
    with pytest.raises(MeshError, match="needs a mesh"):
        page(Scene(), tmp_path / "a.html")
    assert not list(tmp_path.iterdir())
