"""Segments of level sets in triangles: where a function that is linear in each face has a given value."""

from __future__ import annotations

__all__ = ["LevelSegments", "level_segments"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class LevelSegments:
    """One segment in each of k faces.

    Parameters
    ----------
    starts, stops : (k, 3) array of float
        Its ends, which lie on two edges of the face.
    shares_above : (k,) array of float
        Fraction of the area of the face that is above the level.
    """

    starts: NDArray[np.float64]
    stops: NDArray[np.float64]
    shares_above: NDArray[np.float64]


def level_segments(
    vertices: NDArray[np.float64], corners: NDArray[np.int64], heights: NDArray[np.float64]
) -> LevelSegments:
    """Find the segment in which a level cuts each of k faces.

    Parameters
    ----------
    vertices : (n, 3) array of float
    corners : (3, k) array of int
        The vertices of each face.
    heights : (3, k) array of float
        Of the corners above the level: positive at one or two corners of each face.
    """
    (x, y, z), faces = heights > 0, np.arange(corners.shape[1])
    is_single = ~((x & y) | (y & z) | (z & x))
    odd = np.where(x == is_single, 0, np.where(y == is_single, 1, 2))  # the corner alone on its side of the level
    places = [((odd + side) % 3, faces) for side in range(3)]
    A, B, C = (vertices.take(corners[place], axis=0) for place in places)
    a, b, c = (heights[place] for place in places)
    to_b, to_c = a / (a - b), a / (a - c)
    shares_above = np.where(is_single, to_b * to_c, 1 - to_b * to_c)
    return LevelSegments(A + to_b[:, None] * (B - A), A + to_c[:, None] * (C - A), shares_above)
