"""Pictures and pages: what is in the file, not how it was drawn."""

from __future__ import annotations

import io
import re
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.image import imread

from lbskel import FormatError, Mesh, MeshError, MissingDependency, PointCloud, Skeleton
from lbskel.visualization import Panel, draw, page, picture, render

RED, DARK = (0xD6, 0x27, 0x28), (0x1A, 0x1A, 0x2E)  # tips and junctions


def tube(n=24, length=4.0, radius=0.5):
    """A closed tube along x, flatter in z."""
    around = np.linspace(0, 2 * np.pi, n, endpoint=False)
    ring = np.stack([np.zeros(n), radius * np.cos(around), 0.5 * radius * np.sin(around)], axis=1)
    V = np.concatenate([ring + np.array([x, 0, 0]) for x in np.linspace(0, length, n)] + [[[0, 0, 0], [length, 0, 0]]])
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(n - 1), np.arange(n), indexing="ij"))
    a, b = i * n + j, i * n + (j + 1) % n
    j, k = np.arange(n), (np.arange(n) + 1) % n
    caps = [np.stack([np.full(n, n * n), k, j], 1), np.stack([np.full(n, n * n + 1), n * n - n + j, n * n - n + k], 1)]
    return Mesh(V, np.concatenate([np.stack([a, b, a + n], 1), np.stack([b, b + n, a + n], 1), *caps]))


def fork():
    """A skeleton with one junction and three tips, in the plane z = 0."""
    nodes = [[0.3, 0, 0], [2, 0, 0], [3.6, 0.3, 0], [3.6, -0.3, 0]]
    return Skeleton(nodes, [[0, 1], [1, 2], [1, 3]], [0.2, 0.5, 0.3, 0.3])


def pixels(png):
    """(height, width, 3) whole numbers of a PNG."""
    return (imread(io.BytesIO(png), format="png")[:, :, :3] * 255).round().astype(int)


def count_of(image, color):
    """How many separate spots of exactly that color there are."""
    from scipy.ndimage import label

    return label((image == color).all(axis=2))[1]


def box_of_surface(image):
    """First and last column and row with the bluish gray of a surface."""
    rows, columns = np.nonzero((image[:, :, 2] - image[:, :, 0] > 20) & (image.sum(axis=2) > 250))
    return columns.min(), columns.max(), rows.min(), rows.max()


def test_picture_is_a_png_of_the_size_asked_for(tmp_path):
    picture(tube(), fork(), tmp_path / "tube.png", title="a tube", size=(500, 300))
    content = (tmp_path / "tube.png").read_bytes()
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    image = pixels(content)
    assert image.shape == (300, 500, 3)
    assert (image[0, 0] == 255).all()
    assert 0.05 < (image.min(axis=2) < 250).mean() < 0.6


def test_skeleton_is_drawn_where_it_is():
    skeleton = fork()
    image = pixels(draw([Panel(tube(), skeleton)], size=(600, 300)))
    drawing = image[:240]  # the marks are shown again beside the counts below
    assert count_of(drawing, RED) == 3
    assert count_of(drawing, DARK) == 1
    left, right, top, bottom = box_of_surface(drawing)
    rows, columns = np.nonzero((drawing == DARK).all(axis=2))
    # The tube reaches from x = 0 to 4; a mark is a few pixels wide and the outline takes one.
    assert columns.mean() == pytest.approx(left + 2 / 4 * (right - left), abs=2)
    assert rows.mean() == pytest.approx((top + bottom) / 2, abs=2)
    rows, columns = np.nonzero((drawing == RED).all(axis=2))
    assert columns.min() == pytest.approx(left + 0.3 / 4 * (right - left), abs=4)
    assert rows.min() < (top + bottom) / 2 < rows.max()


