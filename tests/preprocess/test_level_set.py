"""Level sets of functions whose surface is known."""

import numpy as np
import pytest

from lbskel import Mesh, MeshError
from lbskel.preprocess.level_set import level_set, level_sets


def ball(positions):
    return 1 - np.linalg.norm(positions, axis=1)


def test_a_sphere_from_one_point_is_closed_and_in_place():
    V, F = level_set(ball, np.array([[1.0, 0, 0]]), 0.1)
    mesh = Mesh(V, F)
    assert mesh.is_closed_manifold
    assert mesh.genus == 0
    assert mesh.volume == pytest.approx(4 / 3 * np.pi, rel=0.01)  # chords of cells of 0.1: 0.1^2 / 8 of the radius
    assert np.linalg.norm(V, axis=1) == pytest.approx(np.ones(len(V)), abs=0.1**2 / 8 * 3)


def test_only_parts_with_a_point_are_found():
    def two(positions):
        return np.maximum(ball(positions), ball(positions - [5, 0, 0]))

    points = np.array([[1.0, 0, 0], [6.0, 0, 0]])
    assert Mesh(*level_set(two, points, 0.2)).n_components == 2
    assert Mesh(*level_set(two, points[:1], 0.2)).n_components == 1


def test_a_function_without_a_level_set_has_no_faces():
    V, F = level_set(lambda positions: -np.ones(len(positions)), np.zeros((1, 3)), 0.1)
    assert len(V) == len(F) == 0


def test_levels_are_surfaces_of_their_own_though_evaluated_once():
    calls = []

    def counted(positions):
        calls.append(len(positions))
        return ball(positions)

    point = np.array([[1.0, 0, 0]])
    outer, inner = (Mesh(*each.triangles()) for each in level_sets(counted, point, 0.1, [-0.05, 0.05]))
    assert outer.volume == pytest.approx(4 / 3 * np.pi * 1.05**3, rel=0.01)
    assert inner.volume == pytest.approx(4 / 3 * np.pi * 0.95**3, rel=0.01)
    n_calls = sum(calls)
    level_set(counted, point, 0.1)
    assert n_calls < 2.2 * (sum(calls) - n_calls)


def torus(positions):
    return 0.3 - np.hypot(np.hypot(positions[:, 0], positions[:, 1]) - 1, positions[:, 2])


def test_handles_are_counted_without_triangles():
    point = np.array([[1.0, 0, 0.3]])
    for function, genus in ((torus, 1), (lambda places: ball(places - [0.01, 0.02, 0]), 0)):
        (level,) = level_sets(function, point + [0, 0, -0.01], 0.1, [0.0])
        assert level.least_handles == Mesh(*level.triangles()).genus == genus
    (empty,) = level_sets(lambda positions: -np.ones(len(positions)), point, 0.1, [0.0])
    assert empty.least_handles == np.inf


@pytest.mark.parametrize("far", [1e6, -1e6])
def test_points_too_far_apart_for_the_grid_are_refused(far):
    """The keys of their cells would be those of others."""
    with pytest.raises(MeshError, match=r"cells of a grid apart.*leave stray points out"):
        level_set(ball, np.array([[1.0, 0, 0], [0, far, 0]]), 0.5)
