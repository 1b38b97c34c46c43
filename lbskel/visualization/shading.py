"""The color of each pixel of a surface or a point cloud: soft light from the upper left, darker towards the rim.

What is seen where comes from :mod:`lbskel.visualization.rasterizer`; here normals (and a scalar field, if there is one) are
interpolated over the triangle seen at each pixel and lit; where the depth jumps a line is drawn, and 2 x 2 samples are
averaged into each pixel of the picture, which smooths all outlines.
"""

from __future__ import annotations

__all__ = ["Paint", "shade_mesh", "shade_points"]

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from lbskel.visualization.rasterizer import nearest_discs, nearest_triangles

Paint: TypeAlias = Callable[[NDArray], NDArray]
Shader: TypeAlias = Callable[[NDArray, NDArray, NDArray], NDArray]  # item, x and y of samples to their colors

SAMPLES = 2  # per pixel and direction
BASE = np.array([0.66, 0.73, 0.83], dtype=np.float32)
LIGHT = np.array([-0.40, 0.58, 0.71], dtype=np.float32)  # unit vectors: to the light,
HALFWAY = np.array([-0.22, 0.31, 0.925], dtype=np.float32)  # and halfway from there to the viewer
CREASE = np.cos(np.radians(30))  # a smooth normal farther than this from that of the face is not used for the face
SLIVER = 1e-6  # pixels: a smaller face has no direction of its own but that of its neighbors
JUMP = 0.02  # of the picture's longer side: a step in depth that is drawn as a line
DARKNESS = 0.45  # of that line
HAZE = 0.5  # share of white in the farthest point of a cloud


def shade_mesh(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    width: int,
    height: int,
    *,
    field: NDArray[np.float64] | None = None,
    paint: Paint | None = None,
) -> NDArray[np.float32]:
    """Draw a surface.

    Parameters
    ----------
    points : (n, 3) array of float
        Vertices as (column, row, depth towards the viewer), in pixels.
    faces : (m, 3) array of int
    width, height : int
        Of the picture.
    field : (n,) array of float, optional
        A number for each vertex, to be shown by color.
    paint : callable, optional
        From an array of such numbers to their colors, (..., 3).

    Returns
    -------
    (height, width, 4) array of float
        Red, green, blue and opacity in [0, 1].
    """
    triangles = points[faces] * SAMPLES
    corners = triangles[:, :, :2].astype(np.float32)
    corner_normals = _corner_normals(triangles, points, faces)

    def color_at(item: NDArray, x: NDArray, y: NDArray) -> NDArray[np.float32]:
        weights = _barycentric(corners, item, x, y)
        normals = np.einsum("pi,pij->pj", weights, corner_normals[item])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-6)
        if field is None or paint is None:
            return _lit(BASE, normals)
        return _lit(paint(np.einsum("pi,pi->p", weights, field[faces[item]])), normals)

    item, depth = nearest_triangles(triangles, width * SAMPLES, height * SAMPLES)
    return _picture(item, _outline(item, depth), color_at)


def shade_points(points: NDArray[np.float64], radius: float, width: int, height: int) -> NDArray[np.float32]:
    """Draw points as small balls of that radius in pixels; else as shade_mesh."""
    centers, reach = points * SAMPLES, radius * SAMPLES
    depth = points[:, 2]
    far = ((depth.max() - depth) / max(np.ptp(depth), 1e-9)).astype(np.float32)

    def color_at(item: NDArray, x: NDArray, y: NDArray) -> NDArray[np.float32]:
        across, down = np.clip((np.stack([x, y]) - centers[item, :2].T) / reach, -1, 1)
        towards = np.sqrt(np.maximum(1 - across**2 - down**2, 0))
        lit = _lit(BASE, np.stack([across, -down, towards], axis=1).astype(np.float32))
        return 1 - (1 - lit) * (1 - HAZE * far[item])[:, None]

    item, _ = nearest_discs(centers, reach, width * SAMPLES, height * SAMPLES)
    return _picture(item, np.zeros(item.shape, dtype=np.float32), color_at)


def _barycentric(corners: NDArray, item: NDArray, x: NDArray, y: NDArray) -> NDArray[np.float32]:
    """(p, 3) weights of the corners of a triangle at a point, none negative; equal where it is seen edge-on."""
    (ax, ay), (bx, by), (cx, cy) = corners[item].transpose(1, 2, 0) - np.stack([x, y]).astype(np.float32)
    weights = np.stack([bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx], axis=1)
    weights = np.maximum(weights * np.sign(weights.sum(axis=1, keepdims=True)), 0)
    total = weights.sum(axis=1, keepdims=True)
    return np.where(total > 1e-6, weights / np.maximum(total, 1e-6), np.float32(1 / 3))


