"""The interactive page of a mesh and its skeleton: one HTML file that opens without a network, drawn by plotly.

The file contains plotly.js, the geometry of a :class:`~lbskel.visualization.scene.Scene`, and ``page.js``, which
connects the toggles, the slider of the contraction, and the branch table. ``start.js`` runs both programs when a
picture of the first view is on the screen.
"""

from __future__ import annotations

__all__ = ["page", "page_content", "require_plotly"]

import base64
import math
import os
from html import escape
from importlib.util import find_spec
from typing import Any

from lbskel.errors import MissingDependency, counted
from lbskel.io.atomic_write import write_safely
from lbskel.skeleton.skeleton import Skeleton
from lbskel.visualization.html import document, paragraphs, script, table
from lbskel.visualization.panel import Panel
from lbskel.visualization.poster import poster
from lbskel.visualization.scene import Scene, encode_scene

PAGE = """\
<p id="summary">{summary}</p>
<noscript><p>The view needs JavaScript, which this browser does not run; the tables below do not.</p></noscript>
<div class="layout">
<div id="frame">{picture}
<div id="view" role="img" tabindex="0" aria-label="{label}" aria-describedby="summary"></div>
</div>
<div>
<fieldset><legend>Show</legend>
{toggles}
</fieldset>
{replay}
{branches}
</div>
</div>
{notes}
{tables}"""
POSTER = '<img id="poster" alt="" style="transform: scale({:.3f})" src="data:image/png;base64,{}">'
HOW_TO_MOVE = "Drag or press arrows to turn, scroll or press plus and minus to zoom."
REPLAY = """\
<fieldset><legend>Contraction</legend>
<label for="step" id="step-text">{text}</label>
<input type="range" id="step" min="0" max="{last}" value="0" aria-valuetext="{text}">
<button type="button" id="play">Play</button>
<div id="curves" role="img" aria-label="Area and volume of the contracted surface by step"></div>
</fieldset>"""
BRANCHES = """\
<fieldset><legend>Branch</legend>
<label for="branch">Click on a branch, or choose it here:</label>
<select id="branch"><option value="-1">none</option></select>
<div aria-live="polite"><table aria-label="The chosen branch"><tbody id="branch-rows"></tbody></table></div>
</fieldset>"""


def page(scene: Scene, path: str | os.PathLike[str], *, force: bool = False) -> None:
    """Write an interactive page.

    Parameters
    ----------
    scene : Scene
        A mesh or a skeleton, or both, and what else the page shows.
    path : path-like
        HTML file to write; below 8 MB, since large surfaces are simplified for display.
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
    write_safely(path, page_content(scene), force=force)


def require_plotly() -> None:
    """Raise the error that a page would raise without plotly, before there is something to show.

    Raises
    ------
    MissingDependency
        If plotly is not installed.
    """
    if find_spec("plotly") is None:
        raise MissingDependency("plotly", "view", "an interactive page")


def page_content(scene: Scene) -> bytes:
    """Compose the page that :func:`page` writes.

    Parameters
    ----------
    scene : Scene

    Raises
    ------
    MeshError
        If there is neither a mesh nor a skeleton.
    MissingDependency
        If plotly is not installed.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.visualization import Scene, page_content
    >>> stick = lbskel.Skeleton([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1], [1, 2]], [0.1, 0.2, 0.1])
    >>> page_content(Scene(skeleton=stick, title="a stick"))[:15]
    b'<!DOCTYPE html>'
    """
    require_plotly()
    from plotly.offline import get_plotlyjs

    data, notes = encode_scene(scene)
    picture = poster(Panel(scene.mesh, scene.skeleton, field=scene.field, field_name=scene.field_name))
    summary = _summary(scene)
    body = PAGE.format(
        picture=POSTER.format(_share(data["extent"]), base64.b64encode(picture).decode()) if picture else "",
        summary=escape(summary),
        label=escape(f"Three-dimensional view: {summary} {HOW_TO_MOVE}"),
        toggles="\n".join(_toggle(name, label, shown) for name, label, shown in _layers(scene, data)),
        replay=_replay(data),
        branches=BRANCHES if scene.skeleton is not None and scene.skeleton.branches else "",
        notes=paragraphs([*notes, *scene.notes]),
        tables="\n".join(map(table, scene.tables)),
    )
    programs = {"scripts": [script("start.js")], "held": [get_plotlyjs(), script("page.js")]}
    return document(scene.title or "lbskel", body, **programs, data=data)


def _share(extent: list[float]) -> float:
    """Share of the view that the shape fills, from the camera's distance in page.js and its angle of 45 degrees."""
    longer, depth = max(extent[:2]), extent[2]
    return longer / (2 * math.tan(math.pi / 8)) / (1.3 * longer + depth / 2) if longer > 0 else 1.0


def _summary(scene: Scene) -> str:
    """Describe in words what is shown."""
    parts = []
    if scene.mesh is not None:
        sizes = repr(scene.mesh).partition("(")[2].rstrip(")")
        parts.append(f"{'A point cloud' if 'point' in sizes else 'A mesh'} of {sizes.replace(', ', ' and ')}.")
    if scene.skeleton is not None:
        of = scene.skeleton
        parts.append(
            f"Its skeleton has {counted(len(of.nodes), 'node')}, {counted(len(of.tips), 'tip')}, "
            f"{counted(len(of.junctions), 'junction')} and {counted(of.cycle_rank, 'cycle')}."
        )
    return " ".join(parts)


def _layers(scene: Scene, data: dict[str, Any]) -> list[tuple[str, str, bool]]:
    """List what can be shown and hidden: name, label, whether it is shown at first."""
    of, has_field, has_parts = scene.skeleton, *(name in data.get("mesh", {}) for name in ("field", "parts"))
    layers = [
        (
            "mesh",
            "points" if "cloud" in data else "mesh",
            not (has_field or scene.parts_first),
            "mesh" in data or "cloud" in data,
        ),
        ("field", scene.field_name, True, has_field),
        ("skeleton", "skeleton, colored by radius", True, of is not None),
        ("tips", "tips (red)", True, of is not None and len(of.tips) > 0),
        ("junctions", "junctions (squares)", True, of is not None and len(of.junctions) > 0),
        ("balls", _balls(of), False, bool(data.get("skeleton", {}).get("balls"))),
        ("parts", scene.parts_name, scene.parts_first, has_parts),
        ("contracted", "contracted mesh", False, "steps" in data),
        ("off_center", "nodes off their center (rings)", False, len(scene.off_center) > 0),
        ("mended", "where the surface was mended (diamonds)", False, "mended" in data),
    ]
    return [(name, label, shown) for name, label, shown, exists in layers if exists]


def _balls(of: Skeleton | None) -> str:
    """Name the balls by the kind of radii that they have."""
    return "inscribed balls" if of is None or of.radius_kind == "inscribed" else f"balls of {of.radius_kind} radii"


def _toggle(name: str, label: str, shown: bool) -> str:
    checked = " checked" if shown else ""
    box = f'<input type="checkbox" id="show-{name}" data-layer="{name}"{checked}>'
    return f"<label>{box} {escape(label)}</label>"


def _replay(data: dict[str, Any]) -> str:
    if "steps" not in data:
        return ""
    labels = data["steps"]["labels"]
    return REPLAY.format(text=escape(labels[0]), last=len(labels) - 1)
