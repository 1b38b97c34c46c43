"""Faces in blocks of neighbours, each in a ball, so that a search leaves out most of a mesh at a glance.

Faces are put along a curve that fills space (Morton 1966, "A computer oriented geodetic data base") by their centres;
each run of them is a block.
"""

from __future__ import annotations

__all__ = ["COARSE", "FINE", "Balls", "Blocks", "blocks_of", "within"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.ordering import stable_order

FINE, COARSE = 4, 64  # faces to a ball, of the small ones and of the large ones, which hold whole small ones
BITS = 10  # of each coordinate along the curve
ROUNDING = 1e-12  # of the largest coordinate, by which each ball is larger, so that none is missed by rounding


@dataclass(frozen=True, eq=False)
class Balls:
    """Balls round consecutive runs of faces."""

    centres: NDArray[np.float64]
    radii: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Blocks:
    """Runs of faces with a ball round each, at two sizes.

    Parameters
    ----------
    order : (m,) array of int
        The faces along the curve.
    coarse, fine : Balls
        Round each COARSE and each FINE of them.
    """

    order: NDArray[np.int64]
    coarse: Balls
    fine: Balls


def within(runs: NDArray[np.int64], size: int, n: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """For some runs of ``size`` out of n things, the row of each thing among the runs, and the thing."""
    things = size * runs[:, None] + np.arange(size)
    row, column = np.nonzero(things < n)
    return row, things[row, column]


def _along_curve(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """(n,) place of points along the curve."""
    low, size = points.min(axis=0), np.ptp(points, axis=0).max()
    cells = ((points - low) * ((2**BITS - 1) / size if size > 0 else 0.0)).astype(np.int64)
    numbers = np.arange(2**BITS)
    spread = np.sum([(numbers >> bit & 1) << (3 * bit) for bit in range(BITS)], axis=0)
    return spread[cells[:, 0]] | spread[cells[:, 1]] << 1 | spread[cells[:, 2]] << 2


def _balls(low: NDArray[np.float64], high: NDArray[np.float64], slack: float) -> Balls:
    """Balls round (3, k) boxes."""
    return Balls(((low + high) / 2).T, np.linalg.norm(high - low, axis=0) / 2 + slack)


def blocks_of(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> Blocks:
    """Blocks of triangles, which lie along the curve as their first corners do."""
    order = stable_order(_along_curve(vertices)[faces[:, 0]])
    corners = faces[order].ravel()
    first = np.arange(0, len(faces), FINE)
    low, high = (
        np.stack([least.reduceat(x[corners], 3 * first) for x in vertices.T]) for least in (np.minimum, np.maximum)
    )
    slack = ROUNDING * float(np.abs(vertices).max())
    fine, runs = _balls(low, high, slack), np.arange(0, len(first), COARSE // FINE)
    low, high = np.minimum.reduceat(low, runs, axis=1), np.maximum.reduceat(high, runs, axis=1)
    return Blocks(order, _balls(low, high, slack), fine)
