"""Measures of a point cloud that matter for its skeleton, counted without changing it, and what will be done."""

from __future__ import annotations

__all__ = ["PointReport", "check_points"]

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from lbskel.errors import MeshError, counted
from lbskel.geometry.mesh import PointCloud
from lbskel.preprocess.messages import as_sentence
from lbskel.preprocess.point_cleaning import clean_points

MAX_SPREAD = 10.0  # ratio of distances between neighbors, 99 % over 1 %, from which the density is told to be uneven


@dataclass(frozen=True)
class PointReport:
    """Measures and findings of :func:`check_points`.

    Parameters
    ----------
    points, duplicates, outliers, kept : int
        Kept are the distinct points that are no outliers, or means of them where the cloud is thinned.
    diameter_bound, spacing : float
        Twice the largest distance of a point from their mean, and median distance of a point from its nearest, in the
        units of the cloud.
    spacing_spread : float
        The 99th percentile of the distances from a point to its nearest, over the 1st percentile.
    findings : tuple of str
        A sentence for each defect, with what lbskel does about it.
    is_advised : bool
        Whether the points can have a skeleton.
    """

    points: int
    duplicates: int
    outliers: int
    kept: int
    diameter_bound: float
    spacing: float
    spacing_spread: float
    findings: tuple[str, ...]
    is_advised: bool

    def as_dict(self) -> dict[str, Any]:
        """Return all fields as a dictionary that JSON can hold."""
        return asdict(self)

    def __str__(self) -> str:
        lines = [
            f"{counted(self.points, 'point')}, {self.kept:,} kept",
            f"  spacing   {self.spacing:.4g}; the diameter bound is {self.diameter_bound:.6g}",
            *(f"  found     {finding}" for finding in self.findings or ["Nothing that prevents a skeleton."]),
        ]
        return "\n".join(lines)


def check_points(cloud: PointCloud) -> PointReport:
    """Measure a cloud and list its defects.

    Parameters
    ----------
    cloud : PointCloud
    """
    distinct = np.unique(cloud.points, axis=0)
    nearest = cKDTree(distinct).query(distinct, k=2)[0][:, 1] if len(distinct) > 1 else np.zeros(1)
    few, median, many = np.quantile(nearest, [0.01, 0.5, 0.99])
    findings: list[str] = []
    report = {"duplicates": len(cloud.points) - len(distinct), "outliers": 0, "kept": 0}
    try:
        cleaned = clean_points(cloud.points)
        report |= {name: cleaned.report[name] for name in report}
        findings += map(as_sentence, cleaned.notes)
        is_advised = True
    except MeshError as error:
        findings.append(f"No skeleton: {error}.")
        is_advised = False
    spread = float(many / few) if few > 0 else 1.0
    if spread > MAX_SPREAD:
        findings.append(f"The distance between neighbors varies by a factor of {spread:.3g}: thin limbs may be missed.")
    return PointReport(
        points=len(cloud.points),
        **report,
        diameter_bound=2 * float(np.linalg.norm(distinct - distinct.mean(axis=0), axis=1).max()),
        spacing=float(median),
        spacing_spread=spread,
        findings=tuple(findings),
        is_advised=is_advised,
    )
