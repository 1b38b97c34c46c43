"""The direction of view in which limbs hide one another least: the one in which the shape has the largest silhouette.

Directions near the axis of least variance are tried, along which the shape looks broadest on the whole. Where parts of
the shape lie behind one another, as the legs of an animal seen from the side, another direction shows more of it.
"""

from __future__ import annotations

__all__ = ["turned", "unobstructed_view"]

from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from lbskel.geometry.mesh import Mesh
from lbskel.visualization.camera import Drawable, View, principal_view
from lbskel.visualization.cell_merging import merged_by_cells
from lbskel.visualization.rasterizer import rasterize_triangles

# Degrees to the side and from above by which the view is turned, and the growth of the silhouette that is worth it.
# Choices of style: the five meshes of the README grow by 4, 2.5, 0, 0 and 0 % at most.
TURNS, HEIGHTS, MIN_GROWTH = (-25, 25, -40, 40), (0, 20), 1.02
N_PIXELS, MAX_FACES = 128, 4000  # pixels across the diameter bound, and faces drawn: 10 ms for each direction


def unobstructed_view(shape: Drawable) -> View:
    """Choose the view of a mesh with the largest silhouette; of clouds and skeletons, along the axis of least variance.

    Parameters
    ----------
    shape : Mesh, PointCloud or Skeleton
    """
    view = principal_view(shape)
    if not isinstance(shape, Mesh) or not shape.diameter_bound > 0:
        return view
    kept, faces, _ = merged_by_cells(shape.vertices, shape.faces, MAX_FACES)
    triangles = (shape.vertices[kept][faces] - view.center) * (N_PIXELS / shape.diameter_bound)
    views = [turned(view, turn, height) for turn, height in product(TURNS, HEIGHTS)]
    areas = [_silhouette(triangles, each) for each in views]
    best = int(np.argmax(areas))
    return views[best] if areas[best] > MIN_GROWTH * _silhouette(triangles, view) else view


def turned(view: View, turn: float, height: float = 0.0) -> View:
    """Turn a view about its vertical axis, then raise the viewer.

    Parameters
    ----------
    view : View
    turn, height : float
        Degrees.
    """
    axes = view.axes @ Rotation.from_rotvec(np.radians(turn) * view.axes[1]).as_matrix()
    return View(view.center, axes @ Rotation.from_rotvec(np.radians(height) * axes[0]).as_matrix())


def _silhouette(triangles: np.ndarray, view: View) -> int:
    """Count the pixels that triangles around the origin cover."""
    projected = triangles @ view.axes.T * [1, -1, 1] + [N_PIXELS, N_PIXELS, 0]
    item, _ = rasterize_triangles(projected, 2 * N_PIXELS, 2 * N_PIXELS)
    return int((item >= 0).sum())
