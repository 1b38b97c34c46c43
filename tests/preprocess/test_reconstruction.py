"""Surfaces through the points of shapes that are known."""

import numpy as np
import pytest

from lbskel import MeshError, PointCloud, reconstruct_surface
from lbskel.preprocess.reconstruction import _n_handles
from lbskel.shapes import make, sphere, torus
from lbskel.skeleton.edge_distances import nearest_on_edges

RNG = np.random.default_rng(6)
TORUS = torus(1.0, 0.3)


def distance_from_torus(points):
    ring = np.hypot(points[:, 0], points[:, 1]) - 1
    return np.abs(np.hypot(ring, points[:, 2]) - 0.3)


def noisy(name, seed):
    """10,000 points of a shape of the catalog with noise of a tenth of the local radius."""
    shape, rng = make(name), np.random.default_rng(seed)
    weights = shape.mesh.face_areas
    corners = shape.mesh.vertices[shape.mesh.faces[rng.choice(len(weights), 10_000, p=weights / weights.sum())]]
    points = np.einsum("nk,nki->ni", rng.dirichlet(np.ones(3), 10_000), corners)
    return points + rng.normal(size=points.shape) * 0.1 * nearest_on_edges(shape.truth, points)[2][:, None]


@pytest.fixture(scope="module")
def surface():
    return reconstruct_surface(PointCloud(TORUS.vertices))


def test_the_surface_of_a_torus_is_closed_and_near(surface):
    assert surface.mesh.is_closed_manifold
    assert surface.mesh.genus == 1
    assert distance_from_torus(surface.mesh.vertices).max() < 0.03  # a tenth of the radius
    nearest = surface.mesh.vertices[surface.vertex_map.indices]
    assert np.linalg.norm(nearest - TORUS.vertices, axis=1).max() < 0.166  # the side of a cell, 1.6 spacings


def test_it_follows_similarities(surface):
    rotation = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    moved = reconstruct_surface(PointCloud(50 * TORUS.vertices @ rotation.T + 1e6))
    assert moved.mesh.genus == 1
    # the grid is not rotated, so only the measures are compared
    assert moved.mesh.volume == pytest.approx(
        50**3 * surface.mesh.volume, rel=0.02
    )  # its cells are 0.1, a third of the radius


def test_a_side_that_no_scanner_saw_is_closed():
    points = TORUS.vertices[TORUS.vertices[:, 2] > -0.15]
    surface = reconstruct_surface(PointCloud(points))
    assert surface.mesh.is_closed
    assert surface.mesh.genus == 1


def test_limbs_that_almost_touch_stay_apart():
    # where its strands cross, the knot's surfaces are two spacings apart; with the level at most 0.5 it had 3 handles
    assert reconstruct_surface(PointCloud(noisy("knot", 7))).mesh.genus == 1


def test_noise_as_large_as_the_points_are_apart():
    # in the thick end, where normals of 16 neighbors, a third of them inward, made a surface of 41 parts
    mesh = reconstruct_surface(PointCloud(noisy("dumbbell", 2))).mesh
    assert mesh.genus == 0
    assert mesh.n_components == 1


def test_two_bodies_get_two_surfaces():
    ball = sphere(4).vertices
    surface = reconstruct_surface(PointCloud(np.concatenate([ball, ball + [0, 0, 5]])))
    assert surface.mesh.n_components == 2


def test_a_twig_thinner_than_its_points_are_apart_gets_a_tube():
    twig = np.stack([np.linspace(0.98, 3, 60), *RNG.normal(size=(2, 60)) * 1e-3], axis=1)
    surface = reconstruct_surface(PointCloud(np.concatenate([sphere(4).vertices, twig])), preprocess="none")
    assert surface.report["steps"][0]["points_in_tubes"] > 40
    assert any("or seen from one side, whose ends and joints are uncertain" in note for note in surface.notes)
    assert surface.mesh.vertices[:, 0].max() > 2.9
    assert surface.mesh.n_components == 1


def test_outliers_are_on_no_surface():
    points = np.concatenate([TORUS.vertices, [[0, 0, 3.0]]])
    surface = reconstruct_surface(PointCloud(points))
    assert surface.vertex_map.indices[-1] == -1
    assert surface.notes == ("1 outlier was left out, where points are much farther apart than nearby",)


@pytest.mark.parametrize("seed", range(5))
def test_few_scattered_points_are_a_result_or_a_typed_error(seed):
    points = np.random.default_rng(seed).normal(size=(30, 3))
    try:
        surface = reconstruct_surface(PointCloud(points))
    except MeshError:
        return
    assert len(surface.mesh.faces) > 0


def test_of_some_levels_that_with_the_fewest_handles_is_taken():
    ring, ball = torus(1.0, 0.3), sphere(3)
    assert _n_handles(ring.vertices, ring.faces) == 1
    assert _n_handles(ball.vertices, ball.faces) == 0
    assert _n_handles(ball.vertices[:0], ball.faces[:0]) == np.inf
    V = np.concatenate([ring.vertices, ball.vertices + 5])
    assert _n_handles(V, np.concatenate([ring.faces, ball.faces + len(ring.vertices)])) == 1
