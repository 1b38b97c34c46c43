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


def test_stars_agree_on_a_diagonal_of_points_on_a_circle():
    """The rings of a grid and of regular polygons: each triangle is in the stars of its three corners."""
    turns = np.exp(2j * np.pi * np.arange(7) / 7)
    polygon = np.column_stack([turns.real, turns.imag, np.zeros(7)])
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(5.0), np.arange(5.0), indexing="ij"))
    grid = np.column_stack([x, y, np.zeros(25)])
    for points, n_triangles in ((polygon, 5), (grid, 32)):
        for seed in range(5):
            order = np.random.default_rng(seed).permutation(len(points))
            triangles = np.sort(delaunay_stars(points[order], 25), axis=1)
            unique, counts = np.unique(triangles, axis=0, return_counts=True)
            assert len(unique) == n_triangles
            assert (counts == 3).all()
