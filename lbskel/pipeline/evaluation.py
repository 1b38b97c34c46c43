"""The score of a skeleton on the mesh that a user has."""

from __future__ import annotations

__all__ = ["score"]

from typing import Any

from lbskel.errors import MeshError
from lbskel.evaluation.measures import Score
from lbskel.evaluation.scoring import require_scorable, score_on
from lbskel.pipeline.preparation import PreparedMesh, prepare
from lbskel.preprocess import Pipeline
from lbskel.skeleton.skeleton import Skeleton


def score(skeleton: Skeleton, mesh: Any, *, preprocess: str | Pipeline | None = "auto") -> Score:
    """Measure a skeleton on its mesh, which is prepared first as :func:`lbskel.skeletonize` does.

    ``lbskel.skeletonize(mesh).report["score"]`` is the report of this score.

    Parameters
    ----------
    skeleton : Skeleton
        In the coordinates of the mesh. Without a map, each vertex is mapped to the nearest ball, and the measures of
        the map are ``None``.
    mesh : Mesh, (vertices, faces), path, mesh object or PreparedMesh
        The mesh that the skeleton was made from.
    preprocess : str, Pipeline or None
        As for :func:`lbskel.skeletonize`; a PreparedMesh is taken as it is.

    Raises
    ------
    MeshError
        If the input is no mesh or has no area, the skeleton has no nodes or some that are not finite, or its map is
        for another mesh.

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
    prepared = mesh if isinstance(mesh, PreparedMesh) else prepare(mesh, preprocess=preprocess)
    require_scorable(skeleton, prepared.source)
    return score_on(prepared.skeleton_to_unit(skeleton), prepared.surface)
