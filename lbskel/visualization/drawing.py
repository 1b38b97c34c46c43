"""One panel on a matplotlib figure: the surface as an image, the skeleton over it, and what they mean in words.

Coordinates are pixels throughout: a figure at 72 dots per inch has points of one pixel, and every drawing is an axes
whose data coordinates are its pixels.
"""

from __future__ import annotations

__all__ = ["draw_panel", "lines_of_text"]

from typing import Any

import numpy as np

from lbskel.geometry.mesh import Mesh
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.camera import View
from lbskel.visualization.colormaps import Scale
from lbskel.visualization.layout import Frame, Layout
from lbskel.visualization.panel import Panel
from lbskel.visualization.shading import shade_mesh, shade_points

LINE = (0.49, 0.01, 0.66)  # of a skeleton whose radii are not known, and in the counts
TIP, JUNCTION, INK = "#d62728", "#1a1a2e", "#333333"
FONT = "DejaVu Sans"  # comes with matplotlib, so the picture is the same everywhere
VEIL = 0.7  # opacity of a surface with a skeleton in it
EDGE_WIDTH = 1 / 180  # of the longer side of a drawing
BEHIND = 0.02  # of the longer side: how far in front an edge must be to cut through the one behind with its halo
BALL = 0.35  # radius of a point's ball, times the distance between as many points spread evenly over the drawing
TITLE_LINES, COUNT_LINES, BAR_LINES = 2.2, 2.2, 2.6


def lines_of_text(panel: Panel) -> tuple[float, float]:
    """Lines of text that a panel needs above and below its drawing."""
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
    radii: Scale | None,
    fields: Scale | None,
) -> None:
    """Draw a panel at its place in the layout, with the scales of radii and of its field."""
    (left, bottom), (width, height) = layout.corner(number), layout.drawing
    axes = _axes(figure, left, bottom, width, height)
    _draw_surface(axes, panel, view, frame, fields)
    bars = []
    if panel.field is not None and fields is not None:
        bars.append((panel.field_name, fields))
    if panel.skeleton is not None:
        _draw_skeleton(axes, panel.skeleton, view, frame, radii)
        if radii is not None:
            bars.append(("radius", radii))
        _write_counts(figure, panel.skeleton, left + width / 2, bottom - COUNT_LINES * layout.letter / 2, layout.letter)
    top = bottom - COUNT_LINES * layout.letter * (panel.skeleton is not None)
    for i, (name, scale) in enumerate(bars):
        share = width / len(bars)
        _draw_bar(figure, name, scale, left + i * share, top, share, layout.letter)
    if panel.title:
        size = min(1.25 * layout.letter, 1.6 * width / len(panel.title))
        _write(
            figure,
            panel.title,
            left + width / 2,
            bottom + height + TITLE_LINES * layout.letter / 2,
            size,
            "center",
            "bold",
        )


def _axes(figure: Any, left: float, bottom: float, width: float, height: float) -> Any:
    """SectionCenters over a rectangle of the figure, whose data coordinates are its pixels; nothing of them is seen."""
    across, down = figure.get_size_inches() * figure.dpi
    axes = figure.add_axes((left / across, bottom / down, width / across, height / down))
    axes.set_axis_off()
    axes.set_xlim(0, width)
    axes.set_ylim(0, height)
    return axes


def _draw_surface(axes: Any, panel: Panel, view: View, frame: Frame, fields: Scale | None) -> None:
    """The mesh or point cloud as a shaded image, see-through where there is a skeleton in it."""
    if isinstance(panel.mesh, Mesh):
        points = frame.rows_down(view.project(panel.mesh.vertices))
        paint = fields.colors if fields is not None and panel.field is not None else None
        image = shade_mesh(points, panel.mesh.faces, frame.width, frame.height, field=panel.field, paint=paint)
    elif panel.mesh is not None:
        points = frame.rows_down(view.project(panel.mesh.points))
        ball = float(np.clip(BALL * np.sqrt(frame.width * frame.height / len(points)), 1.0, 6.0))
        image = shade_points(points, ball, frame.width, frame.height)
    else:
        return
    if panel.skeleton is not None:
        image[..., 3] *= VEIL
    axes.imshow(
        image,
        extent=(0, frame.width, 0, frame.height),
        interpolation="nearest",
        aspect="auto",
        resample=False,
        zorder=1,
    )


