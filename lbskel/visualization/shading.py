"""Shading of surfaces and point clouds: soft light from the upper left, darker at silhouettes.

:mod:`lbskel.visualization.rasterizer` finds the triangle visible at each sample. Normals, and a scalar field if there
is one, are interpolated over it, and the color is computed by wrapped diffuse and Blinn-Phong lighting. A line is drawn
at discontinuities of the depth. 2 x 2 samples are averaged into each pixel, which smooths the outlines.
"""

from __future__ import annotations

__all__ = ["FieldColors", "shade_mesh", "shade_points"]

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from lbskel.visualization.rasterizer import rasterize_balls, rasterize_triangles

# From p field values to their (p, 3) colors.
FieldColors: TypeAlias = Callable[[NDArray[Any]], NDArray[np.float32]]
# From item indices, x and y of p samples to their (p, 3) colors.
Shader: TypeAlias = Callable[[NDArray[Any], NDArray[Any], NDArray[Any]], NDArray[np.float32]]

# Samples per pixel in each direction; a guess.
N_SAMPLES = 2
# Colors, light and the numbers of _illuminate() are choices of style, made by eye. Axes: right, up, to the viewer.
BASE_COLOR = np.array([0.66, 0.73, 0.83], dtype=np.float32)
LIGHT = np.array([-0.40, 0.58, 0.71], dtype=np.float32)  # unit vector to the light
HALFWAY = np.array([-0.22, 0.31, 0.925], dtype=np.float32)  # unit vector halfway between the light and the viewer
# Largest angle, 30 degrees, between a vertex normal and a face normal at which the vertex normal is used; a guess.
CREASE_COSINE = np.cos(np.radians(30))
# Twice the area of a face, in squared samples, below which its normal is not reliable and those of its vertices are
# used. A guess.
MIN_DOUBLED_AREA = 1e-6
# Lower bound on lengths and weights that are divided by; a guess, far below a pixel.
EPSILON = 1e-6
# Depth difference drawn as an outline, relative to the image's longer side: it begins at half of this. By eye.
OUTLINE_DEPTH = 0.02
OUTLINE_DARKNESS = 0.45  # opacity of black in an outline; by eye
DEPTH_FADE = 0.5  # opacity of white over the farthest point of a cloud; by eye


def shade_mesh(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    width: int,
    height: int,
    *,
    field: NDArray[np.float64] | None = None,
    colormap: FieldColors | None = None,
) -> NDArray[np.float32]:
    """Draw a surface.

    Parameters
    ----------
    points : (n, 3) array of float
        Vertices as (column, row, depth towards the viewer), in pixels.
    faces : (m, 3) array of int
    width, height : int
        Size of the image.
    field : (n,) array of float, optional
        A number for each vertex, shown by color.
    colormap : callable, optional
        From (p,) numbers to (p, 3) colors in [0, 1]; without it the field is not shown.

    Returns
    -------
    (height, width, 4) array of float
        Red, green, blue and opacity in [0, 1].
    """
    triangles = points[faces] * N_SAMPLES
    corners = triangles[:, :, :2].astype(np.float32)
    corner_normals = _corner_normals(triangles, points, faces)

    def color_at(item: NDArray[Any], x: NDArray[Any], y: NDArray[Any]) -> NDArray[np.float32]:
        weights = _barycentric(corners, item, x, y)
        normals = np.einsum("pi,pij->pj", weights, corner_normals[item])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), EPSILON)
        if field is None or colormap is None:
            return _illuminate(BASE_COLOR, normals)
        return _illuminate(colormap(np.einsum("pi,pi->p", weights, field[faces[item]])), normals)

    item, depth = rasterize_triangles(triangles, width * N_SAMPLES, height * N_SAMPLES)
    return _resolve_samples(item, _outline(item, depth), color_at)


def shade_points(points: NDArray[np.float64], radius: float, width: int, height: int) -> NDArray[np.float32]:
    """Draw points as balls, paler with increasing distance from the viewer.

    Parameters
    ----------
    points : (n, 3) array of float
        As (column, row, depth towards the viewer), in pixels.
    radius : float
        Of the balls, in pixels.
    width, height : int
        Size of the image.

    Returns
    -------
    (height, width, 4) array of float
        Red, green, blue and opacity in [0, 1].
    """
    centers, sample_radius = points * N_SAMPLES, radius * N_SAMPLES
    depth = points[:, 2]
    relative_depth = ((depth.max() - depth) / max(np.ptp(depth), 1e-9)).astype(np.float32)

    def color_at(item: NDArray[Any], x: NDArray[Any], y: NDArray[Any]) -> NDArray[np.float32]:
        across, down = np.clip((np.stack([x, y]) - centers[item, :2].T) / sample_radius, -1, 1)
        to_viewer = np.sqrt(np.maximum(1 - across**2 - down**2, 0))
        colors = _illuminate(BASE_COLOR, np.stack([across, -down, to_viewer], axis=1).astype(np.float32))
        faded: NDArray[np.float32] = 1 - (1 - colors) * (1 - DEPTH_FADE * relative_depth[item])[:, None]
        return faded

    item, _ = rasterize_balls(centers, sample_radius, width * N_SAMPLES, height * N_SAMPLES)
    return _resolve_samples(item, np.zeros(item.shape, dtype=np.float32), color_at)


