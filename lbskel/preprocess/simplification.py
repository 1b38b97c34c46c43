"""Simplification by edge collapses, with a vertex map and a check that the topology is kept.

Quadric error collapses, Garland, Heckbert 1997, https://doi.org/10.1145/258734.258849, by fast-simplification, which
returns its collapses, so that the vertex map is exact. But within an error bound, chains of collapses that cost nothing
carry vertices along flat and ruled parts, so there :mod:`lbskel.preprocess.transfer` maps them.

The library may change the topology or miss its target silently, so both are checked afterwards. If one fails, a slower
schedule is tried, then, on closed manifolds, libigl's collapses of short edges, which keep the topology.
"""

from __future__ import annotations

__all__ = ["fewest_faces", "simplify", "topology_of"]

import math
from collections.abc import Iterator
from dataclasses import replace

import fast_simplification
import igl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.errors import UnknownChoice, were
from lbskel.geometry.components import MIN_FACES
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import (
    MAX_DISTANCE,
    PreprocessResult,
    hausdorff_distance,
    identity_result,
    preprocess_step,
)
from lbskel.preprocess.transfer import transfer_map

# How fast fast-simplification raises its error threshold, tried in this order. Measured: 4 leaves half the distance of
# the library's default of 7 in the same time; not in a committed table.
AGGRESSIVENESS = (4.0, 2.0)

TARGET_TOLERANCE = 1.1  # faces that still meet the target, relative to it; a guess

# Coordinates are rounded to multiples of this share of half the diameter bound, far above their rounding errors, which
# decide between equal collapses else, and those of a mesh of voxels are nearly all equal. It bounds by how much a
# rotation moves the skeleton of a large mesh. benchmarks/results/voxels.md: four such meshes in four units and places
# have 15 graphs without rounding, 9 with 2^-40, and one each from 2^-34 on; by hand, those of neurons need 2^-30
ROUNDING = 2.0**-30

# Number of faces of the next attempt, relative to the last, while the error bound is met. A guess.
REDUCTION = 0.7


@preprocess_step
def simplify(mesh: Mesh, *, target_faces: int | None = None, error: float | None = None) -> PreprocessResult:
    """Collapse edges until a number of faces is reached, or as far as an error bound allows.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    target_faces : int, optional
        Number of faces to reach; the result has at most a tenth more.
    error : float, optional
        Largest Hausdorff distance, measured at samples, as a fraction of the diameter bound. Exactly one of
        ``target_faces`` and ``error`` must be given.

    Returns
    -------
    PreprocessResult
        The simplified mesh; its report has the ``deviation``, the Hausdorff distance in the units of the mesh. If the
        topology could not be kept or the target not be met, the unchanged mesh and a note.

    Raises
    ------
    UnknownChoice
        If neither or both are given, or the given one is not positive, or no whole number of faces.
    """
    if target_faces is not None and error is None:
        if not (target_faces > 0 and target_faces % 1 == 0):
            raise UnknownChoice(f"target_faces must be a positive whole number, not {target_faces}")
        return _to_target(mesh, int(target_faces), MAX_DISTANCE)
    if error is None or target_faces is not None:
        raise UnknownChoice(
            "simplify needs one of target_faces and error, as the steps simplify:target_faces=2000 "
            "or simplify:error=0.01"
        )
    if not error > 0:
        raise UnknownChoice(f"error must be positive, not {error}")
    best, target = identity_result(mesh), REDUCTION * len(mesh.faces)
    while target >= MIN_FACES:
        attempt = _to_target(mesh, int(target), error)
        if attempt.mesh is mesh:
            break
        best, target = attempt, REDUCTION * target
    if best.mesh is mesh:
        note = f"{were(len(mesh.faces), 'face')} not simplified: none could be spared with error={error:g}"
        return identity_result(mesh, note)
    return replace(transfer_map(mesh, best.mesh, *best.notes), report=best.report)


def _to_target(mesh: Mesh, target: int, error: float) -> PreprocessResult:
    """Return the first candidate that keeps topology and distance; the unchanged mesh if none does."""
    if len(mesh.faces) <= target:
        return identity_result(mesh)
    if mesh.genus and target < (needed := fewest_faces(mesh.genus)):
        note = f"{len(mesh.faces):,} faces were not simplified to {target:,}, since genus {mesh.genus} needs {needed:,}"
        return identity_result(mesh, note)
    expected = topology_of(mesh)
    for simple in _candidates(mesh, target):
        if len(simple.mesh.faces) > TARGET_TOLERANCE * target or topology_of(simple.mesh) != expected:
            continue
        distance = hausdorff_distance(mesh, simple.mesh)
        if distance <= error:
            n_faces = f"{len(mesh.faces):,} faces were simplified to {len(simple.mesh.faces):,}"
            note = f"{n_faces}{', '.join(('', *simple.notes))}"
            return replace(simple, notes=(note,), report={"deviation": distance * mesh.diameter_bound})
    note = f"{len(mesh.faces):,} faces could not be simplified to {target:,} without changing the topology or the shape"
    return identity_result(mesh, note)


