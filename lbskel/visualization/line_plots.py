"""Line plots of quantities over the steps of several runs, on a logarithmic scale, as PNG."""

from __future__ import annotations

__all__ = ["draw_curves"]

import io
from collections.abc import Mapping, Sequence
from typing import Any

from lbskel.errors import MissingDependency

# Range of the values shown, as ratios to the value at the start; others are drawn at its limits. A choice of style.
MAX_SHOWN, MIN_SHOWN = 1e3, 1e-6


def draw_curves(
    panels: Mapping[str, Mapping[str, Sequence[float | None]]], *, size: tuple[float, float] = (12, 5)
) -> bytes:
    """Draw one plot for each quantity, side by side, and encode them as PNG.

    Parameters
    ----------
    panels : mapping
        From the name of a quantity to a mapping from the name of a run to its values from step 1 on; None is drawn at
        the upper limit.
    size : pair of float
        Width and height in inches, at 110 dots per inch.

    Raises
    ------
    MissingDependency
        If matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingDependency("matplotlib", "view", "drawing curves") from None
    figure = Figure(figsize=size, dpi=110, layout="constrained")
    names = list(dict.fromkeys(name for runs in panels.values() for name in runs))
    for ax, (quantity, runs) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels.items(), strict=True):
        for name, values in runs.items():
            number = names.index(name)
            style: dict[str, Any] = {"color": f"C{number % 10}", "linestyle": ("-", "--", ":")[number // 10 % 3]}
            shown = [MAX_SHOWN if value is None else min(max(value, MIN_SHOWN), MAX_SHOWN) for value in values]
            ax.semilogy(range(1, 1 + len(shown)), shown, marker=".", label=name, **style)
        ax.set_xlabel("step")
        ax.set_ylabel(quantity)
        ax.grid(alpha=0.3)
    handles = {label: line for ax in figure.axes for line, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    figure.legend(list(handles.values()), list(handles), loc="outside right upper", fontsize=8)
    content = io.BytesIO()
    figure.savefig(content, metadata={"Software": None})
    return content.getvalue()
