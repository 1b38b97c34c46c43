"""Panels as they appear in a picture: positions, colors, markers and opacity."""

from __future__ import annotations

import io

import numpy as np
import pytest
from helpers import LITTLE_SKELETONS, count_spots, flat_tube, planar_fork, png_pixels
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lbskel import Mesh, PointCloud, Skeleton
from lbskel.visualization import Panel, draw, drawing
from lbskel.visualization.camera import View
from lbskel.visualization.colormaps import radius_scale
from lbskel.visualization.layout import arrange

RED, DARK = (0xD6, 0x27, 0x28), (0x1A, 0x1A, 0x2E)  # colors of tips and junctions


def box_of_surface(image):
    """First and last column and row with the bluish gray of a surface."""
    rows, columns = np.nonzero((image[:, :, 2] - image[:, :, 0] > 20) & (image.sum(axis=2) > 250))
    return columns.min(), columns.max(), rows.min(), rows.max()


def test_tips_and_junctions_are_drawn_at_their_positions():
    skeleton = planar_fork()
    image = png_pixels(draw([Panel(flat_tube(), skeleton)], size=(600, 300)))
    drawing = image[:240]  # the markers are drawn again next to the counts below
    assert count_spots(drawing, RED) == 3
    assert count_spots(drawing, DARK) == 1
    left, right, top, bottom = box_of_surface(drawing)
    rows, columns = np.nonzero((drawing == DARK).all(axis=2))
    # The tube extends from x = 0 to 4; a marker is a few pixels wide and the outline one pixel.
    assert columns.mean() == pytest.approx(left + 2 / 4 * (right - left), abs=2)
    assert rows.mean() == pytest.approx((top + bottom) / 2, abs=2)
    rows, columns = np.nonzero((drawing == RED).all(axis=2))
    assert columns.min() == pytest.approx(left + 0.3 / 4 * (right - left), abs=4)
    assert rows.min() < (top + bottom) / 2 < rows.max()


