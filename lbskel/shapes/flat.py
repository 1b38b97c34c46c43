"""Flat shapes around known axes: tubes whose sections are ellipses, closed by half ellipsoids.

The axis of an ellipse is its center, however flat it is. The unit of distances to the axis is the radius of the circle
of the same area, which is the geometric mean of the two half axes.
"""

from __future__ import annotations

__all__ = ["elliptic_tube", "leaf", "ribbon", "twisted_ellipse"]

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.preprocess.pymeshlab_adapter import remesh_isotropic
from lbskel.shapes.primitives import join_rings, section_frames
from lbskel.shapes.truth import Shape, Truth

N_SIDES = 48  # of a section before remeshing
N_CAP_RINGS = 12  # of a half ellipsoid before remeshing
EDGE_LENGTH = 0.75  # upper bound on edges, relative to the smallest half axis, as for the shapes of the catalog
MAX_VERTICES = 20_000  # which bounds the time for very flat shapes


def elliptic_tube(
    axis: NDArray[np.float64], half_axes: NDArray[np.float64], twist: float, name: str, n_vertices: int
) -> Shape:
    """Mesh a tube with elliptical sections by nearly equilateral triangles.

    Parameters
    ----------
    axis : (k, 3) array of float
        Densely sampled.
    half_axes : (k, 2) array of float
        Half axes of the ellipse at each point, in the two directions of
        :func:`lbskel.shapes.primitives.section_frames`, in the units of the axis.
    twist : float
        Angle by which the last ellipse is turned relative to the first, in radians.
    name : str
    n_vertices : int
        Approximate number of vertices; exceeded if the smallest half axis needs shorter edges.

    Raises
    ------
    MissingDependency
        If pymeshlab is not installed.
    """
    k = len(axis)
    radii = np.sqrt(half_axes.prod(axis=1))
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1)))
    rise = np.sin(np.linspace(0, np.pi / 2, N_CAP_RINGS + 1)[1:-1])
    first, last = axis[0] - axis[1], axis[-1] - axis[-2]
    first, last = radii[0] * first / np.linalg.norm(first), radii[-1] * last / np.linalg.norm(last)
    P = np.concatenate([axis[0] + rise[::-1, None] * first, axis, axis[-1] + rise[:, None] * last])
    shrink = np.sqrt(1 - rise**2)
    scale = np.concatenate([shrink[::-1], np.ones(k), shrink])
    rows = np.clip(np.arange(len(P)) - len(rise), 0, k - 1)
    angle, around = twist * arc[rows] / arc[-1], 2 * np.pi * np.arange(N_SIDES) / N_SIDES
    turn = np.stack([np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)], axis=1).reshape(-1, 2, 2)
    frames = turn @ section_frames(P)
    circle = np.stack([np.cos(around), np.sin(around)], axis=1)
    sections = circle[None] * (half_axes[rows] * scale[:, None])[:, None, :]
    raw = join_rings((P[:, None] + sections @ frames)[::-1], (axis[-1] + last, axis[0] + first))
    wanted = np.sqrt(2 * raw.area / np.sqrt(3) / np.array([n_vertices, MAX_VERTICES]))
    length = max(min(wanted[0], EDGE_LENGTH * half_axes.min()), wanted[1])
    V, F = remesh_isotropic(raw.vertices, raw.faces, target_length=length, feature_angle=180.0)
    edges = np.stack([np.arange(k - 1), np.arange(1, k)], axis=1)
    return Shape(Mesh(V, F), Truth(axis, edges, radii), name)


def twisted_ellipse(*, ratio: float = 4.0, twist: float = np.pi, n_vertices: int = 5000) -> Shape:
    """Build a tube of elliptical sections that turn along a bent axis: two tips.

    Parameters
    ----------
    ratio : float
        Ratio of the two half axes.
    twist : float
        Angle by which the last section is turned relative to the first, in radians.
    n_vertices : int
        Approximate number of vertices.
    """
    t = np.linspace(-1.2, 1.2, 97)
    axis = 1.6 * np.stack([np.sin(t), np.zeros(len(t)), np.cos(t)], axis=1)
    half_axes = np.tile(0.2 * np.array([np.sqrt(ratio), 1 / np.sqrt(ratio)]), (len(t), 1))
    return elliptic_tube(axis, half_axes, twist, "twisted ellipse", n_vertices)


def ribbon(*, ratio: float = 10.0, length: float = 4.0, n_vertices: int = 5000) -> Shape:
    """Build a flat, slightly wavy strip: two tips.

    Parameters
    ----------
    ratio : float
        Ratio of the width to the thickness; the width is 1.
    length : float
    n_vertices : int
        Approximate number of vertices.
    """
    x = np.linspace(-length / 2, length / 2, 97)
    axis = np.stack([x, np.zeros(len(x)), 0.15 * np.sin(2 * x)], axis=1)
    return elliptic_tube(axis, np.tile([0.5, 0.5 / ratio], (len(x), 1)), 0.0, "ribbon", n_vertices)


def leaf(*, ratio: float = 6.0, width: float = 0.5, n_vertices: int = 5000) -> Shape:
    """Build a round stalk that widens into a flat blade: two tips.

    Parameters
    ----------
    ratio : float
        Ratio of the blade's width to its thickness, where it is widest.
    width : float
        Half of the largest width of the blade.
    n_vertices : int
        Approximate number of vertices.
    """
    t = np.linspace(0, 1, 129)
    axis = np.stack([2.6 * t, np.zeros(len(t)), 0.3 * t**2], axis=1)
    stalk = width / ratio
    blade = np.where(t > 0.4, np.sin(np.pi * np.clip((t - 0.4) / 0.63, 0, 1)) ** 0.8, 0.0)
    half_axes = np.stack([stalk + (width - stalk) * blade, np.full(len(t), stalk)], axis=1)
    return elliptic_tube(axis, half_axes, 0.0, "leaf", n_vertices)
