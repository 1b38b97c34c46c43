"""Meshing the zero level set of an implicit function: marching cubes, then Newton's method for the vertices.

Lorensen, Cline 1987, "Marching cubes", https://doi.org/10.1145/37402.37422. Only cells that the surface can cross are
evaluated. They are found from coarse to fine: a function with Lipschitz constant 1 has no zero in a cell if its value
at the center exceeds half the diagonal.
"""

from __future__ import annotations

__all__ = ["marching_cubes", "project"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.shapes.round_cones import Solid

# Corners of the unit cell in the order of igl.marching_cubes.
CELL_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
# Number of times that the coarsest cells are halved; a guess.
N_REFINEMENTS = 4
# Offset of the grid, in cells, so that grid points of symmetric shapes are not on the surface; arbitrary.
GRID_OFFSET = np.array([0.137, 0.311, 0.223])
# Newton's method reuses each gradient, which costs six values, for several steps; guesses.
N_GRADIENTS, N_STEPS_PER_GRADIENT = 2, 4
# Value, relative to the largest step, at which a point is on the surface: above the rounding error.
CONVERGED = 1e-12
# Lower bound on the gradient's length in a Newton step; smooth unions between fingers have gradients as short. A guess.
MIN_SLOPE = 0.2
# Step of the central differences, relative to a grid step: truncation error 1e-8 (the step squared), rounding 1e-12.
DIFFERENCE_STEP = 1e-4


def _crossed_cells(
    solid: Solid, origin: NDArray[np.float64], size: float, counts: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Find the cells that the surface can cross: (c, 3) integer positions in the finest grid.

    ``size`` is the side of a cell of the finest grid, ``counts`` the numbers of cells of the coarsest one.
    """
    cells = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    for level in range(N_REFINEMENTS, -1, -1):
        width = size * 2**level
        half_diagonal = np.sqrt(3) / 2 * width
        cells = cells[np.abs(solid.distance(origin + (cells + 0.5) * width, cutoff=half_diagonal)) <= half_diagonal]
        if level:
            cells = (2 * cells[:, None] + CELL_CORNERS).reshape(-1, 3)
    return cells


def project(solid: Solid, points: NDArray[np.float64], *, step: float) -> NDArray[np.float64]:
    """Move points near the surface of a solid onto it, along the gradient.

    Parameters
    ----------
    solid : Solid
    points : (n, 3) array of float
        Coordinates in the units of the solid, at most a few ``step`` off the surface.
    step : float
        Upper bound on the length of each Newton step, in the units of the solid.
    """
    points, off = np.array(points), np.arange(len(points))
    for _ in range(N_GRADIENTS):
        slope = solid.gradient(points[off], step=DIFFERENCE_STEP * step)
        slope /= np.maximum((slope**2).sum(axis=1, keepdims=True), MIN_SLOPE**2)
        for _ in range(N_STEPS_PER_GRADIENT):
            values = solid.distance(points[off], cutoff=step)
            far = np.abs(values) > CONVERGED * step
            off, slope = off[far], slope[far]
            points[off] -= np.clip(values[far], -step, step)[:, None] * slope
    return points


def marching_cubes(solid: Solid, step: float) -> Mesh:
    """Mesh the surface of a solid by marching cubes; faces point outwards, and some are slivers.

    The vertices are off the surface by about ``step**2 / (8 * radius)``; :func:`project` moves them onto it.

    Parameters
    ----------
    solid : Solid
    step : float
        Side of a grid cell, in the units of the solid.
    """
    margin = 2 * solid.radii.max()
    low, high = solid.centers.min(axis=0) - margin, solid.centers.max(axis=0) + margin
    origin = low - GRID_OFFSET * step
    counts = np.ceil((high - origin) / (step * 2**N_REFINEMENTS)).astype(np.int64)
    cells = _crossed_cells(solid, origin, step, counts)
    grid_shape = (counts << N_REFINEMENTS) + 1
    corners = np.ravel_multi_index((cells[:, None] + CELL_CORNERS).T, grid_shape)
    grid_points, corner_rows = np.unique(corners, return_inverse=True)
    positions = origin + np.stack(np.unravel_index(grid_points, grid_shape), axis=1) * step
    V, F, _ = igl.marching_cubes(
        solid.distance(positions, cutoff=2 * step), positions, np.ascontiguousarray(corner_rows.reshape(8, -1).T), 0.0
    )
    return Mesh(V, F)
