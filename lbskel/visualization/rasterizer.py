"""Which triangle or disc is seen at each pixel: a depth buffer in numpy, no OpenGL.

Every triangle is cut into the spans of pixels that it covers, row by row; each covered pixel is a fragment, one integer
with the depth in its upper half and the number of its triangle in the lower, so that the largest integer at a pixel
is what is seen there. Triangles thinner than a pixel would fall between the pixel centers, so they are drawn as the
line that they are: a shape contracted to curves stays visible.
"""

from __future__ import annotations

__all__ = ["nearest_discs", "nearest_triangles"]

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Seen: TypeAlias = tuple[NDArray[np.int64], NDArray[np.float32]]

ROWS_AT_A_TIME = 50_000  # rows of triangles cut at a time: bounds the memory, and stays in the processor's cache
DEPTH_LEVELS = 2**30


def nearest_triangles(triangles: NDArray[np.float64], width: int, height: int) -> Seen:
    """For each pixel the triangle seen there.

    Parameters
    ----------
    triangles : (m, 3, 3) array of float
        Corners as (column, row, depth towards the viewer), in pixels; pixel (0, 0) has its center at (0.5, 0.5).
    width, height : int
        Of the image.

    Returns
    -------
    item : (height, width) array of int
        Number of the triangle, -1 where there is none.
    depth : (height, width) array of float
        Its depth there, -inf where there is none.
    """
    depth = triangles[:, :, 2]
    buffer = _Buffer(width, height, depth.min(initial=np.inf), depth.max(initial=-np.inf))
    for fragments in _spans(triangles, width, height):
        buffer.add(*fragments)
    buffer.add(*_thin(triangles))
    return buffer.seen()


def nearest_discs(centers: NDArray[np.float64], radius: float, width: int, height: int) -> Seen:
    """For each pixel the point whose ball of that radius is seen there; else as nearest_triangles."""
    offsets = np.arange(-np.ceil(radius), np.ceil(radius) + 1)
    across, down = (grid.ravel() for grid in np.meshgrid(offsets, offsets))
    bulge = radius**2 - across**2 - down**2
    across, down, bulge = across[bulge >= 0], down[bulge >= 0], np.sqrt(bulge[bulge >= 0])
    buffer = _Buffer(width, height, centers[:, 2].min(), centers[:, 2].max() + radius)
    columns, rows = np.floor(centers[:, :2].T)
    for column, row, higher in zip(across, down, bulge, strict=True):
        buffer.add(np.arange(len(centers)), columns + column, rows + row, centers[:, 2] + higher)
    return buffer.seen()


class _Buffer:
    """The nearest fragment of each pixel so far."""

    def __init__(self, width: int, height: int, farthest: float, nearest: float):
        self.width, self.height = width, height
        self.farthest, self.levels_per_unit = farthest, DEPTH_LEVELS / max(nearest - farthest, 1e-9)
        self.keys = np.full(width * height, -1, dtype=np.int64)

    def add(self, items: NDArray, columns: NDArray, rows: NDArray, depths: NDArray) -> None:
        """Take fragments: numbers of items with the pixels and depths at which they are."""
        columns, rows = columns.astype(np.int64, copy=False), rows.astype(np.int64, copy=False)
        inside = (columns >= 0) & (columns < self.width) & (rows >= 0) & (rows < self.height)
        if not inside.all():
            items, columns, rows, depths = items[inside], columns[inside], rows[inside], depths[inside]
        levels = ((depths - self.farthest) * self.levels_per_unit).astype(np.int64)
        np.maximum.at(self.keys, rows * self.width + columns, (levels << 32) | items)

    def seen(self) -> Seen:
        """The item and the depth at each pixel."""
        hit = self.keys >= 0
        depth = ((self.keys >> 32) / self.levels_per_unit + self.farthest).astype(np.float32)
        item = np.where(hit, self.keys & 0xFFFFFFFF, -1)
        size = (self.height, self.width)
        return item.reshape(size), np.where(hit, depth, np.float32(-np.inf)).reshape(size)


