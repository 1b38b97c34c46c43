"""Pictures as PNG: size, shared view and scale, determinism, and what is refused."""

from __future__ import annotations

import subprocess
import sys
import warnings

import numpy as np
import pytest
from helpers import flat_tube, planar_fork, png_pixels

from lbskel import FormatError, Mesh, MeshError, MissingDependency, PointCloud
from lbskel.visualization import Panel, draw, picture, render


def box_of_surface(image):
    """First and last column and row with the bluish gray of a surface."""
    rows, columns = np.nonzero((image[:, :, 2] - image[:, :, 0] > 20) & (image.sum(axis=2) > 250))
    return columns.min(), columns.max(), rows.min(), rows.max()


def test_picture_is_a_png_of_the_given_size(tmp_path):
    picture(flat_tube(), planar_fork(), tmp_path / "tube.png", title="a tube", size=(500, 300))
    content = (tmp_path / "tube.png").read_bytes()
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    image = png_pixels(content)
    assert image.shape == (300, 500, 3)
    assert (image[0, 0] == 255).all()
    assert 0.05 < (image.min(axis=2) < 250).mean() < 0.6


def test_two_runs_give_the_same_bytes():
    mesh, field = flat_tube(), flat_tube().vertices[:, 0]
    panels = [Panel(mesh, planar_fork(), "one"), Panel(mesh, None, "two", field, "x"), Panel(PointCloud(mesh.vertices))]
    first, second = draw(panels), draw(panels)
    assert first == second
    assert b"Software" not in first


def test_an_existing_picture_is_replaced_only_by_force(tmp_path):
    path = tmp_path / "there"
    path.write_text("old content")
    with pytest.raises(FormatError, match="exists already"):
        picture(flat_tube(), None, path)
    assert path.read_text() == "old content"
    picture(flat_tube(), None, path, force=True)
    assert path.stat().st_size > 1000
    assert [file.name for file in tmp_path.iterdir()] == ["there"]


def test_without_matplotlib_the_error_names_the_pip_command(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingDependency, match=r"matplotlib.*pip install 'lbskel\[view\]'"):
        render([Panel(flat_tube())], tmp_path / "tube.png")
    assert not list(tmp_path.iterdir())


def test_importing_loads_no_plotting_package_and_drawing_does_not_load_pyplot():
    program = """
import sys
import lbskel.visualization
assert not {"matplotlib", "plotly"} & set(sys.modules)
import lbskel
from lbskel.visualization import Panel, draw
draw([Panel(skeleton=lbskel.Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1, 1]))])
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_panels_share_direction_and_scale():
    mesh = flat_tube()
    half = Mesh(mesh.vertices * 0.5, mesh.faces)
    image = png_pixels(draw([Panel(mesh), Panel(half)], size=(800, 200)))
    first, second = box_of_surface(image[:, :400]), box_of_surface(image[:, 400:])
    # Both ends of a size are known to a pixel.
    assert second[1] - second[0] == pytest.approx((first[1] - first[0]) / 2, abs=2)
    assert second[3] - second[2] == pytest.approx((first[3] - first[2]) / 2, abs=2)
    assert second[0] == pytest.approx(first[0], abs=1)  # both start at x = 0


@pytest.mark.parametrize("factor", [2.0**-20, 2.0**20])
@pytest.mark.parametrize("shift", [0.0, 2.0**20])
def test_scaled_and_shifted_shapes_look_the_same(factor, shift):
    # Powers of two, and coordinates of 30 bits: scaling and shifting are exact, so the pictures are equal.
    V, F = (flat_tube().vertices * 2**20).round() / 2**20, flat_tube().faces
    expected = draw([Panel(Mesh(V, F))], size=(300, 200))
    assert draw([Panel(Mesh((V + shift) * factor, F))], size=(300, 200)) == expected


def test_pictures_without_panels_or_of_too_many_are_refused():
    with pytest.raises(MeshError, match="at least one panel"):
        draw([])
    with pytest.raises(FormatError, match="9 panels cannot fit into 90 x 90 pixels"):
        draw([Panel(flat_tube(), planar_fork())] * 9, size=(90, 90))


def test_a_picture_is_the_rendering_of_one_panel(tmp_path):
    picture(flat_tube(), planar_fork(), tmp_path / "a.png", title="a", size=(300, 200))
    render([Panel(flat_tube(), planar_fork(), "a")], tmp_path / "b.png", size=(300, 200))
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_the_direction_of_view_is_that_of_the_first_mesh():
    mesh = flat_tube()
    turned = Mesh(mesh.vertices[:, [2, 1, 0]], mesh.faces)  # thin along x, long along z
    for panels, is_long in (
        ([Panel(skeleton=planar_fork()), Panel(turned)], True),
        ([Panel(mesh), Panel(turned)], False),  # seen along z, so along its axis
        ([Panel(turned), Panel(mesh)], False),
    ):
        left, right, top, bottom = box_of_surface(png_pixels(draw(panels, size=(800, 200)))[:, 400:])
        assert (right - left > 3 * (bottom - top)) == is_long
        assert (right - left < bottom - top) == (not is_long)


def test_a_turned_view_shows_the_narrow_side():
    """The panel of a tube that is broader than deep is as high from the side as from the front, and narrower."""
    front, side = (box_of_surface(png_pixels(draw([Panel(flat_tube())], turn=turn))) for turn in (0, 90))
    assert (front[1] - front[0]) / (front[3] - front[2]) > 1.2 * (side[1] - side[0]) / (side[3] - side[2])


@pytest.mark.parametrize("title", ["日", "n\udcff.ply"])
def test_a_title_may_have_characters_that_no_font_has(title, rod):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert draw([Panel(rod, title=title)], size=(120, 120)).startswith(b"\x89PNG")
