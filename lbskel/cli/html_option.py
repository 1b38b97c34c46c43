"""The option ``--html``: an interactive page beside what a command writes."""

from __future__ import annotations

__all__ = ["add_html_option", "refuse_page", "write_page"]

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from lbskel.cli.options import refuse_unwritable
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.skeleton.skeleton import Skeleton


def add_html_option(parser: argparse.ArgumentParser, note: str = "") -> None:
    """Add ``--html``."""
    parser.add_argument("--html", metavar="PAGE", help=f"write an interactive page, as lbskel view does{note}")


def refuse_page(path: str | Path | None, force: bool) -> None:
    """Raise an error if a page could not be written, before anything is computed; None means no page.

    Raises
    ------
    FormatError
        If the name is not that of a page, or the file exists.
    MissingDependency
        If plotly is not installed.
    """
    if not path:
        return
    from lbskel.visualization.interactive import require_plotly

    refuse_unwritable([(path, ("html",))], force)
    require_plotly()


def write_page(
    path: str | Path,
    shape: Mesh | PointCloud,
    skeleton: Skeleton,
    arguments: argparse.Namespace,
    *,
    title: str,
    **changes: Any,
) -> None:
    """Write the page of :func:`lbskel.view`, with some fields of its scene changed."""
    from lbskel.pipeline.viewing import view_scene
    from lbskel.visualization import page

    scene = view_scene(shape, skeleton, title=title, preprocess=arguments.preprocess, simplify=arguments.simplify)
    page(replace(scene, **changes), path, force=arguments.force)
