"""Pictures of meshes, point clouds and skeletons as PNG, by matplotlib; no display and no OpenGL is needed.

All panels of a picture share one direction of view, one scale and one color scale of radii, so that they can be
compared. The same panels give the same bytes.
"""

from __future__ import annotations

__all__ = ["draw", "picture", "render", "require_matplotlib"]

import io
import os
import warnings
from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np

from lbskel.errors import MeshError, MissingDependency
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io.atomic_write import write_safely
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.colormaps import field_scales, radius_scale
from lbskel.visualization.layout import arrange
from lbskel.visualization.panel import Panel
from lbskel.visualization.viewpoint import turned, unobstructed_view


def render(
    panels: Sequence[Panel],
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] | None = None,
    force: bool = False,
) -> None:
    """Write a picture of several panels as PNG.

    Parameters
    ----------
    panels : sequence of Panel
        Row by row, from left to right.
    path : path-like
        PNG file to write.
    size : pair of int, optional
        Width and height in pixels; by default they follow the shape.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    FormatError
        If the file exists and ``force`` is not set, it cannot be written, or the panels do not fit into the size.
    MeshError
        If there is no panel.
    MissingDependency
        If matplotlib is not installed.
    """
    write_safely(path, draw(panels, size=size), force=force)


def picture(
    mesh: Mesh | PointCloud | None,
    skeleton: Skeleton | None,
    path: str | os.PathLike[str],
    *,
    title: str = "",
    size: tuple[int, int] | None = None,
    force: bool = False,
) -> None:
    """Write a picture of a mesh and its skeleton, or of one of them (the other None), as PNG.

    Parameters
    ----------
    mesh : Mesh or PointCloud or None
    skeleton : Skeleton or None
        In the coordinates of the mesh.
    path, size, force
        As in :func:`render`.
    title : str
        Text above the drawing.

    Raises
    ------
    FormatError, MissingDependency
        As :func:`render`.
    MeshError
        If there is neither a mesh nor a skeleton.
    """
    render([Panel(mesh, skeleton, title)], path, size=size, force=force)


def require_matplotlib() -> None:
    """Raise the error that drawing would raise without matplotlib, before there is something to draw.

    Raises
    ------
    MissingDependency
        If matplotlib is not installed.
    """
    if find_spec("matplotlib") is None:
        raise MissingDependency("matplotlib", "view", "drawing pictures")


def draw(panels: Sequence[Panel], *, size: tuple[int, int] | None = None, turn: float = 0.0) -> bytes:
    """Draw the picture that :func:`render` writes, and return the bytes of its PNG file.

    Parameters
    ----------
    panels, size
        As in :func:`render`.
    turn : float
        Degrees by which the view is turned about its vertical axis: 90 for the side.

    Raises
    ------
    FormatError
        If the panels do not fit into the size.
    MeshError
        If there is no panel.
    MissingDependency
        If matplotlib is not installed.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.visualization import Panel, draw
    >>> stick = lbskel.Skeleton([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1], [1, 2]], [0.1, 0.2, 0.1])
    >>> draw([Panel(skeleton=stick, title="a stick")])[1:4]
    b'PNG'
    """
    require_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    if not panels:
        raise MeshError("a picture needs at least one panel")
    from lbskel.visualization.drawing import draw_panel, text_lines

    view = unobstructed_view(next((panel for panel in panels if panel.mesh is not None), panels[0]).subject)
    view = turned(view, turn) if turn else view  # a turn by 0 would round
    corners = np.concatenate([view.project(panel.points)[:, :2] for panel in panels])
    low, high = (corners.min(axis=0), corners.max(axis=0)) if len(corners) else np.zeros((2, 2))
    layout = arrange(high - low, [text_lines(panel) for panel in panels], size)
    radii = radius_scale(panel.skeleton.radii for panel in panels if panel.skeleton is not None)
    fields = field_scales([(panel.field_name, panel.field) for panel in panels if panel.field is not None])
    # at 72 dots per inch, a point is a pixel
    figure = Figure(figsize=(layout.width / 72, layout.height / 72), dpi=72, facecolor="white")
    canvas: Any = FigureCanvasAgg(figure)
    for number, panel in enumerate(panels):
        draw_panel(figure, layout, number, panel, view, layout.frame(low, high), radii, fields.get(panel.field_name))
    content = io.BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # of a title: it has a box there
        # compression level 4 takes half the time of the default, 6
        canvas.print_png(content, metadata={"Software": None}, pil_kwargs={"compress_level": 4})
    return content.getvalue()
