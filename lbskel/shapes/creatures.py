"""Random shapes with known axes: a bent trunk whose thickness varies, with limbs at random places.

The trunk is an arc in the plane z = 0; its radius is at most 1. Limbs begin at inner nodes of its axis, several at one
node or at neighboring ones, in all directions. A limb is straight up to a bend in the middle of its part outside of the
trunk. It is tried again at another place if it comes too near to the trunk or to another limb beyond its foot; feet may
overlap.
"""

from __future__ import annotations

__all__ = ["creature", "creature_branches"]

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.shapes.catalog import mesh_solid
from lbskel.shapes.round_cones import Branch, solid_of, subdivide
from lbskel.shapes.truth import Shape

Spheres: TypeAlias = NDArray[np.float64]  # (k, 4): centers along an axis, and radii

# All ranges are guesses at what animals and plants have. Of the trunk: its length and its radius at both ends and in
# the middle, in the largest radius of all trunks, and its bend in radians.
LENGTH, BEND, THICKNESS = (8.0, 14.0), (0.0, 1.2), (0.6, 1.0)
N_SEGMENTS = 12  # of the trunk's axis; of the nodes between them, the last two at each end have no limbs
# Of limbs: their number, their angle to the trunk in degrees, towards one of its ends, their radius over that of the
# trunk, their length outside of the trunk in their radii, and the radius at their ends over that at their bends.
N_LIMBS, ANGLE, RATIO, LIMB_LENGTH, TAPER = (3, 6), (35.0, 145.0), (0.25, 0.7), (4.0, 10.0), (0.6, 1.0)
LIMB_BEND = 0.2  # standard deviation of each coordinate of what is added to a unit direction at a bend; a guess
# Distance along a limb from the surface of the trunk, in radii of the limb, from which it is clear of the trunk and of
# other limbs. At an angle of 35 degrees, a limb of 0.4 of the trunk's radius is clear of a straight trunk from 3.
FROM_TRUNK, FROM_LIMBS = 3.0, 1.0
# Least distance of two centers there, in sums of their radii. From 1.13 no limbs are blended into one: at the width of
# round_cones.BLEND_WIDTH the gap of two equal limbs fills up below a quarter of their radius.
CLEARANCE = 1.2
N_TRIES, N_ATTEMPTS = 400, 20  # of placing limbs on a trunk, and of making a shape; guesses


def creature(seed: int, *, n_vertices: int = 5000) -> Shape:
    """Build a bent trunk with three to six limbs at random places: two tips more than limbs, genus 0.

    Parameters
    ----------
    seed : int
        Seed of all random choices.
    n_vertices : int
        Approximate number of vertices; exceeded if the thinnest limb needs shorter edges.

    Returns
    -------
    Shape
        The same for the same arguments.

    Raises
    ------
    MeshError
        If no attempt gives a closed surface of genus 0 in one component.
    MissingDependency
        If pymeshlab is not installed.
    UnknownChoice
        If the number of vertices is not positive.

    Examples
    --------
    >>> from lbskel.shapes import creature
    >>> shape = creature(0, n_vertices=1000)
    >>> shape.mesh.genus, shape.truth.n_components, 5 <= shape.truth.n_tips <= 8
    (0, 1, True)
    """
    random = np.random.default_rng(seed)
    for _ in range(N_ATTEMPTS):
        branches = creature_branches(random)
        if len(branches) <= N_LIMBS[0]:
            continue
        solid = solid_of(branches)
        mesh = mesh_solid(solid, n_vertices=n_vertices)
        if _is_in_one_piece(mesh):
            return Shape(mesh, solid.truth, f"creature {seed}")
    raise MeshError(
        f"no closed surface of genus 0 in {N_ATTEMPTS} attempts with seed {seed}: take another seed or more vertices"
    )


