"""What notebooks show."""

import html
import io
import re

import numpy as np
import pytest
from helpers import flat_tube, planar_fork, unpacked
from PIL import Image
from scipy.sparse import csc_array

import lbskel
from lbskel import FormatError, MeshError, PointCloud
from lbskel.visualization.notebook import LONGER_SIDE, InlinePage, picture_of


def pixels(png):
    with Image.open(io.BytesIO(png)) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def test_values_are_drawn_side_by_side():
    image = pixels(picture_of([("one", flat_tube()), ("two", planar_fork())]))
    assert image.shape == (LONGER_SIDE, 2 * LONGER_SIDE, 3)
    assert all((half.sum(axis=2) < 700).mean() > 0.01 for half in np.split(image, 2, axis=1))


def test_the_entries_of_a_matrix_are_marked():
    empty, full = (pixels(picture_of([("", csc_array(np.full((9, 9), value)))])) for value in (0, 1))
    assert (full.sum(axis=2) < 600).sum() > 2 * (empty.sum(axis=2) < 600).sum()


@pytest.mark.parametrize("value", [flat_tube(), PointCloud(flat_tube().vertices), planar_fork()])
def test_plot_gives_a_page_in_a_frame_and_in_a_file(value, tmp_path):
    shown = value.plot()
    shown.save(tmp_path / "page.html")
    content = (tmp_path / "page.html").read_text()
    frame = re.fullmatch(r'<iframe srcdoc="([^"]*)"[^>]*></iframe>', shown._repr_html_())
    assert html.unescape(frame[1]) == content
    assert html.escape(repr(value)) in content
    with pytest.raises(FormatError, match="exists already"):
        shown.save(tmp_path / "page.html")


def test_a_contraction_is_plotted_with_its_end_and_its_steps(rod):
    contraction = lbskel.contract(rod)
    text = unpacked(contraction.plot()._content)
    assert 'data-layer="contracted"' in text
    assert f"area {100 * contraction.steps[-1].area_ratio:.3g} %" in text
    assert html.escape(contraction.status.value) in text


def test_a_laplacian_is_plotted_as_curvature(rod, ring):
    laplacian = lbskel.laplacian(rod)
    text = unpacked(laplacian.plot(rod)._content)
    assert re.search('data-layer="field" checked> mean curvature', text)
    assert not re.search('data-layer="mesh" checked', text)
    with pytest.raises(MeshError, match="the operator 152"):
        laplacian.plot(ring)


def test_a_skeleton_is_plotted_in_its_mesh():
    text = unpacked(planar_fork().plot(flat_tube())._content)
    assert 'data-layer="mesh"' in text
    assert 'data-layer="skeleton"' in text
    assert repr(InlinePage(skeleton=planar_fork())).startswith("InlinePage(")


def test_a_mesh_to_plot_may_be_a_pair_of_arrays_or_a_cloud(rod):
    pair, laplacian = (rod.vertices, rod.faces), lbskel.laplacian(rod)
    assert laplacian.plot(pair)._content == laplacian.plot(rod)._content
    tube, fork = flat_tube(), planar_fork()
    assert fork.plot((tube.vertices, tube.faces))._content == fork.plot(tube)._content
    assert fork.plot(PointCloud(tube.vertices))._content != fork.plot(tube)._content
    with pytest.raises(MeshError, match="mesh"):
        fork.plot(3)