def _barycentric(corners: NDArray[Any], item: NDArray[Any], x: NDArray[Any], y: NDArray[Any]) -> NDArray[np.float32]:
    """Compute (p, 3) barycentric coordinates, clipped to nonnegative; equal ones if the triangle is seen edge-on."""
    (ax, ay), (bx, by), (cx, cy) = corners[item].transpose(1, 2, 0) - np.stack([x, y]).astype(np.float32)
    weights = np.stack([bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx], axis=1)
    weights = np.maximum(weights * np.sign(weights.sum(axis=1, keepdims=True)), 0)
    total = weights.sum(axis=1, keepdims=True)
    return np.where(total > EPSILON, weights / np.maximum(total, EPSILON), np.float32(1 / 3))


def _corner_normals(triangles: NDArray[Any], points: NDArray[Any], faces: NDArray[Any]) -> NDArray[np.float32]:
    """Compute (m, 3, 3) unit normals at the triangles' corners, facing the viewer, y up, smooth except at creases."""
    A, B, C = triangles.transpose(1, 0, 2)
    N = np.cross(B - A, C - A) * [1, -1, 1]  # rows grow downwards
    doubled_area = np.linalg.norm(N, axis=1)
    flat = doubled_area < MIN_DOUBLED_AREA  # their normals are rounding error
    N = np.where(flat[:, None], 0.0, N / np.maximum(doubled_area, MIN_DOUBLED_AREA)[:, None])
    # Vertex normals weighted by the corner angle do not depend on the triangulation of a flat region.
    dots = [np.einsum("ij,ij->i", P - Q, R - Q) for P, Q, R in ((B, A, C), (C, B, A), (A, C, B))]
    angles = np.arctan2(doubled_area[:, None], np.stack(dots, axis=1))
    weighted = (angles[:, :, None] * N[:, None]).reshape(-1, 3)
    per_vertex = np.stack([np.bincount(faces.ravel(), part, minlength=len(points)) for part in weighted.T], axis=1)
    lengths = np.linalg.norm(per_vertex, axis=1, keepdims=True)
    N, corners = N.astype(np.float32), (per_vertex / np.maximum(lengths, 1e-30)).astype(np.float32)[faces]
    smooth = (np.einsum("fij,fj->fi", corners, N) > CREASE_COSINE) | flat[:, None]
    to_viewer = np.where(flat, corners[:, :, 2].sum(axis=1), N[:, 2])
    corners = np.where(smooth[:, :, None], corners, N[:, None])
    facing: NDArray[np.float32] = corners * np.where(to_viewer < 0, -1, 1).astype(np.float32)[:, None, None]
    return facing


def _illuminate(colors: NDArray[Any], normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """Compute the (p, 3) colors of surfaces with those normals under the light."""
    diffuse = 0.5 + 0.5 * (normals @ LIGHT)  # wrapped diffuse lighting: no side is black
    rim = (1 - np.clip(normals[:, 2], 0, 1)) ** 3
    brightness = 0.55 + 0.55 * diffuse**1.5 - 0.30 * rim
    highlight = 0.12 * np.clip(normals @ HALFWAY, 0, 1) ** 30
    shaded: NDArray[np.float32] = np.clip(colors * brightness[:, None] + highlight[:, None], 0, 1).astype(np.float32)
    return shaded


def _outline(item: NDArray[np.int64], depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Compute the strength of the outline at each sample, 0 to 1: on the far side of discontinuities of the depth."""
    depth_step = maximum_filter(np.where(item >= 0, depth, np.float32(np.inf)), 3) - depth
    strength: NDArray[np.float32] = np.clip(depth_step / (OUTLINE_DEPTH * max(depth.shape)) - 0.5, 0, 1)
    return strength


def _resolve_samples(item: NDArray[np.int64], line: NDArray[np.float32], color_at: Shader) -> NDArray[np.float32]:
    """Shade and average the samples of each pixel; a pixel fully covered and without outline is shaded once."""
    offsets = [slice(i, None, N_SAMPLES) for i in range(N_SAMPLES)]
    samples = [(down, across) for down in offsets for across in offsets]
    plain = np.logical_and.reduce([(item[s] >= 0) & (line[s] == 0) for s in samples])
    picture = np.zeros((*plain.shape, 4), dtype=np.float32)
    rows, columns = np.nonzero(plain)
    center = N_SAMPLES / 2
    x, y = columns * N_SAMPLES + center, rows * N_SAMPLES + center
    picture[rows, columns, :3] = color_at(item[samples[0]][plain], x, y)
    picture[rows, columns, 3] = 1
    for down, across in samples:
        mixed = ~plain & (item[down, across] >= 0)
        rows, columns = np.nonzero(mixed)
        x, y = columns * N_SAMPLES + across.start + 0.5, rows * N_SAMPLES + down.start + 0.5
        colors = color_at(item[down, across][mixed], x, y) * (1 - OUTLINE_DARKNESS * line[down, across][mixed])[:, None]
        picture[rows, columns, :3] += colors
        picture[rows, columns, 3] += 1
    mixed = ~plain & (picture[..., 3] > 0)
    picture[mixed, :3] /= picture[mixed, 3:]
    picture[mixed, 3] /= len(samples)
    return picture
