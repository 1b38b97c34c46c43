"""Laplacians of point clouds: tufted, local Delaunay and heat kernel.

The star of a point is its Delaunay star among its neighbors, projected to their plane of least squares. ``robust``: the
tufted Laplacian of the triangles on which stars agree; Sharp, Crane 2020, https://doi.org/10.1111/cgf.14069.
``local_delaunay``: cotangents in the stars. Each gives one row, so the matrix is not symmetric; Cao, Tagliasacchi,
Olson, Zhang, Su 2010, https://doi.org/10.1109/SMI.2010.25. ``heat_kernel``: Belkin, Sun, Wang 2009,
https://doi.org/10.1137/1.9781611973068.112, with the Voronoi areas of the stars.
"""

from __future__ import annotations

__all__ = ["cloud_stars", "heat_kernel", "local_delaunay", "local_delaunay_of_stars", "robust"]

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from lbskel.errors import MeshError
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.geometry.point_stars import PointStars
from lbskel.geometry.scaling import unit_scale
from lbskel.geometry.sorting import distinct, unique_rows
from lbskel.operators.assembly import diagonal_matrix
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import corner_cotangents, zero_degenerate
from lbskel.operators.heat_kernel import CUT_OFF, TIME, heat_kernel_stiffness
from lbskel.operators.local_delaunay import delaunay_stars
from lbskel.operators.masses import voronoi_corner_areas
from lbskel.operators.robust import MOLLIFY_FACTOR
from lbskel.operators.robust import robust as robust_of_mesh

N_NEIGHBORS = 30  # neighbors of each point in its local triangulation: default of Sharp, Crane's robust_laplacian


def _zero_laplacian(n: int) -> Laplacian:
    """Build the zero operator of n points that span no triangle."""
    return Laplacian(csc_array((n, n)), csc_array((n, n)), treated_vertices=np.arange(n))


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
        Slack of every triangle inequality, relative to the mean edge length.
    """
    n = len(cloud.points)
    # not the stars of robust_laplacian, which change when the cloud is moved, and lose area when it is dense
    stars = delaunay_stars(unit_scale(cloud.points)[0], n_neighbors + 1)
    if len(stars) == 0:
        return _zero_laplacian(n)
    triangle = unique_rows(np.sort(stars, axis=1))[1]
    is_shared = (np.bincount(triangle) > 1)[triangle]
    is_alone = np.bincount(stars[is_shared].ravel(), minlength=n) == 0
    stars = stars[is_shared | is_alone[stars[:, 0]]]
    soup = robust_of_mesh(Mesh(cloud.points, stars), mollify_factor=mollify_factor)
    isolated = np.setdiff1d(np.arange(n), stars)
    return replace(soup, treated_vertices=distinct(np.append(soup.treated_vertices, isolated)))


def cloud_stars(cloud: PointCloud) -> NDArray[np.int64]:
    """Compute the (t, 3) Delaunay stars of the points among their 8 to 30 nearest points, as in Cao et al. 2010.

    The point itself is one of them. Each triangle has the center of its star first.

    Parameters
    ----------
    cloud : PointCloud
    """
    n_neighbors = int(np.clip(round(0.012 * len(cloud.points)), 8, 30))
    return delaunay_stars(unit_scale(cloud.points)[0], n_neighbors)


def _star_areas(cloud: PointCloud, stars: NDArray[np.int64]) -> NDArray[np.float64]:
    """Compute the (n,) Voronoi area of each point in its own star."""
    center_areas = voronoi_corner_areas(Mesh(cloud.points, stars))[:, 0]
    return np.bincount(stars[:, 0], weights=center_areas, minlength=len(cloud.points)).astype(np.float64)


def local_delaunay(cloud: PointCloud, *, stars: NDArray[np.int64] | None = None) -> Laplacian:
    """Build the Laplacian of cotangents in each point's own star, with the Voronoi areas there as mass; S != S^T.

    Parameters
    ----------
    cloud : PointCloud
    stars : (t, 3) array of int, optional
        Stars to use instead of those of the cloud; the contraction of Cao et al. keeps those of its input.
    """
    n = len(cloud.points)
    stars = cloud_stars(cloud) if stars is None else stars
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
    return local_delaunay(PointCloud(stars.vertices), stars=stars.faces)


def heat_kernel(cloud: PointCloud, *, time: float = TIME, cut_off: float = CUT_OFF) -> Laplacian:
    """Build the heat kernel Laplacian with the Voronoi area of each point in its star as mass.

    Parameters
    ----------
    cloud : PointCloud
    time : float
        t, in units of the squared mean length of the edges from the centers of the stars.
    cut_off : float
        Radius of the kernel, in sqrt(2t).
    """
    stars = cloud_stars(cloud)
    if len(stars) == 0:
        return _zero_laplacian(len(cloud.points))
    P, k = unit_scale(cloud.points)
    areas = _star_areas(cloud, stars)
    mean_edge = np.linalg.norm(P[stars[:, 1]] - P[stars[:, 0]], axis=1).mean()
    stiffness = heat_kernel_stiffness(P, np.ldexp(areas, -2 * k), time * mean_edge**2, cut_off)
    treated = np.setdiff1d(np.arange(len(P)), stars[:, 0])
    return Laplacian(stiffness, diagonal_matrix(areas), treated_vertices=treated)
