"""Laplacians of point clouds: tufted, local Delaunay and heat kernel.

The star of a point is its Delaunay star among its neighbors, projected to their plane of least squares. ``robust``: the
tufted Laplacian of the triangles on which stars agree; Sharp, Crane 2020, https://doi.org/10.1111/cgf.14069.
``local_delaunay``: cotangents in the stars. Each gives one row, so the matrix is not symmetric; Cao, Tagliasacchi,
Olson, Zhang, Su 2010, https://doi.org/10.1109/SMI.2010.25. ``heat_kernel``: Belkin, Sun, Wang 2009,
https://doi.org/10.1137/1.9781611973068.112, with the Voronoi areas of the stars.

Of the points at one place, as where scans were merged, the first has the area and the weights of that place. Each other
is coupled with it alone and has no area, so that functions have one value there, and both matrices stay sparse.
"""

from __future__ import annotations

__all__ = ["heat_kernel", "local_delaunay", "local_delaunay_of_stars", "robust"]

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import Concatenate, ParamSpec

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.geometry.point_stars import PointStars, distinct_points
from lbskel.geometry.scaling import unit_scale
from lbskel.geometry.sorting import distinct, unique_rows
from lbskel.operators.assembly import diagonal_matrix, stiffness_of_pairs
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import corner_cotangents, zero_degenerate
from lbskel.operators.heat_kernel import CUT_OFF, TIME, heat_kernel_stiffness, median_length
from lbskel.operators.local_delaunay import delaunay_stars
from lbskel.operators.masses import voronoi_corner_areas
from lbskel.operators.robust import MOLLIFY_FACTOR
from lbskel.operators.robust import robust as robust_of_mesh

# Neighbors of each point in its local triangulation: default of Sharp, Crane's robust_laplacian. With 7 neighbors the
# stars of random points have 69 % of the area of a sphere, with 11, 15, 19, 30: 88, 95, 98 and 99.6 %, and 45 have more
# of it by 0.2 %, but by up to 5 % too much where the surface bends between the points (a torus of 500).
N_NEIGHBORS = 30
P = ParamSpec("P")


def _zero_laplacian(n: int) -> Laplacian:
    """Build the zero operator of n points that span no triangle."""
    return Laplacian(csc_array((n, n)), csc_array((n, n)), treated_vertices=np.arange(n))


def _stars(points: NDArray[np.float64], n_neighbors: int = N_NEIGHBORS) -> NDArray[np.int64]:
    """Compute the (t, 3) Delaunay stars of points among their nearest ones, each triangle with its center first."""
    return delaunay_stars(unit_scale(points)[0], n_neighbors + 1)  # a point is one of its nearest


def _of_distinct_points(
    build: Callable[Concatenate[PointCloud, P], Laplacian],
) -> Callable[Concatenate[PointCloud, P], Laplacian]:
    """Return the operator that builds the Laplacian of the distinct points, and ties each copy of one to it.

    A copy has no area, and a weight of one, that of an edge between squares, to the first point at its place. So the
    eigenfunctions of the distinct points remain, with their eigenvalues. Copies are listed as treated.
    """

    @wraps(build)
    def build_of_distinct(cloud: PointCloud, /, *args: P.args, **options: P.kwargs) -> Laplacian:
        first, place = distinct_points(cloud.points)
        n = len(place)
        if len(first) == n:
            return build(cloud, *args, **options)
        L = build(PointCloud(cloud.points[first]), *args, **options)
        copies = np.setdiff1d(np.arange(n), first)
        ties = stiffness_of_pairs(n, first[place[copies]], copies, np.ones(len(copies)))
        at = csc_array((np.ones(len(first)), (first, np.arange(len(first)))), shape=(n, len(first)))
        return Laplacian(
            (at @ L.stiffness @ at.T + ties).tocsc(),
            (at @ L.mass @ at.T).tocsc(),
            treated_vertices=np.sort(np.append(first[L.treated_vertices], copies)),
        )

    return build_of_distinct


