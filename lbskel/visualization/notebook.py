"""The displays in notebooks: pictures of meshes, point clouds, skeletons and sparse matrices, and pages in a cell."""

from __future__ import annotations

__all__ = ["InlinePage", "picture_of"]

import io
import os
from collections.abc import Sequence
from html import escape
from typing import Any

from scipy.sparse import issparse

from lbskel.io.atomic_write import write_safely
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.interactive import page_content
from lbskel.visualization.panel import Panel
from lbskel.visualization.rendering import draw, require_matplotlib
from lbskel.visualization.scene import Scene

LONGER_SIDE = 480  # pixels of a picture in a notebook; a choice of style
FRAME_HEIGHT = 720  # pixels of a page in a notebook; a choice of style


def picture_of(drawings: Sequence[tuple[str, Any]]) -> bytes:
    """Draw values side by side, as PNG.

    Parameters
    ----------
    drawings : sequence of (str, value)
        Titles, and meshes, point clouds or skeletons; or sparse matrices only, whose entries are marked.

    Raises
    ------
    MissingDependency
        If matplotlib is not installed.
    """
    if all(issparse(value) for _, value in drawings):
        return _entries(drawings)
    panels = [
        Panel(skeleton=value, title=title) if isinstance(value, Skeleton) else Panel(value, title=title)
        for title, value in drawings
    ]
    return draw(panels, size=(LONGER_SIDE * len(panels), LONGER_SIDE))


def _entries(matrices: Sequence[tuple[str, Any]]) -> bytes:
    """Mark the entries of sparse matrices."""
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4 * len(matrices), 4), dpi=90, layout="constrained")
    for axes, (title, matrix) in zip(figure.subplots(1, len(matrices), squeeze=False)[0], matrices, strict=True):
        axes.spy(matrix, markersize=max(0.3, min(4.0, 200 / matrix.shape[0])), color="#4c78a8")
        axes.set_title(title, fontsize=9)
    content = io.BytesIO()
    figure.savefig(content, metadata={"Software": None})
    return content.getvalue()


class InlinePage:
    """An interactive page, which a notebook shows in a frame.

    Parameters
    ----------
    **scene
        The fields of :class:`~lbskel.visualization.scene.Scene`.

    Raises
    ------
    MeshError
        If there is neither a mesh nor a skeleton.
    MissingDependency
        If plotly is not installed.

    Examples
    --------
    >>> from lbskel.shapes import torus
    >>> torus(1.0, 0.2).plot()
    InlinePage(show it in a notebook, or save(path))
    """

    def __init__(self, **scene: Any):
        self._content = page_content(Scene(**scene))

    def __repr__(self) -> str:
        return "InlinePage(show it in a notebook, or save(path))"

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{escape(self._content.decode())}" title="lbskel" sandbox="allow-scripts" '
            f'style="width: 100%; height: {FRAME_HEIGHT}px; border: 0"></iframe>'
        )

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Write the page to a file.

        Parameters
        ----------
        path : path-like
        force : bool
            Whether an existing file may be replaced.

        Raises
        ------
        FormatError
            If the file exists and ``force`` is not set, or it cannot be written.
        """
        write_safely(path, self._content, force=force)
