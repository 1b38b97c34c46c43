"""The picture of the first view: transparent around the shape, small, and none without matplotlib."""

import io
from importlib.util import find_spec

import numpy as np
import pytest
from helpers import flat_tube, planar_fork
from PIL import Image

from lbskel import PointCloud, Skeleton
from lbskel.shapes import torus
from lbskel.visualization.panel import Panel
from lbskel.visualization.poster import LONGER_SIDE, poster


@pytest.mark.parametrize(
    "panel",
    [Panel(flat_tube(), planar_fork()), Panel(PointCloud(flat_tube().vertices)), Panel(skeleton=planar_fork())],
    ids=["both", "cloud", "skeleton"],
)
def test_the_shape_fills_the_picture(panel):
    png = poster(panel)
    with Image.open(io.BytesIO(png)) as image:
        opacity = np.asarray(image.convert("RGBA"))[..., 3]
    assert max(opacity.shape) in (LONGER_SIDE, LONGER_SIDE + 1)
    filled = (opacity > 0).any(axis=0)
    assert filled[[0, -1]].all()  # from side to side
    assert len(png) < 100_000
    assert png == poster(panel)


def test_the_ground_is_transparent():
    with Image.open(io.BytesIO(poster(Panel(torus(1.0, 0.2))))) as image:
        opacity = np.asarray(image.convert("RGBA"))[..., 3]
    middle, corner = len(opacity) // 2, 2
    assert opacity[middle, middle] == opacity[corner, corner] == 0
    assert (opacity == 255).mean() > 0.3


def test_a_single_point_has_a_picture():
    assert poster(Panel(skeleton=Skeleton([[0.0, 0, 0]], np.empty((0, 2), int), [1.0])))[1:4] == b"PNG"


def test_without_matplotlib_there_is_none(monkeypatch):
    monkeypatch.setattr(
        "lbskel.visualization.poster.find_spec", lambda name: None if name == "matplotlib" else find_spec(name)
    )
    assert poster(Panel(flat_tube())) == b""
