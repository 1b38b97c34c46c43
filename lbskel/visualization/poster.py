"""The picture that a page shows until its view is drawn: the shape from the same side, on a transparent ground."""

from __future__ import annotations

__all__ = ["poster"]

import io
from importlib.util import find_spec
from typing import Any

import numpy as np

from lbskel.visualization.colormaps import field_scales, radius_scale
from lbskel.visualization.layout import Frame
from lbskel.visualization.panel import Panel
from lbskel.visualization.viewpoint import unobstructed_view

LONGER_SIDE = 640  # of the picture, in pixels: half of what the view has on a wide screen; a choice of style
N_COLORS = 128  # of the picture, which is then a quarter as large; a choice of style


def poster(panel: Panel) -> bytes:
    """Draw a mesh or point cloud and its skeleton, and nothing around them, as PNG; empty without matplotlib.

    Parameters
    ----------
    panel : Panel
    """
    if find_spec("matplotlib") is None or not len(panel.points):
        return b""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    from lbskel.visualization.drawing import draw_shape

    view = unobstructed_view(panel.subject)
    corners = view.project(panel.points)[:, :2]
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = LONGER_SIDE / (float((high - low).max()) or 1.0)
    width, height = np.maximum(np.ceil((high - low) * scale), 1).astype(int).tolist()
    figure = Figure(figsize=(width / 72, height / 72), dpi=72, facecolor="none")
    canvas: Any = FigureCanvasAgg(figure)
    frame = Frame(width, height, scale, (low + high) / 2)
    radii = radius_scale([panel.skeleton.radii]) if panel.skeleton is not None else None
    field = None if panel.field is None else field_scales([(panel.field_name, panel.field)]).get(panel.field_name)
    draw_shape(figure, (0, 0, width, height), panel, view, frame, radii, field)
    canvas.draw()
    content = io.BytesIO()
    colored = Image.fromarray(np.asarray(canvas.buffer_rgba()))
    colored.quantize(N_COLORS, method=Image.Quantize.FASTOCTREE).save(content, "PNG", optimize=True)
    return content.getvalue()
