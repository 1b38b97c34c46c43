"""Line plots: one plot per quantity, one line per run, values limited to the range shown."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from helpers import png_pixels
from matplotlib.axes import Axes

from lbskel import MissingDependency
from lbskel.visualization.line_plots import MAX_SHOWN, MIN_SHOWN, draw_curves


@pytest.fixture
def drawn(monkeypatch):
    """The x, y and style of every line that is drawn."""
    calls = []
    original = Axes.semilogy

    def semilogy(self, x, y, **style):
        calls.append((list(x), list(y), style))
        return original(self, x, y, **style)

    monkeypatch.setattr(Axes, "semilogy", semilogy)
    return calls


def test_values_are_drawn_from_step_one_on_and_limited_to_the_range(drawn):
    draw_curves({"area": {"run": [1.0, 0.5, 1e-9, 1e9, None]}})
    ((steps, values, style),) = drawn
    assert steps == [1, 2, 3, 4, 5]
    assert values == [1.0, 0.5, MIN_SHOWN, MAX_SHOWN, MAX_SHOWN]
    assert style["label"] == "run"


def test_a_run_has_the_same_style_in_every_plot_and_no_two_runs_share_one(drawn):
    names = [f"run {i}" for i in range(12)]
    draw_curves({"area": {name: [1.0] for name in names}, "box": {name: [2.0] for name in names[::-1]}})
    styles = [
        {style["label"]: (style["color"], style["linestyle"]) for _, _, style in half}
        for half in (drawn[:12], drawn[12:])
    ]
    assert styles[0] == styles[1]
    assert len(set(styles[0].values())) == 12


def test_the_picture_has_the_size_in_inches_times_110():
    image = png_pixels(draw_curves({"area": {"run": [1.0, 0.1]}}, size=(4, 3)))
    assert image.shape == (330, 440, 3)
    assert (image < 128).any()


def test_two_runs_give_the_same_bytes():
    panels = {"area": {"run": [1.0, 0.1], "other": np.array([1.0, 3.0])}}
    assert draw_curves(panels) == draw_curves(panels)
    assert b"Software" not in draw_curves(panels)


def test_without_matplotlib_the_error_names_the_pip_command(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingDependency, match=r"matplotlib.*pip install 'lbskel\[view\]'"):
        draw_curves({"area": {"run": [1.0]}})
