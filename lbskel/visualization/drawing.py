"""Drawing a panel on a matplotlib figure: the surface as an image, the skeleton over it, title, counts and color bars.

All coordinates are pixels: the figure has 72 dots per inch, so that a point is a pixel, and every drawing is an Axes
whose data coordinates are pixels.
"""

from __future__ import annotations

__all__ = ["draw_panel", "draw_shape", "line_widths", "text_lines"]

from typing import Any

import numpy as np

from lbskel.geometry.mesh import Mesh
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.camera import View
from lbskel.visualization.colormaps import ColorScale
from lbskel.visualization.layout import Frame, Layout
from lbskel.visualization.panel import Panel
from lbskel.visualization.shading import shade_mesh, shade_points

# All numbers and colors of this module are choices of style, made by eye.
LINE_COLOR = (0.49, 0.01, 0.66)  # of skeletons whose radii are not known, and of the count of nodes
TIP_COLOR, JUNCTION_COLOR, TEXT_COLOR = "#d62728", "#1a1a2e", "#333333"
FONT = "DejaVu Sans"  # included in matplotlib, so that pictures are the same on every machine
SURFACE_OPACITY = 0.7  # of a surface with a skeleton in it
EDGE_WIDTH = 1 / 180  # line width of an edge, relative to the longer side of the drawing
MIN_EDGE_WIDTH = 1.2  # of a line, in pixels
EDGE_SHARE = 0.6  # largest width of the lines, relative to the median diameter of the skeleton in the drawing
HALO = 0.9  # width of the halo of a line beyond it, relative to its width
HALO_DEPTH = 0.02  # smallest difference in depth at which an edge's halo covers another, relative to the longer side
POINT_RADIUS = 0.35  # of the ball at a point, relative to the spacing of as many points on a grid over the drawing
POINT_RADIUS_RANGE = (1.0, 6.0)  # bounds on that radius, in pixels
TITLE_LINES, COUNT_LINES, BAR_LINES = 2.2, 2.2, 2.6  # heights of title, counts and color bars, in font sizes


def text_lines(panel: Panel) -> tuple[float, float]:
    """Compute the height of a panel's text above and below its drawing, in font sizes."""
    counts = COUNT_LINES * (panel.skeleton is not None)
    known = panel.skeleton is not None and np.isfinite(panel.skeleton.radii).any()
    bars = BAR_LINES * bool(known or panel.field is not None)
    return TITLE_LINES * bool(panel.title), counts + bars


def draw_panel(
    figure: Any,
    layout: Layout,
    number: int,
    panel: Panel,
    view: View,
    frame: Frame,
    radii: ColorScale | None,
    fields: ColorScale | None,
) -> None:
    """Draw a panel at its position in the layout.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        At 72 dots per inch, of the size of the layout.
    layout : Layout
    number : int
        Index of the panel in the layout.
    panel : Panel
    view : View
    frame : Frame
    radii, fields : ColorScale or None
        Color scales of the skeleton's radii and of the panel's field.
    """
    (left, bottom), (width, height) = layout.corner(number), layout.drawing
    draw_shape(figure, (left, bottom, width, height), panel, view, frame, radii, fields)
    bars = []
    if panel.field is not None and fields is not None:
        bars.append((panel.field_name, fields))
    if panel.skeleton is not None:
        if radii is not None:
            bars.append(("radius", radii))
        _write_counts(
            figure, panel.skeleton, left + width / 2, bottom - COUNT_LINES * layout.font_size / 2, layout.font_size
        )
    top = bottom - COUNT_LINES * layout.font_size * (panel.skeleton is not None)
    for i, (name, scale) in enumerate(bars):
        share = width / len(bars)
        _draw_color_bar(figure, name, scale, left + i * share, top, share, layout.font_size)
    if panel.title:
        size = min(1.25 * layout.font_size, 1.6 * width / len(panel.title))
        _write(
            figure,
            panel.title,
            left + width / 2,
            bottom + height + TITLE_LINES * layout.font_size / 2,
            size,
            "center",
            "bold",
        )


