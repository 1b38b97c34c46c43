"""A mesh, its skeleton, and how one became the other, as an interactive page."""

from __future__ import annotations

__all__ = ["view", "view_scene"]

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.applications import branch_table
from lbskel.errors import UnknownChoice, counted
from lbskel.evaluation.measures import MEASURES
from lbskel.evaluation.scoring import centeredness_errors, require_scorable
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.geometry.surface_queries import Surface
from lbskel.io import as_shape
from lbskel.io.atomic_write import writable_target
from lbskel.pipeline.options import PAGE_OPTIONS
from lbskel.pipeline.preparation import PreparedMesh, prepare
from lbskel.pipeline.replay import replay, what_is_told
from lbskel.pipeline.stages import skeletonize
from lbskel.preprocess import Pipeline, reconstruct_surface
from lbskel.skeleton.skeleton import Skeleton
from lbskel.skeleton.source import require_near
from lbskel.visualization import Scene, Table, page
from lbskel.visualization.interactive import require_plotly

# Distance of a repaired surface from the given one, in diameter bounds, above which it is marked as mended. It is less
# than a pixel of a page. A choice of style.
MENDED_DISTANCE = 1e-3


def view(
    mesh: Any,
    path: str | os.PathLike[str],
    *,
    skeleton: Skeleton | None = None,
    title: str = "",
    force: bool = False,
    **options: Any,
) -> Skeleton:
    """Write an interactive page of a mesh or point cloud and its skeleton, which needs no network.

    The page shows the mesh, the skeleton colored by radius, every step of the contraction, inscribed balls, parts by
    branch, nodes off their center and mended surface, the branch table, the report and the score.

    Parameters
    ----------
    mesh : Mesh, PointCloud, (vertices, faces), (n, 3) array, path, or mesh or cloud object
        Whatever :func:`lbskel.skeletonize` takes.
    path : path-like
        HTML file to write; below 8 MB, since large surfaces are simplified for display.
    skeleton : Skeleton, optional
        Of the mesh, in place of one that is made. The contraction and the score are shown if its report has them.
    title : str
        Heading of the page.
    force : bool
        Whether an existing file may be replaced.
    **options
        Of :func:`lbskel.skeletonize`; with a skeleton only ``preprocess`` and ``simplify``.

    Returns
    -------
    Skeleton
        The skeleton that is shown.

    Raises
    ------
    FormatError
        If the file exists and ``force`` is not set, or it cannot be written.
    MeshError
        If the input is no mesh or cloud, or encloses nothing, or the skeleton has no nodes, maps another number of
        vertices, or lies elsewhere.
    MissingDependency
        If plotly is not installed.
    UnknownChoice
        If an option has a value that is in no table, or no effect since a skeleton is given.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     skeleton = lbskel.view(torus(1.0, 0.2), Path(folder) / "ring.html", title="a ring")
    ...     (Path(folder) / "ring.html").stat().st_size < 8_000_000
    True
    """
    require_plotly()
    preparing = {name: options[name] for name in PAGE_OPTIONS if name in options}
    unused = sorted(options.keys() - preparing.keys())
    if skeleton is not None and unused:
        raise UnknownChoice(f"{', '.join(unused)}: the skeleton is given, so leave out how it is to be made")
    writable_target(Path(path), force)  # before anything is computed
    shape = as_shape(mesh)
    if skeleton is None:
        skeleton = skeletonize(shape, **options)
    page(view_scene(shape, skeleton, title=title, **preparing), path, force=force)
    return skeleton


