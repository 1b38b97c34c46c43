"""Rigging: bones from the skeleton of a mesh, and smooth weights that bind its vertices to them.

Bones: :mod:`lbskel.applications.bones`; weights: :mod:`lbskel.applications.bone_heat`. Where the mesh is symmetric
(:mod:`lbskel.applications.mirror`), so are bones and weights, and the names tell left from right: left is where the
coordinate is larger, as of a character that faces +z with y up, or -y with z up. A root attracts vertices as the point
of its head; its tail only shows where up is.
"""

from __future__ import annotations

__all__ = ["rig"]

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.applications.bone_heat import bone_weights, keep_largest
from lbskel.applications.bones import Bones, bones_of
from lbskel.applications.mirror import MirrorPlane, find_mirror_plane
from lbskel.applications.mirrored_bones import paired_bones
from lbskel.errors import MeshError, checked_count, counted, first_few
from lbskel.geometry.mesh import as_mesh
from lbskel.preprocess import oriented_surface
from lbskel.skeleton.armature import Rig
from lbskel.skeleton.skeleton import Skeleton
from lbskel.skeleton.source import require_map

MAX_BONES = 30  # default; a choice: a human has a bone for each limb segment and finger
MAX_INFLUENCES = 4  # default; what real-time engines read
# Distance of a bone's ends from the mirror image of its twin, relative to the diameter bound; 0.035 to 0.07 do as well
# (benchmarks/results/rig.md, "Constants")
PAIR_DISTANCE = 0.05


def rig(mesh: Any, skeleton: Skeleton, *, max_bones: int = MAX_BONES, max_influences: int = MAX_INFLUENCES) -> Rig:
    """Make bones from a skeleton and bind a mesh to them.

    Parameters
    ----------
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
        The mesh that the skeleton was made from. It may be inside out or of mixed orientation, and vertices at one
        place have the same weights.
    skeleton : Skeleton
        With ``node_of_vertex``.
    max_bones : int
        Largest number of bones. The spine, the head and each limb have one before a limb has a second, but ends of
        limbs such as fingers; where these are too many, the shortest have none. ``notes`` tells the limbs without one.
    max_influences : int
        Largest number of bones that a vertex follows.

    Raises
    ------
    MeshError
        If the skeleton has no map from the vertices of this mesh, the mesh has no size, a radius of the skeleton is
        not known, or there are more components than ``max_bones``.
    UnknownChoice
        If a number is no whole number from 1 on.
    SolveError
        If the weights cannot be solved for.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import capsule
    >>> rod = capsule(6.0, 0.5)
    >>> rigged = lbskel.rig(rod, lbskel.skeletonize(rod))
    >>> rigged.names
    ('root', 'spine_1', 'spine_2')
    """
    surface = as_mesh(mesh)
    if len(unknown := np.flatnonzero(~np.isfinite(skeleton.radii))):
        raise MeshError(f"the radius of node {unknown[0]} is not known, and the lengths of bones follow from the radii")
    checked_count(max_bones, "max_bones", 1)
    checked_count(max_influences, "max_influences", 1)
    if surface.diameter_bound == 0:
        raise MeshError("the mesh has no size: all its vertices are at one point")
    if not np.isfinite([surface.diameter_bound, surface.area]).all():
        raise MeshError("the mesh is too large for its area to be finite: scale it")
    require_map(skeleton, surface.vertices)
    bones = bones_of(skeleton, max_bones=max_bones)
    plane = find_mirror_plane(surface)
    heads, tails = bones.heads, bones.tails
    twins, limb_ends, off = np.full(len(heads), -1), bones.limb_ends, 0.0
    if plane is not None:
        limit = PAIR_DISTANCE * surface.diameter_bound
        given, (bones, twins) = bones, paired_bones(bones, plane, surface.vertices, limit, max_bones)
        off = 0.0 if bones is given else limit  # mirrored bones end near the ends of their limbs
        heads, tails = bones.heads, bones.tails
        lengths = np.linalg.norm(tails - heads, axis=1, keepdims=True)
        heads, tails = (_symmetric(points, twins, plane) for points in (heads, tails))
        upward = np.eye(3)[1 if abs(plane.normal[1]) < 0.5 else 2]
        tails = np.where(bones.branches[:, None] < 0, heads + lengths * upward, tails)
    oriented, representative = oriented_surface(surface)
    ends = np.where(bones.branches[:, None] < 0, heads, tails)  # the tail of a root is arbitrary
    weights = bone_weights(oriented, heads, ends, bones.parents, bones.bone_of_vertex)
    if plane is not None:
        weights = _symmetric_weights(weights, twins, _merged_twins(plane.twins, representative))
    names = _names(bones, twins, plane)
    weights = keep_largest(weights, max_influences)[representative]
    notes = _notes(bones, limb_ends, off, max_bones)
    return Rig(surface, names, heads, tails, bones.parents, weights, notes)