def test_mesh_is_paler_with_a_skeleton_in_it():
    images = [pixels(draw([Panel(tube(), skeleton)], size=(600, 300))) for skeleton in (None, fork())]
    seen = []
    for drawing in (images[0], images[1][:240]):
        _, _, top, bottom = box_of_surface(drawing)
        seen.append(drawing[(3 * top + bottom) // 4, 400])  # beside the skeleton, where the tube is the same all along
    alone, inside = seen
    # Seven tenths of the color and three of white; the two drawings differ in height, so a pixel's place by a little.
    np.testing.assert_allclose(inside, 0.7 * alone + 0.3 * 255, atol=4)
    assert (inside > alone + 2).all()


def test_edges_have_the_colors_of_their_radii():
    from matplotlib import colormaps

    skeleton = Skeleton([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [[0, 1], [2, 3]], [1, 1, 2, 2])
    drawing = pixels(draw([Panel(skeleton=skeleton)], size=(400, 300)))[:240]
    for position in (0.0, 0.88):  # ends of the part of plasma that is in use
        color = np.round(np.array(colormaps["plasma"](position)[:3]) * 255)
        assert ((drawing == color).all(axis=2)).sum() > 50


def test_two_runs_give_the_same_bytes(tmp_path):
    mesh, field = tube(), tube().vertices[:, 0]
    panels = [Panel(mesh, fork(), "one"), Panel(mesh, None, "two", field, "x"), Panel(PointCloud(mesh.vertices))]
    first, second = draw(panels), draw(panels)
    assert first == second
    assert b"Software" not in first
    for path in (tmp_path / "a.html", tmp_path / "b.html"):
        page(mesh, fork(), path)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


@pytest.mark.parametrize("write", [picture, page])
def test_nothing_is_overwritten_unasked(tmp_path, write):
    path = tmp_path / "there"
    path.write_text("mine")
    with pytest.raises(FormatError, match="exists already"):
        write(tube(), None, path)
    assert path.read_text() == "mine"
    write(tube(), None, path, force=True)
    assert path.stat().st_size > 1000
    assert [file.name for file in tmp_path.iterdir()] == ["there"]


def test_missing_matplotlib_is_said_with_the_pip_line(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingDependency, match=r"matplotlib.*pip install 'lbskel\[view\]'"):
        render([Panel(tube())], tmp_path / "tube.png")
    assert not list(tmp_path.iterdir())


def test_missing_plotly_is_said_with_the_pip_line(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "plotly.graph_objects", None)
    with pytest.raises(MissingDependency, match=r"plotly.*pip install 'lbskel\[view\]'"):
        page(tube(), None, tmp_path / "tube.html")
    assert not list(tmp_path.iterdir())


def test_importing_views_is_light_and_drawing_leaves_pyplot_alone():
    program = """
import sys
import lbskel.visualization
assert not {"matplotlib", "plotly"} & set(sys.modules)
import lbskel
lbskel.visualization.draw([lbskel.visualization.Panel(skeleton=lbskel.Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1, 1]))])
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_panels_share_direction_and_scale():
    mesh = tube()
    half = Mesh(mesh.vertices * 0.5, mesh.faces)
    image = pixels(draw([Panel(mesh), Panel(half)], size=(800, 200)))
    ours, theirs = box_of_surface(image[:, :400]), box_of_surface(image[:, 400:])
    # Each end of an extent is known to a pixel.
    assert theirs[1] - theirs[0] == pytest.approx((ours[1] - ours[0]) / 2, abs=2)
    assert theirs[3] - theirs[2] == pytest.approx((ours[3] - ours[2]) / 2, abs=2)
    assert theirs[0] == pytest.approx(ours[0], abs=1)  # both start at x = 0


def test_panels_share_the_scale_of_radii():
    thin, thick = (Skeleton([[0, 0, 0], [4, 0, 0]], [[0, 1]], [r, r]) for r in (1.0, 2.0))
    together = pixels(draw([Panel(skeleton=thin), Panel(skeleton=thick)], size=(800, 200)))
    middle = [together[75:85, column].reshape(-1, 3) for column in (200, 600)]
    ours, theirs = (colors[colors.sum(axis=1).argmin()] for colors in middle)
    assert np.abs(ours - theirs).max() > 100


@pytest.mark.parametrize("factor", [2.0**-20, 2.0**20])
@pytest.mark.parametrize("shift", [0.0, 2.0**20])
def test_tiny_huge_and_distant_shapes_look_the_same(factor, shift):
    # Powers of two, and coordinates with 30 bits: scaling and shifting are exact, so the pictures are too.
    V, F = (tube().vertices * 2**20).round() / 2**20, tube().faces
    expected = draw([Panel(Mesh(V, F))], size=(300, 200))
    assert draw([Panel(Mesh((V + shift) * factor, F))], size=(300, 200)) == expected


def test_contracted_mesh_stays_visible():
    mesh = tube()
    line = Mesh(mesh.vertices * [1, 0, 0], mesh.faces)
    image = pixels(draw([Panel(mesh), Panel(line)], size=(800, 200)))[:, 400:]
    dark = image.min(axis=2) < 200
    left, right = np.flatnonzero(dark.any(axis=0))[[0, -1]]
    assert right - left > 300
    assert dark[:, left:right].any(axis=0).all()
    assert dark.any(axis=1).sum() <= 4


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
def test_sparse_skeletons_are_drawn_and_counted(tmp_path, skeleton):
    image = pixels(draw([Panel(skeleton=skeleton)], size=(300, 300)))
    drawing, below = image[:220], image[220:]
    assert (below < 128).any()
    assert (drawing < 250).any() == bool(len(skeleton.nodes))
    page(None, skeleton, tmp_path / "page.html")
    assert "scatter3d" in (tmp_path / "page.html").read_text()


def test_field_is_blue_below_zero_and_red_above_and_gray_where_unknown():
    mesh = tube()
    field = mesh.vertices[:, 0] - 2
    field[np.abs(field) < 0.4] = np.nan
    image = pixels(draw([Panel(mesh, field=field, field_name="x")], size=(600, 300)))[100:140]
    left, middle, right = (
        image[:, columns].mean(axis=(0, 1)) for columns in (slice(60, 120), slice(290, 310), slice(480, 540))
    )
    assert left[2] - left[0] > 50
    assert right[0] - right[2] > 50
    assert np.ptp(middle) < 2


def test_fields_of_one_name_share_their_colors_and_others_do_not():
    mesh = tube()
    x = mesh.vertices[:, 0] + 1
    for name, alike in (("x", False), ("another", True)):
        panels = [Panel(mesh, field=x, field_name="x"), Panel(mesh, field=2 * x, field_name=name)]
        image = pixels(draw(panels, size=(800, 200)))[:140]
        assert (np.abs(image[:, :400] - image[:, 400:]).max() <= 1) == alike


def test_panel_refuses_what_it_cannot_draw():
    with pytest.raises(MeshError, match="needs a mesh"):
        Panel(title="nothing")
    with pytest.raises(MeshError, match=r"one number for each vertex of a mesh, \(578,\), not \(3,\)"):
        Panel(tube(), field=[1, 2, 3])
    with pytest.raises(MeshError, match="one number for each vertex"):
        Panel(PointCloud([[0, 0, 0]]), field=[1])
    with pytest.raises(MeshError, match="at least one panel"):
        draw([])
    with pytest.raises(FormatError, match="9 panels do not fit into 90 x 90 pixels"):
        draw([Panel(tube(), fork())] * 9, size=(90, 90))


def test_point_cloud_is_drawn_as_separate_balls():
    across, up = np.meshgrid(np.linspace(0, 4, 12), np.linspace(-0.5, 0.5, 4))
    cloud = PointCloud(np.stack([across.ravel(), up.ravel(), 0.01 * across.ravel() ** 2], axis=1))
    image = pixels(draw([Panel(cloud)], size=(600, 300)))
    assert count_of((image.min(axis=2) < 250)[..., None], (True,)) == 48
    with_skeleton = pixels(draw([Panel(cloud, fork())], size=(600, 300)))[:240]
    assert count_of(with_skeleton, RED) == 3


def test_page_carries_everything_in_it(tmp_path):
    page(tube(), fork(), tmp_path / "tube.html", title="A tube")
    text = (tmp_path / "tube.html").read_text()
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=", text)
    assert "mesh3d" in text
    assert "3 edges, 0 cycles" in text
    assert "node 1\\u003cbr\\u003e(2, 0, 0)\\u003cbr\\u003einscribed radius 0.5" in text
    assert "3 tips" in text
    assert "A tube" in text
    assert len(text) < 8e6
