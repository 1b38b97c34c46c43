"""Roughness: noise is distinguished from shape and smoothed; smooth, coarse and spiky surfaces are unchanged."""

from unittest import mock

import numpy as np
import pytest
from scipy import ndimage

from lbskel import Mesh, check, ground_truth_distances, skeletonize
from lbskel.geometry.roughness import ROUGHNESS_LIMIT, roughness
from lbskel.preprocess import preprocess_mesh
from lbskel.shapes import SHAPES, make, mesh_solid, schwarz_lantern, sphere, torus, voxel_surface


def with_noise(mesh, height, seed=0):
    """Vertices moved by up to a fraction of the diagonal along each axis."""
    offsets = np.random.default_rng(seed).uniform(-1, 1, size=mesh.vertices.shape)
    return mesh.with_vertices(mesh.vertices + height * mesh.diagonal * offsets)


def with_spikes(ball, height):
    """A ball with a spike of one vertex on every face."""
    tips = ball.vertices[ball.faces].mean(axis=1)
    tips *= (1 + height) / np.linalg.norm(tips, axis=1, keepdims=True)
    a, b, c = ball.faces.T
    tip = len(ball.vertices) + np.arange(len(tips))
    sides = [np.stack(side, axis=1) for side in ((a, b, tip), (b, c, tip), (c, a, tip))]
    return Mesh(np.concatenate([ball.vertices, tips]), np.concatenate(sides))


def fine_box(n=12):
    """A triangulated cube with n by n squares on each side, which has only flat parts and creases."""
    u, v = (axis.ravel() for axis in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    corner = np.flatnonzero((u < n) & (v < n))
    square = [[corner, corner + n + 1, corner + n + 2], [corner, corner + n + 2, corner + 1]]
    one = np.concatenate([np.stack(triangle, axis=1) for triangle in square])
    sides, faces = [], []
    for axis in range(3):
        for end in (0, n):
            side = np.stack([np.full(len(u), end), u, v], axis=1)
            faces.append((one if end else one[:, ::-1]) + len(sides) * len(u))
            sides.append(np.roll(side, axis, axis=1))
    V, first = np.unique(np.concatenate(sides), axis=0, return_inverse=True)
    return Mesh(V.astype(float), first.ravel()[np.concatenate(faces)])


def spool(n=96):
    """A spool with a bore, turned from a polygon of eight corners: its edges are long along the axis and across."""
    r, z = np.array([(1, 0), (3, 0), (3, 0.3), (1.5, 0.3), (1.5, 2.7), (3, 2.7), (3, 3), (1, 3)]).T
    angles, k = 2 * np.pi * np.arange(n)[:, None] / n, len(r)
    V = np.stack([r * np.cos(angles), r * np.sin(angles), np.broadcast_to(z, (n, k))], axis=-1).reshape(-1, 3)
    i, j = np.divmod(np.arange(n * k), k)
    a, b, c, d = (row % n * k + column % k for row, column in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    return Mesh(V, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]))


def voxel_rod(noise, n=200, radius=8.0):
    """A rod of voxels, its radius with noise of its own in each voxel: the largest connected part, filled."""
    x, y, z = np.indices((26, 26, n))
    wall = np.random.default_rng(0).normal(radius, noise, x.shape)
    filled = (np.hypot(x - 12.5, y - 12.5) < wall) & (z >= 2) & (z < n - 2)
    parts = ndimage.label(filled)[0]
    largest = parts == 1 + np.bincount(parts.ravel())[1:].argmax()
    return voxel_surface(ndimage.binary_fill_holes(largest))


def test_noise_of_voxels_whose_corners_move_together_is_measured():
    """The wall is half a voxel off: 0.4 of an edge; measured at the shortest wavelengths alone, it would be 0.14."""
    noisy, clean = voxel_rod(0.5), voxel_rod(0.0)
    assert roughness(clean) < 0.9 * ROUGHNESS_LIMIT
    assert roughness(noisy) > 1.1 * ROUGHNESS_LIMIT
    assert any("noise was smoothed" in note for note in preprocess_mesh(noisy).notes)


