"""Triangles that are no more than a line taken away without opening a hole: needles collapse, caps flip.

A needle has one side much shorter than the others, and that side is collapsed; a cap has three corners almost on a
line, and its long side is handed to the triangle beside it, as Botsch, Kobbelt 2001, "A robust procedure to eliminate
degenerate faces from triangle meshes", do. Every operation is local and keeps the topology, else it is not done.
"""

from __future__ import annotations

__all__ = ["corner_angles", "remove_degenerate"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.cleaning import without_unused
from lbskel.preprocess.result import PreprocessResult, identity_result, measured

ROUNDS = 20


@measured
def remove_degenerate(mesh: Mesh, *, angle: float = 0.5) -> PreprocessResult:
    """Take away faces with a corner of nearly no angle, or of nearly half a turn, by collapses and flips of edges.

    Parameters
    ----------
    mesh : Mesh
    angle : float
        In degrees: a corner below it, or above 180 less it, makes a face degenerate.

    Raises
    ------
    UnknownChoice
        If the angle does not lie within 0 and 30.
    """
    if not 0 <= angle <= 30:
        raise UnknownChoice(f"angle must lie within 0 and 30 degrees, not {angle}")
    worst = _sharpness(mesh.vertices[mesh.faces])
    if worst.min() > np.radians(angle):
        return identity_result(mesh)
    surface = _Surface(mesh)
    for _ in range(ROUNDS):
        alive = np.flatnonzero(surface.is_alive)
        sharpness = _sharpness(mesh.vertices[surface.faces[alive]])
        order = np.argsort(sharpness, kind="stable")
        bad = alive[order[sharpness[order] <= np.radians(angle)]]
        if not sum([surface.mend(face) for face in bad.tolist()]):
            break
    if not (surface.n_collapsed + surface.n_flipped):
        note = f"{len(bad)} degenerate faces stay, since the topology or the shape would change without them"
        return identity_result(mesh, note)
    left = f"; {len(bad)} stay" if len(bad) else ""
    note = f"{surface.n_collapsed} needles were collapsed and {surface.n_flipped} caps flipped{left}"
    taken = without_unused(mesh, surface.faces[surface.is_alive], note)
    return PreprocessResult(taken.mesh, VertexMap(surface.final()).compose(taken.vertex_map), taken.notes)


def corner_angles(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3) angles of triangles given by the (k, 3, 3) places of their corners; those of a point are 0."""
    sides = np.roll(corners, -1, axis=1) - corners
    back = -np.roll(sides, 1, axis=1)
    sine = np.linalg.norm(np.cross(sides, back), axis=2)
    return np.arctan2(sine, (sides * back).sum(axis=2))


def _sharpness(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) the smallest of the angles of a triangle and what its largest lacks of half a turn, in radians."""
    angles = corner_angles(corners)
    return np.minimum(angles.min(axis=1), np.pi - angles.max(axis=1))


class _Surface:
    """Faces that can be changed one by one, and the faces around each vertex."""

    def __init__(self, mesh: Mesh):
        self.positions = mesh.vertices
        self.faces = np.array(mesh.faces)
        self.is_alive = (self.faces != np.roll(self.faces, 1, axis=1)).all(axis=1)
        self.into = np.arange(len(mesh.vertices))
        self.n_collapsed = self.n_flipped = 0
        alive = np.flatnonzero(self.is_alive)
        corners = self.faces[alive].ravel()
        ends = np.cumsum(np.bincount(corners, minlength=len(mesh.vertices)))
        faces = alive[np.argsort(corners, kind="stable") // 3]
        self.around = [set(part.tolist()) for part in np.split(faces, ends[:-1])]

    def final(self) -> NDArray[np.int64]:
        """(n,) the vertex that each has become."""
        while not np.array_equal(self.into, self.into[self.into]):
            self.into = self.into[self.into]
        return self.into

    def mend(self, face: int) -> bool:
        """Take one degenerate face away if that is possible."""
        if not self.is_alive[face]:
            return False
        corners = self.faces[face]
        P = self.positions[corners]
        lengths = np.linalg.norm(np.roll(P, 1, axis=0) - np.roll(P, -1, axis=0), axis=1)  # opposite each corner
        order = np.argsort(lengths, kind="stable")
        if lengths[order[0]] <= 0.1 * lengths[order[2]]:
            i, j = (int(corners[k]) for k in range(3) if k != order[0])
            if self._collapse(i, j) or self._collapse(j, i):
                return True
        return self._flip(face, int(order[2]))

    def _neighbors(self, vertex: int) -> set[int]:
        return {int(v) for face in self.around[vertex] for v in self.faces[face]} - {vertex}

    def _is_rim(self, vertex: int) -> bool:
        """Whether an edge of a vertex has not exactly two faces."""
        corners = [int(v) for face in self.around[vertex] for v in self.faces[face] if v != vertex]
        return any(corners.count(v) != 2 for v in corners)

    def _collapse(self, i: int, j: int) -> bool:
        """Let a vertex become its neighbor, unless that pinches the surface, moves its rim, or folds it over."""
        shared = self.around[i] & self.around[j]
        opposite = {int(v) for face in shared for v in self.faces[face]} - {i, j}
        if len(opposite) != len(shared) or self._neighbors(i) & self._neighbors(j) != opposite:
            return False
        if self._is_rim(i) and not (len(shared) == 1 and self._is_rim(j)):
            return False
        moving = np.array(sorted(self.around[i] - shared), dtype=np.int64)
        if len(moving) == 0 or len(self.around[i] | self.around[j]) - len(shared) < 2 * len(shared):
            return False
        moved = np.where(self.faces[moving] == i, j, self.faces[moving])
        if not self._keeps_shape(self.faces[moving], moved):
            return False
        self.faces[moving] = moved
        self.is_alive[list(shared)] = False
        for face in shared:
            for vertex in self.faces[face]:
                self.around[vertex].discard(face)
        self.around[j] |= self.around[i]
        self.around[i] = set()
        self.into[i] = j
        self.n_collapsed += 1
        return True

    def _flip(self, face: int, corner: int) -> bool:
        """Exchange the edge opposite a corner for the other diagonal, unless it exists or the shape would change."""
        c, a, b = (int(self.faces[face, (corner + k) % 3]) for k in range(3))
        shared = self.around[a] & self.around[b]
        if len(shared) != 2:
            return False
        (other,) = shared - {face}
        place = [int(v) for v in self.faces[other]]
        d = next(v for v in place if v not in (a, b))
        follows_a = place[(place.index(a) + 1) % 3]
        if follows_a == b or d == c or self.around[c] & self.around[d]:
            return False  # the two disagree in orientation, or the new edge exists
        before = np.array([[c, a, b], place])
        after = np.array([[c, a, d], [c, d, b]])
        if _sharpness(self.positions[after]).min() <= _sharpness(self.positions[before]).min():
            return False
        if not self._keeps_shape(before[[1, 1]], after):
            return False
        self.faces[face], self.faces[other] = after
        self.around[b].discard(face)
        self.around[a].discard(other)
        self.around[d].add(face)
        self.around[c].add(other)
        self.n_flipped += 1
        return True

    def _keeps_shape(self, before: NDArray[np.int64], after: NDArray[np.int64]) -> bool:
        """Whether no face turns over, and none becomes sharper than the sharpest was."""
        old, new = self.positions[before], self.positions[after]
        turned = (_normals(old) * _normals(new)).sum(axis=1) < 0
        is_line = _sharpness(old) < np.radians(0.01)  # which has no normal to speak of
        return not (turned & ~is_line).any() and bool(_sharpness(new).min() >= min(_sharpness(old).min(), 1e-3))


def _normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3) normals of triangles, as long as twice their areas."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
