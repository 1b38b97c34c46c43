"""Bodies of voxels, as the segmentation of an image volume has them, around the axes of a shape."""

from __future__ import annotations

__all__ = ["voxel_body"]

import numpy as np

import lbskel
from lbskel.shapes import Shape, solid_of
from lbskel.shapes.isosurface import GRID_OFFSET, marching_cubes

BLEND = 1e-3  # of the tubes where they meet, in their radii: nearly none


def voxel_body(shape: Shape, size: float) -> Shape:
    """Mesh the voxels whose centers are in the round cones around the axes of a shape, by marching cubes.

    The vertices lie in the middle between the centers of two voxels, so that the surface has steps. Parts thinner than
    a voxel are lost, and parts nearer to each other than that touch.

    Parameters
    ----------
    shape : Shape
    size : float
        Of a voxel, in median radii.
    """
    truth = shape.truth
    branches = lbskel.Skeleton(truth.nodes, truth.edges, truth.radii).branches
    solid = solid_of([(truth.nodes[branch], truth.radii[branch]) for branch in branches], blend=BLEND)
    step = size * float(np.median(truth.radii))
    mesh = marching_cubes(solid, step)
    origin = solid.centers.min(axis=0) - 2 * solid.radii.max() - GRID_OFFSET * step
    places = (mesh.vertices - origin) / step  # two of the three coordinates of each are integers
    rows, between = np.arange(len(places)), np.abs(places - np.rint(places)).argmax(axis=1)
    middles = np.rint(places)
    middles[rows, between] = np.floor(places[rows, between]) + 0.5
    return Shape(mesh.with_vertices(origin + step * middles), truth, shape.name)
