"""Delaunay stars of points, against a Delaunay triangulation of each neighborhood."""

import numpy as np
from operator_shapes import fibonacci_sphere
from scipy.spatial import Delaunay

from lbskel.operators.local_delaunay import delaunay_stars


def test_stars_are_those_of_delaunay_triangulations():
    P = fibonacci_sphere(300) + 0.03 * np.random.default_rng(0).normal(size=(300, 3))
    stars = delaunay_stars(P, 20)
    for i in range(0, 300, 7):
        near = np.argsort(np.linalg.norm(P - P[i], axis=1), kind="stable")[:20]
        centered = P[near] - P[near].mean(axis=0)
        plane = np.linalg.svd(centered)[2][:2]
        simplices = near[Delaunay((P[near] - P[i]) @ plane.T).simplices]
        expected = {frozenset(s) for s in simplices.tolist() if i in s}
        assert {frozenset(s) for s in stars[stars[:, 0] == i].tolist()} == expected
