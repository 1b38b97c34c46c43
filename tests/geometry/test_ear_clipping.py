"""Ear clipping: the triangles of a polygon turn as it does and have its area; outlines that cross themselves fail."""

import numpy as np
import pytest

from lbskel.geometry.ear_clipping import clip_ears

TURN = 2 * np.pi * np.arange(120) / 120
CIRCLE = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)


def polar(radii):
    return np.asarray(radii)[:, None] * CIRCLE


def area_of(polygon):
    x, y = polygon.T
    return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2


def spiral(k):
    t = np.linspace(0.5, 10 * np.pi, k)
    outer, inner = (r[:, None] * np.stack([np.cos(t), np.sin(t)], axis=1) for r in (t + 1.5, t))
    return np.concatenate([outer, inner[::-1]])


SQUARE = np.array([[0, 0], [4, 0], [4, 4], [0, 4]], dtype=float)
POLYGONS = {
    "a triangle": SQUARE[:3],
    "convex": CIRCLE,
    "star": polar(np.where(np.arange(120) % 2, 0.3, 1.0)),
    "gear": polar(np.where(np.arange(120) // 4 % 2, 0.3, 1.0)),
    "random": polar(np.random.default_rng(0).uniform(0.1, 1.0, 120)),
    "spiral": spiral(100),
    "corners in line": np.array([[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [4, 4], [2, 4], [0, 4], [0, 2]], dtype=float),
    "a hole with a bridge": np.concatenate([SQUARE, SQUARE[:1], 1 + SQUARE[[0, 3, 2, 1, 0]] / 2]),
    "a thin ring with a bridge": np.concatenate([CIRCLE, CIRCLE[:1], 0.999 * CIRCLE[:1], 0.999 * CIRCLE[::-1]]),
}


@pytest.mark.parametrize("name", POLYGONS)
def test_triangles_turn_as_the_polygon_and_have_its_area(name):
    polygon = POLYGONS[name]
    triangles = clip_ears(polygon)
    assert triangles.shape == (len(polygon) - 2, 3)
    areas = [area_of(corners) for corners in polygon[triangles]]
    assert min(areas) > -1e-12
    assert sum(areas) == pytest.approx(area_of(polygon))
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    uses = np.unique(edges, axis=0, return_counts=True)[1]
    assert np.bincount(uses, minlength=3).tolist() == [0, len(polygon), len(polygon) - 3]


def test_an_outline_that_crosses_itself_fails():
    eight = np.stack([np.cos(TURN), np.sin(2 * TURN)], axis=1)
    assert clip_ears(eight) is None
