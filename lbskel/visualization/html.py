"""An interactive page of a mesh and its skeleton: one HTML file that turns, zooms and tells radii, by plotly.

The file carries plotly.js in it (about 5 MB), so nothing is downloaded when it is opened. Browsers compute in single
precision: coordinates are centered, divided by the size of the shape and turned to the view of the pictures; the
numbers shown at a node are the caller's.
"""

from __future__ import annotations

__all__ = ["page"]

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MissingDependency
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io.atomic_write import write_safely
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.camera import principal_view
from lbskel.visualization.colormaps import radius_scale
from lbskel.visualization.panel import Panel

SURFACE, LINE, TIP, JUNCTION = "#a8bad4", "#7e03a8", "#d62728", "#1a1a2e"


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
    path : path-like
        Of the HTML file.
    title : str
    force : bool
        Whether a file that exists may be replaced.

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
    view = principal_view(panel.shape)
    size = np.abs(view.project(panel.points)).max(initial=0.0) or 1.0

    def place(points: NDArray[np.float64]) -> dict[str, NDArray[np.float32]]:
        return dict(zip("xyz", (view.project(points) / size).astype(np.float32).T, strict=True))

    traces = []
    if isinstance(mesh, Mesh):
        corners = dict(zip("ijk", mesh.faces.astype(np.int32).T, strict=True))
        look = {"opacity": 0.35, "color": SURFACE, "name": "mesh", "hoverinfo": "skip", "showlegend": True}
        traces.append({"type": "mesh3d", **place(mesh.vertices), **corners, **look})
    elif mesh is not None:
        traces.append(_dots(place(mesh.points), "points", SURFACE, 1.5))
    if skeleton is not None:
        traces.extend(_skeleton_traces(skeleton, place))
    unseen = {"visible": False}
    figure = Figure(
        traces,
        {
            "template": "none",
            "title": {"text": title},
            "margin": {"l": 0, "r": 0, "b": 0, "t": 50 if title else 0},
            "legend": {"itemsizing": "constant", "x": 0.01, "y": 0.99},
            "scene": {
                "xaxis": unseen,
                "yaxis": unseen,
                "zaxis": unseen,
                "aspectmode": "data",
                "camera": {"eye": {"x": 0, "y": 0, "z": 1.8}, "up": {"x": 0, "y": 1, "z": 0}},
            },
        },
    )
    html = figure.to_html(include_plotlyjs=True, div_id="lbskel", config={"displaylogo": False, "responsive": True})
    write_safely(path, html.encode(), force=force)


def _skeleton_traces(skeleton: Skeleton, place: Any) -> list[dict[str, Any]]:
    """Edges colored by radius, every node with its number, place and radius at hand, tips and junctions marked."""
    from plotly.colors import sample_colorscale

    scale = radius_scale([skeleton.radii])
    words = [
        f"node {i}<br>({x:.6g}, {y:.6g}, {z:.6g})<br>{skeleton.radius_kind} radius {radius:.4g}"
        for i, ((x, y, z), radius) in enumerate(zip(skeleton.nodes, skeleton.radii, strict=True))
    ]
    nodes = place(skeleton.nodes)
    edge_look, node_look = {"width": 7, "color": LINE}, {"size": 3, "color": LINE}
    if scale is not None:
        colors = sample_colorscale(scale.name, np.linspace(0, scale.diameter_bound, 12))
        shared = {"colorscale": colors, "cmin": scale.low, "cmax": scale.high}
        bar = {"title": {"text": "radius"}, "len": 0.5, "thickness": 14}
        edge_look |= {"color": np.repeat(skeleton.radii[skeleton.edges].mean(axis=1), 3), **shared}
        node_look |= {"color": skeleton.radii, **shared, "colorbar": bar}
    # The three entries of an edge are its ends and a gap.
    ends = {axis: np.insert(values[skeleton.edges], 2, np.nan, axis=1).ravel() for axis, values in nodes.items()}
    edges = {"type": "scatter3d", **ends, "mode": "lines", "line": edge_look}
    every = {"type": "scatter3d", **nodes, "mode": "markers", "marker": node_look, "text": words, "hoverinfo": "text"}
    traces = [
        {**edges, "name": f"{len(skeleton.edges)} edges, {skeleton.cycle_rank} cycles", "hoverinfo": "skip"},
        {**every, "name": f"{len(skeleton.nodes)} nodes"},
    ]
    for chosen, what, color in ((skeleton.tips, "tips", TIP), (skeleton.junctions, "junctions", JUNCTION)):
        if len(chosen):
            some = {axis: values[chosen] for axis, values in nodes.items()}
            traces.append(_dots(some, f"{len(chosen)} {what}", color, 5))
    return traces


def _dots(where: dict[str, NDArray[np.float32]], name: str, color: str, size: float) -> dict[str, Any]:
    """Points of one color."""
    marker = {"size": size, "color": color}
    return {"type": "scatter3d", **where, "mode": "markers", "marker": marker, "name": name, "hoverinfo": "skip"}