def draw_shape(
    figure: Any,
    rectangle: tuple[int, int, int, int],
    panel: Panel,
    view: View,
    frame: Frame,
    radii: ColorScale | None,
    fields: ColorScale | None,
) -> None:
    """Draw the mesh or point cloud and the skeleton of a panel in a rectangle of the figure.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        At 72 dots per inch.
    rectangle : tuple of int
        Left, bottom, width and height, in pixels.
    panel, view, frame, radii, fields
        As for :func:`draw_panel`.
    """
    axes = _add_axes(figure, *rectangle)
    _draw_surface(axes, panel, view, frame, fields)
    if panel.skeleton is not None:
        _draw_skeleton(axes, panel.skeleton, view, frame, radii)


def _add_axes(figure: Any, left: float, bottom: float, width: float, height: float) -> Any:
    """Add invisible Axes over a rectangle of the figure; their data coordinates are its pixels."""
    figure_width, figure_height = figure.get_size_inches() * figure.dpi
    rectangle = (left / figure_width, bottom / figure_height, width / figure_width, height / figure_height)
    axes = figure.add_axes(rectangle)
    axes.set_axis_off()
    axes.set_xlim(0, width)
    axes.set_ylim(0, height)
    return axes


def _draw_surface(axes: Any, panel: Panel, view: View, frame: Frame, fields: ColorScale | None) -> None:
    """Draw the mesh or point cloud as a shaded image, translucent if there is a skeleton in it."""
    if isinstance(panel.mesh, Mesh):
        points = frame.image_coordinates(view.project(panel.mesh.vertices))
        colormap = fields.colors if fields is not None and panel.field is not None else None
        image = shade_mesh(points, panel.mesh.faces, frame.width, frame.height, field=panel.field, colormap=colormap)
    elif panel.mesh is not None:
        points = frame.image_coordinates(view.project(panel.mesh.points))
        spacing = np.sqrt(frame.width * frame.height / len(points))
        radius = float(np.clip(POINT_RADIUS * spacing, *POINT_RADIUS_RANGE))
        image = shade_points(points, radius, frame.width, frame.height)
    else:
        return
    if panel.skeleton is not None:
        image[..., 3] *= SURFACE_OPACITY
    axes.imshow(
        image,
        extent=(0, frame.width, 0, frame.height),
        interpolation="nearest",
        aspect="auto",
        resample=False,
        zorder=1,
    )


def line_widths(skeleton: Skeleton, longer: int, scale: float) -> tuple[float, float]:
    """Compute the width of the lines of a skeleton, and how much wider their halo is, in pixels.

    Thin branches stay visible around their lines; lines of the least width have no halo, which would hide them.

    Parameters
    ----------
    skeleton : Skeleton
    longer : int
        Longer side of the drawing, in pixels.
    scale : float
        Pixels in a unit of the skeleton.
    """
    width = EDGE_WIDTH * longer
    known = skeleton.radii[np.isfinite(skeleton.radii) & (skeleton.radii > 0)]
    if len(known):
        width = min(width, EDGE_SHARE * 2 * float(np.median(known)) * scale)
    return max(width, MIN_EDGE_WIDTH), HALO * width if width > MIN_EDGE_WIDTH else 0.0


def _draw_skeleton(axes: Any, skeleton: Skeleton, view: View, frame: Frame, radii: ColorScale | None) -> None:
    """Draw the edges colored by radius, the nearer over the farther with a white halo, and mark tips and junctions."""
    from matplotlib.collections import LineCollection

    longer = max(frame.width, frame.height)
    width, halo = line_widths(skeleton, longer, frame.scale)
    points = frame.pixels(view.project(skeleton.nodes))
    ends = points[skeleton.edges]
    depth = ends[:, :, 2].mean(axis=1)
    colors = radii.colors(skeleton.radii[skeleton.edges].mean(axis=1)) if radii else np.tile(LINE_COLOR, (len(ends), 1))
    widths: Any = width
    if halo:
        # The halo of an edge covers edges far behind it, but none that share a node with it.
        farthest = np.full(len(points), np.inf)
        np.minimum.at(farthest, skeleton.edges, depth[:, None])
        halo_depth = farthest[skeleton.edges].min(axis=1) - HALO_DEPTH * longer
        order = np.argsort(np.concatenate([halo_depth, depth]), kind="stable")
        ends, colors = np.concatenate([ends, ends]), np.concatenate([np.ones_like(colors), colors])
        widths = np.repeat([width + halo, width], len(depth))[order]
    else:
        order = np.argsort(depth, kind="stable")
    lines = LineCollection(
        list(ends[order, :, :2]), colors=colors[order], linewidths=widths, capstyle="round", zorder=2
    )
    axes.add_collection(lines, autolim=False)
    isolated = np.flatnonzero(skeleton.degrees == 0)
    for nodes, color, marker, size in (
        (isolated, radii.colors(skeleton.radii[isolated]) if radii else LINE_COLOR, "o", 2.2),
        (skeleton.junctions, JUNCTION_COLOR, "s", 1.7),
        (skeleton.tips, TIP_COLOR, "o", 1.9),
    ):
        x, y, _ = points[nodes].T
        axes.scatter(
            x,
            y,
            s=(size * width) ** 2,
            facecolors=color,
            marker=marker,
            edgecolors="white",
            linewidths=0.35 * width,
            zorder=3,
        )


