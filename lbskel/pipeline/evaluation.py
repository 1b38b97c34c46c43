"""The score of a skeleton on the mesh or the cloud that a user has."""

from __future__ import annotations

__all__ = ["score", "score_cloud", "score_prepared"]

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.errors import MeshError
from lbskel.evaluation.measures import Score
from lbskel.evaluation.point_scoring import score_points
from lbskel.evaluation.scoring import require_scorable, score_on
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.mesh import PointCloud
from lbskel.io import as_shape
from lbskel.pipeline.preparation import PreparedMesh, prepare
from lbskel.preprocess import Pipeline
from lbskel.skeleton.joining import joining_by_report
from lbskel.skeleton.short_loops import n_opened_loops
from lbskel.skeleton.skeleton import Skeleton


def score(skeleton: Skeleton, mesh: Any, *, preprocess: str | Pipeline | None = "auto") -> Score:
    """Measure a skeleton on its mesh, which is prepared first as :func:`lbskel.skeletonize` does, or on its cloud.

    ``lbskel.skeletonize(mesh).report["score"]`` is the report of this score.

    Parameters
    ----------
    skeleton : Skeleton
        In the coordinates of the mesh. Without a map, each vertex is mapped to the nearest ball, and the measures of
        the map are ``None``. Loops that were opened on purpose according to its report do not count as lost. Edges that
        join pieces, or that join bodies according to its report, are not measured.
    mesh : Mesh, PointCloud, (vertices, faces), (n, 3) array, path, mesh or cloud object, or PreparedMesh
        What the skeleton was made from. On a cloud, sections, coverage, tips and parts are measured by the points
        alone, and the measures of a surface are ``None``.
    preprocess : str, Pipeline or None
        As for :func:`lbskel.skeletonize`; a PreparedMesh is taken as it is, and so is a cloud.

    Raises
    ------
    MeshError
        If the input is no mesh or has no area, the skeleton has no nodes, or its map is for another mesh.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> mesh = torus(1.0, 0.2)
    >>> skeleton = lbskel.skeletonize(mesh)
    >>> lbskel.score(skeleton, mesh).verdict
    'pass'
    >>> cut = lbskel.Skeleton(skeleton.nodes, skeleton.edges[1:], skeleton.radii, skeleton.node_of_vertex)
    >>> lbskel.score(cut, mesh).extra_cycles
    -1
    """
    if not isinstance(skeleton, Skeleton):
        raise MeshError(f"a score needs a Skeleton and its mesh, in this order, not {type(skeleton).__name__} first")
    if isinstance(mesh, PreparedMesh):
        return score_prepared(skeleton, mesh)
    shape = as_shape(mesh)
    if isinstance(shape, PointCloud):
        return score_cloud(skeleton, shape)
    return score_prepared(skeleton, prepare(shape, preprocess=preprocess))


def score_prepared(skeleton: Skeleton, prepared: PreparedMesh, *, deadline: Deadline = NEVER) -> Score:
    """Measure a skeleton on a prepared mesh.

    Parameters
    ----------
    skeleton : Skeleton
    prepared : PreparedMesh
    deadline : Deadline
        After it, OutOfTime is raised.
    """
    require_scorable(skeleton, len(prepared.source.vertices))
    unit = prepared.skeleton_to_unit(skeleton)
    is_joining = joining_by_report(skeleton)
    if is_joining is None:
        is_joining = _joins_bodies(unit, prepared)
    unit = replace(unit, edges=unit.edges[~is_joining])
    deadline.check()
    open_ends = np.concatenate([body.open_ends for body in prepared.bodies])
    surface = replace(prepared.surface, deadline=deadline)
    return score_on(unit, surface, open_ends=open_ends, n_loops_opened=n_opened_loops(skeleton))


def score_cloud(skeleton: Skeleton, cloud: PointCloud, neighbors: NDArray[np.int64] | None = None) -> Score:
    """Measure a skeleton on a cloud, without the edges between its parts that join bodies according to the report.

    Parameters
    ----------
    skeleton : Skeleton
    cloud : PointCloud
    neighbors : (n, k) array of int, optional
        As for :func:`lbskel.evaluation.point_scoring.score_points`.
    """
    require_scorable(skeleton, len(cloud.points))
    return score_points(skeleton, cloud, neighbors, joining_by_report(skeleton))


def _joins_bodies(skeleton: Skeleton, prepared: PreparedMesh) -> NDArray[np.bool_]:
    """(e,) whether each edge joins two pieces, or two bodies if the report says that they were joined on purpose.

    The body of a node is that of the last vertex that it represents, or else of the vertex nearest to it, which may be
    another's where bodies overlap.
    """
    mesh = prepared.mesh
    is_joinable = np.zeros(mesh.n_components, dtype=bool)
    for body in prepared.bodies:
        was_joined = body.is_piece or skeleton.report.get("pieces_joined", 0) > 0
        is_joinable[mesh.component_of_vertex[body.vertices[0]]] = was_joined
    used = mesh.used_vertices
    body_of_node = mesh.component_of_vertex[used[cKDTree(mesh.vertices[used]).query(skeleton.nodes)[1]]]
    if len(skeleton.node_of_vertex):
        body_of_node[skeleton.node_of_vertex[used]] = mesh.component_of_vertex[used]
    i, j = body_of_node[skeleton.edges].T
    is_between: NDArray[np.bool_] = (i != j) & is_joinable[i] & is_joinable[j]
    return is_between
