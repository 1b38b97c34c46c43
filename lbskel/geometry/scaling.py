"""Scaling by a power of two, which is exact."""

from __future__ import annotations

__all__ = ["unit_scale"]

import numpy as np
from numpy.typing import NDArray


def unit_scale(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], int]:
    """Vertices divided by 2^k so that the largest coordinate lies between 1/2 and 1, and k: exact, without overflow."""
    k = int(np.frexp(np.abs(vertices).max())[1])
    return np.ldexp(vertices, -k), k
