"""Removal of needle and cap triangles without opening a hole: needles are collapsed, caps are flipped.

A needle has one side much shorter than the others; that side is collapsed. A cap has three almost collinear corners;
its longest edge is flipped. Botsch, Kobbelt 2001, "A robust procedure to eliminate degenerate faces from triangle
meshes". Every operation is local, and is done only if it keeps the topology.
"""

from __future__ import annotations

__all__ = ["corner_angles", "remove_degenerate"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice, were
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import triangle_normals, vector_lengths
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.cleaning import extract_faces
from lbskel.preprocess.result import PreprocessResult, identity_result, preprocess_step

MAX_ROUNDS = 20  # passes over the faces that are still degenerate; a guess
NEEDLE_RATIO = 0.1  # shortest over longest side up to which a degenerate face is a needle; a guess
COLLINEAR_ANGLE = 0.01  # degrees: a sharper face has no reliable normal to compare; a guess
MIN_SHARPNESS = 1e-3  # radians: an operation may not make a face sharper than this, unless one was; a guess


@preprocess_step
def remove_degenerate(mesh: Mesh, *, angle: float = 0.5) -> PreprocessResult:
    """Remove faces with an angle near 0 or 180 degrees by collapsing and flipping edges.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    angle : float
        In degrees; a face with an angle below this, or above 180 minus this, is degenerate.

    Raises
    ------
    UnknownChoice
        If the angle is not between 0 and 30.
    """
    if not 0 <= angle <= 30:
        raise UnknownChoice(f"angle must lie between 0 and 30 degrees, not {angle}")
    sharpness = _sharpness(mesh.vertices[mesh.faces])
    if sharpness.min() > np.radians(angle):
        return identity_result(mesh)
    surface = _EditableSurface(mesh)
    for _ in range(MAX_ROUNDS):
        alive = np.flatnonzero(surface.is_alive)
        sharpness = _sharpness(mesh.vertices[surface.faces[alive]])
        order = np.argsort(sharpness, kind="stable")
        bad = alive[order[sharpness[order] <= np.radians(angle)]]
        if not sum([surface.remove(face) for face in bad.tolist()]):
            break
    if not (surface.n_collapsed + surface.n_flipped):
        if not len(bad):  # none but faces that name a vertex twice
            return identity_result(mesh)
        note = f"{were(len(bad), 'degenerate face')} kept, since a change there would alter the topology or the shape"
        return identity_result(mesh, note)
    kept = f"; {len(bad):,} kept" if len(bad) else ""
    note = f"{were(surface.n_collapsed, 'needle')} collapsed and {were(surface.n_flipped, 'cap')} flipped{kept}"
    result = extract_faces(mesh, surface.faces[surface.is_alive], note)
    vertex_map = VertexMap(surface.merged_vertices()).compose(result.vertex_map)
    return PreprocessResult(result.mesh, vertex_map, result.notes)


def corner_angles(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3) angles of triangles, in radians; 0 where two corners coincide.

    Parameters
    ----------
    corners : (k, 3, 3) array of float
        Positions of the three corners of each triangle.
    """
    sides = np.roll(corners, -1, axis=1) - corners
    back = -np.roll(sides, 1, axis=1)
    sine = vector_lengths(np.cross(sides, back))
    angles: NDArray[np.float64] = np.arctan2(sine, (sides * back).sum(axis=2))
    return angles


def _sharpness(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) smallest distance of an angle of each triangle from 0 or pi, in radians; 0 for a degenerate triangle."""
    angles = corner_angles(corners)
    sharpness: NDArray[np.float64] = np.minimum(angles.min(axis=1), np.pi - angles.max(axis=1))
    return sharpness


class _EditableSurface:
    """Faces that can be collapsed and flipped one by one, and the faces around each vertex."""

    def __init__(self, mesh: Mesh):
        self.positions = mesh.vertices
        self.faces = np.array(mesh.faces)
        self.is_alive = (self.faces != np.roll(self.faces, 1, axis=1)).all(axis=1)
        self.merged_into = np.arange(len(mesh.vertices))
        self.n_collapsed = self.n_flipped = 0
        alive = np.flatnonzero(self.is_alive)
        corners = self.faces[alive].ravel()
        ends = np.cumsum(np.bincount(corners, minlength=len(mesh.vertices)))
        faces = alive[np.argsort(corners, kind="stable") // 3]
        self.faces_around = [set(part.tolist()) for part in np.split(faces, ends[:-1])]

    def merged_vertices(self) -> NDArray[np.int64]:
        """(n,) the vertex that each was finally merged into."""
        while not np.array_equal(self.merged_into, self.merged_into[self.merged_into]):
            self.merged_into = self.merged_into[self.merged_into]
        return self.merged_into

    def remove(self, face: int) -> bool:
        """Remove one degenerate face, and return whether that was possible."""
        if not self.is_alive[face]:
            return False
        corners = self.faces[face]
        P = self.positions[corners]
        lengths = vector_lengths(np.roll(P, 1, axis=0) - np.roll(P, -1, axis=0))  # opposite each corner
        order = np.argsort(lengths, kind="stable")
        if lengths[order[0]] <= NEEDLE_RATIO * lengths[order[2]]:
            i, j = (int(corners[k]) for k in range(3) if k != order[0])
            if self._collapse(i, j) or self._collapse(j, i):
                return True
        return self._flip(face, int(order[2]))

    def _neighbors(self, vertex: int) -> set[int]:
        return {int(v) for face in self.faces_around[vertex] for v in self.faces[face]} - {vertex}

    def _is_on_boundary(self, vertex: int) -> bool:
        """Whether an edge at a vertex does not have exactly two faces."""
        corners = [int(v) for face in self.faces_around[vertex] for v in self.faces[face] if v != vertex]
        return any(corners.count(v) != 2 for v in corners)

    def _collapse(self, i: int, j: int) -> bool:
        """Merge vertex i into its neighbor j, unless that pinches or folds the surface or moves its boundary."""
        shared = self.faces_around[i] & self.faces_around[j]
        opposite = {int(v) for face in shared for v in self.faces[face]} - {i, j}
        if len(opposite) != len(shared) or self._neighbors(i) & self._neighbors(j) != opposite:
            return False
        if self._is_on_boundary(i) and not (len(shared) == 1 and self._is_on_boundary(j)):
            return False
        changed = np.array(sorted(self.faces_around[i] - shared), dtype=np.int64)
        if len(changed) == 0 or len(self.faces_around[i] | self.faces_around[j]) - len(shared) < 2 * len(shared):
            return False
        collapsed = np.where(self.faces[changed] == i, j, self.faces[changed])
        if not self._keeps_shape(self.faces[changed], collapsed):
            return False
        self.faces[changed] = collapsed
        self.is_alive[list(shared)] = False
        for face in shared:
            for vertex in self.faces[face]:
                self.faces_around[vertex].discard(face)
        self.faces_around[j] |= self.faces_around[i]
        self.faces_around[i] = set()
        self.merged_into[i] = j
        self.n_collapsed += 1
        return True

    def _flip(self, face: int, corner: int) -> bool:
        """Flip the edge opposite a corner, unless the flipped edge exists or the shape would change."""
        c, a, b = (int(self.faces[face, (corner + k) % 3]) for k in range(3))
        shared = self.faces_around[a] & self.faces_around[b]
        if len(shared) != 2:
            return False
        (other,) = shared - {face}
        corners = [int(v) for v in self.faces[other]]
        d = next(v for v in corners if v not in (a, b))
        follows_a = corners[(corners.index(a) + 1) % 3]
        if follows_a == b or d == c or self.faces_around[c] & self.faces_around[d]:
            return False  # the two faces have opposite orientation, or the flipped edge exists
        before = np.array([[c, a, b], corners])
        after = np.array([[c, a, d], [c, d, b]])
        if _sharpness(self.positions[after]).min() <= _sharpness(self.positions[before]).min():
            return False
        if not self._keeps_shape(before[[1, 1]], after):
            return False
        self.faces[face], self.faces[other] = after
        self.faces_around[b].discard(face)
        self.faces_around[a].discard(other)
        self.faces_around[d].add(face)
        self.faces_around[c].add(other)
        self.n_flipped += 1
        return True

    def _keeps_shape(self, before: NDArray[np.int64], after: NDArray[np.int64]) -> bool:
        """Whether no face is reversed, and none gets sharper than MIN_SHARPNESS unless one was as sharp before."""
        old, new = self.positions[before], self.positions[after]
        is_reversed = (_normals(old) * _normals(new)).sum(axis=1) < 0
        is_collinear = _sharpness(old) < np.radians(COLLINEAR_ANGLE)
        if (is_reversed & ~is_collinear).any():
            return False
        return bool(_sharpness(new).min() >= min(_sharpness(old).min(), MIN_SHARPNESS))


def _normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3) normals of triangles given by the (k, 3, 3) positions of their corners; their length is twice the area."""
    return triangle_normals(corners[:, 0], corners[:, 1], corners[:, 2])
