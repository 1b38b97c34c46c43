"""Isotropic remeshing, and smoothing of noise."""

import numpy as np
import pytest
from helpers import patches_are_connected

from lbskel import UnknownChoice
from lbskel.preprocess.remeshing import remesh_isotropic, smooth_noise
from lbskel.shapes import capsule, cylinder, sphere, torus


def test_noise_is_smoothed_and_the_shape_kept():
    mesh = capsule(3.0, 0.4, 24)
    rng = np.random.default_rng(0)
    noisy = mesh.with_vertices(mesh.vertices + 0.008 * rng.standard_normal(mesh.vertices.shape))
    smooth = smooth_noise(noisy).mesh
    before, after = (np.linalg.norm(other.vertices - mesh.vertices, axis=1) for other in (noisy, smooth))
    assert np.sqrt(np.mean(after**2)) < 0.75 * np.sqrt(
        np.mean(before**2)
    )  # 0.66: noise tangential to the surface is kept
    assert smooth.volume == pytest.approx(mesh.volume, rel=0.02)
    pipe = cylinder(0.3, 2.0, 12, 8)
    is_rim = np.isin(np.arange(len(pipe.vertices)), pipe.edges[pipe.faces_per_edge == 1])
    assert np.array_equal(smooth_noise(pipe).mesh.vertices[is_rim], pipe.vertices[is_rim])


TORUS = torus(1.0, 0.4, 40, 24)
_BALL = sphere(4)
_X = _BALL.vertices[:, :1]
# a ball, of which a cap with a radius of 0.14 is drawn out by its diameter
SPIKE = _BALL.with_vertices(_BALL.vertices + [1.0, 0, 0] * np.clip((_X - 0.99) / 0.01, 0, 1) * 2.0)


def test_remeshing_makes_edges_of_the_target_length():
    pytest.importorskip("pymeshlab")
    result = remesh_isotropic(TORUS, edge_length=0.05, feature_angle=180.0)
    start, end = result.mesh.vertices[result.mesh.edges].transpose(1, 0, 2)
    assert np.linalg.norm(end - start, axis=1).mean() == pytest.approx(0.05 * TORUS.diameter_bound, rel=0.1)
    assert result.mesh.genus == 1
    back = result.pull_back(np.array(result.mesh.vertices))
    # chords of 0.15 on a tube of radius 0.4 lie 0.15^2 / 3.2 below it
    assert np.linalg.norm(back - TORUS.vertices, axis=1).max() < 3 * 0.15**2 / 3.2
    assert patches_are_connected(TORUS, result.vertex_map.indices)


def test_a_limb_that_remeshing_would_lose_is_kept():
    """A ball with a spike thinner than an edge, which collapses."""
    pytest.importorskip("pymeshlab")
    result = remesh_isotropic(SPIKE, edge_length=0.12, feature_angle=180.0)
    assert result.mesh is SPIKE
    [note] = result.notes
    assert note.startswith("the mesh was not remeshed: the surface would move by")


@pytest.mark.parametrize(
    "options", [{"edge_length": np.inf}, {"edge_length": np.nan}, {"feature_angle": np.nan}, {"feature_angle": 181.0}]
)
def test_lengths_and_angles_are_checked(options):
    with pytest.raises(UnknownChoice, match=next(iter(options))):
        remesh_isotropic(TORUS, **options)


@pytest.mark.parametrize("iterations", [-1, 2.5, 1001, np.nan])
def test_iterations_are_a_whole_number(iterations):
    with pytest.raises(UnknownChoice, match="iterations must be a whole number from 0 to 1,000, not"):
        smooth_noise(TORUS, iterations=iterations)


def test_an_edge_that_would_make_too_many_faces_is_refused_with_the_syntax_of_another():
    with pytest.raises(UnknownChoice, match=r"remesh_isotropic:edge_length=NUMBER:relative_to=diameter_bound"):
        remesh_isotropic(TORUS, edge_length=1e-5)
