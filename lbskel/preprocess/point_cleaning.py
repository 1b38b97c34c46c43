"""Cleaning of point clouds: duplicates merged, large clouds thinned, outliers removed, with the map of the points."""

from __future__ import annotations

__all__ = ["CLOUD_PREPARATIONS", "MAX_CELLS", "CleanedPoints", "clean_points", "thinned"]

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError, choose, counted, were
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.outliers import find_outliers
from lbskel.preprocess.point_neighborhoods import Neighborhoods

MIN_POINTS = 20  # fewer enclose nothing that has a skeleton: a guess, above the 16 neighbors of a normal
MIN_WIDTH = 1e-6  # of the cloud across its flattest direction, relative to its longest: thinner is a plane or a line
# Number of points that a cloud is thinned to: this share of its points, between two bounds. Guesses that bound the
# time: the surface takes 0.1 s per thousand points.
SHARE, FEWEST, MOST = 0.125, 20_000, 80_000
MAX_CELLS = 2**20  # upper bound on the cells to each side of the median: the number of a cell has 21 bits for each axis
MAX_HALVINGS = 64  # of the side of cells, from the extent of the cloud with its stray points: to 1e-19 of it; it ends
# the search where hardly any point is near the median. A guess
# Largest inverse density of a point that is no outlier, relative to that of the denser points nearby, by preparation;
# guesses: clean samples have up to 2.5
CLOUD_PREPARATIONS: dict[str, float] = {"auto": 3.0, "scan": 2.5, "none": np.inf}


@dataclass(frozen=True, eq=False)
class CleanedPoints:
    """Distinct points of a cloud.

    Parameters
    ----------
    cloud : Neighborhoods
        The points.
    vertex_map : VertexMap
        From the points of the cloud to these; an outlier has none.
    notes : tuple of str
        What was done, a sentence each.
    report : dict
        Counts, ready for JSON.
    """

    cloud: Neighborhoods
    vertex_map: VertexMap
    notes: tuple[str, ...]
    report: dict[str, Any]

    @property
    def points(self) -> NDArray[np.float64]:
        """(k, 3) the points."""
        return self.cloud.points

    def source_neighbors(self, k: int) -> NDArray[np.int64] | None:
        """(n, k) nearest points of each point of the cloud, itself first; None where points were merged or left out.

        Parameters
        ----------
        k : int
        """
        number = self.vertex_map.indices
        if len(number) != len(self.points):
            return None
        source = np.empty_like(number)
        source[number] = np.arange(len(number))
        neighbors: NDArray[np.int64] = source[self.cloud.nearest(k)[1][number]]
        return neighbors


def clean_points(points: NDArray[np.float64], preparation: str = "auto") -> CleanedPoints:
    """Merge duplicates, thin a large cloud by the means of cubic cells, and remove outliers.

    Parameters
    ----------
    points : (n, 3) array of float
    preparation : str
        ``auto`` removes points that are three times as far from their neighbors as these from theirs, ``scan`` those
        2.5 times as far; ``none`` does not, and does not thin the cloud.

    Raises
    ------
    MeshError
        If there are too few points, or they lie in a plane or on a line.
    UnknownChoice
        If the preparation is none of these.
    """
    limit = choose(CLOUD_PREPARATIONS, preparation, "preparation of point clouds")
    kept, labels = np.unique(points, axis=0, return_inverse=True)
    labels, notes = labels.reshape(-1), []
    report: dict[str, Any] = {"points": len(points), "duplicates": len(points) - len(kept)}
    if report["duplicates"]:
        notes.append(f"{were(report['duplicates'], 'duplicate point')} merged")
    budget = int(np.clip(SHARE * len(kept), FEWEST, MOST))
    if len(kept) > budget and np.isfinite(limit):
        cell = _cell_size(kept, budget)
        kept, step = thinned(kept, cell)
        labels = step[labels]
        report["cell"] = cell
        means = f"{len(kept):,} points, the means of cubic cells"
        notes.append(f"the cloud was thinned to {means}, to save time; the preparation none keeps all points")
    _require_many(kept, f"among {len(points):,}", "coordinates in double precision if single precision merged them")
    cloud = Neighborhoods(kept)
    is_outlier, cloud = find_outliers(cloud, limit) if np.isfinite(limit) else (np.zeros(len(kept), dtype=bool), cloud)
    report["outliers"] = int(is_outlier[labels].sum())
    if report["outliers"]:
        notes.append(f"{were(report['outliers'], 'outlier')} left out, where points are much farther apart than nearby")
        _require_many(cloud.points, "without the outliers", "preprocess='none' if the others are no outliers")
    _require_solid(cloud.points)  # without outliers: from one far away, all others lie on a line
    new = np.where(is_outlier, -1, np.cumsum(~is_outlier) - 1)
    report["kept"] = len(cloud.points)
    return CleanedPoints(cloud, VertexMap(new[labels]), tuple(notes), report)


def _require_many(points: NDArray[np.float64], where: str, remedy: str) -> None:
    """Raise MeshError for points that are too few to enclose anything."""
    if len(points) < MIN_POINTS:
        found = counted(len(points), "distinct point")
        raise MeshError(f"the cloud has {found} {where}, and needs {MIN_POINTS}: give more points, or {remedy}")


def _require_solid(points: NDArray[np.float64]) -> None:
    """Raise MeshError for points that enclose nothing."""
    offsets = points - points.mean(axis=0)
    offsets /= np.abs(offsets).max()  # squares of 1e-200 would be zero
    widths = np.linalg.svd(offsets.T @ offsets, compute_uv=False)
    if widths[2] <= MIN_WIDTH**2 * widths[0]:
        what = "on a line" if widths[1] <= MIN_WIDTH**2 * widths[0] else "in a plane"
        raise MeshError(f"the points lie {what} and enclose nothing; give points on the surface of a body")


def _cell_size(points: NDArray[np.float64], budget: int) -> float:
    """Find by bisection about the smallest side of cells of which at most ``budget`` hold a point."""
    low, high = 0.0, float(np.ptp(points, axis=0).max())
    size = high / np.sqrt(budget)
    for _ in range(MAX_HALVINGS):
        if high - low < high / 1000:
            break
        if len(np.unique(_cells(points, size))) > budget:
            low = size
        else:
            high = size
        size = (low + high) / 2
    return high


def _cells(points: NDArray[np.float64], size: float) -> NDArray[np.int64]:
    """(n,) number of the cubic cell of each point; points farther than MAX_CELLS from the median are moved there."""
    from_median = np.floor((points - np.median(points, axis=0)) / size)
    cells = np.clip(from_median, -MAX_CELLS, MAX_CELLS - 1).astype(np.int64) + MAX_CELLS
    numbers: NDArray[np.int64] = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    return numbers


def thinned(points: NDArray[np.float64], size: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Average the points of each cell: (k, 3) means and (n,) the mean that each point went to.

    Parameters
    ----------
    points : (n, 3) array of float
    size : float
        Side of a cell.
    """
    label = np.unique(_cells(points, size), return_inverse=True)[1].reshape(-1)
    count = np.bincount(label)
    return np.stack([np.bincount(label, column) / count for column in points.T], axis=1), label