def _write_counts(figure: Any, skeleton: Skeleton, x: float, y: float, font_size: float) -> None:
    """Write the numbers of nodes, tips, junctions and cycles, each next to its marker in the drawing."""
    from matplotlib.lines import Line2D

    figure_width, figure_height = figure.get_size_inches() * figure.dpi
    counts = (
        ("node", len(skeleton.nodes), {"color": LINE_COLOR, "linewidth": 0.25 * font_size}),
        ("tip", len(skeleton.tips), {"color": "none", "marker": "o", "markerfacecolor": TIP_COLOR}),
        ("junction", len(skeleton.junctions), {"color": "none", "marker": "s", "markerfacecolor": JUNCTION_COLOR}),
        (
            "cycle",
            skeleton.cycle_rank,
            {"color": "none", "marker": "o", "markerfacecolor": "none", "markeredgecolor": TEXT_COLOR},
        ),
    )
    handles = [
        Line2D(
            [],
            [],
            markersize=0.6 * font_size,
            label=f"{n} {name}{'s' * (n != 1)}",
            **{"markeredgecolor": "none"} | style,
        )
        for name, n, style in counts
    ]
    figure.legend(
        handles=handles,
        loc="center",
        bbox_to_anchor=(x / figure_width, y / figure_height),
        ncols=len(handles),
        frameon=False,
        handlelength=1.0,
        handletextpad=0.4,
        columnspacing=1.4,
        borderpad=0,
        labelcolor=TEXT_COLOR,
        prop={"family": FONT, "size": font_size},
    )


def _draw_color_bar(
    figure: Any, name: str, scale: ColorScale, left: float, top: float, width: float, font_size: float
) -> None:
    """Draw a color bar with its label to the left and three numbers below."""
    size = min(font_size, 0.9 * width / max(len(name), 1))  # a letter is about 0.55 sizes wide: at most half the width
    label_width = 0.55 * size * len(name)
    length = min(0.5 * width, 0.86 * width - label_width - font_size)
    start = left + (width - length + label_width + font_size) / 2
    _write(figure, name, start - font_size, top - 0.55 * font_size, size, "right")
    axes = _add_axes(figure, start, top - 0.9 * font_size, length, 0.7 * font_size)
    axes.set_axis_on()
    ticks = [scale.low, (scale.low + scale.high) / 2, scale.high]
    bar = figure.colorbar(scale.mappable(), cax=axes, orientation="horizontal", extend=scale.extend, ticks=ticks)
    bar.outline.set_visible(False)
    bar.ax.set_xticklabels([f"{number:.3g}" for number in ticks], family=FONT)
    bar.ax.tick_params(
        length=0.2 * font_size, width=0.6, pad=0.15 * font_size, labelsize=0.85 * font_size, colors=TEXT_COLOR
    )


def _write(figure: Any, text: str, x: float, y: float, size: float, alignment: str, weight: str = "normal") -> None:
    """Write text at a pixel of the figure, vertically centered and with that horizontal alignment."""
    figure_width, figure_height = figure.get_size_inches() * figure.dpi
    figure.text(
        x / figure_width,
        y / figure_height,
        text.encode(errors="backslashreplace").decode(),  # of the name of a file with bytes that are not UTF-8
        size=size,
        ha=alignment,
        va="center",
        family=FONT,
        weight=weight,
        color=TEXT_COLOR,
        parse_math=False,
    )