def test_a_sample_of_the_vertices_has_the_roughness_of_all():
    noisy = voxel_rod(0.5)
    measured = []
    for n_samples in (1000, len(noisy.vertices)):
        with mock.patch("lbskel.geometry.roughness.MAX_SAMPLES", n_samples):
            measured.append(roughness(Mesh(noisy.vertices, noisy.faces)))
    assert measured[0] == pytest.approx(measured[1], rel=0.1)  # the median of 1,000 is good to 4 %


def test_roughness_measures_noise_in_edge_lengths():
    ball = sphere(4)
    start, end = ball.vertices[ball.edges].transpose(1, 0, 2)
    edge = np.linalg.norm(end - start, axis=1).mean()
    heights = np.random.default_rng(0).standard_normal(len(ball.vertices))
    for share in (0.05, 0.1, 0.2):
        noisy = ball.with_vertices(ball.vertices * (1 + share * edge * heights)[:, None])
        # 0.9 as the module says, less the longer edges of steeper noise; a median of 2562 is good to 2 %
        assert roughness(noisy) == pytest.approx(0.9 * share, rel=0.07)


@pytest.mark.parametrize(
    "mesh",
    [
        fine_box(),
        sphere(4),
        torus(1.0, 0.3, 60, 12),
        schwarz_lantern(8, 80),
        with_spikes(sphere(2), 0.5),
        with_spikes(sphere(3), 0.2),
        with_noise(sphere(2), 0.1),  # 162 vertices: too few to tell noise from shape
        make("hand", n_vertices=1500, noise=0.1).mesh,
        make("spiked_ring", n_vertices=1500, noise=0.1).mesh,
        spool(),
    ],
    ids=[
        "box",
        "ball",
        "torus",
        "lantern",
        "spikes",
        "short spikes",
        "few vertices",
        "noisy hand",
        "noisy ring",
        "spool",
    ],
)
def test_moderate_noise_and_detail_are_kept(mesh):
    assert roughness(mesh) <= ROUGHNESS_LIMIT
    prepared = preprocess_mesh(mesh)
    assert np.array_equal(prepared.mesh.vertices[: len(mesh.vertices)], mesh.vertices)
    assert not [note for note in prepared.notes if "noise" in note]


def test_the_box_and_the_spool_of_these_tests_are_closed():
    assert fine_box().is_closed_manifold
    assert spool().is_closed_manifold
    assert spool().volume > 0
    assert fine_box().volume == 12**3


def test_a_rough_surface_is_smoothed_and_reported():
    mesh = mesh_solid(SHAPES["limbs"](), n_vertices=1500)
    rough = with_noise(mesh, 0.03)
    assert roughness(rough) > ROUGHNESS_LIMIT
    assert any("rough" in finding for finding in check(rough).findings)
    prepared = preprocess_mesh(rough)
    assert any("noise was smoothed" in note for note in prepared.notes)
    assert [step["step"] for step in prepared.report["steps"]] == ["smooth_noise"]
    assert np.array_equal(prepared.vertex_map.indices, np.arange(len(mesh.vertices)))
    assert roughness(prepared.mesh) < 0.2 * ROUGHNESS_LIMIT
    # noise adds no volume on average, but smoothing keeps wavelengths above ten edges, which add up to a tenth
    assert prepared.mesh.volume == pytest.approx(mesh.volume, rel=0.1)


@pytest.mark.parametrize("name", ["limbs", "ladder"])
def test_noise_as_high_as_a_limb_radius_hardly_moves_the_skeleton(name):
    mesh = mesh_solid(SHAPES[name](), n_vertices=1500)
    rough = skeletonize(with_noise(mesh, 0.03))
    moved = ground_truth_distances(rough, skeletonize(mesh))
    assert moved.n_tips == moved.n_true_tips
    assert moved.is_topology_right
    # noise of 3 % of the diagonal is 0.9 radii high here; a section of some twenty vertices averages it to a fifth
    assert max(moved.accuracy, moved.coverage) < 0.2
    assert len(rough.node_of_vertex) == len(mesh.vertices)
    assert rough.report["score"]["verdict"] != "fail"
