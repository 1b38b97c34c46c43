"""A closed surface through a point cloud, so that clouds take the path of meshes.

The surface is where the smooth winding number of the oriented points has the value that it has at the points nearby.
This is Poisson reconstruction (Kazhdan, Bolitho, Hoppe 2006, https://doi.org/10.2312/SGP/SGP06/061-070) in closed form,
with a level that varies over space, so that thin limbs are kept, in which the smoothed number stays below one half.
Where points are missing, a handle may come and go with the level: of some levels the one with the fewest handles is
taken. Points that this surface misses, as those of a twig thinner than the distance between them, get a tube.
"""

from __future__ import annotations

__all__ = ["reconstruct_surface", "surface_and_points"]

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from lbskel._kernels.point_tree import PointTree
from lbskel.errors import MeshError, counted
from lbskel.geometry.graphs import weighted_graph
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.level_set import level_sets
from lbskel.preprocess.point_cleaning import CleanedPoints, clean_points
from lbskel.preprocess.point_neighborhoods import Neighborhoods
from lbskel.preprocess.point_normals import SURFACE_SMOOTHING, oriented
from lbskel.preprocess.result import PreprocessResult

Field: TypeAlias = Callable[[NDArray[np.float64]], NDArray[np.float64]]

# Side of a cell, in median spacings; larger ones take less time. Swept in benchmarks/results/point_constants.md; by
# hand, the limbs of a knot with noise were joined for two of seven seeds with 1.9, for none with 1.6 and 1.75
CELL = 1.6
N_LEVELS = 24  # points whose mean winding number is the level nearby; a guess
N_BLENDED = 4  # points nearby whose levels are averaged, so that the level changes gradually; a guess
# Lower bound on the level; benchmarks/results/point_constants.md. There is no upper bound: between limbs that almost
# touch, the field of each raises the other's, and the surface of both is where it is up to 0.7 (knot with noise)
LEAST_LEVEL = 0.15
# Level below which the normals of points contradict each other, as along a twig of one row of points, whose levels are
# below 0.05; on shapes of the catalog with noise or hidden sides they are above, except at 45 points of a hand. A guess
MIN_LEVEL = 0.05
# Shifts of the level that are tried; the first with the fewest handles is taken. A guess: by hand, the genus of whole
# clouds was the same within 0.1, and handles where points are missing came and went
SHIFTS = (0.0, 0.03, -0.03, 0.06, -0.06)
MISSED = 2.5  # distance from the surface, in spacings, beyond which it misses a point; a guess
TUBE_RADIUS = 1.3  # of the tube around missed points, in distances to the third neighbor among them; a guess
MAX_GAP = 4.0  # distance to the third neighbor among the missed points, in cells, up to which they get one; a guess
OVERLAP = 2.5  # distance in cells of other points from missed ones up to which they get a tube too; a guess
MIN_MISSED = 10  # missed points that get a tube; a guess


def reconstruct_surface(cloud: PointCloud, *, preprocess: str = "auto") -> PreprocessResult:
    """Make a closed surface through a point cloud.

    Parameters
    ----------
    cloud : PointCloud
    preprocess : str
        ``auto`` leaves out points that are three times as far from their neighbors as these from theirs, ``scan`` those
        2.5 times as far, and both thin clouds of more than 20,000 points; ``none`` keeps all points.

    Returns
    -------
    PreprocessResult
        The surface, the map of each point to the vertex nearest to it, -1 for an outlier, and notes on what was done.

    Raises
    ------
    MeshError
        If there are too few points, they lie in a plane or on a line, or no surface passes through them.
    UnknownChoice
        If ``preprocess`` is none of these words.

    References
    ----------
    Kazhdan, Bolitho, Hoppe 2006, https://doi.org/10.2312/SGP/SGP06/061-070; Barill et al. 2018,
    https://doi.org/10.1145/3197517.3201337

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> surface = lbskel.reconstruct_surface(lbskel.PointCloud(torus(1.0, 0.3).vertices))
    >>> surface.mesh.genus, len(surface.vertex_map)
    (1, 1152)
    """
    return surface_and_points(cloud, preprocess)[0]


