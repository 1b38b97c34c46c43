"""Uncovered limbs: found where a branch is missing, and nowhere else."""

from dataclasses import replace
from unittest.mock import patch

import igl
import numpy as np
import pytest
from helpers import path_in

from lbskel import Mesh, skeletonize
from lbskel.refinement.uncovered_limbs import MIN_BULGE, Limbs, _ball_distances, _bulging_patches, find_limbs
from lbskel.shapes import capsule, make, sphere
from lbskel.skeleton.editing import contract_nodes


def uncovered(skeleton, mesh):
    """The limbs where none are known."""
    return find_limbs(skeleton, mesh)


def drawn_out(ball, stretch):
    """A ball whose vertices are stretched along z."""
    return ball.with_vertices(ball.vertices * np.stack([np.ones_like(stretch)] * 2 + [stretch], axis=1))


def at_center(mesh, radius=1.0):
    return path_in(mesh, [[-0.01, 0, 0], [0.01, 0, 0]], radius=radius)


@pytest.fixture(scope="module")
def whole(tripod):
    return skeletonize(tripod)


@pytest.mark.parametrize("number", range(3))
def test_a_limb_without_a_branch_is_found_with_its_end_its_radius_and_its_vertices(whole, tripod, number):
    branch = whole.end_branches[number]
    target = np.arange(len(whole.nodes))
    target[branch[1:]] = branch[0]
    limbs = uncovered(contract_nodes(whole, target), tripod)
    [end] = limbs.ends
    tip, radius = whole.nodes[branch[-1]], whole.radii[branch[-1]]
    assert np.linalg.norm(tripod.vertices[end] - tip) < 1.5 * radius  # the tip is about a radius inside
    assert limbs.radii == pytest.approx(radius, rel=0.2)  # the cap counts as area, and the foot of the limb does not
    own = np.isin(whole.node_of_vertex, branch[2 * len(branch) // 3 :])
    assert (limbs.limb_of_vertex[own] == 0).all()


@pytest.mark.parametrize("name", ["octopus", "spiked_ring", "dumbbell", "knot"])
def test_a_whole_skeleton_leaves_nothing_uncovered(name):
    shape = make(name, n_vertices=2500)
    assert len(uncovered(skeletonize(shape.mesh), shape.mesh).ends) == 0


def test_a_limb_with_few_faces_is_covered_by_its_branch():
    """Around the spikes of a ring are so few faces that vertices are up to 1.2 of the inscribed radii from the axis."""
    fine = make("spiked_ring", n_vertices=4000).mesh
    V, F, *_ = igl.decimate(fine.vertices, fine.faces, len(fine.faces) // 4, True)
    coarse = Mesh(V, F)
    skeleton = skeletonize(coarse)
    assert len(skeleton.tips) == 5
    assert len(uncovered(skeleton, coarse).ends) == 0


def test_the_rim_of_a_flat_part_is_no_limb():
    """The skeleton runs along a plate ten times as wide as thick, whose rims are far outside of its balls."""
    round_bar = capsule(32.0, 0.5)
    plate = round_bar.with_vertices(round_bar.vertices * [1, 10, 1])
    skeleton = path_in(plate, [[0, 0, z] for z in np.linspace(-16, 16, 65)], radius=0.5)
    assert len(uncovered(skeleton, plate).ends) == 0
    assert len(uncovered(path_in(plate, [[0, -4, 0], [0, -3, 0]], radius=0.5), plate).ends) > 0


def patches_that_bulge(mesh, heights, level, least=MIN_BULGE):
    """The vertices of the disks above a level whose bulge is over a bound, and the lengths of their rims."""
    with patch("lbskel.refinement.uncovered_limbs.MIN_BULGE", least):
        [patches] = _bulging_patches(mesh, heights, np.array([level]))
    return patches


@pytest.mark.parametrize("length", [0.0, 1.0, 3.0])
def test_the_bulge_of_a_round_limb_is_its_length_in_radii(length):
    rod = capsule(8.0, 0.5, 64)
    [vertices], rims = patches_that_bulge(rod, rod.vertices[:, 2], 4.0 - 0.5 * length, 0.98 * (1 + length))
    assert set(vertices) == set(np.flatnonzero(rod.vertices[:, 2] > 4.0 - 0.5 * length))
    assert rims == pytest.approx(np.pi, rel=0.01)
    assert patches_that_bulge(rod, rod.vertices[:, 2], 4.0 - 0.5 * length, 1.02 * (1 + length))[0] == []


@pytest.mark.parametrize(
    ("level", "width"),
    [pytest.param(1.0, 2.5, id="through the edges"), pytest.param(-1.0, 4.0, id="beyond the square")],
)
def test_the_boundary_of_the_surface_is_a_part_of_the_rim(level, width):
    """A square of side 4 with heights of x + 1/2, of which the part above the level is a rectangle."""
    grid = np.stack(np.meshgrid(np.arange(5.0), np.arange(5.0), [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    corner = (5 * np.arange(4)[:, None] + np.arange(4)).ravel()[:, None]
    square = Mesh(grid, np.concatenate([corner + [0, 5, 6], corner + [0, 6, 1]]))
    rim = 2 * (4 + width)
    bulge = 4 * width / (rim * np.hypot(2, width / 2))
    assert patches_that_bulge(square, grid[:, 0] - 0.5, level, (1 - 1e-9) * bulge)[1] == pytest.approx([rim])
    assert patches_that_bulge(square, grid[:, 0] - 0.5, level, (1 + 1e-9) * bulge)[0] == []


def test_the_end_of_a_flat_limb_bulges_by_its_length_in_half_widths():
    """A plate of width 2 and thickness 0.02, of which the last 3 are above the level."""
    rod = capsule(16.0, 0.01, 64)
    plate = rod.with_vertices(rod.vertices * [1, 100, 1])
    level = plate.vertices[:, 2].max() - 3.0
    assert len(patches_that_bulge(plate, plate.vertices[:, 2], level, 2.9)[0]) == 1
    assert patches_that_bulge(plate, plate.vertices[:, 2], level, 3.1)[0] == []


def test_a_band_around_a_rod_is_no_limb():
    rod = capsule(8.0, 0.5, 64)
    assert patches_that_bulge(rod, -np.abs(rod.vertices[:, 2]), -2.0)[0] == []


@pytest.mark.parametrize(("top", "n_limbs"), [(1.1, 0), (1.4, 0), (1.7, 1), (3.0, 1)])
def test_a_sharp_cone_is_a_limb_and_a_blunt_one_is_not(top, n_limbs):
    """Of the cones on a ball, whose base has a radius of 1/2, the second would be pruned."""
    ball = sphere(4)
    z, radius = ball.vertices[:, 2], 0.5
    inside = np.linalg.norm(ball.vertices[:, :2], axis=1)
    height = np.where(z > 0, np.maximum(z, top - (top - np.sqrt(1 - radius**2)) * inside / radius), z)
    cone = ball.with_vertices(np.stack([*ball.vertices[:, :2].T, height], axis=1))
    limbs = uncovered(at_center(cone), cone)
    assert len(limbs.ends) == n_limbs
    assert (limbs.radii < radius / 2).all()  # of the cap, not of the base


def test_of_two_limbs_on_a_longer_limb_each_is_found():
    """The two are half as long as the one that they are on, in radii, which therefore bulges more."""
    ball = sphere(5)
    x, y, z = ball.vertices.T
    near = np.hypot(np.abs(x) - 0.2, y) < 0.1
    drawn = drawn_out(ball, np.where(near & (z > 0), 4.6, np.where(z > 0.9, 4.0, 1.0)))
    limbs = uncovered(at_center(drawn), drawn)
    assert len(limbs.ends) == 2
    assert np.sign(drawn.vertices[limbs.ends, 0]).sum() == 0
    for limb, end in enumerate(limbs.ends):
        assert limbs.limb_of_vertex[end] == limb
        assert set(np.sign(x[limbs.limb_of_vertex == limb])) == {np.sign(x[end])}


def test_a_limb_of_a_missed_end_is_the_first_and_is_not_found_again():
    ball = sphere(4)
    drawn = drawn_out(ball, np.where(ball.vertices[:, 2] > 0.95, 4.0, np.where(ball.vertices[:, 2] < -0.97, 3.0, 1.0)))
    top = drawn.vertices[:, 2] > 0.99 * drawn.vertices[:, 2].max()  # less than the patch that bulges
    ends = np.array([drawn.vertices[:, 2].argmax(), 0])
    known = Limbs(ends, np.array([0.2, 0.1]), np.where(top, 0, -1))
    limbs = find_limbs(at_center(drawn), drawn, known.take(np.array([True, False])))
    assert limbs.ends.tolist() == [ends[0], drawn.vertices[:, 2].argmin()]
    assert limbs.radii[0] == 0.2
    assert np.array_equal(limbs.limb_of_vertex == 0, top)


def test_of_the_limbs_some_can_be_taken_with_their_vertices():
    limbs = Limbs(np.array([5, 3, 4]), np.array([0.5, 0.3, 0.4]), np.array([-1, 2, 2, 1, 2, 0]))
    taken = limbs.take(np.array([True, False, True]))
    assert taken.ends.tolist() == [5, 4]
    assert taken.radii.tolist() == [0.5, 0.4]
    assert taken.limb_of_vertex.tolist() == [-1, 1, 1, -1, 1, 0]
    none = limbs.take(np.zeros(3, dtype=bool))
    assert len(none.ends) == 0
    assert none.limb_of_vertex.tolist() == [-1] * 6


@pytest.mark.parametrize("seed", range(4))
def test_vertices_far_out_are_no_limbs(seed):
    """A limb reaches 1.5 radii; one vertex moved out by two edges makes a sharp cone, but a short one."""
    ball = sphere(4)
    far = np.random.default_rng(seed).choice(len(ball.vertices), 6, replace=False)
    balls_of = [
        ball.vertices * (1 + length * np.isin(np.arange(len(ball.vertices)), far)[:, None]) for length in (0.2, 1)
    ]
    near, farther = (ball.with_vertices(vertices) for vertices in balls_of)
    assert len(uncovered(at_center(near), near).ends) == 0
    assert set(uncovered(at_center(farther), farther).ends) == set(far)


@pytest.mark.parametrize(("last", "n_limbs"), [(3.3, 0), (2.5, 1)])
def test_a_flat_end_with_a_tip_near_it_is_no_limb(last, n_limbs):
    round_bar = capsule(8.0, 0.5, 64)
    bar = round_bar.with_vertices(np.clip(round_bar.vertices, [-1, -1, -4], [1, 1, 4]))
    skeleton = path_in(bar, np.linspace([0, 0, -3.5], [0, 0, last], 30), radius=0.5)
    assert len(uncovered(skeleton, bar).ends) == n_limbs


def test_where_noise_makes_a_ball_small_the_local_radius_counts():
    """At the middle of a rod the skeleton nearly touches the surface: its ball there leaves the rod uncovered."""
    rod = capsule(8.0, 0.5, 32)
    skeleton = path_in(rod, np.linspace([0, 0, -4], [0, 0, 4], 33), radius=0.5)
    radii = np.where(np.abs(skeleton.nodes[:, 2]) < 1, 0.05, 0.5)
    uneven = replace(skeleton, radii=radii)
    assert _ball_distances(uneven, rod)[1].max() < 1.2
    assert len(uncovered(uneven, rod).ends) == 0


def test_vertices_of_no_face_are_no_limb():
    ball = sphere(2)
    stray = Mesh(np.concatenate([ball.vertices, [[9.0, 0, 0]]]), ball.faces)
    assert _ball_distances(at_center(stray), stray)[1][-1] == 0
    assert len(uncovered(at_center(stray), stray).ends) == 0


def test_a_thin_branch_across_a_gap_does_not_uncover_what_the_own_ball_covers():
    """The cone of a ball, which its large radius covers, points at a rod that is nearer than the center of the ball."""
    ball, rod = sphere(3), capsule(2.0, 0.05, n=8)
    drawn = ball.vertices * np.where(ball.vertices[:, 2:] > 0.95, [1, 1, 1.6], 1)
    mesh = Mesh(
        np.concatenate([drawn, rod.vertices[:, [2, 1, 0]] + [0, 0, 1.9]]),
        np.concatenate([ball.faces, rod.faces[:, ::-1] + len(drawn)]),
    )
    skeleton = path_in(mesh, [[-0.01, 0, 0], [0.01, 0, 0], *([x, 0, 1.9] for x in np.linspace(-1, 1, 41))])
    skeleton = replace(skeleton, edges=np.delete(skeleton.edges, 1, axis=0), radii=np.repeat([1.7, 0.05], [2, 41]))
    in_ball = np.arange(len(mesh.vertices)) < len(drawn)
    assert len(uncovered(skeleton, mesh).ends) == 1
    own = replace(skeleton, node_of_vertex=np.where(in_ball, 0, skeleton.node_of_vertex))
    assert len(uncovered(own, mesh).ends) == 0
