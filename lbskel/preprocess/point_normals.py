"""Outward normals of points, and the area that each point stands for.

The normal of a point is that of the least-squares plane of its neighbors. Signs follow a minimum spanning tree of the
angles between neighbors (Hoppe, DeRose, Duchamp, McDonald, Stuetzle 1992, https://doi.org/10.1145/133994.134011). Where
the tree steps from one limb to another that almost touches it, a limb may be inside out; the winding number around its
points is negative, and their normals are turned. Then each normal is replaced by the direction in which the winding
number of all of them falls, which makes noisy normals smooth and wrong signs right (Lin, Shi, Liu 2024, "Fast and
globally consistent normal orientation based on the winding number normal consistency",
https://doi.org/10.1145/3687895).
"""

from __future__ import annotations

__all__ = ["OrientedPoints", "oriented"]

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.spanning_signs import spanning_signs
from lbskel.geometry.normals import normalized
from lbskel.geometry.sorting import distinct
from lbskel.preprocess.dipole_tree import DipoleTree, leaf_order
from lbskel.preprocess.point_neighborhoods import Neighborhoods

N_NEIGHBORS = 16  # of a point in its plane of least squares, and for its area; a guess
# Upper bound on the variance of the few neighbors across their plane, over the smaller one along it. Above it the plane
# of all neighbors is tried, as noise as large as the spacing needs; benchmarks/results/point_constants.md
MAX_VARIATION = 0.15
N_LINKS = 8  # nearest neighbors that the sign of a normal can follow; a guess
# Widths of the dipoles, in spacings, in the two rounds that correct the normals; the second is left out if the first
# turns none around. Wide enough for the field between points, narrow enough for thin limbs;
# benchmarks/results/point_constants.md
FIRST_SMOOTHING, SECOND_SMOOTHING = 3.0, 2.0
# Width of the dipoles, in spacings, in the field whose level set is the surface, and where normals are turned.
# benchmarks/results/point_orientation.md
SURFACE_SMOOTHING = 1.5
# Upper bound on the rounds in which normals are turned; the border of what is inside out moves in each.
# benchmarks/results/point_orientation.md
MAX_TURNS = 16


@dataclass(frozen=True, eq=False)
class OrientedPoints:
    """Points of a surface with normals and areas.

    Parameters
    ----------
    points : (n, 3) array of float
    normals : (n, 3) array of float
        Of unit length, outward.
    areas : (n,) array of float
        Area of the disk that each point stands for.
    order : array of int
        Order of the points in the leaves of a tree, by :func:`lbskel.preprocess.dipole_tree.leaf_order`.
    rough : (r,) array of int
        Points whose larger neighborhood is flatter than the small one: noise is as large as the spacing of the points.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    areas: NDArray[np.float64]
    order: NDArray[np.int64]
    rough: NDArray[np.int64]

    @property
    def spacings(self) -> NDArray[np.float64]:
        """(n,) distance between neighbors: the side of a square of the point's area."""
        spacings: NDArray[np.float64] = np.sqrt(self.areas)
        return spacings

    def field(self, smoothing: float) -> DipoleTree:
        """Build the field of the points' winding number, smoothed over ``smoothing`` spacings."""
        moments = self.areas[:, None] * self.normals
        return DipoleTree.of(self.points, moments, smoothing * self.spacings, self.order)


def oriented(cloud: Neighborhoods) -> OrientedPoints:
    """Estimate the outward normals and the areas of points.

    Parameters
    ----------
    cloud : Neighborhoods
        Of a closed surface or parts of one; more points than N_NEIGHBORS.
    """
    points, (distances, neighbors) = cloud.points, cloud.nearest(N_NEIGHBORS)
    normals, variation = _plane_normals(points, neighbors)
    rough = np.flatnonzero(variation > MAX_VARIATION)
    wide_normals, wide_variation = _plane_normals(points, cloud.wide(rough))
    is_flatter = wide_variation < variation[rough]
    rough = rough[is_flatter]
    normals[rough] = wide_normals[is_flatter]
    areas = np.pi * distances[:, -1] ** 2 / (N_NEIGHBORS - 0.5)
    signed = _with_signs(points, normals, areas, neighbors[:, 1 : N_LINKS + 1])
    found = OrientedPoints(points, signed, areas, leaf_order(points), rough)
    found = _turned_outward(found, neighbors)
    for smoothing in (FIRST_SMOOTHING, SECOND_SMOOTHING):
        normals = normalized(-found.field(smoothing).gradients())
        is_turned = (normals * found.normals).sum(axis=1) < 0
        found = replace(found, normals=normals)
        if not is_turned.any():
            break
    return found


def _turned_outward(found: OrientedPoints, neighbors: NDArray[np.int64]) -> OrientedPoints:
    """Turn normals where the winding number around the point is negative: the surface there is inside out."""
    for _ in range(MAX_TURNS):
        values = found.field(SURFACE_SMOOTHING).values()
        is_inside_out = values[neighbors].mean(axis=1) < 0
        if is_inside_out.sum() < N_NEIGHBORS:
            break
        found = replace(found, normals=np.where(is_inside_out, -1.0, 1.0)[:, None] * found.normals)
    return found


def _plane_normals(
    points: NDArray[np.float64], neighbors: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(q, 3) normals of the planes of some neighborhoods, and (q,) variance along the normal over the next larger."""
    coordinates = [column[neighbors] for column in np.ascontiguousarray(points.T)]
    offsets = [column - column.mean(axis=1, keepdims=True) for column in coordinates]
    covariances = np.empty((len(neighbors), 3, 3))
    for i, j in zip(*np.tril_indices(3), strict=True):  # all that eigh reads
        covariances[:, i, j] = np.einsum("nk,nk->n", offsets[i], offsets[j])
    variances, axes = np.linalg.eigh(covariances)
    return axes[:, :, 0], variances[:, 0] / np.maximum(variances[:, 1], np.finfo(float).tiny)


def _with_signs(
    points: NDArray[np.float64], normals: NDArray[np.float64], areas: NDArray[np.float64], neighbors: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Give normals the signs that neighbors agree on, such that the volume of each connected part is positive."""
    n, k = neighbors.shape
    first, second = np.repeat(np.arange(n), k), neighbors.ravel()
    keys = distinct(np.minimum(first, second) * n + np.maximum(first, second))
    links = np.stack(np.divmod(keys, n), axis=1)
    cosines = (normals[links[:, 0]] * normals[links[:, 1]]).sum(axis=1)
    order = np.argsort(-np.abs(cosines))
    sign, part = spanning_signs(links[order], np.where(cosines[order] < 0, -1, 1).astype(np.int8), n)
    signed = normals * sign[:, None]
    count = np.bincount(part)
    centers = np.stack([np.bincount(part, column) / count for column in points.T], axis=1)
    volumes = np.bincount(part, areas * (signed * (points - centers[part])).sum(axis=1))
    outward: NDArray[np.float64] = signed * np.where(volumes < 0, -1.0, 1.0)[part, None]
    return outward
