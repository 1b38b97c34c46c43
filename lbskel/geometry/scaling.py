"""Scaling: by powers of two, which is exact, and to other units."""

from __future__ import annotations

__all__ = ["require_scale", "unit_scale"]

import math

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice


def require_scale(scale: float) -> None:
    """Raise UnknownChoice unless a factor between units is a positive, finite number.

    Parameters
    ----------
    scale : float
    """
    if not (scale > 0 and math.isfinite(scale)):
        raise UnknownChoice(f"scale must be a positive number, not {scale!r}")


def unit_scale(vertices: NDArray[np.float64], used: NDArray[np.int64] | None = None) -> tuple[NDArray[np.float64], int]:
    """Divide vertices by 2^k so that the largest absolute coordinate is in [1/2, 1), exactly and without overflow.

    Parameters
    ----------
    vertices : (n, 3) array of float
    used : (u,) array of int, optional
        The vertices that have a face: their mean takes the place of all others, which may be anywhere.

    Returns
    -------
    scaled : (n, 3) array of float
    k : int
    """
    if used is not None and len(used) < len(vertices):
        own, k = unit_scale(vertices[used])
        scaled = np.tile(own.mean(axis=0), (len(vertices), 1))
        scaled[used] = own
        return scaled, k
    k = int(np.frexp(np.abs(vertices).max())[1])
    return np.ldexp(vertices, -k), k
