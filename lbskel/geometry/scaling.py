"""Exact scaling by powers of two."""

from __future__ import annotations

__all__ = ["unit_scale"]

import numpy as np
from numpy.typing import NDArray


def unit_scale(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], int]:
    """Divide vertices by 2^k so that the largest absolute coordinate is in [1/2, 1), exactly and without overflow.

    Parameters
    ----------
    vertices : (n, 3) array of float

    Returns
    -------
    scaled : (n, 3) array of float
    k : int
    """
    k = int(np.frexp(np.abs(vertices).max())[1])
    return np.ldexp(vertices, -k), k
