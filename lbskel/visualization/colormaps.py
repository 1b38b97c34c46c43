"""Color scales: of radii on a skeleton, of scalar fields on a surface.

Radii use matplotlib's plasma without its palest part, which would not be visible on white. Fields use viridis, or a
diverging map centered at zero if they have both signs.
"""

from __future__ import annotations

__all__ = ["ColorScale", "field_scales", "radius_scale"]

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

NAN_COLOR = "0.75"  # matplotlib's notation of a gray
# Percentage of a field's values at each end that may lie outside the scale, because curvatures have a few huge values.
# A guess.
OUTLIER_PERCENT = 5.0
# Part of plasma that is used, from its dark end; chosen by eye.
PLASMA_FRACTION = 0.88
# matplotlib's words for whether there are numbers below and above a scale
EXTENDS = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
# Percentage of the radii at each end that may lie outside the scale, and the ratio of the extreme radius to the rest
# from which on they do: with the soma of a neuron inside, all its branches would have one color. Choices of style.
RADIUS_OUTLIER_PERCENT, MAX_RADIUS_RATIO = 2.0, 2.0


@dataclass(frozen=True)
class ColorScale:
    """A range of numbers with a color map.

    Parameters
    ----------
    low, high : float
        Numbers with the first and the last color.
    colormap : str
        Name of a matplotlib color map.
    fraction : float
        Fraction of the color map that is used, from its start.
    extend : str
        At which ends of the range numbers lie outside it: ``neither``, ``min``, ``max`` or ``both``.
    """

    low: float
    high: float
    colormap: str
    fraction: float = 1.0
    extend: str = "neither"

    def mappable(self) -> Any:
        """Convert the scale to a matplotlib ScalarMappable."""
        from matplotlib import colormaps
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import ListedColormap, Normalize

        listed = ListedColormap(colormaps[self.colormap](np.linspace(0, self.fraction, 256)))
        return ScalarMappable(Normalize(self.low, self.high), listed.with_extremes(bad=NAN_COLOR))

    def colors(self, values: ArrayLike) -> NDArray[np.float32]:
        """Compute the (n, 3) red, green and blue in [0, 1] of n numbers; gray for NaN."""
        rgb: NDArray[np.float32] = (
            self.mappable().to_rgba(np.asarray(values, dtype=np.float64))[:, :3].astype(np.float32)
        )
        return rgb


def radius_scale(radii: Iterable[NDArray[np.float64]]) -> ColorScale | None:
    """Choose one scale for the radii of all skeletons of a picture; None if no radius is known (finite).

    A few radii that are far smaller or larger than all others lie outside the scale.

    Parameters
    ----------
    radii : iterable of (k,) array of float
        The radii of each skeleton.
    """
    known = np.concatenate([np.empty(0), *radii])
    known = known[np.isfinite(known)]
    if not len(known):
        return None
    low, high = known.min(), known.max()
    lower, upper = np.percentile(known, [RADIUS_OUTLIER_PERCENT, 100 - RADIUS_OUTLIER_PERCENT])
    is_below, is_above = MAX_RADIUS_RATIO * low < lower, high > MAX_RADIUS_RATIO * upper
    limits = _nonempty_range(lower if is_below else low, upper if is_above else high)
    return ColorScale(*limits, "plasma", PLASMA_FRACTION, EXTENDS[bool(is_below), bool(is_above)])


def field_scales(fields: Sequence[tuple[str, NDArray[np.float64]]]) -> dict[str, ColorScale]:
    """Choose one scale for all fields of the same name.

    Parameters
    ----------
    fields : sequence of (str, (n,) array of float)
        Pairs of a name and values.
    """
    return {name: _field_scale(np.concatenate([f for n, f in fields if n == name])) for name, _ in fields}


def _field_scale(values: NDArray[np.float64]) -> ColorScale:
    """Choose the range of all values but the outliers; symmetric around zero if it contains both signs."""
    values = values[np.isfinite(values)] if np.isfinite(values).any() else np.zeros(1)
    low, high = np.percentile(values, [OUTLIER_PERCENT, 100 - OUTLIER_PERCENT])
    signed = low < 0 < high
    low, high = _nonempty_range(*((-max(-low, high), max(-low, high)) if signed else (low, high)))
    extend = EXTENDS[bool(values.min() < low), bool(values.max() > high)]
    return ColorScale(low, high, "RdBu_r" if signed else "viridis", 1.0, extend)


def _nonempty_range(low: float, high: float) -> tuple[float, float]:
    """Widen a range that consists of one number."""
    if high > low:
        return float(low), float(high)
    margin = abs(low) / 2 or 0.5
    return float(low - margin), float(high + margin)