def _spans(triangles: NDArray[np.float64], width: int, height: int) -> Iterator[tuple[NDArray, ...]]:
    """The fragments of the triangles: their numbers, columns, rows and depths, some rows at a time."""
    farthest, nearest = triangles[:, :, 2].min(axis=1), triangles[:, :, 2].max(axis=1)
    to_right, down = _depth_slopes(triangles)
    x, y, z = triangles[:, 0].T
    at_corner = z - to_right * (x - 0.5) - down * (y - 0.5)  # depth at the center of pixel (0, 0)
    x, y = np.take_along_axis(triangles[:, :, :2], triangles[:, :, 1:2].argsort(axis=1, kind="stable"), axis=1).T
    long_side, upper, lower = (_line(x[i], y[i], x[j], y[j]) for i, j in ((0, 2), (0, 1), (1, 2)))
    first, last = (np.clip(np.ceil(end - 0.5), 0, height).astype(np.int64) for end in (y[0], y[2]))
    ends = np.cumsum(last - first)
    cuts = np.searchsorted(ends, np.arange(ROWS_AT_A_TIME, ends[-1], ROWS_AT_A_TIME))
    for chunk in np.split(np.arange(len(triangles)), cuts):
        owner, row = _expand(first[chunk], last[chunk])
        owner, level = chunk[owner], row + 0.5
        one = long_side[0][owner] + long_side[1][owner] * level
        short = np.where(level < y[1][owner], upper[:, owner], lower[:, owner])
        other = short[0] + short[1] * level
        start = np.clip(np.ceil(np.minimum(one, other) - 0.5), 0, width).astype(np.int64)
        end = np.clip(np.ceil(np.maximum(one, other) - 0.5), 0, width).astype(np.int64)
        span, column = _expand(start, end)
        item, row = owner[span], row[span]
        depth = at_corner[item] + to_right[item] * column + down[item] * row
        yield item, column, row, np.clip(depth, farthest[item], nearest[item])


def _line(x0: NDArray, y0: NDArray, x1: NDArray, y1: NDArray) -> NDArray[np.float64]:
    """(2, m) a and b of the lines x = a + b y through two points, y1 >= y0; no row of pixels meets the flat ones."""
    slope = (x1 - x0) / np.maximum(y1 - y0, 1e-6)
    return np.stack([x0 - slope * y0, slope])


def _expand(first: NDArray[np.int64], last: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """All integers of the ranges [first, last), one after another, each with the number of its range."""
    counts = np.maximum(last - first, 0)
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) + np.repeat(first - np.cumsum(counts) + counts, counts)


def _depth_slopes(triangles: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, m) change of each triangle's depth per pixel to the right and down; 0 for a triangle seen edge-on."""
    (ax, ay, az), (bx, by, bz) = (triangles[:, 1:] - triangles[:, :1]).transpose(1, 2, 0)
    area = ax * by - ay * bx
    safe = np.where(area == 0, np.inf, area)
    return np.stack([(az * by - bz * ay) / safe, (ax * bz - bx * az) / safe])


def _thin(triangles: NDArray[np.float64]) -> tuple[NDArray, ...]:
    """Fragments along the longest side of each triangle that is thinner than a pixel, two pixels wide."""
    sides = np.roll(triangles, -1, axis=1) - triangles
    lengths = np.linalg.norm(sides[:, :, :2], axis=2)
    area = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    longest = lengths.argmax(axis=1)
    thin = np.flatnonzero(area <= lengths.max(axis=1))
    start, side = triangles[thin, longest[thin]], sides[thin, longest[thin]]
    steps = np.ceil(lengths[thin, longest[thin]]).astype(np.int64) + 1
    owner, step = _expand(np.zeros_like(steps), steps)
    x, y, z = (start[owner] + side[owner] * (step / np.maximum(steps - 1, 1)[owner])[:, None]).T
    x, y = (np.concatenate([p + q for q in offsets]) for p, offsets in ((x, (0, 1, 0, 1)), (y, (0, 0, 1, 1))))
    return np.tile(thin[owner], 4), np.floor(x - 0.5), np.floor(y - 0.5), np.tile(z, 4)
