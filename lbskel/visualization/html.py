"""An interactive 3D view of a mesh and its skeleton in one HTML file, by plotly.

The file contains plotly.js (about 5 MB), so nothing is downloaded when it is opened. Browsers compute in single
precision, so the coordinates are projected to the view of the pictures and divided by the size of the shape; the labels
of nodes show the caller's coordinates.
"""

from __future__ import annotations

__all__ = ["page"]

import os
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MissingDependency
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io.atomic_write import write_safely
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.camera import principal_view
from lbskel.visualization.colormaps import radius_scale
from lbskel.visualization.panel import Panel

# From (n, 3) points to the x, y and z of a trace.
Coordinates: TypeAlias = Callable[[NDArray[np.float64]], dict[str, NDArray[np.float32]]]

# Colors, opacity and sizes of this module are choices of style, made by eye.
SURFACE_COLOR, LINE_COLOR, TIP_COLOR, JUNCTION_COLOR = "#a8bad4", "#7e03a8", "#d62728", "#1a1a2e"


def page(
    mesh: Mesh | PointCloud | None,
    skeleton: Skeleton | None,
    path: str | os.PathLike[str],
    *,
    title: str = "",
    force: bool = False,
) -> None:
    """Write an interactive page of a mesh and its skeleton, or of one of them (the other None).

    Parameters
    ----------
    mesh : Mesh or PointCloud or None
    skeleton : Skeleton or None
        In the coordinates of the mesh.
    path : path-like
        HTML file to write.
    title : str
        Heading of the page.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    FormatError
        If the file exists and ``force`` is not set, or it cannot be written.
    MeshError
        If there is neither a mesh nor a skeleton.
    MissingDependency
        If plotly is not installed.
    """
    try:
        from plotly.graph_objects import Figure
    except ImportError:
        raise MissingDependency("plotly", "view", "writing an interactive page") from None
    panel = Panel(mesh, skeleton, title)
    view = principal_view(panel.subject)
    size = np.abs(view.project(panel.points)).max(initial=0.0) or 1.0

    def coordinates(points: NDArray[np.float64]) -> dict[str, NDArray[np.float32]]:
        return dict(zip("xyz", (view.project(points) / size).astype(np.float32).T, strict=True))

    traces = []
    if isinstance(mesh, Mesh):
        corners = dict(zip("ijk", mesh.faces.astype(np.int32).T, strict=True))
        style = {"opacity": 0.35, "color": SURFACE_COLOR, "name": "mesh", "hoverinfo": "skip", "showlegend": True}
        traces.append({"type": "mesh3d", **coordinates(mesh.vertices), **corners, **style})
    elif mesh is not None:
        traces.append(_point_trace(coordinates(mesh.points), "points", SURFACE_COLOR, 1.5))
    if skeleton is not None:
        traces.extend(_skeleton_traces(skeleton, coordinates))
    hidden = {"visible": False}
    figure = Figure(
        traces,
        {
            "template": "none",
            "title": {"text": title},
            "margin": {"l": 0, "r": 0, "b": 0, "t": 50 if title else 0},
            "legend": {"itemsizing": "constant", "x": 0.01, "y": 0.99},
            "scene": {
                "xaxis": hidden,
                "yaxis": hidden,
                "zaxis": hidden,
                "aspectmode": "data",
                "camera": {"eye": {"x": 0, "y": 0, "z": 1.8}, "up": {"x": 0, "y": 1, "z": 0}},
            },
        },
    )
    html = figure.to_html(include_plotlyjs=True, div_id="lbskel", config={"displaylogo": False, "responsive": True})
    write_safely(path, html.encode(), force=force)


def _skeleton_traces(skeleton: Skeleton, coordinates: Coordinates) -> list[dict[str, Any]]:
    """List the traces of a skeleton: edges colored by radius, nodes labeled with number, position, radius; markers."""
    from plotly.colors import sample_colorscale

    scale = radius_scale([skeleton.radii])
    labels = [
        f"node {i}<br>({x:.6g}, {y:.6g}, {z:.6g})<br>{skeleton.radius_kind} radius {radius:.4g}"
        for i, ((x, y, z), radius) in enumerate(zip(skeleton.nodes, skeleton.radii, strict=True))
    ]
    nodes = coordinates(skeleton.nodes)
    edge_style, node_style = {"width": 7, "color": LINE_COLOR}, {"size": 3, "color": LINE_COLOR}
    if scale is not None:
        colors = sample_colorscale(scale.colormap, np.linspace(0, scale.fraction, 12))
        shared = {"colorscale": colors, "cmin": scale.low, "cmax": scale.high}
        bar = {"title": {"text": "radius"}, "len": 0.5, "thickness": 14}
        edge_style |= {"color": np.repeat(skeleton.radii[skeleton.edges].mean(axis=1), 3), **shared}
        node_style |= {"color": skeleton.radii, **shared, "colorbar": bar}
    # Each edge has three entries: its two ends and NaN, which interrupts the line.
    ends = {axis: np.insert(values[skeleton.edges], 2, np.nan, axis=1).ravel() for axis, values in nodes.items()}
    edges = {"type": "scatter3d", **ends, "mode": "lines", "line": edge_style}
    all_nodes = {
        "type": "scatter3d",
        **nodes,
        "mode": "markers",
        "marker": node_style,
        "text": labels,
        "hoverinfo": "text",
    }
    traces = [
        {**edges, "name": f"{len(skeleton.edges)} edges, {skeleton.cycle_rank} cycles", "hoverinfo": "skip"},
        {**all_nodes, "name": f"{len(skeleton.nodes)} nodes"},
    ]
    for selected, kind, color in (
        (skeleton.tips, "tips", TIP_COLOR),
        (skeleton.junctions, "junctions", JUNCTION_COLOR),
    ):
        if len(selected):
            marked = {axis: values[selected] for axis, values in nodes.items()}
            traces.append(_point_trace(marked, f"{len(selected)} {kind}", color, 5))
    return traces


def _point_trace(coordinates: dict[str, NDArray[np.float32]], name: str, color: str, size: float) -> dict[str, Any]:
    """Make a trace of points of one color and of a size in pixels."""
    marker = {"size": size, "color": color}
    return {"type": "scatter3d", **coordinates, "mode": "markers", "marker": marker, "name": name, "hoverinfo": "skip"}
