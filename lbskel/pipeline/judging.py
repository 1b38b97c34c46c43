"""The score of a skeleton on the mesh that a user has, which is prepared first as :func:`lbskel.skeletonize` does."""

from __future__ import annotations

__all__ = ["score"]

from typing import Any

from lbskel.evaluation import scoring
from lbskel.evaluation.scoring import Score
from lbskel.io import as_mesh
from lbskel.preprocess import Pipeline, preprocess_mesh
from lbskel.refinement.vertex_map import complete_map
from lbskel.skeleton.skeleton import Skeleton


def score(skeleton: Skeleton, mesh: Any, *, preprocess: str | Pipeline | None = "auto") -> Score:
    """Measure a skeleton on its mesh.

    Parameters
    ----------
    skeleton : Skeleton
        In the coordinates of the mesh. Without a map, each vertex goes to the nearest ball, and the map is not judged.
    mesh : Mesh, (vertices, faces), path or mesh object
        What the skeleton was made from.
    preprocess : str, Pipeline or None
        As for :func:`lbskel.skeletonize`.

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
    given = as_mesh(mesh)
    scoring.check(skeleton, given)
    prepared = preprocess_mesh(given, preprocess)
    if len(skeleton.node_of_vertex):
        node_of_vertex = prepared.vertex_map.push_forward(skeleton.node_of_vertex, len(prepared.mesh.vertices))
        skeleton = complete_map(skeleton, node_of_vertex, prepared.mesh)
    return scoring.score(skeleton, prepared.mesh)
