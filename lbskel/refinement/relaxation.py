"""Relaxation of paths inside a solid: short where it is wide, in the middle where it is narrow.

The length of a path, weighted by a power of the inscribed radius r, falls along the flow of geodesic active contours
(Caselles, Kimmel, Sapiro 1997, "Geodesic active contours", https://doi.org/10.1023/A:1007979827043). With the weight
``r ** -p`` a point moves by ``curvature + p * (gradient of r) / r``, both across the path. Where points are ``s * r``
apart, the vector from a point to the mean of its neighbors is ``(s * r) ** 2 / 2`` times the curvature. A step moves
the point by two thirds of this vector and of ``(s * r) ** 2 / 2`` times the second term, which is reduced to zero over
the steps. A point stays within its ball, and thus the path in its homotopy class, if its neighbors lie in the ball;
where a path touches the surface, they do not.
"""

from __future__ import annotations

__all__ = ["relax_inside"]

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.traversal import sums_along_paths
from lbskel.geometry.normals import normalized, vector_lengths
from lbskel.geometry.surface_queries import Surface

# Distances of the points of a path in radii of their balls, for STEPS_BETWEEN steps each: below 1, each point lies
# inside the balls of its neighbors. A path relaxes as far in a fourth of the steps if its points are twice as far
# apart; the last points are as close as those of other branches. Rows "points of paths at" in
# benchmarks/results/refinement.md
SPACINGS = (0.9, 0.9, 0.9, 0.6)
MIN_RATIO = 0.1  # of a ball to the largest of its path, below which the spacing no longer follows the ball; it bounds
# the number of points of a path that touches the surface. Rows "smallest ball of" in the same table
MAX_PIECES = 1000  # of a path, which bounds the time where nearly all of it lies on the surface; a guess
# Upper bound on the radii between the ends of a path that lies on the surface, in lengths of the path. A guess: above
# the 1e-6 diameter bounds by which paths along the surface are moved inside, and below the radii of limbs
ON_SURFACE = 1e-4
# Exponent of the radius in the weight. Rows "power of" in the same table are alike; by hand, with 1 two more of CGAL's
# meshes fail
POWER = 2.0
# Steps after which the points are spaced anew, which bounds how far a path relaxes, and the time. Rows "steps between
# spacings" in the same table
STEPS_BETWEEN = 4


def relax_inside(paths: list[NDArray[np.float64]], surface: Surface) -> list[NDArray[np.float64]]:
    """Move the points of paths inside a surface towards the shortest weighted length; the ends stay.

    Parameters
    ----------
    paths : list of (k, 3) array of float
        Each of at least two points.
    surface : Surface
        Closed, or open, where a path may have to lie on the surface.

    Returns
    -------
    list of (m, 3) array of float
        For each path its ends, and between them points at distances of about ``SPACINGS[-1]`` radii; as many as there
        were if the path lies on the surface, where there is no radius.
    """
    sizes = [len(path) for path in paths]
    P, path_of = np.concatenate(paths), np.repeat(np.arange(len(paths)), sizes)
    on_surface = np.array([_lies_on_surface(path, surface) for path in paths])
    n_steps = STEPS_BETWEEN * len(SPACINGS)
    for step in range(n_steps):
        spacing = SPACINGS[step // STEPS_BETWEEN]
        if step % STEPS_BETWEEN == 0:
            P, path_of = _spaced(P, path_of, spacing, surface, on_surface)
            inner = np.flatnonzero((path_of[1:-1] == path_of[:-2]) & (path_of[1:-1] == path_of[2:])) + 1
            side = np.where(surface.contains(P[inner]), 1.0, -1.0)[:, None]
        before, after = P[inner - 1], P[inner + 1]
        radii, nearest = surface.closest(P[inner])
        away, tangents = side * normalized(P[inner] - nearest), normalized(after - before)
        across = away - (away * tangents).sum(axis=1, keepdims=True) * tangents
        # at the medial axis the gradient alternates between the sides from step to step, so its weight is reduced to
        # zero, and the last step only smooths
        share = POWER * spacing**2 / 2 * (1 - (step + 1) / n_steps)
        P[inner] += 2 / 3 * ((before + after) / 2 - P[inner] + share * radii[:, None] * across)
    return np.split(P, np.flatnonzero(np.diff(path_of)) + 1)


def _lies_on_surface(path: NDArray[np.float64], surface: Surface) -> bool:
    """Whether no point between the ends of a path has a ball inside the surface; if there is none, neither end."""
    length = float(vector_lengths(np.diff(path, axis=0)).sum())
    return float(surface.distance(path[1:-1] if len(path) > 2 else path).max()) <= ON_SURFACE * length


def _spaced(
    P: NDArray[np.float64], path_of: NDArray[np.int64], spacing: float, surface: Surface, on_surface: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Points on the same polylines at distances of about ``spacing`` radii, and the number of the path of each.

    Paths on the surface get as many points as they have.
    """
    begins = np.flatnonzero(np.diff(path_of, prepend=-1))
    lasts = np.append(begins[1:], len(P)) - 1
    radii = surface.distance(P)
    largest = np.maximum.reduceat(radii, begins)[path_of]
    radii = np.maximum(radii, np.where(largest > 0, MIN_RATIO * largest, np.finfo(float).tiny))
    radii[on_surface[path_of]] = 1.0
    steps = vector_lengths(np.diff(P, axis=0, prepend=P[:1]))
    steps[1:] /= (radii[1:] + radii[:-1]) / 2
    lengths = sums_along_paths(steps, np.append(begins, len(P)))
    totals = lengths[lasts]
    counts = np.where(on_surface, lasts - begins, np.clip(np.rint(totals / spacing), 1, MAX_PIECES)).astype(np.int64)
    new_path_of = np.repeat(np.arange(len(begins)), counts + 1)
    number = np.arange(len(new_path_of)) - np.repeat(np.cumsum(counts + 1) - counts - 1, counts + 1)
    # the share of its path's length before each point, plus twice the number of the path
    places = 2.0 * path_of + np.divide(lengths, totals[path_of], out=np.zeros(len(P)), where=totals[path_of] > 0)
    at = 2.0 * new_path_of + number / counts[new_path_of]
    spaced = np.stack([np.interp(at, places, coordinate) for coordinate in P.T], axis=1)
    spaced[number == 0], spaced[number == counts[new_path_of]] = P[begins], P[lasts]
    return spaced, new_path_of