def test_mesh_is_paler_with_a_skeleton_in_it():
    images = [png_pixels(draw([Panel(flat_tube(), skeleton)], size=(600, 300))) for skeleton in (None, planar_fork())]
    shades = []
    for image in (images[0], images[1][:240]):
        _, _, top, bottom = box_of_surface(image)
        shades.append(
            image[(3 * top + bottom) // 4, 400]
        )  # next to the skeleton; the tube looks the same along its length
    alone, inside = shades
    # 70 % of the color and 30 % of white; the drawings differ in height, so the pixels are not at quite the same point.
    np.testing.assert_allclose(inside, 0.7 * alone + 0.3 * 255, atol=4)
    assert (inside > alone + 2).all()


def test_edges_have_the_colors_of_their_radii():
    from matplotlib import colormaps

    skeleton = Skeleton([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [[0, 1], [2, 3]], [1, 1, 2, 2])
    drawing = png_pixels(draw([Panel(skeleton=skeleton)], size=(400, 300)))[:240]
    for position in (0.0, 0.88):  # ends of the part of plasma that is used
        color = np.round(np.array(colormaps["plasma"](position)[:3]) * 255)
        assert ((drawing == color).all(axis=2)).sum() > 50


def test_panels_share_the_scale_of_radii():
    thin, thick = (Skeleton([[0, 0, 0], [4, 0, 0]], [[0, 1]], [r, r]) for r in (1.0, 2.0))
    together = png_pixels(draw([Panel(skeleton=thin), Panel(skeleton=thick)], size=(800, 200)))
    middle = [together[75:85, column].reshape(-1, 3) for column in (200, 600)]
    first, second = (colors[colors.sum(axis=1).argmin()] for colors in middle)
    assert np.abs(first - second).max() > 100


@pytest.mark.parametrize("skeleton", LITTLE_SKELETONS.values(), ids=LITTLE_SKELETONS)
def test_skeletons_with_little_to_draw_are_drawn_and_counted(skeleton):
    image = png_pixels(draw([Panel(skeleton=skeleton)], size=(300, 300)))
    drawing, below = image[:220], image[220:]
    assert (below < 128).any()
    assert (drawing < 250).any() == bool(len(skeleton.nodes))


def test_field_is_blue_below_zero_and_red_above_and_gray_for_nan():
    mesh = flat_tube()
    field = mesh.vertices[:, 0] - 2
    field[np.abs(field) < 0.4] = np.nan
    image = png_pixels(draw([Panel(mesh, field=field, field_name="x")], size=(600, 300)))[100:140]
    left, middle, right = (
        image[:, columns].mean(axis=(0, 1)) for columns in (slice(60, 120), slice(290, 310), slice(480, 540))
    )
    assert left[2] - left[0] > 50
    assert right[0] - right[2] > 50
    assert np.ptp(middle) < 2


def test_fields_of_one_name_share_a_color_scale_and_others_do_not():
    mesh = flat_tube()
    x = mesh.vertices[:, 0] + 1
    for name, same in (("x", False), ("another", True)):
        panels = [Panel(mesh, field=x, field_name="x"), Panel(mesh, field=2 * x, field_name=name)]
        image = png_pixels(draw(panels, size=(800, 200)))[:140]
        assert (np.abs(image[:, :400] - image[:, 400:]).max() <= 1) == same


def test_point_cloud_is_drawn_as_separate_balls():
    across, up = np.meshgrid(np.linspace(0, 4, 12), np.linspace(-0.5, 0.5, 4))
    cloud = PointCloud(np.stack([across.ravel(), up.ravel(), 0.01 * across.ravel() ** 2], axis=1))
    image = png_pixels(draw([Panel(cloud)], size=(600, 300)))
    assert count_spots((image.min(axis=2) < 250)[..., None], (True,)) == 48
    with_skeleton = png_pixels(draw([Panel(cloud, planar_fork())], size=(600, 300)))[:240]
    assert count_spots(with_skeleton, RED) == 3


def test_contracted_mesh_stays_visible():
    mesh = flat_tube()
    line = Mesh(mesh.vertices * [1, 0, 0], mesh.faces)
    image = png_pixels(draw([Panel(mesh), Panel(line)], size=(800, 200)))[:, 400:]
    dark = image.min(axis=2) < 200
    left, right = np.flatnonzero(dark.any(axis=0))[[0, -1]]
    assert right - left > 300
    assert dark[:, left:right].any(axis=0).all()
    assert dark.any(axis=1).sum() <= 4


def test_text_lines_are_reserved_for_what_a_panel_shows():
    mesh, unknown = flat_tube(), Skeleton([[0, 0, 0], [1, 0, 0]], [[0, 1]], [np.nan, np.nan])
    title, counts, bar = drawing.TITLE_LINES, drawing.COUNT_LINES, drawing.BAR_LINES
    assert drawing.text_lines(Panel(mesh)) == (0, 0)
    assert drawing.text_lines(Panel(mesh, title="a")) == (title, 0)
    assert drawing.text_lines(Panel(mesh, field=mesh.vertices[:, 0])) == (0, bar)
    assert drawing.text_lines(Panel(mesh, unknown)) == (0, counts)  # no radius, no color bar
    assert drawing.text_lines(Panel(mesh, planar_fork(), "a")) == (title, counts + bar)


@pytest.mark.parametrize("least_width", [drawing.MIN_EDGE_WIDTH, 9.0], ids=["with a halo", "without one"])
def test_a_nearer_edge_is_drawn_over_a_farther_one(least_width, monkeypatch):
    """Two crossing bars, one in front: the front one is not interrupted at the crossing, the other one is."""
    monkeypatch.setattr(drawing, "MIN_EDGE_WIDTH", least_width)
    flat = [[-2, -1, 0], [2, 1, 0], [-2, 1, 0], [2, -1, 0]]
    for front in (0, 2):
        nodes = np.array(flat, dtype=float)
        nodes[front : front + 2, 2] = 1.0
        skeleton = Skeleton(nodes, [[0, 1], [2, 3]], [1, 1, 2, 2])
        view = View(np.zeros(3), np.eye(3))
        figure = Figure(figsize=(400 / 72, 300 / 72), dpi=72, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        layout = arrange(np.array([4.0, 2.0]), [(0, 0)], (400, 300))
        frame = layout.frame(np.array([-2.0, -1.0]), np.array([2.0, 1.0]))
        scale = radius_scale([skeleton.radii])
        drawing.draw_panel(figure, layout, 0, Panel(skeleton=skeleton), view, frame, scale, None)
        content = io.BytesIO()
        canvas.print_png(content)
        center = png_pixels(content.getvalue())[150, 200]
        expected = np.round(scale.colors([1.0, 2.0])[front // 2] * 255)
        np.testing.assert_allclose(center, expected, atol=40)  # antialiased; the two colors differ by over 150


def test_an_edge_has_the_color_of_the_mean_radius_of_its_ends():
    scale = radius_scale([np.array([1.0, 3.0])])
    image = png_pixels(draw([Panel(skeleton=Skeleton([[0, 0, 0], [3, 0, 0]], [[0, 1]], [1, 3]))], size=(400, 300)))[
        :240
    ]
    for radius, is_drawn in ((1.0, False), (2.0, True), (3.0, False)):
        color = np.round(scale.colors([radius])[0] * 255)
        assert ((np.abs(image - color).max(axis=2) <= 1).sum() > 50) == is_drawn


def test_thin_branches_stay_visible_around_their_lines():
    x = np.linspace(0, 1, 40)
    stick = Skeleton(np.stack([x, x, x], axis=1), [[i, i + 1] for i in range(39)], [*[0.005] * 38, np.nan, 0.0])
    thick, thick_halo = drawing.line_widths(stick, 900, 1e4)
    assert (thick, thick_halo) == (900 * drawing.EDGE_WIDTH, pytest.approx(0.9 * thick))
    assert drawing.line_widths(stick, 900, 400) == (pytest.approx(0.6 * 4), pytest.approx(0.9 * 0.6 * 4))
    assert drawing.line_widths(stick, 900, 40) == (drawing.MIN_EDGE_WIDTH, 0)  # 0.4 pixels thick
    unknown = Skeleton(stick.nodes, stick.edges, [np.nan] * 40)
    assert drawing.line_widths(unknown, 900, 40)[0] == thick
