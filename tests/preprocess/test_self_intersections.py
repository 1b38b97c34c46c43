"""Faces that intersect others."""

from helpers import joined, moved

from lbskel import check
from lbskel.shapes import torus

TORUS = torus(1.0, 0.4, 40, 24)


def test_intersecting_surfaces_are_found():
    apart = joined(TORUS, moved(TORUS, 3.0))
    assert check(apart).self_intersecting_faces == 0
    crossing = check(joined(TORUS, moved(TORUS, 1.5)))
    assert 50 < crossing.self_intersecting_faces < 800
    assert crossing.self_intersection_sample == 1.0