def fewest_faces(genus: int) -> int:
    """Compute the fewest faces that a closed surface can have.

    From Heawood's bound on the vertices, which is reached except for genus 2: Jungerman, Ringel 1980, "Minimal
    triangulations on orientable surfaces", https://doi.org/10.1007/BF02414187.

    Parameters
    ----------
    genus : int
        Of all components together.
    """
    n_vertices = math.ceil((7 + math.sqrt(1 + 48 * genus)) / 2)
    return 2 * (n_vertices - 2 + 2 * genus)


def _candidates(mesh: Mesh, target: int) -> Iterator[PreprocessResult]:
    """Generate simplified meshes, each made only when it is asked for."""
    # fast-simplification has thresholds without a unit: the smaller a mesh is, the more edges it collapses at once. By
    # hand, errors of the 28 hard shapes with a half, a third and a quarter of the bound for unit:
    # 0.0078, 0.0081, 0.0091. The bound does not change when the mesh is rotated, as the bounding box does
    center, length = mesh.centroid, mesh.diameter_bound / 2 or 1.0
    unit = (mesh.vertices - center) / length
    near = np.rint(np.clip(unit, -1.0, 1.0) / ROUNDING) * ROUNDING  # a vertex without a face may lie anywhere

    def in_caller_units(V: NDArray[np.float64], F: NDArray[np.int64]) -> Mesh:
        return Mesh(length * V + center, F, mesh.notes)

    for aggressiveness in AGGRESSIVENESS:
        V, F = np.array(near), np.array(mesh.faces)  # fast-simplification rejects read-only arrays
        V, F, collapses = fast_simplification.simplify(
            V, F, target_count=target, agg=aggressiveness, return_collapses=True
        )
        if len(F) == 0 or not np.abs(V).max() <= 2:  # also true for NaN
            continue
        vertex_map = _vertex_map_of_collapses(collapses, mesh.faces, len(mesh.vertices))
        if vertex_map.max() == len(V) - 1:
            is_lost = np.zeros(len(vertex_map), dtype=bool)
            is_lost[mesh.used_vertices] = vertex_map[mesh.used_vertices] < 0
            if is_lost.any():
                vertex_map[is_lost] = cKDTree(V).query(unit[is_lost])[1]
            yield PreprocessResult(in_caller_units(V, F), VertexMap(vertex_map))
    if mesh.is_closed_manifold:
        V, F, *_ = igl.decimate(np.asfortranarray(near), np.asfortranarray(mesh.faces, dtype=np.int32), target)
        if len(F) and np.isfinite(V).all():
            note = "by libigl, since fast-simplification missed the target or changed the topology"
            yield transfer_map(mesh, in_caller_units(V, F), note)


def _vertex_map_of_collapses(collapses: NDArray[np.integer], faces: NDArray[np.int64], n: int) -> NDArray[np.int64]:
    """(n,) new number of the vertex that each vertex was merged into; kept vertices keep their order.

    -1 for vertices that have lost all their faces. The library's own replay takes as long as its simplification, and
    rounds to single precision.
    """
    merged_into = np.arange(n)
    merged_into[collapses[:, 1]] = collapses[:, 0]
    while not np.array_equal(further := merged_into[merged_into], merged_into):
        merged_into = further
    A, B, C = merged_into[faces].T
    is_kept = np.zeros(n, dtype=bool)
    is_kept[merged_into[faces[(A != B) & (B != C) & (C != A)]]] = True
    return np.where(is_kept, np.cumsum(is_kept) - 1, -1)[merged_into]


def topology_of(mesh: Mesh) -> tuple[int, int, int, bool, bool]:
    """Compute what simplification must not change: Euler characteristic, components, boundary loops, manifoldness.

    Parameters
    ----------
    mesh : Mesh
    """
    boundary = mesh.edges[mesh.faces_per_edge == 1]
    n_loops = Mesh(mesh.vertices, np.column_stack([boundary, boundary[:, 0]])).n_components if len(boundary) else 0
    return mesh.euler_characteristic, mesh.n_components, n_loops, mesh.is_edge_manifold, mesh.is_closed_manifold
