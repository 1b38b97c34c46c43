"""A long-necked dinosaur of round cones."""

from __future__ import annotations

__all__ = ["dinosaur"]

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator, make_interp_spline

from lbskel.shapes.solid import Branch, Solid, solid_of

# x forwards, z upwards, radius; the spine lies in the plane y = 0
SPINE = [
    (-2.35, 0.30, 0.030),  # tip of the tail
    (-1.85, 0.16, 0.065),
    (-1.30, 0.28, 0.120),
    (-0.80, 0.55, 0.210),
    (-0.35, 0.74, 0.310),  # hips
    (0.05, 0.80, 0.370),
    (0.42, 0.82, 0.310),  # shoulders
    (0.78, 1.02, 0.190),
    (1.02, 1.40, 0.130),
    (1.16, 1.84, 0.105),
    (1.36, 2.16, 0.110),
    (1.62, 2.22, 0.135),  # back of the head
    (1.88, 2.12, 0.085),  # snout
]
HIPS, SHOULDERS = 4, 6
# x and z from the spine, y to the left, radius
HIND_LEG = [
    (0.0, 0.0, 0.0, 0.20),
    (-0.02, 0.22, -0.22, 0.20),
    (0.0, 0.27, -0.48, 0.145),
    (-0.06, 0.27, -0.78, 0.12),
    (0.06, 0.27, -0.84, 0.11),
]
FORE_LEG = [
    (0.0, 0.0, 0.0, 0.16),
    (0.0, 0.20, -0.26, 0.16),
    (0.03, 0.24, -0.52, 0.115),
    (-0.02, 0.24, -0.84, 0.10),
    (0.09, 0.24, -0.92, 0.09),
]
STEPS = 8  # points of a curve between two of the table


def _curve(points: ArrayLike, radii: ArrayLike) -> Branch:
    """A smooth curve through the points, with radii that do not overshoot."""
    P = np.asarray(points, dtype=np.float64)
    knots = np.append(0.0, np.cumsum(np.sqrt(np.linalg.norm(np.diff(P, axis=0), axis=1))))
    at = np.interp(np.linspace(0, len(P) - 1, STEPS * (len(P) - 1) + 1), np.arange(len(P)), knots)
    return make_interp_spline(knots, P, k=3)(at), PchipInterpolator(knots, np.asarray(radii, dtype=np.float64))(at)


def dinosaur() -> Solid:
    """A body on four legs with a long neck and a long tail: six ends."""
    spine = np.array([(x, 0.0, z) for x, z, _ in SPINE])
    branches = [_curve(spine, [radius for *_, radius in SPINE])]
    for root, leg in ((HIPS, HIND_LEG), (SHOULDERS, FORE_LEG)):
        table: NDArray[np.float64] = np.array(leg)
        for side in (1, -1):
            branches.append(_curve(spine[root] + table[:, :3] * [1, side, 1], table[:, 3]))
    return solid_of(branches)
