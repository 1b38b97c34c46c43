"""The layout of a picture: positions of its panels, and the scale at which shapes are drawn in them, in pixels."""

from __future__ import annotations

__all__ = ["Frame", "Layout", "arrange"]

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError, counted

# All values of this module are choices of style, made by eye.
LONGER_SIDE = {
    True: 900,
    False: 640,
}  # default longer side of a drawing in pixels: of a single panel, of one of several
MIN_SIDE = 20  # smallest side of a drawing in pixels; a smaller one is refused
MAX_ASPECT_RATIO = 2.0  # of a drawing; a longer or taller shape is drawn with margins
ASPECT_RATIO = 1.6  # preferred width over height of a picture of several panels
TEXT_WIDTH = 50  # width of a panel in font sizes, so that the counts below it fit
FONT_SIZE_RANGE = (6, 22)  # bounds on the font size, in pixels


@dataclass(frozen=True, eq=False)
class Frame:
    """The map from projected coordinates to pixels of a drawing.

    Parameters
    ----------
    width, height : int
        Size of the drawing in pixels.
    scale : float
        Pixels per unit of length.
    center : (2,) array of float
        Projected point shown in the middle of the drawing, in the caller's units.
    """

    width: int
    height: int
    scale: float
    center: NDArray[np.float64]

    def pixels(self, projected: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert to (n, 3) pixels (right, up, towards the viewer) from the lower left corner.

        Parameters
        ----------
        projected : (n, 3) array of float
            From :meth:`lbskel.visualization.camera.View.project`.
        """
        offset = [self.width / 2, self.height / 2, 0.0]
        positions: NDArray[np.float64] = (projected - [*self.center, 0.0]) * self.scale + offset
        return positions

    def image_coordinates(self, projected: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert to (n, 3) pixels (column, row, depth towards the viewer), with rows counted from the top."""
        return self.pixels(projected) * [1, -1, 1] + [0, self.height, 0]


@dataclass(frozen=True)
class Layout:
    """A grid of panels, each with a title above its drawing and counts and color bars below it.

    Parameters
    ----------
    width, height : int
        Size of the picture in pixels.
    columns : int
        Number of panels in a row.
    font_size : float
        In pixels.
    above, below : tuple of int
        Height of the text above and below the drawings of each row, in pixels.
    """

    width: int
    height: int
    columns: int
    font_size: float
    above: tuple[int, ...]
    below: tuple[int, ...]

    @property
    def drawing(self) -> tuple[int, int]:
        """Width and height of the drawing in each panel, in pixels."""
        height = (self.height - sum(self.above) - sum(self.below)) // len(self.above)
        return self.width // self.columns, height

    def corner(self, panel: int) -> tuple[int, int]:
        """Compute the lower left corner of a panel's drawing, in pixels from the lower left corner of the picture."""
        width, height = self.drawing
        row, column = divmod(panel, self.columns)
        from_top = (row + 1) * height + sum(self.above[: row + 1]) + sum(self.below[:row])
        return column * width, self.height - from_top

    def frame(self, low: NDArray[np.float64], high: NDArray[np.float64]) -> Frame:
        """Fit a rectangle of projected coordinates into a drawing, with a margin of one font size.

        Parameters
        ----------
        low, high : (2,) array of float
            Lower left and upper right corner, in the caller's units.
        """
        width, height = self.drawing
        sides = np.maximum(np.array([width, height]) - 2 * self.font_size, 1.0)
        extent = high - low
        scale = (sides[extent > 0] / extent[extent > 0]).min(initial=np.inf)
        return Frame(width, height, float(scale) if np.isfinite(scale) else 1.0, (low + high) / 2)


def arrange(extent: NDArray[np.float64], lines: Sequence[tuple[float, float]], size: tuple[int, int] | None) -> Layout:
    """Lay panels out in the number of columns for which the picture's aspect ratio is closest to the one wanted.

    Parameters
    ----------
    extent : (2,) array of float
        Width and height of the projected shape, in the caller's units.
    lines : sequence of pairs of float
        For each panel the height of the text above and below its drawing, in font sizes.
    size : pair of int, optional
        Width and height of the picture in pixels; by default it follows the shape.

    Raises
    ------
    FormatError
        If a drawing would have a side below MIN_SIDE.
    """
    n = len(lines)
    if size is not None and min(size) < MIN_SIDE:
        raise _too_small(n, size)
    shorter = extent.max() / MAX_ASPECT_RATIO if extent.any() else 1.0
    drawing = np.maximum(extent, shorter) / max(extent.max(), shorter) * LONGER_SIDE[n == 1]
    wanted = size[0] / size[1] if size else ASPECT_RATIO
    choices = np.arange(1, n + 1)
    columns = int(choices[np.abs(np.log(choices * drawing[0] / (-(-n // choices) * drawing[1] * wanted))).argmin()])
    rows = [lines[i : i + columns] for i in range(0, n, columns)]
    width, height = (size[0] // columns, size[1] // len(rows)) if size else drawing.round().astype(int).tolist()
    font_size = float(np.clip(min(width, height * 2) / TEXT_WIDTH, *FONT_SIZE_RANGE))
    above, below = (tuple(round(max(panel[i] for panel in row) * font_size) for row in rows) for i in (0, 1))
    width, height = size or (width * columns, height * len(rows) + sum(above) + sum(below))
    layout = Layout(width, height, columns, font_size, above, below)
    if min(layout.drawing) < MIN_SIDE:
        raise _too_small(n, (width, height))
    return layout


def _too_small(n: int, size: tuple[int, int]) -> FormatError:
    return FormatError(f"{counted(n, 'panel')} cannot fit into {size[0]} x {size[1]} pixels; make the picture larger")
