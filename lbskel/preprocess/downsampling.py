"""Downsampling of clouds: means of cells, or points as far from each other as can be, with the map of all points.

Both make the density even: a cell keeps one point however many it had, and neighboring farthest points are about as far
apart everywhere (Eldar, Lindenbaum, Porat, Zeevi 1997, https://doi.org/10.1109/83.623193).
"""

from __future__ import annotations

__all__ = ["DOWNSAMPLINGS", "downsample", "downsample_as"]

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.errors import UnknownChoice, choose, counted
from lbskel.geometry.mesh import PointCloud
from lbskel.geometry.point_stars import distinct_points
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.point_cleaning import MAX_CELLS, CleanedPoints, thinned
from lbskel.preprocess.point_neighborhoods import Neighborhoods

DOWNSAMPLINGS = {"voxel": "cell", "farthest": "points"}
"""The ways to thin a cloud, with the number that each takes."""


def downsample(cloud: PointCloud, *, cell: float | None = None, n_points: int | None = None) -> CleanedPoints:
    """Thin a cloud to the means of cubic cells, or to farthest points.

    Parameters
    ----------
    cloud : PointCloud
    cell : float, optional
        Side of the cells, in the cloud's units.
    n_points : int, optional
        Number of points, among them the first of the cloud; all distinct points if there are no more. The time is
        proportional to it and to the cloud's points.

    Returns
    -------
    CleanedPoints
        The points, the map of the cloud's points to them, and what was done.

    Raises
    ------
    UnknownChoice
        If not exactly one of the two is given, it is not positive, the number of points is not whole, or cells are
        smaller than a millionth of the cloud.

    Examples
    --------
    >>> import numpy as np
    >>> from lbskel import PointCloud
    >>> from lbskel.preprocess.downsampling import downsample
    >>> line = PointCloud(np.arange(101.0)[:, None] * [1, 0, 0])
    >>> len(downsample(line, cell=10.0).points), downsample(line, n_points=3).points[:, 0].tolist()
    (11, [0.0, 50.0, 100.0])
    """
    value = cell if n_points is None else n_points
    if (cell is None) == (n_points is None) or value is None or not value > 0:
        raise UnknownChoice("give the side of a cell or a number of points, more than 0")
    if n_points is None:
        assert cell is not None
        if np.ptp(cloud.points, axis=0).max() >= MAX_CELLS * float(cell):
            raise UnknownChoice(f"cells of side {cell:.4g} are smaller than a millionth of the cloud; give larger ones")
        points, label = thinned(cloud.points, float(cell))
        how = f"the means of cells of side {cell:.4g}"
    else:
        if not float(n_points).is_integer():
            raise UnknownChoice(f"the number of points must be whole, not {n_points}")
        chosen = distinct_points(cloud.points)[0]
        if n_points < len(chosen):
            chosen = np.sort(chosen[_farthest(cloud.points[chosen], int(n_points))])
        points, label = cloud.points[chosen], cKDTree(cloud.points[chosen]).query(cloud.points)[1]
        how = "as far from each other as can be"
    note = f"the cloud was thinned from {len(cloud.points):,} to {counted(len(points), 'point')}, {how}"
    report: dict[str, Any] = {"points": len(cloud.points), "kept": len(points)}
    return CleanedPoints(Neighborhoods(points), VertexMap(label), (note,), report)


def downsample_as(cloud: PointCloud, text: str) -> CleanedPoints:
    """Thin a cloud as a text says: ``voxel:cell=0.1`` or ``farthest:points=2000``.

    Parameters
    ----------
    cloud : PointCloud
    text : str

    Raises
    ------
    UnknownChoice
        If the text is neither of these.
    """
    name, _, given = text.partition(":")
    option = choose(DOWNSAMPLINGS, name, "way to thin a cloud")
    key, _, value = given.partition("=")
    try:
        number = float(value)
    except ValueError:
        number = np.nan
    kind = "finite" if option == "cell" else "whole"
    if key != option or not 0 < number < np.inf or (kind == "whole" and not number.is_integer()):
        raise UnknownChoice(f"{text!r}: write {name}:{option}=NUMBER, a {kind} number more than 0")
    return downsample(cloud, cell=number) if option == "cell" else downsample(cloud, n_points=int(number))


def _farthest(points: NDArray[np.float64], n: int) -> NDArray[np.int64]:
    """Choose n points: the first, then each time the one farthest from all chosen before."""
    chosen, distance = [0], np.full(len(points), np.inf)
    while len(chosen) < n:
        distance = np.minimum(distance, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(distance)))
    return np.array(chosen)