def creature_branches(random: np.random.Generator) -> list[Branch]:
    """Choose a trunk and its limbs.

    Parameters
    ----------
    random : numpy.random.Generator
        Its state advances.

    Returns
    -------
    list of Branch
        The trunk, of N_SEGMENTS segments, and limbs of two segments, which begin at its nodes; fewer than chosen if no
        place is left for them.
    """
    trunk, frames = _trunk(random)
    whole = subdivide(trunk[:, :3], trunk[:, 3], "trunk")
    n_limbs = random.integers(*N_LIMBS, endpoint=True)
    limbs: list[_Limb] = []
    for _ in range(N_TRIES):
        if len(limbs) == n_limbs:
            break
        node = int(random.integers(2, N_SEGMENTS - 2, endpoint=True))
        limb = _limb(trunk[node], frames[node], random)
        if _is_clear(limb.beyond(FROM_TRUNK), whole) and all(
            _is_clear(limb.beyond(FROM_LIMBS), other.beyond(FROM_LIMBS)) for other in limbs
        ):
            limbs.append(limb)
    return [(spheres[:, :3], spheres[:, 3]) for spheres in (trunk, *(limb.spheres for limb in limbs))]


@dataclass(frozen=True, eq=False)
class _Limb:
    """The (3, 4) spheres at the start, bend and end of a limb, and the length of its axis inside of the trunk."""

    spheres: Spheres
    depth: float

    def beyond(self, distance: float) -> Spheres:
        """Sample what is farther along the axis than a distance from the trunk's surface, in radii of the limb."""
        sampled = subdivide(self.spheres[:, :3], self.spheres[:, 3], "limb")
        lengths = np.append(0.0, np.cumsum(vector_lengths(np.diff(sampled[:, :3], axis=0))))
        beyond: Spheres = sampled[lengths > self.depth + distance * self.spheres[0, 3]]
        return beyond


def _trunk(random: np.random.Generator) -> tuple[Spheres, NDArray[np.float64]]:
    """Choose a trunk: the spheres at its nodes, and (n, 3, 3) the rows tangent, normal and binormal there."""
    length, bend, thickness = random.uniform(*LENGTH), random.uniform(*BEND), random.uniform(*THICKNESS, size=3)
    shares = np.linspace(0, 1, N_SEGMENTS + 1)
    tangents = _headings(bend * (shares - 0.5))
    steps = length / N_SEGMENTS * _headings(bend * ((shares[1:] + shares[:-1]) / 2 - 0.5))
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    binormals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    frames = np.stack([tangents, np.cross(binormals, tangents), binormals], axis=1)
    return np.column_stack([points, np.interp(shares, [0, 0.5, 1], thickness)]), frames


def _headings(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) unit vectors in the plane z = 0 at angles to the x axis, in radians."""
    return np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)


def _limb(root: NDArray[np.float64], frame: NDArray[np.float64], random: np.random.Generator) -> _Limb:
    """Choose a limb that begins at the (4,) sphere of a node of the trunk with that frame."""
    angle, turn = np.radians(random.uniform(*ANGLE)), random.uniform(0, 2 * np.pi)
    radius = root[3] * random.uniform(*RATIO)
    half = radius * random.uniform(*LIMB_LENGTH) / 2
    direction = np.array([np.cos(angle), np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn)]) @ frame
    bent = direction + LIMB_BEND * random.standard_normal(3)
    depth = root[3] / np.sin(angle)
    bend = root[:3] + (depth + half) * direction
    end = bend + half * bent / np.linalg.norm(bent)
    radii = radius * np.array([1.0, 1.0, random.uniform(*TAPER)])
    return _Limb(np.column_stack([[root[:3], bend, end], radii]), float(depth))


def _is_clear(spheres: Spheres, others: Spheres) -> bool:
    """Return whether all centers keep the CLEARANCE from the others."""
    distances = np.linalg.norm(spheres[:, None, :3] - others[:, :3], axis=2)
    return bool((distances > CLEARANCE * (spheres[:, None, 3] + others[:, 3])).all())


def _is_in_one_piece(mesh: Mesh) -> bool:
    """Return whether a mesh is a closed surface of genus 0 in one component."""
    return mesh.genus == 0 and mesh.n_components == 1