def surface_and_points(cloud: PointCloud, preprocess: str) -> tuple[PreprocessResult, CleanedPoints]:
    """Make a closed surface, and return the points that it was made of too, at another scale.

    Parameters
    ----------
    cloud, preprocess
        As of :func:`reconstruct_surface`.
    """
    center = cloud.points.mean(axis=0)
    scale = float(np.abs(cloud.points - center).max()) or 1.0
    cleaned = clean_points((cloud.points - center) / scale, preprocess)
    V, F, nearest, n_missed, spacing = _surface_through(cleaned.cloud)
    if len(F) == 0:
        raise MeshError("no surface passes through the points: they are too few or too scattered for a shape")
    notes = [*cleaned.notes]
    if n_missed:
        where = f"{counted(n_missed, 'point')} of limbs thinner than the points are apart or seen from one side"
        notes.append(f"a tube was put around {where}, whose ends and joints are uncertain; give more points of them")
    vertex_map = cleaned.vertex_map.compose(VertexMap(nearest))
    report = {**cleaned.report, "points_in_tubes": n_missed, "spacing": spacing * scale}
    if "cell" in report:
        report["cell"] *= scale
    surface = PreprocessResult(Mesh(V * scale + center, F), vertex_map, tuple(notes), None, {"steps": [report]})
    return surface, cleaned


def _surface_through(
    nearby: Neighborhoods,
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64], int, float]:
    """Make vertices and faces of a closed surface, the vertices nearest to points, the number in tubes, the spacing."""
    cloud, points, tree = oriented(nearby), nearby.points, nearby.tree
    field = cloud.field(SURFACE_SMOOTHING)
    at_points = np.clip(field.values(), 0, 1)
    means = at_points[nearby.nearest(N_LEVELS)[1]].mean(axis=1)
    means[cloud.rough] = at_points[nearby.wide(cloud.rough)].mean(axis=1)
    levels = np.maximum(means, LEAST_LEVEL)
    spacing = float(np.median(cloud.spacings))
    size = CELL * spacing

    def inside(positions: NDArray[np.float64]) -> NDArray[np.float64]:
        level = levels[tree.nearest(positions, N_BLENDED)[1]].mean(axis=1)
        values: NDArray[np.float64] = (field.values(positions) - level) * size
        return values

    V, F = _simplest(inside, points, size)
    missed, nearest = points, np.empty(0, dtype=np.int64)
    if len(V):
        distances, numbers = PointTree(V).nearest(points)
        nearest = numbers[:, 0]
        is_far = distances[:, 0] > MISSED * np.maximum(cloud.spacings, size)
        is_missed = is_far | (means < MIN_LEVEL)
        if is_missed.any():  # with the points near them, so that the tube reaches into the surface
            is_missed |= cKDTree(points[is_missed]).query(points)[0] < OVERLAP * size
        missed = points[is_missed]
    if len(missed) >= MIN_MISSED:
        missed = missed[cKDTree(missed).query(missed, k=4)[0][:, -1] <= MAX_GAP * size]
    if len(missed) < MIN_MISSED:
        return V, F, nearest, 0, spacing
    V, F = _simplest(_united(inside, missed, size), points, size)
    nearest = PointTree(V).nearest(points)[1][:, 0] if len(V) else nearest
    return V, F, nearest, len(missed), spacing


def _simplest(inside: Field, points: NDArray[np.float64], size: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Make vertices and faces of the level set with the fewest handles, among those at SHIFTS."""
    fewest, simplest = np.inf, (np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
    for level in level_sets(inside, points, size, [shift * size for shift in SHIFTS]):
        if level.least_handles >= fewest:
            continue
        surface = level.triangles()
        n_handles = _n_handles(*surface)
        if n_handles < fewest:
            fewest, simplest = n_handles, surface
        if fewest == 0:
            break
    return simplest


def _n_handles(V: NDArray[np.float64], F: NDArray[np.int64]) -> float:
    """Count the handles of a closed surface; infinity if it has no faces."""
    if len(F) == 0:
        return np.inf
    links = np.concatenate([F[:, :2], F[:, 1:]])
    graph = weighted_graph(links, np.ones(len(links), dtype=np.int8), len(V))
    return float(connected_components(graph, directed=False)[0] - (len(V) - len(F) // 2) / 2)


def _united(inside: Field, missed: NDArray[np.float64], size: float) -> Field:
    """Unite the inside of a field with balls around points."""
    tree = cKDTree(missed)
    radii = np.maximum(TUBE_RADIUS * tree.query(missed, k=4)[0][:, -1], size)

    def either(positions: NDArray[np.float64]) -> NDArray[np.float64]:
        distances, near = tree.query(positions, k=N_BLENDED)
        values: NDArray[np.float64] = np.maximum(inside(positions), (radii[near] - distances).max(axis=1))
        return values

    return either
