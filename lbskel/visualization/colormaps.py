"""Which number has which color: radii on a skeleton, scalar fields on a surface.

Perceptually uniform maps (plasma, viridis), of which the palest part is left out because it would be lost on white;
for a field with both signs a map with a neutral middle at zero.
"""

from __future__ import annotations

__all__ = ["Scale", "field_scales", "radius_scale"]

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

UNKNOWN = "0.75"  # the gray of NaN
OUTLIERS = 5.0  # per cent of a field at each end that may lie beyond its colors: curvature has a few huge values


@dataclass(frozen=True)
class Scale:
    """A range of numbers with a color map.

    Parameters
    ----------
    low, high : float
        Numbers with the first and last color.
    name : str
        A matplotlib color map.
    diameter_bound : float
        The part of it that is used, from its start.
    beyond : str
        Where numbers lie outside the range: ``neither``, ``min``, ``max`` or ``both``.
    """

    low: float
    high: float
    name: str
    diameter_bound: float = 1.0
    beyond: str = "neither"

    def mappable(self) -> Any:
        """The scale as matplotlib has it."""
        from matplotlib import colormaps
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import ListedColormap, Normalize

        listed = ListedColormap(colormaps[self.name](np.linspace(0, self.diameter_bound, 256)))
        return ScalarMappable(Normalize(self.low, self.high), listed.with_extremes(bad=UNKNOWN))

    def colors(self, values: ArrayLike) -> NDArray[np.float32]:
        """(n, 3) red, green and blue in [0, 1] of n numbers."""
        return self.mappable().to_rgba(np.asarray(values, dtype=np.float64))[:, :3].astype(np.float32)


def radius_scale(radii: Iterable[NDArray[np.float64]]) -> Scale | None:
    """One scale for the radii of all skeletons of a picture; None if no radius is known."""
    together = np.concatenate([np.empty(0), *radii])
    together = together[np.isfinite(together)]
    return Scale(*_apart(together.min(), together.max()), "plasma", 0.88) if len(together) else None


def field_scales(fields: Sequence[tuple[str, NDArray[np.float64]]]) -> dict[str, Scale]:
    """One scale for all fields of one name."""
    return {name: _field_scale(np.concatenate([f for n, f in fields if n == name])) for name, _ in fields}


def _field_scale(values: NDArray[np.float64]) -> Scale:
    """The range of all but the outliers; symmetric around zero where the field has both signs."""
    values = values[np.isfinite(values)] if np.isfinite(values).any() else np.zeros(1)
    low, high = np.percentile(values, [OUTLIERS, 100 - OUTLIERS])
    signed = low < 0 < high
    low, high = _apart(*((-max(-low, high), max(-low, high)) if signed else (low, high)))
    beyond = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    outside = beyond[bool(values.min() < low), bool(values.max() > high)]
    return Scale(low, high, "RdBu_r" if signed else "viridis", 1.0, outside)


def _apart(low: float, high: float) -> tuple[float, float]:
    """The range itself, or one around the only number in it."""
    if high > low:
        return float(low), float(high)
    around = abs(low) / 2 or 0.5
    return float(low - around), float(high + around)
