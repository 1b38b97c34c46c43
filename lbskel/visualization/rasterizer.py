"""Rasterization of triangles and balls with a depth buffer, in numpy without OpenGL.

Every triangle is divided into the spans of pixels that it covers, row by row. Each covered pixel is a fragment, encoded
as one integer with the depth in its upper half and the index of the triangle in its lower half, so that the largest
integer at a pixel is the visible fragment. Triangles thinner than a pixel could fall between pixel centers, so they are
drawn as lines: a shape contracted to curves stays visible.
"""

from __future__ import annotations

__all__ = ["rasterize_balls", "rasterize_triangles"]

from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

# Index of the visible item and its depth, (height, width) each.
Visible: TypeAlias = tuple[NDArray[np.int64], NDArray[np.float32]]
# Item indices, columns, rows and depths, (p,) each.
Fragments: TypeAlias = tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[np.float64]]

# Pixel rows of triangles processed at once; bounds the memory and keeps it in the processor's cache. A guess.
MAX_ROWS_PER_CHUNK = 50_000
# Number of distinct depths: 30 bits, which with the 32 bits of the item index fit into a signed 64-bit integer.
DEPTH_LEVELS = 2**30


def rasterize_triangles(triangles: NDArray[np.float64], width: int, height: int) -> Visible:
    """Find the triangle that is visible at each pixel.

    Parameters
    ----------
    triangles : (m, 3, 3) array of float
        Corners as (column, row, depth towards the viewer), in pixels; pixel (0, 0) has its center at (0.5, 0.5).
    width, height : int
        Size of the image.

    Returns
    -------
    item : (height, width) array of int
        Index of the triangle, -1 for the background.
    depth : (height, width) array of float
        Its depth at the pixel's center, -inf for the background.
    """
    depth = triangles[:, :, 2]
    buffer = _DepthBuffer(width, height, depth.min(initial=np.inf), depth.max(initial=-np.inf))
    for fragments in _triangle_fragments(triangles, width, height):
        buffer.add(*fragments)
    buffer.add(*_thin_triangle_fragments(triangles))
    return buffer.visible()


def rasterize_balls(centers: NDArray[np.float64], radius: float, width: int, height: int) -> Visible:
    """Find the ball that is visible at each pixel.

    Parameters
    ----------
    centers : (n, 3) array of float
        As (column, row, depth towards the viewer), in pixels.
    radius : float
        Of all balls, in pixels.
    width, height : int
        Size of the image.

    Returns
    -------
    item : (height, width) array of int
        Index of the ball, -1 for the background.
    depth : (height, width) array of float
        Depth of its surface at the pixel, -inf for the background.
    """
    offsets = np.arange(-np.ceil(radius), np.ceil(radius) + 1)
    across, down = (grid.ravel() for grid in np.meshgrid(offsets, offsets))
    bulge = radius**2 - across**2 - down**2
    across, down, bulge = across[bulge >= 0], down[bulge >= 0], np.sqrt(bulge[bulge >= 0])
    buffer = _DepthBuffer(width, height, centers[:, 2].min(), centers[:, 2].max() + radius)
    columns, rows = np.floor(centers[:, :2].T)
    for column, row, height_over_center in zip(across, down, bulge, strict=True):
        buffer.add(np.arange(len(centers)), columns + column, rows + row, centers[:, 2] + height_over_center)
    return buffer.visible()


class _DepthBuffer:
    """The nearest fragment of each pixel."""

    def __init__(self, width: int, height: int, farthest: float, nearest: float):
        self.width, self.height = width, height
        self.farthest, self.levels_per_unit = farthest, DEPTH_LEVELS / max(nearest - farthest, 1e-9)
        self.keys = np.full(width * height, -1, dtype=np.int64)

    def add(self, items: NDArray[Any], columns: NDArray[Any], rows: NDArray[Any], depths: NDArray[np.float64]) -> None:
        """Add fragments: indices of items with their pixels and depths; those outside the image are dropped."""
        columns, rows = columns.astype(np.int64, copy=False), rows.astype(np.int64, copy=False)
        inside = (columns >= 0) & (columns < self.width) & (rows >= 0) & (rows < self.height)
        if not inside.all():
            items, columns, rows, depths = items[inside], columns[inside], rows[inside], depths[inside]
        levels = ((depths - self.farthest) * self.levels_per_unit).astype(np.int64)
        np.maximum.at(self.keys, rows * self.width + columns, (levels << 32) | items)

    def visible(self) -> Visible:
        """Decode the visible item and its depth at each pixel."""
        hit = self.keys >= 0
        depth = ((self.keys >> 32) / self.levels_per_unit + self.farthest).astype(np.float32)
        item = np.where(hit, self.keys & 0xFFFFFFFF, -1)
        size = (self.height, self.width)
        return item.reshape(size), np.where(hit, depth, np.float32(-np.inf)).reshape(size)


