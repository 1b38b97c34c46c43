"""The surface of a solid as a mesh: marching cubes in the cells that the surface can cross, and Newton's method.

Lorensen, Cline 1987, "Marching cubes", https://doi.org/10.1145/37402.37422. The cells are found from coarse to fine: a
function that falls by no more than the distance walked has no zero in a cell whose center is further than half a
diagonal from zero.
"""

from __future__ import annotations

__all__ = ["marching_cubes", "project"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.shapes.solid import Solid

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
N_HALVINGS = 4
OFF_CENTER = np.array([0.137, 0.311, 0.223])  # of a cell, so that symmetric shapes have no zeros on the grid
GRADIENTS, STEPS_PER_GRADIENT = 2, 4  # Newton's method that keeps each gradient, six times dearer, for some steps
FLATTEST = 0.2  # smallest gradient that a step is divided by; smooth unions between fingers get there
DIFFERENCE = 1e-4  # step of the differences, of a grid step: error 1e-8 by the step squared, 1e-12 by rounding


def _crossed_cells(
    solid: Solid, origin: NDArray[np.float64], size: float, counts: NDArray[np.int64]
) -> NDArray[np.int64]:
    """(c, 3) grid positions of the cells of that size, from a grid coarser by N_HALVINGS, that can hold a zero."""
    cells = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    for halving in range(N_HALVINGS, -1, -1):
        width = size * 2**halving
        reach = np.sqrt(3) / 2 * width
        cells = cells[np.abs(solid.distance(origin + (cells + 0.5) * width, reach=reach)) <= reach]
        if halving:
            cells = (2 * cells[:, None] + CORNERS).reshape(-1, 3)
    return cells


def project(solid: Solid, points: NDArray[np.float64], *, step: float) -> NDArray[np.float64]:
    """Points near the surface moved onto it along its gradient, by no more than ``step`` at a time."""
    for _ in range(GRADIENTS):
        slope = solid.gradient(points, step=DIFFERENCE * step)
        slope /= np.maximum((slope**2).sum(axis=1, keepdims=True), FLATTEST**2)
        for _ in range(STEPS_PER_GRADIENT):
            points = points - np.clip(solid.distance(points, reach=step), -step, step)[:, None] * slope
    return points


def marching_cubes(solid: Solid, step: float) -> Mesh:
    """The triangles of marching cubes on a grid of that step, oriented outwards; some are slivers.

    Its vertices are off the surface by about ``step**2 / (8 * radius)``; :func:`project` takes them there.
    """
    outer = 2 * solid.radii.max()
    low, high = solid.centers.min(axis=0) - outer, solid.centers.max(axis=0) + outer
    origin = low - OFF_CENTER * step
    counts = np.ceil((high - origin) / (step * 2**N_HALVINGS)).astype(np.int64)
    cells = _crossed_cells(solid, origin, step, counts)
    grid = (counts << N_HALVINGS) + 1
    number, row = np.unique(np.ravel_multi_index((cells[:, None] + CORNERS).T, grid), return_inverse=True)
    at = origin + np.stack(np.unravel_index(number, grid), axis=1) * step
    V, F, _ = igl.marching_cubes(
        solid.distance(at, reach=2 * step), at, np.ascontiguousarray(row.reshape(8, -1).T), 0.0
    )
    return Mesh(V, F)
