"""Faces that intersect others."""

import tracemalloc

import numpy as np
import pytest
from helpers import joined, moved, triangle_soup

from lbskel import Mesh, check
from lbskel.preprocess import self_intersections
from lbskel.preprocess.self_intersections import self_intersecting_faces
from lbskel.shapes import cylinder, sphere, torus

TORUS = torus(1.0, 0.4, 40, 24)


def test_intersecting_surfaces_are_found():
    apart = joined(TORUS, moved(TORUS, 3.0))
    assert check(apart).self_intersecting_faces == 0
    crossing = check(joined(TORUS, moved(TORUS, 1.5)))
    assert 50 < crossing.self_intersecting_faces < 800
    assert crossing.self_intersection_sample == 1.0


def pierced(P, Q):
    """Whether an edge of triangle P passes through triangle Q, from the signs of the volumes of five tetrahedra."""

    def volume(a, b, c, d):
        return np.linalg.det(np.stack([b - a, c - a, d - a]))

    for k in range(3):
        a, b = P[k], P[(k + 1) % 3]
        around = [volume(a, b, Q[i], Q[(i + 1) % 3]) for i in range(3)]
        crosses = volume(*Q, a) * volume(*Q, b) < 0
        if crosses and (min(around) > 0 or max(around) < 0):
            return True
    return False


@pytest.mark.parametrize("seed", range(4))
def test_all_faces_that_intersect_others_are_found(seed):
    """Triangles of very different sizes, some of which share vertices."""
    rng = np.random.default_rng(seed)
    sizes = 10.0 ** rng.uniform(-2, 0, (40, 1))
    V = rng.normal(size=(40, 3)) * sizes
    F = np.array([rng.choice(40, 3, replace=False) for _ in range(60)])
    mesh = Mesh(V, F)
    expected = np.zeros(len(F), dtype=bool)
    for i in range(len(F)):
        for j in range(len(F)):
            if not set(F[i]) & set(F[j]) and pierced(V[F[i]], V[F[j]]):
                expected[[i, j]] = True
    found, sample = self_intersecting_faces(mesh)
    assert sample == 1.0
    assert np.array_equal(found, np.flatnonzero(expected))


def test_a_large_face_beside_small_ones_takes_little_memory():
    ball = sphere(1)
    large = Mesh([[1, 0.2, 0.1], [3, 2.1, 1.3], [2.2, 2.6, 3]], [[0, 1, 2]])
    mesh = joined(ball.with_vertices(0.01 * ball.vertices), large)
    tracemalloc.start()
    found = self_intersecting_faces(mesh)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (found[0].tolist(), found[1]) == ([], 1.0)
    assert peak < 1e8  # bytes


def test_of_too_many_pairs_a_sample_is_tested_and_the_report_says_so(monkeypatch):
    """The boxes of 600 needles through one point all overlap."""
    monkeypatch.setattr(self_intersections, "MAX_PAIRS", 50_000)
    directions = np.random.default_rng(0).normal(size=(600, 3))
    ends = directions + 0.05 * np.random.default_rng(1).normal(size=(600, 3))
    needles = triangle_soup(Mesh([*directions, *-directions, *ends], np.arange(1800).reshape(3, -1).T))
    found, sample = self_intersecting_faces(needles)
    assert 0 < sample < 0.5
    assert len(found) > 0
    said = " ".join(check(needles).findings)
    assert f"{sample:.0%} of the faces were tested for self-intersections, so there may be more." in said
    monkeypatch.setattr(self_intersections, "MAX_PAIRS", 1_000_000)
    complete, sample = self_intersecting_faces(needles)
    assert sample == 1.0
    assert set(found) <= set(complete)


def test_a_fan_of_needles_intersects_nothing():
    rod = cylinder(1.0, 3.0, 200, 2)
    n = len(rod.vertices)
    rim = rod.edges[rod.faces_per_edge == 1]
    center = np.where(rod.vertices[rim[:, 0], 2] > rod.vertices[:, 2].mean(), n, n + 1)
    V = np.concatenate([rod.vertices, [[0, 0, rod.vertices[:, 2].max()], [0, 0, rod.vertices[:, 2].min()]]])
    found, sample = self_intersecting_faces(Mesh(V, np.concatenate([rod.faces, np.column_stack([rim, center])])))
    assert (found.tolist(), sample) == ([], 1.0)