def _draw_skeleton(axes: Any, skeleton: Skeleton, view: View, frame: Frame, radii: Scale | None) -> None:
    """Edges colored by radius, near ones over far ones with a white halo; tips and junctions marked."""
    from matplotlib.collections import LineCollection

    longer = max(frame.width, frame.height)
    width = max(EDGE_WIDTH * longer, 1.2)
    points = frame.pixels(view.project(skeleton.nodes))
    ends = points[skeleton.edges]
    depth = ends[:, :, 2].mean(axis=1)
    # The halo of an edge cuts through edges far behind it, but through none that it is joined to.
    lowest = np.full(len(points), np.inf)
    np.minimum.at(lowest, skeleton.edges, depth[:, None])
    halo_depth = lowest[skeleton.edges].min(axis=1) - BEHIND * longer
    order = np.argsort(np.concatenate([halo_depth, depth]), kind="stable")
    colors = radii.colors(skeleton.radii[skeleton.edges].mean(axis=1)) if radii else np.tile(LINE, (len(ends), 1))
    axes.add_collection(
        LineCollection(
            list(np.concatenate([ends, ends])[order, :, :2]),
            colors=np.concatenate([np.ones_like(colors), colors])[order],
            linewidths=np.repeat([1.9 * width, width], len(ends))[order],
            capstyle="round",
            zorder=2,
        )
    )
    lone = np.flatnonzero(skeleton.degrees == 0)
    for nodes, color, marker, size in (
        (lone, radii.colors(skeleton.radii[lone]) if radii else LINE, "o", 2.2),
        (skeleton.junctions, JUNCTION, "s", 1.7),
        (skeleton.tips, TIP, "o", 1.9),
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


def _write_counts(figure: Any, skeleton: Skeleton, x: float, y: float, letter: float) -> None:
    """How many nodes, tips, junctions and cycles, beside the marks that they have in the drawing."""
    from matplotlib.lines import Line2D

    across, down = figure.get_size_inches() * figure.dpi
    counts = (
        ("node", len(skeleton.nodes), {"color": LINE, "linewidth": 0.25 * letter}),
        ("tip", len(skeleton.tips), {"color": "none", "marker": "o", "markerfacecolor": TIP}),
        ("junction", len(skeleton.junctions), {"color": "none", "marker": "s", "markerfacecolor": JUNCTION}),
        (
            "cycle",
            skeleton.cycle_rank,
            {"color": "none", "marker": "o", "markerfacecolor": "none", "markeredgecolor": INK},
        ),
    )
    handles = [
        Line2D(
            [], [], markersize=0.6 * letter, label=f"{n} {name}{'s' * (n != 1)}", **{"markeredgecolor": "none"} | look
        )
        for name, n, look in counts
    ]
    figure.legend(
        handles=handles,
        loc="center",
        bbox_to_anchor=(x / across, y / down),
        ncols=len(handles),
        frameon=False,
        handlelength=1.0,
        handletextpad=0.4,
        columnspacing=1.4,
        borderpad=0,
        labelcolor=INK,
        prop={"family": FONT, "size": letter},
    )


def _draw_bar(figure: Any, name: str, scale: Scale, left: float, top: float, width: float, letter: float) -> None:
    """A color bar with the name of what it shows to its left and three numbers under it."""
    size = min(letter, 0.9 * width / max(len(name), 1))  # a letter is about 0.55 wide: at most half of the width
    words = 0.55 * size * len(name)
    length = min(0.5 * width, 0.86 * width - words - letter)
    start = left + (width - length + words + letter) / 2
    _write(figure, name, start - letter, top - 0.55 * letter, size, "right")
    axes = _axes(figure, start, top - 0.9 * letter, length, 0.7 * letter)
    axes.set_axis_on()
    middle = (scale.low + scale.high) / 2
    bar = figure.colorbar(
        scale.mappable(), cax=axes, orientation="horizontal", extend=scale.beyond, ticks=[scale.low, middle, scale.high]
    )
    bar.outline.set_visible(False)
    bar.ax.set_xticklabels([f"{number:.3g}" for number in (scale.low, middle, scale.high)], family=FONT)
    bar.ax.tick_params(length=0.2 * letter, width=0.6, pad=0.15 * letter, labelsize=0.85 * letter, colors=INK)


def _write(figure: Any, text: str, x: float, y: float, size: float, side: str, weight: str = "normal") -> None:
    """Text at a pixel of the figure."""
    across, down = figure.get_size_inches() * figure.dpi
    figure.text(
        x / across,
        y / down,
        text,
        size=size,
        ha=side,
        va="center",
        family=FONT,
        weight=weight,
        color=INK,
        parse_math=False,
    )
