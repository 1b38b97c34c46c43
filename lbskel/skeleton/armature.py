"""A rig: a mesh, bones in a tree, and for each vertex how much it follows each bone.

Linear blend skinning, Magnenat-Thalmann, Laperriere, Thalmann 1988, "Joint-dependent local deformations for hand
animation and object grasping": a vertex v moves to the sum over the bones b of w_b G_b v, with its weights w_b. G_b
turns about the rest position of the bone's head, and then moves as the G of the parent does.
"""

from __future__ import annotations

__all__ = ["Rig"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.errors import MeshError, counted
from lbskel.geometry.arrays import read_only
from lbskel.geometry.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Rig:
    """A mesh with bones in its rest pose.

    Parameters
    ----------
    mesh : Mesh
    names : tuple of str
        Names of the bones, all different.
    heads, tails : (b, 3) array of float
        Ends of each bone; it turns about its head.
    parents : (b,) array of int
        Bone that each hangs on, which comes before it; -1 for a root.
    weights : (n, b) array of float
        Weight of each bone at each vertex, not negative; rows sum to 1.
    notes : tuple of str
        What is worth knowing about it, such as limbs without a bone.

    Raises
    ------
    MeshError
        If there is no bone, the numbers of bones or vertices do not agree, names are not distinct, a parent does not
        come before its child, a number is not finite, or a weight is negative.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import capsule
    >>> rod = capsule(3.0, 0.4, 10)
    >>> rigged = lbskel.rig(rod, lbskel.skeletonize(rod))
    >>> rigged.names[0], bool((abs(rigged.weights.sum(axis=1) - 1) < 1e-9).all())
    ('root', True)
    """

    mesh: Mesh
    names: tuple[str, ...]
    heads: NDArray[np.float64]
    tails: NDArray[np.float64]
    parents: NDArray[np.int64]
    weights: NDArray[np.float64]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        b, n = len(self.names), len(self.mesh.vertices)
        for name, shape in {"heads": (b, 3), "tails": (b, 3), "parents": (b,), "weights": (n, b)}.items():
            numbers = _finite(getattr(self, name), f"{name} of a rig", shape)
            object.__setattr__(self, name, read_only(numbers))
        if (self.parents != np.trunc(self.parents)).any():
            raise MeshError("parents of a rig must be whole numbers")
        object.__setattr__(self, "parents", read_only(self.parents.astype(np.int64)))
        if (self.weights < 0).any():
            raise MeshError("weights of a rig must not be negative")
        if not b or len(set(self.names)) < b:
            raise MeshError("a rig needs bones, and all names must be different")
        if not ((self.parents >= -1) & (self.parents < np.arange(b))).all():
            raise MeshError("the parent of a bone must come before it, or be -1")

    def __repr__(self) -> str:
        return f"Rig({counted(len(self.names), 'bone')}, {self.mesh!r})"

    def posed(self, rotations: dict[str, NDArray[np.float64]]) -> Mesh:
        """Turn bones about their heads, with all that hangs on them, by linear blend skinning.

        Parameters
        ----------
        rotations : dict of str to (3, 3) array of float
            Rotation of each named bone, in the axes of the mesh; other bones keep their place on their parents.

        Raises
        ------
        MeshError
            If the rig has no bone of that name, or a rotation is not a finite (3, 3) matrix.
        """
        if unknown := set(rotations) - set(self.names):
            raise MeshError(f"the rig has no bone {', '.join(sorted(unknown))}; it has {', '.join(self.names)}")
        given = {name: _finite(turn, f"the rotation of {name}", (3, 3)) for name, turn in rotations.items()}
        turns, shifts = np.empty((len(self.names), 3, 3)), np.empty((len(self.names), 3))
        for bone, (name, head, parent) in enumerate(zip(self.names, self.heads, self.parents.tolist(), strict=True)):
            turn = given.get(name, np.eye(3))
            shift = head - turn @ head
            if parent >= 0:
                turn, shift = turns[parent] @ turn, turns[parent] @ shift + shifts[parent]
            turns[bone], shifts[bone] = turn, shift
        moved = np.einsum("nb,bxy,ny->nx", self.weights, turns, self.mesh.vertices, optimize=True)
        return self.mesh.with_vertices(moved + self.weights @ shifts)


def _finite(values: ArrayLike, what: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Copy finite numbers of a given shape; a MeshError names what is not so."""
    try:
        numbers = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MeshError(f"{what} must be an array of numbers: {error}") from None
    if numbers.shape != shape:
        raise MeshError(f"{what} must have shape {shape}, not {numbers.shape}")
    if not np.isfinite(numbers).all():
        raise MeshError(f"{what} must be finite")
    return numbers