def view_scene(
    shape: Mesh | PointCloud,
    skeleton: Skeleton,
    *,
    title: str = "",
    preprocess: str | Pipeline | None = "auto",
    simplify: str = "auto",
) -> Scene:
    """Collect what :func:`view` shows.

    Parameters
    ----------
    shape : Mesh or PointCloud
    skeleton : Skeleton
        The skeleton of the shape.
    title : str
        Heading of the page.
    preprocess, simplify
        As for :func:`lbskel.skeletonize`.

    Raises
    ------
    MeshError
        If the skeleton has no nodes, maps another number of vertices, or lies elsewhere.
    """
    points = shape.points if isinstance(shape, PointCloud) else shape.vertices
    require_scorable(skeleton, len(points))
    require_near(skeleton, points)
    if isinstance(shape, PointCloud):
        cleaning = "none" if preprocess is None else preprocess
        source = reconstruct_surface(shape, preprocess=cleaning).mesh  # type: ignore[arg-type]
        prepared, mesh = prepare(source, simplify=simplify), None
        skeleton_of_source = _without_map(skeleton)
    else:
        prepared = prepare(shape, preprocess=preprocess, simplify=simplify)
        mesh, skeleton_of_source = shape, skeleton
    has_map = mesh is not None and len(skeleton.node_of_vertex) == len(mesh.vertices)
    errors = centeredness_errors(prepared.skeleton_to_unit(skeleton_of_source), prepared.surface)
    contracted, positions, areas, volumes = replay(prepared, skeleton.report)
    columns = branch_table(skeleton, mesh if has_map else None).columns()
    return Scene(
        shape,
        skeleton,
        title,
        part_of_face=_branch_of_face(mesh, skeleton) if mesh is not None and has_map else None,
        contracted=contracted,
        positions=positions,
        area_ratios=areas,
        volume_ratios=volumes,
        columns={_words(name): values for name, values in columns.items() if "_at_" not in name},
        off_center=np.flatnonzero(errors > MEASURES["centeredness_error_worst_branch"].passes),
        mended=_mended(prepared) if mesh is not None else np.empty((0, 3)),
        tables=_tables(skeleton),
    )


def _without_map(skeleton: Skeleton) -> Skeleton:
    """Return nodes, edges and radii alone."""
    return Skeleton(skeleton.nodes, skeleton.edges, skeleton.radii)


def _branch_of_face(mesh: Mesh, skeleton: Skeleton) -> NDArray[np.int64]:
    """(m,) branch of each face: that of two of its vertices, or the middle number if all three differ.

    Nodes without an edge count as a branch each.
    """
    branch_of = len(skeleton.branches) + np.arange(len(skeleton.nodes))
    for number, branch in reversed(list(enumerate(skeleton.branches))):
        branch_of[branch] = number
    return np.sort(branch_of[skeleton.node_of_vertex][mesh.faces], axis=1)[:, 1]


def _mended(prepared: PreparedMesh) -> NDArray[np.float64]:
    """(p, 3) centers of the faces of the prepared mesh that are not on the given surface."""
    centers = prepared.frame.from_unit(prepared.mesh.vertices[prepared.mesh.faces].mean(axis=1))
    distances = Surface(prepared.source).distance(centers)
    mended: NDArray[np.float64] = centers[distances > MENDED_DISTANCE * prepared.frame.scale]
    return mended


def _tables(skeleton: Skeleton) -> list[Table]:
    """Tell the score and the report in words."""
    tables = [what_is_told(tell, skeleton.report) for tell in (_score_table, _report_table)]
    return [table for table in tables if table is not None]


def _score_table(report: dict[str, Any]) -> Table:
    """Tell the measures and their verdicts, a row each."""
    scored = report["score"]
    rows, kinds = [], []
    for name, measure in MEASURES.items():
        sign = "at least" if measure.passes > measure.fails else "at most"
        value, verdict = scored["measures"][name], scored["verdicts"][name]
        rows.append((_words(name), value, verdict, f"{sign} {measure.passes:g}", measure.text))
        kinds.append(verdict if verdict in ("pass", "warn", "fail") else "")
    head = ("measure", "value", "verdict", "passes with", "what it measures")
    return Table(f"Score: {scored['verdict']}", head, rows, kinds)


def _report_table(report: dict[str, Any]) -> Table:
    """Tell what was done, a row each."""
    rows: list[tuple[str, Any]] = [(f"{name} given", value) for name, value in report["input"].items()]
    rows.extend(("note", note) for note in report["notes"])
    for number, body in enumerate(report["components"], 1):
        genus = "open or not manifold" if body["genus"] is None else counted(body["genus"], "handle")
        cycles = counted(body["cycle_rank"], "cycle")
        rows.append((f"body {number}", f"{counted(body['faces'], 'face')}, {genus}; {cycles} in the skeleton"))
        rows.append((f"body {number}, contraction", f"{counted(len(body['steps']), 'step')}, until {body['status']}"))
        rows.extend((f"body {number}, note", note) for note in body["notes"])
    rows.extend((f"seconds to {stage}", round(seconds, 3)) for stage, seconds in report["seconds"].items())
    return Table("Report", ("what", ""), rows)


def _words(name: str) -> str:
    return name.replace("_", " ")
