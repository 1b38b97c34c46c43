"""Simplification that is checked: fewer triangles, the same topology, and the way of every vertex.

Collapses by quadric error, Garland, Heckbert 1997, https://doi.org/10.1145/258734.258849; by fast-simplification, which
returns its collapses, so that the vertex map is exact. It may break topology or miss its target without a word, so both
are compared afterwards, and slower schedules are tried; then libigl's collapses of short edges, which keep topology.
"""

from __future__ import annotations

__all__ = ["simplify"]

from collections.abc import Iterator
from dataclasses import replace

import fast_simplification
import igl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.errors import UnknownChoice
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, distance_between, identity_result, measured
from lbskel.preprocess.transfer import transfer_map

AGGRESSIVENESS = (4.0, 2.0)  # how fast the error allowed grows: half the distance of its own 7 in the same time
MISSED = 1.1  # times the target that still counts as met
FEWEST_FACES = 4
SHORTER = 0.7  # of the faces of the last try, while an error is allowed
FAR = 0.02  # of the diagonal: beyond, another surface has come out


@measured
def simplify(mesh: Mesh, *, target_faces: int | None = None, error: float | None = None) -> PreprocessResult:
    """Collapse edges until about so many faces are left, or until the surface has moved by so much.

    Parameters
    ----------
    mesh : Mesh
    target_faces : int, optional
    error : float, optional
        Largest distance of the surfaces, measured at samples, as a fraction of the diagonal; one of both is needed.

    Returns
    -------
    PreprocessResult
        The mesh unchanged, and a note, where its topology or the target could not be kept. The report has the
        ``deviation``, the largest distance of the two surfaces.

    Raises
    ------
    UnknownChoice
        If neither or both are given, or what is given is not positive.
    """
    if target_faces is not None and error is None:
        if not target_faces > 0:
            raise UnknownChoice(f"target_faces must be positive, not {target_faces}")
        return _to_target(mesh, target_faces, FAR)
    if error is None or target_faces is not None:
        raise UnknownChoice("give either target_faces or error")
    if not error > 0:
        raise UnknownChoice(f"error must be positive, not {error}")
    best, target = identity_result(mesh), SHORTER * len(mesh.faces)
    while target >= FEWEST_FACES:
        tried = _to_target(mesh, int(target), error)
        if tried.mesh is mesh:
            break
        best, target = tried, SHORTER * target
    return best


def _to_target(mesh: Mesh, target: int, error: float) -> PreprocessResult:
    """The first of the ways to simplify a mesh that keeps topology and distance; the mesh itself if none does."""
    if len(mesh.faces) <= target:
        return identity_result(mesh)
    topology = _topology(mesh)
    for simple in _candidates(mesh, target):
        if len(simple.mesh.faces) > MISSED * target or _topology(simple.mesh) != topology:
            continue
        distance = distance_between(mesh, simple.mesh)
        if distance <= error:
            n_faces = f"{len(mesh.faces):,} faces were simplified to {len(simple.mesh.faces):,}"
            note = f"{n_faces}{', '.join(('', *simple.notes))}"
            return replace(simple, notes=(note,), report={"deviation": distance * mesh.diagonal})
    note = f"{len(mesh.faces):,} faces could not be simplified to {target:,} without breaking the topology or the shape"
    return identity_result(mesh, note)


def _candidates(mesh: Mesh, target: int) -> Iterator[PreprocessResult]:
    """Proxy meshes, made one after the other as they are asked for."""
    unit, exponent = unit_scale(mesh.vertices)  # one of both takes single precision, which ends at 1e38

    def in_place(V: NDArray[np.float64], F: NDArray[np.int64]) -> Mesh:
        return Mesh(np.ldexp(V, exponent), F, mesh.notes)

    for aggressiveness in AGGRESSIVENESS:
        V, F = np.array(unit), np.array(mesh.faces)  # it refuses read-only arrays
        V, F, collapses = fast_simplification.simplify(
            V, F, target_count=target, agg=aggressiveness, return_collapses=True
        )
        if len(F) == 0 or not np.abs(V).max() <= 2:  # never of NaN
            continue
        vertex_map = _way_of_collapses(collapses, mesh.faces, len(mesh.vertices))
        if vertex_map.max() == len(V) - 1:
            lost = vertex_map < 0
            if lost.any():
                vertex_map[lost] = cKDTree(V).query(unit[lost])[1]
            yield PreprocessResult(in_place(V, F), VertexMap(vertex_map))
    if mesh.is_closed_manifold:
        V, F, *_ = igl.decimate(np.asfortranarray(unit), np.asfortranarray(mesh.faces, dtype=np.int32), target)
        if len(F) and np.isfinite(V).all():
            note = "by libigl, since fast-simplification missed the target or the topology"
            yield transfer_map(mesh, in_place(V, F), note)


def _way_of_collapses(collapses: NDArray[np.integer], faces: NDArray[np.int64], n: int) -> NDArray[np.int64]:
    """(n,) the new number of the vertex that each has gone into; those that are left keep their order.

    -1 for vertices that have lost all their faces. The library's own replay takes as long as its simplification, and
    rounds to single precision.
    """
    into = np.arange(n)
    into[collapses[:, 1]] = collapses[:, 0]
    while not np.array_equal(further := into[into], into):
        into = further
    A, B, C = into[faces].T
    is_left = np.zeros(n, dtype=bool)
    is_left[into[faces[(A != B) & (B != C) & (C != A)]]] = True
    return np.where(is_left, np.cumsum(is_left) - 1, -1)[into]


def _topology(mesh: Mesh) -> tuple[int, int, int, bool, bool]:
    """What simplification must not change."""
    boundary = mesh.edges[mesh.faces_per_edge == 1]
    n_loops = Mesh(mesh.vertices, np.column_stack([boundary, boundary[:, 0]])).n_components if len(boundary) else 0
    return mesh.euler_characteristic, mesh.n_components, n_loops, mesh.is_edge_manifold, mesh.is_closed_manifold