@_of_distinct_points
def robust(cloud: PointCloud, *, n_neighbors: int = N_NEIGHBORS, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """Build the tufted Laplacian of the triangles of the local Delaunay stars, with the lumped mass of its cover.

    Each distinct triangle of at least two stars counts once, and so do those of the star of a point that is in none of
    these. Sharp and Crane count every triangle of every star and divide by three; but the cover glues the copies of a
    triangle to each other and not to its neighbors, and eigenvalues are 5 % too small, however many points there are.

    Parameters
    ----------
    cloud : PointCloud
    n_neighbors : int
        Number of nearest neighbors in the local triangulation of each point.
    mollify_factor : float
        Slack of every triangle inequality, relative to the median edge length: the mean grows with an outlier, whose
        edges are long.
    """
    n = len(cloud.points)
    # not the stars of robust_laplacian, which change when the cloud is moved, and lose area when it is dense
    stars = _stars(cloud.points, n_neighbors)
    if len(stars) == 0:
        return _zero_laplacian(n)
    triangle = unique_rows(np.sort(stars, axis=1))[1]
    is_shared = (np.bincount(triangle) > 1)[triangle]
    is_alone = np.bincount(stars[is_shared].ravel(), minlength=n) == 0
    stars = stars[is_shared | is_alone[stars[:, 0]]]
    lengths = igl.edge_lengths(unit_scale(cloud.points)[0], stars)
    factor = mollify_factor * median_length(lengths) / (float(lengths.mean()) or 1.0)  # of the mean, which meshes take
    soup = robust_of_mesh(Mesh(cloud.points, stars), mollify_factor=factor)
    isolated = np.setdiff1d(np.arange(n), stars)
    return replace(soup, treated_vertices=distinct(np.append(soup.treated_vertices, isolated)))


def _star_areas(cloud: PointCloud, stars: NDArray[np.int64]) -> NDArray[np.float64]:
    """Compute the (n,) Voronoi area of each point in its own star."""
    center_areas = voronoi_corner_areas(Mesh(cloud.points, stars))[:, 0]
    return np.bincount(stars[:, 0], weights=center_areas, minlength=len(cloud.points)).astype(np.float64)


@_of_distinct_points
def local_delaunay(cloud: PointCloud) -> Laplacian:
    """Build the Laplacian of cotangents in each point's own star, with the Voronoi areas there as mass; S != S^T.

    Cao et al. take 8 to 30 points with the center, 1.2 % of all; fewer than 31 leave stars of random points open.

    Parameters
    ----------
    cloud : PointCloud
    """
    return _of_stars(cloud, _stars(cloud.points))


def _of_stars(cloud: PointCloud, stars: NDArray[np.int64]) -> Laplacian:
    """Build the operator :func:`local_delaunay` of (t, 3) stars."""
    n = len(cloud.points)
    if len(stars) == 0:
        return _zero_laplacian(n)
    mesh = Mesh(cloud.points, stars)
    cotangents, degenerate = zero_degenerate(corner_cotangents(mesh))
    center, first, second = stars.T
    entries = np.concatenate([cotangents[:, 2], cotangents[:, 1]]) / 2
    rows, columns = np.concatenate([center, center]), np.concatenate([first, second])
    W = coo_array((entries, (rows, columns)), shape=(n, n)).tocsc()
    stiffness = (diagonal_matrix(W.sum(axis=1)) - W).tocsc()
    is_treated = np.bincount(center, minlength=n) == 0
    is_treated[center[degenerate.any(axis=1)]] = True
    areas = diagonal_matrix(_star_areas(cloud, stars))
    return Laplacian(stiffness, areas, treated_vertices=np.flatnonzero(is_treated))


def local_delaunay_of_stars(stars: Mesh) -> Laplacian:
    """Build the operator :func:`local_delaunay` with given stars: those of the cloud before it was contracted.

    Parameters
    ----------
    stars : PointStars

    Raises
    ------
    MeshError
        If ``stars`` is an ordinary mesh, whose faces are not stars.
    """
    if not isinstance(stars, PointStars):
        raise MeshError("the operator local_delaunay is one of points; give a PointCloud of the vertices")
    return _of_stars(PointCloud(stars.vertices), stars.faces)


@_of_distinct_points
def heat_kernel(cloud: PointCloud, *, time: float = TIME, cut_off: float = CUT_OFF) -> Laplacian:
    """Build the heat kernel Laplacian with the Voronoi area of each point in its star as mass.

    The kernel has one radius on the whole cloud, 4.4 median edges by default. Points that are farther from all others,
    as in the sparse parts of a cloud that is mostly dense, are coupled with none, and are listed as treated.

    Parameters
    ----------
    cloud : PointCloud
    time : float
        t, in units of the squared median length of the two edges from the center in each triangle of the stars.
    cut_off : float
        Radius of the kernel, in sqrt(2t).

    Raises
    ------
    MeshError
        If the kernel would couple so many pairs of points that memory might run out.
    """
    stars = _stars(cloud.points)
    if len(stars) == 0:
        return _zero_laplacian(len(cloud.points))
    points, k = unit_scale(cloud.points)
    areas = _star_areas(cloud, stars)
    # both neighbors: which is the last of an open star depends on the side from which it is seen
    length = median_length(np.linalg.norm(points[stars[:, 1:]] - points[stars[:, :1]], axis=2).ravel())
    stiffness = heat_kernel_stiffness(points, np.ldexp(areas, -2 * k), time * length**2, cut_off)
    treated = np.flatnonzero(stiffness.diagonal() == 0)
    return Laplacian(stiffness, diagonal_matrix(areas), treated_vertices=treated)