def _triangle_fragments(triangles: NDArray[np.float64], width: int, height: int) -> Iterator[Fragments]:
    """Generate the fragments of the triangles, chunk by chunk."""
    farthest, nearest = triangles[:, :, 2].min(axis=1), triangles[:, :, 2].max(axis=1)
    to_right, down = _depth_slopes(triangles)
    x, y, z = triangles[:, 0].T
    at_corner = z - to_right * (x - 0.5) - down * (y - 0.5)  # depth at the center of pixel (0, 0)
    x, y = np.take_along_axis(triangles[:, :, :2], triangles[:, :, 1:2].argsort(axis=1, kind="stable"), axis=1).T
    long_side, upper, lower = (_line_through(x[i], y[i], x[j], y[j]) for i, j in ((0, 2), (0, 1), (1, 2)))
    first, last = (np.clip(np.ceil(end - 0.5), 0, height).astype(np.int64) for end in (y[0], y[2]))
    ends = np.cumsum(last - first)
    cuts = np.searchsorted(ends, np.arange(MAX_ROWS_PER_CHUNK, ends[-1], MAX_ROWS_PER_CHUNK))
    for chunk in np.split(np.arange(len(triangles)), cuts):
        owner, row = _expand_ranges(first[chunk], last[chunk])
        owner, level = chunk[owner], row + 0.5
        x_long = long_side[0][owner] + long_side[1][owner] * level
        short = np.where(level < y[1][owner], upper[:, owner], lower[:, owner])
        x_short = short[0] + short[1] * level
        start = np.clip(np.ceil(np.minimum(x_long, x_short) - 0.5), 0, width).astype(np.int64)
        end = np.clip(np.ceil(np.maximum(x_long, x_short) - 0.5), 0, width).astype(np.int64)
        span, column = _expand_ranges(start, end)
        item, row = owner[span], row[span]
        depth = at_corner[item] + to_right[item] * column + down[item] * row
        yield item, column, row, np.clip(depth, farthest[item], nearest[item])


def _line_through(
    x0: NDArray[np.float64], y0: NDArray[np.float64], x1: NDArray[np.float64], y1: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Compute (2, m) a and b of the lines x = a + b y through two points, y1 >= y0; horizontal ones meet no row."""
    slope = (x1 - x0) / np.maximum(y1 - y0, 1e-6)
    return np.stack([x0 - slope * y0, slope])


def _expand_ranges(first: NDArray[np.int64], last: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """List all integers of the ranges [first, last), one range after another, each with the index of its range."""
    counts = np.maximum(last - first, 0)
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) + np.repeat(first - np.cumsum(counts) + counts, counts)


def _depth_slopes(triangles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the (2, m) change of each triangle's depth per pixel to the right and down; 0 if it is seen edge-on."""
    (ax, ay, az), (bx, by, bz) = (triangles[:, 1:] - triangles[:, :1]).transpose(1, 2, 0)
    area = ax * by - ay * bx
    safe = np.where(area == 0, np.inf, area)
    return np.stack([(az * by - bz * ay) / safe, (ax * bz - bx * az) / safe])


def _thin_triangle_fragments(triangles: NDArray[np.float64]) -> Fragments:
    """Generate fragments of two pixels' width along the longest side of each triangle thinner than a pixel."""
    sides = np.roll(triangles, -1, axis=1) - triangles
    lengths = np.linalg.norm(sides[:, :, :2], axis=2)
    area = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    longest = lengths.argmax(axis=1)
    thin = np.flatnonzero(area <= lengths.max(axis=1))  # height over the longest side at most 1 pixel
    start, side = triangles[thin, longest[thin]], sides[thin, longest[thin]]
    steps = np.ceil(lengths[thin, longest[thin]]).astype(np.int64) + 1
    owner, step = _expand_ranges(np.zeros_like(steps), steps)
    x, y, z = (start[owner] + side[owner] * (step / np.maximum(steps - 1, 1)[owner])[:, None]).T
    x, y = (np.concatenate([p + q for q in offsets]) for p, offsets in ((x, (0, 1, 0, 1)), (y, (0, 0, 1, 1))))
    return np.tile(thin[owner], 4), np.floor(x - 0.5), np.floor(y - 0.5), np.tile(z, 4)
