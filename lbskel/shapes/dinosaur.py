"""A long-necked dinosaur built from round cones along smooth curves."""

from __future__ import annotations

__all__ = ["dinosaur"]

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator, make_interp_spline

from lbskel.shapes.round_cones import Branch, Solid, solid_of

# Control points of the spine, in the plane y = 0: x (forwards), z (upwards), radius. The coordinates and radii of all
# tables were chosen by eye and define the unit of length.
SPINE = [
    (-2.20, 0.46, 0.080),  # tip of the tail
    (-1.80, 0.26, 0.090),
    (-1.30, 0.30, 0.130),
    (-0.80, 0.55, 0.220),
    (-0.35, 0.74, 0.320),  # hips
    (0.05, 0.79, 0.375),
    (0.42, 0.82, 0.310),  # shoulders
    (0.76, 1.02, 0.195),
    (0.96, 1.38, 0.135),
    (1.06, 1.80, 0.115),
    (1.24, 2.12, 0.130),
    (1.46, 2.22, 0.175),  # back of the head
    (1.66, 2.17, 0.150),
    (1.84, 2.08, 0.130),  # snout
]
HIPS, SHOULDERS = 4, 6  # rows of SPINE at which the legs start
# Control points of a left leg relative to its row of SPINE: x, y (to the left), z, radius.
HIND_LEG = [
    (0.00, 0.00, 0.00, 0.20),
    (0.02, 0.23, -0.22, 0.20),
    (0.05, 0.28, -0.48, 0.15),
    (-0.04, 0.28, -0.76, 0.125),
    (0.06, 0.28, -0.86, 0.135),
]
FORE_LEG = [
    (0.00, 0.00, 0.00, 0.16),
    (0.02, 0.21, -0.28, 0.16),
    (0.02, 0.25, -0.56, 0.12),
    (-0.02, 0.25, -0.84, 0.11),
    (0.07, 0.25, -0.94, 0.115),
]
N_STEPS = 5  # segments of a curve between two control points; a guess


def _curve(points: ArrayLike, radii: ArrayLike) -> Branch:
    """Interpolate points by a cubic spline, and radii by a monotone interpolant, which does not overshoot."""
    P = np.asarray(points, dtype=np.float64)
    knots = np.append(0.0, np.cumsum(np.sqrt(np.linalg.norm(np.diff(P, axis=0), axis=1))))
    parameters = np.interp(np.linspace(0, len(P) - 1, N_STEPS * (len(P) - 1) + 1), np.arange(len(P)), knots)
    radius_at = PchipInterpolator(knots, np.asarray(radii, dtype=np.float64))
    return make_interp_spline(knots, P, k=3)(parameters), radius_at(parameters)


def dinosaur() -> Solid:
    """Build a body on four legs with a long neck and a long tail: six tips."""
    spine = np.array([(x, 0.0, z) for x, z, _ in SPINE])
    branches = [_curve(spine, [radius for *_, radius in SPINE])]
    for root, leg in ((HIPS, HIND_LEG), (SHOULDERS, FORE_LEG)):
        table: NDArray[np.float64] = np.array(leg)
        for side in (1, -1):
            branches.append(_curve(spine[root] + table[:, :3] * [1, side, 1], table[:, 3]))
    return solid_of(branches)