def _corner_normals(triangles: NDArray, points: NDArray, faces: NDArray) -> NDArray[np.float32]:
    """(m, 3, 3) unit normals at the corners of each triangle, on the viewer's side, y up, smooth but for creases."""
    A, B, C = triangles.transpose(1, 0, 2)
    N = np.cross(B - A, C - A) * [1, -1, 1]  # rows grow downwards
    doubled_area = np.linalg.norm(N, axis=1)
    flat = doubled_area < SLIVER  # its direction is rounding error
    N = np.where(flat[:, None], 0.0, N / np.maximum(doubled_area, SLIVER)[:, None])
    # Weighted by the angle at the corner, they do not depend on how a flat side is cut into triangles.
    dots = [np.einsum("ij,ij->i", P - Q, R - Q) for P, Q, R in ((B, A, C), (C, B, A), (A, C, B))]
    angles = np.arctan2(doubled_area[:, None], np.stack(dots, axis=1))
    shares = (angles[:, :, None] * N[:, None]).reshape(-1, 3)
    per_vertex = np.stack([np.bincount(faces.ravel(), part, minlength=len(points)) for part in shares.T], axis=1)
    lengths = np.linalg.norm(per_vertex, axis=1, keepdims=True)
    N, corners = N.astype(np.float32), (per_vertex / np.maximum(lengths, 1e-30)).astype(np.float32)[faces]
    smooth = (np.einsum("fij,fj->fi", corners, N) > CREASE) | flat[:, None]
    towards = np.where(flat, corners[:, :, 2].sum(axis=1), N[:, 2])
    corners = np.where(smooth[:, :, None], corners, N[:, None])
    return corners * np.where(towards < 0, -1, 1).astype(np.float32)[:, None, None]


def _lit(colors: NDArray, normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """Colors under the light."""
    diffuse = 0.5 + 0.5 * (normals @ LIGHT)  # wrapped around the shape: no side is black
    rim = (1 - np.clip(normals[:, 2], 0, 1)) ** 3
    brightness = 0.55 + 0.55 * diffuse**1.5 - 0.30 * rim
    highlight = 0.12 * np.clip(normals @ HALFWAY, 0, 1) ** 30
    return np.clip(colors * brightness[:, None] + highlight[:, None], 0, 1).astype(np.float32)


def _outline(item: NDArray[np.int64], depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """How much of a line, 0 to 1, there is at each sample: around the shape, and behind whatever lies before it."""
    jump = maximum_filter(np.where(item >= 0, depth, np.float32(np.inf)), 3) - depth
    return np.clip(jump / (JUMP * max(depth.shape)) - 0.5, 0, 1)


def _picture(item: NDArray[np.int64], line: NDArray[np.float32], color_at: Shader) -> NDArray[np.float32]:
    """The picture of the samples; a pixel that is covered and has no line in it is shaded once."""
    samples = [(slice(i, None, SAMPLES), slice(j, None, SAMPLES)) for i in range(SAMPLES) for j in range(SAMPLES)]
    plain = np.logical_and.reduce([(item[s] >= 0) & (line[s] == 0) for s in samples])
    picture = np.zeros((*plain.shape, 4), dtype=np.float32)
    rows, columns = np.nonzero(plain)
    center = SAMPLES / 2
    picture[rows, columns, :3] = color_at(item[samples[0]][plain], columns * SAMPLES + center, rows * SAMPLES + center)
    picture[rows, columns, 3] = 1
    for down, across in samples:
        mixed = ~plain & (item[down, across] >= 0)
        rows, columns = np.nonzero(mixed)
        x, y = columns * SAMPLES + across.start + 0.5, rows * SAMPLES + down.start + 0.5
        colors = color_at(item[down, across][mixed], x, y) * (1 - DARKNESS * line[down, across][mixed])[:, None]
        picture[rows, columns, :3] += colors
        picture[rows, columns, 3] += 1
    mixed = ~plain & (picture[..., 3] > 0)
    picture[mixed, :3] /= picture[mixed, 3:]
    picture[mixed, 3] /= len(samples)
    return picture
