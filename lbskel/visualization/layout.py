"""Where the panels of a picture go, and how large a shape is drawn in them: arithmetic in pixels, nothing drawn."""

from __future__ import annotations

__all__ = ["Frame", "Layout", "arrange"]

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError

LONGER_SIDE = {True: 900, False: 640}  # of a drawing, in pixels: of the only panel, of one of several
SMALLEST = 20  # side of a drawing, in pixels
MOST_OBLONG = 2.0  # a longer or taller shape is drawn with white beside it
PICTURE = 1.6  # width over height that a picture of several panels tends to
LETTERS = 50  # width of the text under a panel, in heights of a letter


@dataclass(frozen=True, eq=False)
class Frame:
    """How projected coordinates become pixels of a drawing."""

    width: int
    height: int
    scale: float
    middle: NDArray[np.float64]

    def pixels(self, projected: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 3) pixels to the right and up from the lower left corner, and towards the viewer."""
        return (projected - [*self.middle, 0.0]) * self.scale + [self.width / 2, self.height / 2, 0.0]

    def rows_down(self, projected: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same with rows counted from the top, as in an image."""
        return self.pixels(projected) * [1, -1, 1] + [0, self.height, 0]


@dataclass(frozen=True)
class Layout:
    """A grid of panels, each with a title above its drawing, counts and color bars below; lengths in pixels."""

    width: int
    height: int
    columns: int
    letter: float
    above: tuple[int, ...]
    below: tuple[int, ...]

    @property
    def drawing(self) -> tuple[int, int]:
        """Width and height of the drawing in each panel."""
        height = (self.height - sum(self.above) - sum(self.below)) // len(self.above)
        return self.width // self.columns, height

    def corner(self, panel: int) -> tuple[int, int]:
        """Lower left corner of the drawing of a panel, from the lower left corner of the picture."""
        width, height = self.drawing
        row, column = divmod(panel, self.columns)
        from_top = (row + 1) * height + sum(self.above[: row + 1]) + sum(self.below[:row])
        return column * width, self.height - from_top

    def frame(self, low: NDArray[np.float64], high: NDArray[np.float64]) -> Frame:
        """The frame in which a rectangle of projected coordinates fills a drawing, less a margin."""
        width, height = self.drawing
        sides = np.maximum(np.array([width, height]) - 2 * self.letter, 1.0)
        extent = high - low
        scale = (sides[extent > 0] / extent[extent > 0]).min(initial=np.inf)
        return Frame(width, height, float(scale) if np.isfinite(scale) else 1.0, (low + high) / 2)


def arrange(extent: NDArray[np.float64], lines: Sequence[tuple[float, float]], size: tuple[int, int] | None) -> Layout:
    """The grid that wastes least.

    Parameters
    ----------
    diameter_bound : (2,) array of float
        Width and height of what is drawn.
    lines : sequence of pairs of float
        For each panel the lines of text above and below its drawing.
    size : pair of int, optional
        Width and height of the picture; by default as the shape needs.

    Raises
    ------
    FormatError
        If the picture is too small to show anything.
    """
    n = len(lines)
    tiny = extent.max() / MOST_OBLONG if extent.any() else 1.0
    drawing = np.maximum(extent, tiny) / max(extent.max(), tiny) * LONGER_SIDE[n == 1]
    wanted = size[0] / size[1] if size else PICTURE
    choices = np.arange(1, n + 1)
    columns = int(choices[np.abs(np.log(choices * drawing[0] / (-(-n // choices) * drawing[1] * wanted))).argmin()])
    rows = [lines[i : i + columns] for i in range(0, n, columns)]
    width, height = (size[0] // columns, size[1] // len(rows)) if size else drawing.round().astype(int).tolist()
    letter = float(np.clip(min(width, height * 2) / LETTERS, 6, 22))
    above, below = (tuple(round(max(panel[i] for panel in row) * letter) for row in rows) for i in (0, 1))
    width, height = size or (width * columns, height * len(rows) + sum(above) + sum(below))
    layout = Layout(width, height, columns, letter, above, below)
    if min(layout.drawing) < SMALLEST:
        raise FormatError(f"{n} panels do not fit into {width} x {height} pixels; make the picture larger")
    return layout
