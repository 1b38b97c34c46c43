"""Simplification that is checked: fewer triangles, the same topology, and the way of every vertex.

Collapses by quadric error, Garland, Heckbert 1997, https://doi.org/10.1145/258734.258849; by fast-simplification, which
returns its collapses, so that the vertex map is exact. It may break topology or miss its target without a word, so both
are compared afterwards, and a slower schedule is tried before giving up.
"""

from __future__ import annotations

__all__ = ["simplify"]

import fast_simplification
import numpy as np

from lbskel.errors import UnknownChoice
from lbskel.mesh import Mesh
from lbskel.preprocess.tidying import Preprocessed

AGGRESSIVENESS = (7.0, 4.0, 2.0)  # how fast the error allowed grows: fast-simplification's own, then slower
MISSED = 1.1  # times the target that still counts as met


def simplify(mesh: Mesh, *, target_faces: int) -> Preprocessed:
    """Collapse edges until about so many faces are left.

    Parameters
    ----------
    mesh : Mesh
    target_faces : int

    Returns
    -------
    Preprocessed
        The mesh unchanged, and a note, where its topology or the target could not be kept.

    Raises
    ------
    UnknownChoice
        If the target is not positive.
    """
    if not target_faces > 0:
        raise UnknownChoice(f"target_faces must be positive, not {target_faces}")
    n = len(mesh.vertices)
    if len(mesh.faces) <= target_faces:
        return Preprocessed(mesh, np.arange(n))
    for aggressiveness in AGGRESSIVENESS:
        V, F = np.array(mesh.vertices), np.array(mesh.faces)  # it refuses read-only arrays
        *_, collapses = fast_simplification.simplify(
            V, F, target_count=target_faces, agg=aggressiveness, return_collapses=True
        )
        V, F, vertex_map = fast_simplification.replay_simplification(V, F, collapses)
        if len(F) == 0 or len(F) > MISSED * target_faces or vertex_map.min() < 0 or not np.isfinite(V).all():
            continue
        simple = Mesh(V, F, mesh.notes)
        if _topology(simple) == _topology(mesh):
            note = f"{len(mesh.faces):,} faces were simplified to {len(F):,}"
            return Preprocessed(simple, np.asarray(vertex_map, dtype=np.int64), (note,))
    note = f"{len(mesh.faces):,} faces could not be simplified to {target_faces:,} without breaking the topology"
    return Preprocessed(mesh, np.arange(n), (note,))


def _topology(mesh: Mesh) -> tuple[int, int, int, bool, bool]:
    """What simplification must not change."""
    boundary = mesh.edges[mesh.faces_per_edge == 1]
    n_loops = Mesh(mesh.vertices, np.column_stack([boundary, boundary[:, 0]])).n_components if len(boundary) else 0
    return mesh.euler_characteristic, mesh.n_components, n_loops, mesh.is_edge_manifold, mesh.is_closed_manifold