def _notes(bones: Bones, limb_ends: NDArray[np.float64], limit: float, max_bones: int) -> tuple[str, ...]:
    """Tell the limbs at whose ends no bone ends, up to a distance."""
    distance = np.linalg.norm(limb_ends[:, None] - bones.tails[bones.branches >= 0], axis=2).min(axis=1, initial=np.inf)
    ends = [f"({', '.join(f'{x:.4g}' for x in end)})" for end in limb_ends[distance > limit].tolist()]
    if not ends:
        return ()
    return (
        f"{counted(len(ends), 'limb')} got no bone, with max_bones {max_bones}: with the ends {first_few(ends, 10)}",
    )


def _symmetric(points: NDArray[np.float64], twins: NDArray[np.int64], plane: MirrorPlane) -> NDArray[np.float64]:
    """Average each point with the mirror image of its twin."""
    has_twin = twins >= 0
    moved = points.copy()
    moved[has_twin] = (points[has_twin] + plane.mirrored(points[twins[has_twin]])) / 2
    return moved


def _merged_twins(twins: NDArray[np.int64], representative: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) for each representative the one of its twin, which one of the vertices at its place has; -1 elsewhere."""
    found, has_twin = np.full(len(twins), -1), twins >= 0
    found[representative[has_twin]] = representative[twins[has_twin]]
    return found


def _symmetric_weights(
    weights: NDArray[np.float64], twins: NDArray[np.int64], vertex_twins: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Average the weights of each vertex with those of the twin bones at its twin, if all bones have twins."""
    rows = np.flatnonzero(vertex_twins >= 0)
    if not (twins >= 0).all() or len(rows) == 0:
        return weights
    averaged = weights.copy()
    averaged[rows] = (weights[rows] + weights[vertex_twins[rows]][:, twins]) / 2
    return averaged


def _names(bones: Bones, twins: NDArray[np.int64], plane: MirrorPlane | None) -> tuple[str, ...]:
    """Name the bones: root; spine with a number if a bone is its own twin; else limb with number, side and position."""
    names: list[str] = []
    n_limbs = n_spine = 0
    limb_of_branch: dict[tuple[int, bool], int] = {}
    position: dict[tuple[int, str], int] = {}
    for bone, (branch, twin) in enumerate(zip(bones.branches.tolist(), twins.tolist(), strict=True)):
        if branch < 0:
            names.append("root" if bone == 0 else f"root_{bone + 1}")
            continue
        if twin == bone:
            n_spine += 1
            names.append(f"spine_{n_spine}")
            continue
        side = ""
        if twin >= 0 and plane is not None:
            heights = plane.heights(
                np.stack([bones.heads[bone] + bones.tails[bone], bones.heads[twin] + bones.tails[twin]]) / 2
            )
            side = "_left" if heights[0] > heights[1] else "_right"
        key = branch, twin >= 0
        if key not in limb_of_branch:
            n_limbs += 1
            limb_of_branch[key] = n_limbs
            if twin >= 0:
                limb_of_branch[int(bones.branches[twin]), True] = n_limbs
        limb = limb_of_branch[key]
        position[limb, side] = position.get((limb, side), 0) + 1
        names.append(f"limb_{limb}{side}_{position[limb, side]}")
    return tuple(names)
