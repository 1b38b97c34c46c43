"""Bounding volume hierarchy: a tree of axis-aligned bounding boxes (AABB) over the faces of a mesh.

The faces of each box are split along the axis on which their centroids extend farthest, at the rank that fills the
first child. Unlike libigl's, the tree is complete, has no pointers, and has a few faces in each leaf. It was measured
to be built in a third of the time of libigl's tree and searched in two thirds. Its rays hit faces of any size; those
of libigl miss faces with an area below about 1e-6.
"""

from __future__ import annotations

__all__ = ["AABBTree", "build_aabb_tree"]

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel._kernels.bvh import bounding_boxes, spatial_order
from lbskel._kernels.nearest_points import nearest_points
from lbskel._kernels.ray_casting import first_hits, winding_numbers
from lbskel.geometry.deadline import NEVER, Deadline, in_slices

# Margin by which each box is enlarged, relative to the largest coordinate, so that rounding errors miss no face. A
# guess, well above the rounding error of 1e-16.
BOX_MARGIN = 1e-12

LEAF_SIZE = 4  # faces in a leaf: LEAF of lbskel._kernels.bvh, which has C type and cannot be imported
BLOCK_SIZE = 10_000  # pairs of a box and a node that are compared at a time, which takes about 10 MB; a guess


@dataclass(frozen=True, eq=False)
class AABBTree:
    """Triangles in a complete binary tree of bounding boxes.

    Parameters
    ----------
    order : (m,) array of int
        The faces in the order of the leaves.
    corners : (m, 9) array of float
        Positions of the three corners of each face, in that order.
    bounds : (2 p, 6) array of float
        Lowest and highest corner of each box. Row 1 is the root, the children of row i are rows 2 i and 2 i + 1, the
        second half are leaves.
    """

    order: NDArray[np.int64]
    corners: NDArray[np.float64]
    bounds: NDArray[np.float64]

    @property
    def overlap(self) -> float:
        """Total area of the leaf boxes over that of the root box: the mean number that a line through it meets."""
        leaves = self.bounds[len(self.bounds) // 2 :]
        boxes = np.concatenate([self.bounds[1:2], leaves[leaves[:, 0] <= leaves[:, 3]]])
        x, y, z = (boxes[:, 3:] - boxes[:, :3]).T
        areas = x * y + y * z + z * x
        return float(areas[1:].sum() / areas[0]) if areas[0] > 0 else 0.0

    def nearest(
        self, points: NDArray[np.float64], *, deadline: Deadline = NEVER
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(k,) distance of each point from the faces, and (k, 3) nearest point on them.

        Parameters
        ----------
        points : (k, 3) array of float
        deadline : Deadline
        """
        distances, nearest, _ = self.nearest_faces(points, deadline=deadline)
        return distances, nearest

    def nearest_faces(
        self, points: NDArray[np.float64], *, deadline: Deadline = NEVER
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """(k,) distance of each point from the faces, (k, 3) nearest point on them, and (k,) the face of that.

        Where a point is not finite, the distance is infinite, and the face is any.

        Parameters
        ----------
        points : (k, 3) array of float
        deadline : Deadline
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        distances, nearest, rows = in_slices(
            lambda some: nearest_points(self.corners, self.bounds, some), points, deadline=deadline
        )
        return distances, nearest, self.order[rows]

    def winding_numbers(self, points: NDArray[np.float64], *, deadline: Deadline = NEVER) -> NDArray[np.int64]:
        """(k,) winding number of the faces around each point; they must be closed and consistently oriented.

        Counted along a ray: the faces through which it leaves minus those through which it enters. An edge that the ray
        meets is counted for one of its two faces: Haines 1994, "Point in polygon strategies", Graphics Gems IV,
        pages 24 to 46.

        Parameters
        ----------
        points : (k, 3) array of float
        deadline : Deadline
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        (numbers,) = in_slices(
            lambda some: (winding_numbers(self.corners, self.bounds, some),), points, deadline=deadline
        )
        return numbers

    def first_hits(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64], *, deadline: Deadline = NEVER
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """(k,) first face that each ray hits, or -1, and (k,) its distance in lengths of the direction, or infinity.

        Möller, Trumbore 1997, "Fast, minimum storage ray/triangle intersection",
        https://doi.org/10.1080/10867651.1997.10487468.

        Parameters
        ----------
        origins, directions : (k, 3) array of float
            Directions of any length.
        deadline : Deadline
        """
        rays = (np.ascontiguousarray(each, dtype=np.float64) for each in (origins, directions))
        faces, distances = in_slices(
            lambda *some: first_hits(self.corners, self.order, self.bounds, *some), *rays, deadline=deadline
        )
        return faces, distances

    def overlapping_faces(
        self, low: NDArray[np.float64], high: NDArray[np.float64]
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """Generate pairs of a given box and a face whose bounding box overlaps it, in blocks of bounded size.

        The boxes come in their order: those before the last of a block are complete. Boxes that touch overlap.

        Parameters
        ----------
        low, high : (k, 3) array of float
            Lowest and highest corner of each box.

        Yields
        ------
        box, face : (j,) array of int
        """
        first_leaf = len(self.bounds) // 2
        stack = [(np.arange(len(low)), np.ones(len(low), dtype=np.int64))]  # each entry is of one level of the tree
        while stack:
            box, node = stack.pop()
            if len(box) > BLOCK_SIZE:
                stack.append((box[BLOCK_SIZE:], node[BLOCK_SIZE:]))
                box, node = box[:BLOCK_SIZE], node[:BLOCK_SIZE]
            x, y, z = ((low[box] <= self.bounds[node, 3:]) & (self.bounds[node, :3] <= high[box])).T
            is_met = x & y & z
            box, node = box[is_met], node[is_met]
            if not len(box):
                continue
            if node[0] < first_leaf:
                stack.append((np.repeat(box, 2), np.repeat(2 * node, 2) + np.tile([0, 1], len(node))))
                continue
            row = ((node - first_leaf)[:, None] * LEAF_SIZE + np.arange(LEAF_SIZE)).ravel()
            box, row = np.repeat(box, LEAF_SIZE)[row < len(self.order)], row[row < len(self.order)]
            A, B, C = self.corners[row].reshape(-1, 3, 3).transpose(1, 0, 2)
            lowest, highest = np.minimum(np.minimum(A, B), C), np.maximum(np.maximum(A, B), C)
            x, y, z = ((low[box] <= highest) & (lowest <= high[box])).T
            is_met = x & y & z
            yield box[is_met], self.order[row[is_met]]


def build_aabb_tree(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> AABBTree:
    """Build the tree of a set of triangles.

    Parameters
    ----------
    vertices : (n, 3) array of float
    faces : (m, 3) array of int
    """
    order = spatial_order(vertices, faces)
    is_used = np.bincount(faces.ravel(), minlength=len(vertices)) > 0
    margin = BOX_MARGIN * float(np.abs(vertices[is_used]).max())
    return AABBTree(order, *bounding_boxes(vertices, faces, order, margin))
