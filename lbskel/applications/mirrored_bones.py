"""Bones of a symmetric mesh in pairs: each with a twin at its mirror image, or itself in the plane.

A skeleton is nearly as symmetric as its mesh, so most bones find their twin. Where one has none, as a finger of one
bone on one side and of two on the other, the bones of the side with more are mirrored to the other one. A branch from
the middle whose part of the surface is mirrored onto itself, as a head's is, stays one, and its bones go to the plane.
"""

from __future__ import annotations

__all__ = ["paired_bones", "twin_bones"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.applications.bones import Bones
from lbskel.applications.mirror import MirrorPlane


def twin_bones(bones: Bones, plane: MirrorPlane, vertices: NDArray[np.float64], limit: float) -> NDArray[np.int64]:
    """(b,) for each bone the one at its mirror image, or itself if it is in the middle; -1 where there is none.

    Parameters
    ----------
    bones : Bones
    plane : MirrorPlane
    vertices : (n, 3) array of float
        Of the mesh.
    limit : float
        Largest root of the summed squared distances of a bone's two ends from the mirror images of its twin's ends.
    """
    is_root = bones.branches < 0
    tails = np.where(is_root[:, None], bones.heads, bones.tails)  # that of a root is arbitrary
    ends = np.column_stack([bones.heads, tails])
    images = np.column_stack([plane.mirrored(bones.heads), plane.mirrored(tails)])
    distance, nearest = cKDTree(ends).query(images)
    is_twin = (nearest[nearest] == np.arange(len(ends))) & (distance <= limit) & (is_root == is_root[nearest])
    is_twin &= is_twin[nearest]
    # twins must hang on twins, from the roots outwards
    twins = np.where(is_twin, nearest, -1)
    is_own = ~is_twin & _is_mirrored_branch(bones, plane, vertices)
    lengths = np.linalg.norm(
        (tails - bones.heads) - np.outer((tails - bones.heads) @ plane.normal, plane.normal), axis=1
    )
    for bone, parent in enumerate(bones.parents.tolist()):
        if is_own[bone] and lengths[bone] > limit and (parent < 0 or twins[parent] == parent):
            twins[bone] = bone
        if twins[bone] >= 0 and parent >= 0 and twins[parent] != bones.parents[twins[bone]]:
            twins[[bone, twins[bone]]] = -1
    return twins


def _is_mirrored_branch(bones: Bones, plane: MirrorPlane, vertices: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(b,) whether most vertices of a bone's branch have their mirror images in the branch, as those of a head have."""
    image = cKDTree(vertices).query(plane.mirrored(vertices))[1]
    branch = bones.branches[bones.bone_of_vertex] + 1  # 0: of a root
    n = int(bones.branches.max()) + 2
    share = np.bincount(branch, branch[image] == branch, minlength=n) / np.bincount(branch, minlength=n).clip(min=1)
    is_mirrored: NDArray[np.bool_] = (share > 0.5)[bones.branches + 1] & (bones.branches >= 0)
    return is_mirrored


def paired_bones(
    bones: Bones, plane: MirrorPlane, vertices: NDArray[np.float64], limit: float, max_bones: int
) -> tuple[Bones, NDArray[np.int64]]:
    """Give every bone a twin, and return the bones and the twins.

    The bones are unchanged if there would be too many, if a root beside the plane has bones that are not on its side,
    or if the parent of a bone in the plane lies beside it.

    Parameters
    ----------
    bones : Bones
    plane : MirrorPlane
    vertices : (n, 3) array of float
        Of the mesh.
    limit : float
        As for :func:`twin_bones`; a bone whose ends are as near to the plane lies in it.
    max_bones : int
        Largest number of bones.
    """
    twins = twin_bones(bones, plane, vertices, limit)
    if (twins >= 0).all():
        return bones, twins
    tails = np.where((bones.branches < 0)[:, None], bones.heads, bones.tails)
    heights = plane.heights(tails)
    is_central = (twins == np.arange(len(twins))) | (
        (twins < 0) & (np.maximum(np.abs(heights), np.abs(plane.heights(bones.heads))) <= limit)
    )
    sides = np.where(is_central, 0, np.sign(heights)).astype(np.int64)
    root = np.arange(len(sides))
    for bone, parent in enumerate(bones.parents.tolist()):
        root[bone] = root[parent] if parent >= 0 else bone
    is_whole = bool((is_central[root] | (sides == sides[root])).all())
    is_whole &= bool(is_central[bones.parents[is_central & (bones.parents >= 0)]].all())
    counts = {side: int((sides == side).sum()) for side in (1, -1)}
    for side in sorted(counts, key=lambda each: -counts[each]):
        kept = np.flatnonzero(is_central | (sides == side))
        has_parents = bool(np.isin(bones.parents[kept], [*kept, -1]).all())
        if is_whole and has_parents and len(kept) + counts[side] <= max_bones and (counts[side] or not counts[-side]):
            return _mirrored(bones, plane, vertices, kept, sides, side)
    return bones, twins


def _mirrored(
    bones: Bones,
    plane: MirrorPlane,
    vertices: NDArray[np.float64],
    kept: NDArray[np.int64],
    sides: NDArray[np.int64],
    side: int,
) -> tuple[Bones, NDArray[np.int64]]:
    """Keep the bones of one side and those in the plane, and mirror those of the side."""
    k = len(kept)
    number = np.full(len(sides), -1)
    number[kept] = np.arange(k)
    copied = np.flatnonzero(sides[kept] == side)  # of those kept
    image = np.arange(k)
    image[copied] = k + np.arange(len(copied))
    parents = np.where(bones.parents[kept] >= 0, number[bones.parents[kept]], -1)
    branches = bones.branches[kept]
    copies = np.where(branches[copied] >= 0, branches[copied] + bones.branches.max() + 1, -1)
    found = Bones(
        np.concatenate([bones.heads[kept], plane.mirrored(bones.heads[kept[copied]])]),
        np.concatenate([bones.tails[kept], plane.mirrored(bones.tails[kept[copied]])]),
        np.concatenate([parents, np.where(parents[copied] >= 0, image[parents[copied]], -1)]),
        np.concatenate([branches, copies]),
        bones.bone_of_vertex,
    )
    upwards = np.arange(len(sides))
    for bone, parent in enumerate(bones.parents.tolist()):  # the bone kept that a bone hangs on
        if number[bone] < 0:
            upwards[bone] = upwards[parent] if parent >= 0 else kept[0]
    of_vertex = number[upwards[bones.bone_of_vertex]]
    is_here = side * plane.heights(vertices) >= 0
    here = np.flatnonzero(is_here)
    if len(here):
        nearest = here[cKDTree(vertices[here]).query(plane.mirrored(vertices[~is_here]))[1]]
        of_vertex[~is_here] = image[of_vertex[nearest]]
    twins = np.concatenate([image, copied])
    return replace(found, bone_of_vertex=of_vertex), twins
