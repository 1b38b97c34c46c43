"""Thin and long shapes: their proportions, closed surfaces, and axes that lie in them."""

import numpy as np
import pytest

from lbskel import MeshError, Skeleton, UnknownChoice
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import inside_fraction
from lbskel.shapes import coil, tube_mesh, vessel_tree, with_local_noise


@pytest.mark.parametrize("n_turns", [2, 5])
def test_a_coil_is_a_closed_tube_around_its_axis(n_turns):
    shape = coil(n_turns)
    assert shape.mesh.is_closed_manifold
    assert (shape.mesh.genus, shape.mesh.n_components) == (0, 1)
    assert (shape.truth.n_tips, shape.truth.genus, shape.truth.n_components) == (2, 0, 1)
    arc = n_turns * np.hypot(16 * np.pi, 6)
    # chords of angle 1/8: shorter by 1/24 of the angle squared, 7e-4
    assert shape.truth.length == pytest.approx(arc, rel=1e-3)
    # the chords, sections that meet at 1/8, by 1/8 of its square, 2e-3, and polyhedra in place of half spheres
    assert shape.mesh.volume == pytest.approx(np.pi * arc + 4 / 3 * np.pi, rel=4e-3)
    assert inside_fraction(shape.truth, Surface(shape.mesh)) == 1


def test_the_radius_of_a_coil_is_near_its_distance_to_the_surface():
    shape = coil(2)
    distances = Surface(shape.mesh).distance(shape.truth.nodes)
    # the inscribed radius of a 12-gon with the area of the unit circle is sqrt(pi / 12 / tan(pi / 12)), 0.9885; a bend
    # of radius 8 with sections 1 apart puts the faces on the outside 1/128 of 9 closer
    assert np.percentile(distances, [5, 95]) == pytest.approx([0.9885, 0.9885], abs=0.01)


@pytest.mark.parametrize(("n_turns", "ratio"), [(5, 0.0245), (20, 0.0080), (60, 0.00276)])
def test_the_thickness_over_the_diagonal_falls_with_the_turns(n_turns, ratio):
    V = coil(n_turns).mesh.vertices
    assert 1 / np.linalg.norm(np.ptp(V, axis=0)) == pytest.approx(ratio, rel=0.01)


def test_edges_are_no_longer_than_the_sections_are_apart():
    mesh = coil(3).mesh
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    lengths = np.linalg.norm(end - start, axis=1)
    assert lengths.max() < 1.35  # a diagonal: 0.53 around the tube, 9/8 on the outside of the bend
    assert lengths.min() > 0.2  # in the ends' last rings, 0.53 cos 60 degrees


def test_a_vessel_tree_is_one_surface_around_its_axes():
    shape = vessel_tree(6, min_radius=0.2, seed=1)
    assert shape.mesh.is_closed_manifold
    assert (shape.mesh.genus, shape.mesh.n_components) == (0, 1)
    assert (shape.truth.n_tips, shape.truth.genus, len(shape.truth.junctions)) == (8, 0, 6)
    assert inside_fraction(shape.truth, Surface(shape.mesh)) == 1
    distance = Surface(shape.mesh).distance(shape.truth.nodes) / shape.truth.radii
    # triangles with edges of half a radius between vertices at 1.015 radii: 0.984 at the middle of an edge around the
    # tube; more where vessels blend
    assert np.median(distance) == pytest.approx(0.984, abs=0.01)
    assert np.percentile(distance, 2) > 0.95
    assert shape.truth.radii.min() >= 0.2


def test_the_tubes_of_a_skeleton_are_one_surface():
    nodes = [[0, 0, 0], [0, 0, 9], [5, 0, 15], [-5, 0, 15], [8, 0, 8]]
    fork = Skeleton(nodes, [[0, 1], [1, 2], [1, 3], [2, 4]], [1.0, 0.9, 0.6, 0.7, 0.5])
    shape = tube_mesh(fork)
    assert shape.mesh.is_closed_manifold
    assert (shape.mesh.genus, shape.truth.n_tips, len(shape.truth.junctions)) == (0, 3, 1)
    assert shape.truth.length == pytest.approx(fork.length)
    assert inside_fraction(shape.truth, Surface(shape.mesh)) == 1
    coarse = tube_mesh(fork, edge_length=0.8)
    assert len(coarse.mesh.faces) < 0.5 * len(shape.mesh.faces)
    assert coarse.mesh.volume == pytest.approx(shape.mesh.volume, rel=0.01)  # both are of the volume of the tubes


def test_noise_is_in_proportion_to_the_local_edge_length():
    mesh = vessel_tree(2, seed=1).mesh
    noisy = with_local_noise(mesh, 0.1)
    moved = np.linalg.norm(noisy.vertices - mesh.vertices, axis=1)
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    local = np.bincount(mesh.edges.ravel(), np.repeat(np.linalg.norm(end - start, axis=1), 2))
    local /= np.bincount(mesh.edges.ravel())
    # |normal deviate| has the mean sqrt(2 / pi); 2,000 of them are known to 2 %
    assert (moved / local).mean() == pytest.approx(0.1 * np.sqrt(2 / np.pi), rel=0.05)
    thin, thick = (local < np.percentile(local, 20)), (local > np.percentile(local, 80))
    assert moved[thick].mean() / moved[thin].mean() == pytest.approx(local[thick].mean() / local[thin].mean(), rel=0.15)


def test_a_coil_has_turns_and_tubes_have_radii():
    with pytest.raises(UnknownChoice, match="n_turns must be positive, not 0"):
        coil(0)
    with pytest.raises(MeshError, match="no radius of the skeleton is known and positive"):
        tube_mesh(Skeleton([[0, 0, 0], [0, 0, 9]], [[0, 1]], [np.nan, np.nan]))


def test_the_volume_of_a_coil_is_a_quarter_of_a_per_cent_below_that_of_its_tube():
    length = 2 * np.pi * 5 * np.hypot(8, 3 / np.pi)
    assert coil(5, sides=40).mesh.volume == pytest.approx(0.9975 * (np.pi * length + 4 * np.pi / 3), rel=3e-4)
