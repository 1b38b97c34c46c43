"""Characters with known joints: bodies of round cones whose limbs bend slightly at elbows, knees and knuckles."""

from __future__ import annotations

__all__ = ["CHARACTERS", "Character"]

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import lbskel
from lbskel.shapes import mesh_solid, solid_of
from lbskel.shapes.round_cones import Branch


@dataclass(frozen=True, eq=False)
class Character:
    """A mesh and the places where its limbs bend.

    Parameters
    ----------
    mesh : Mesh
    joints : (j, 3) array of float
    radii : (j,) array of float
        Of the limbs there.
    """

    mesh: lbskel.Mesh
    joints: NDArray[np.float64]
    radii: NDArray[np.float64]


def _made(bodies: list[Branch], limbs: list[Branch], n_vertices: int) -> Character:
    """Mesh bodies and limbs; all points of a limb but its ends are joints."""
    mesh = mesh_solid(solid_of([*bodies, *limbs]), n_vertices=n_vertices)
    joints = [(point, radius) for points, radius in limbs for point in points[1:-1]]
    return Character(mesh, np.array([point for point, _ in joints]), np.array([radius for _, radius in joints]))


def _both_sides(limbs: list[Branch]) -> list[Branch]:
    """Limbs and their mirror images in the plane x = 0."""
    return [(np.multiply(points, [side, 1, 1]), radius) for points, radius in limbs for side in (1, -1)]


def human(n_vertices: int = 3000) -> Character:
    """A human with elbows and knees, y up."""
    trunk = [([[0, 0, 0], [0, 0.45, 0]], [0.16, 0.15]), ([[0, 0.45, 0], [0, 0.72, 0]], 0.06), ([[0, 0.8, 0]], 0.11)]
    arm = ([[0.14, 0.45, 0], [0.45, 0.38, -0.04], [0.74, 0.38, 0.06]], 0.045)
    leg = ([[0.1, -0.02, 0], [0.14, -0.45, 0.05], [0.15, -0.9, -0.04]], 0.065)
    return _made(trunk, _both_sides([arm, leg]), n_vertices)


def camel(n_vertices: int = 3000) -> Character:
    """A quadruped with knees and a bent neck, y up."""
    trunk = [([[0, 0, -0.45], [0, 0, 0.4]], 0.2)]
    neck = ([[0, 0.05, 0.5], [0, -0.02, 0.85], [0, 0.45, 1.0], [0, 0.47, 1.25]], 0.075)
    legs = [
        ([[0.13, -0.1, z], [0.14, -0.5, z + bend], [0.14, -0.9, z]], 0.06) for z, bend in ((0.35, 0.06), (-0.4, -0.06))
    ]
    return _made(trunk, [neck, *_both_sides(legs)], n_vertices)


def hand(n_vertices: int = 3000) -> Character:
    """A palm with four fingers of two knuckles, and a thumb of one."""
    palm = [([[0, 0, -0.5], [0, 0, 0]], 0.22), ([[-0.2, 0, 0.2], [0.2, 0, 0.2]], 0.16)]
    fingers = [
        ([[x, 0, 0.3], [1.15 * x, 0.0, 0.62], [1.3 * x, -0.06, 0.88], [1.35 * x, -0.17, 1.08]], 0.055)
        for x in (-0.27, -0.09, 0.09, 0.27)
    ]
    thumb = ([[0.25, 0, 0.1], [0.55, 0.0, 0.2], [0.68, -0.02, 0.45]], 0.06)
    return _made(palm, [*fingers, thumb], n_vertices)


CHARACTERS: dict[str, Callable[[], Character]] = {"human": human, "camel": camel, "hand": hand}
