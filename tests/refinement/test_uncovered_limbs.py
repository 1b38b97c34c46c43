"""Uncovered limbs: found where a branch is missing, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import path_in

from lbskel import Mesh, skeletonize
from lbskel.refinement.extrema import GeodesicExtrema
from lbskel.refinement.uncovered_limbs import ball_distances, find_limbs
from lbskel.shapes import capsule, make, sphere, with_local_noise
from lbskel.skeleton.editing import contract_nodes


def uncovered(balls, bounds):
    """The limbs where no end is known to be missed."""
    n_vertices = len(balls.mesh.vertices)
    none = GeodesicExtrema(np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0), np.full(n_vertices, -1))
    return find_limbs(balls, bounds, none)


@pytest.fixture(scope="module")
def whole(tripod):
    return skeletonize(tripod)


@pytest.mark.parametrize("number", range(3))
def test_a_limb_without_a_branch_is_found_with_its_end_its_radius_and_its_vertices(whole, tripod, number):
    branch = whole.end_branches[number]
    target = np.arange(len(whole.nodes))
    target[branch[1:]] = branch[0]
    limbs = uncovered(ball_distances(contract_nodes(whole, target), tripod), BOUNDS)
    [end] = limbs.ends
    tip, radius = whole.nodes[branch[-1]], whole.radii[branch[-1]]
    assert np.linalg.norm(tripod.vertices[end] - tip) < 1.5 * radius  # the tip is about a radius inside
    assert limbs.radii == pytest.approx(radius, rel=0.2)  # the cap counts as area, and the foot of the limb does not
    own = np.isin(whole.node_of_vertex, branch[2 * len(branch) // 3 :])
    assert (limbs.limb_of_vertex[own] == 0).all()


@pytest.mark.parametrize("name", ["octopus", "spiked_ring", "dumbbell", "knot"])
def test_a_whole_skeleton_leaves_nothing_uncovered(name):
    shape = make(name, n_vertices=2500)
    assert len(uncovered(ball_distances(skeletonize(shape.mesh), shape.mesh), BOUNDS).ends) == 0


BOUNDS = ((1.75, 1.5),)


def test_the_rim_of_a_flat_part_is_no_limb():
    """The skeleton runs along a plate ten times as wide as thick, whose rims are far outside of its balls."""
    round_bar = capsule(8.0, 0.5)
    plate = round_bar.with_vertices(round_bar.vertices * [1, 10, 1])
    skeleton = path_in(plate, [[0, 0, z] for z in np.linspace(-4, 4, 17)], radius=0.5)
    assert len(uncovered(ball_distances(skeleton, plate), BOUNDS).ends) == 0
    assert len(uncovered(ball_distances(path_in(plate, [[0, -4, 0], [0, -3, 0]], radius=0.5), plate), BOUNDS).ends) > 0


def test_a_limb_shorter_than_the_bound_counts_as_covered():
    ball = sphere(3)
    drawn = ball.with_vertices(ball.vertices * np.where(ball.vertices[:, 2:] > 0.9, [1, 1, 4], 1))
    at_center = path_in(drawn, [[-0.01, 0, 0], [0.01, 0, 0]], radius=1.0)
    assert len(uncovered(ball_distances(at_center, drawn), ((1.75, 1.5),)).ends) == 1
    assert len(uncovered(ball_distances(at_center, drawn), ((5.0, 1.5),)).ends) == 0


def test_each_limb_is_found_by_the_first_pair_of_bounds_that_finds_it():
    ball = sphere(4)
    stretch = np.where(ball.vertices[:, 2] > 0.95, 4.0, np.where(ball.vertices[:, 2] < -0.97, 1.9, 1.0))
    drawn = ball.with_vertices(ball.vertices * np.stack([np.ones_like(stretch)] * 2 + [stretch], axis=1))
    at_center = path_in(drawn, [[-0.01, 0, 0], [0.01, 0, 0]], radius=1.0)
    limbs = uncovered(ball_distances(at_center, drawn), ((1.75, 1.5), (1.25, 1.0)))
    assert drawn.vertices[limbs.ends, 2] == pytest.approx([4.0, -1.9])
    assert limbs.min_reaches.tolist() == [1.75, 1.25]
    for limb, side in ((0, 1), (1, -1)):
        assert set(np.sign(drawn.vertices[limbs.limb_of_vertex == limb, 2])) == {side}


def test_a_limb_of_a_missed_end_is_the_first_and_is_not_found_again():
    ball = sphere(4)
    stretch = np.where(ball.vertices[:, 2] > 0.95, 4.0, np.where(ball.vertices[:, 2] < -0.97, 3.0, 1.0))
    drawn = ball.with_vertices(ball.vertices * np.stack([np.ones_like(stretch)] * 2 + [stretch], axis=1))
    at_center = path_in(drawn, [[-0.01, 0, 0], [0.01, 0, 0]], radius=1.0)
    top = drawn.vertices[:, 2] > 3
    ends = np.array([drawn.vertices[:, 2].argmax(), 0])
    known = GeodesicExtrema(ends, np.array([2.0, 1.0]), np.array([0.2, 0.1]), np.where(top, 0, -1))
    balls = ball_distances(at_center, drawn)
    limbs = find_limbs(balls, BOUNDS, known.take(np.array([True, False])))
    assert limbs.ends.tolist() == [ends[0], drawn.vertices[:, 2].argmin()]
    assert limbs.min_reaches.tolist() == [0.0, 1.75]
    assert np.array_equal(limbs.limb_of_vertex == 0, top)
    none = known.take(np.zeros(2, dtype=bool))
    assert len(none.vertices) == 0
    assert (none.limb_of_vertex == -1).all()
    assert len(find_limbs(balls, BOUNDS, none).ends) == 2


def test_a_vertex_that_noise_has_moved_is_no_limb_and_a_long_one_is():
    """A spike on one vertex is as high as the noise of its long edges; a cone over many vertices is far higher."""
    ball, bounds = sphere(4), ((1.1, 1.5),)
    top = np.argmax(ball.vertices[:, 2])
    spiked = ball.vertices * np.where(np.arange(len(ball.vertices)) == top, 1.3, 1.0)[:, None]
    coned = ball.vertices * np.where(ball.vertices[:, 2:] > 0.95, [1, 1, 2], 1)
    for vertices, on_smooth, on_noisy in ((spiked, 1, 0), (coned, 1, 1)):
        for noise, n_limbs in ((0.0, on_smooth), (0.2, on_noisy)):
            mesh = with_local_noise(ball.with_vertices(vertices), noise)
            at_center = path_in(mesh, [[-0.01, 0, 0], [0.01, 0, 0]], radius=1.0)
            assert len(uncovered(ball_distances(at_center, mesh), bounds).ends) == n_limbs


def test_vertices_of_no_face_are_no_limb():
    ball = sphere(2)
    stray = Mesh(np.concatenate([ball.vertices, [[9.0, 0, 0]]]), ball.faces)
    at_center = path_in(stray, [[-0.01, 0, 0], [0.01, 0, 0]], radius=1.0)
    assert len(uncovered(ball_distances(at_center, stray), BOUNDS).ends) == 0


def test_a_thin_branch_across_a_gap_does_not_uncover_what_the_own_ball_covers():
    """The cone of a ball points at a rod, which is nearer than the center of the ball."""
    ball, rod = sphere(3), capsule(2.0, 0.05, n=8)
    drawn = ball.vertices * np.where(ball.vertices[:, 2:] > 0.95, [1, 1, 1.6], 1)
    mesh = Mesh(
        np.concatenate([drawn, rod.vertices[:, [2, 1, 0]] + [0, 0, 1.9]]),
        np.concatenate([ball.faces, rod.faces[:, ::-1] + len(drawn)]),
    )
    skeleton = path_in(mesh, [[-0.01, 0, 0], [0.01, 0, 0], *([x, 0, 1.9] for x in np.linspace(-1, 1, 41))])
    skeleton = replace(skeleton, edges=np.delete(skeleton.edges, 1, axis=0), radii=np.repeat([1.0, 0.05], [2, 41]))
    in_ball = np.arange(len(mesh.vertices)) < len(drawn)
    assert len(uncovered(ball_distances(skeleton, mesh), BOUNDS).ends) == 1
    own = replace(skeleton, node_of_vertex=np.where(in_ball, 0, skeleton.node_of_vertex))
    assert len(uncovered(ball_distances(own, mesh), BOUNDS).ends) == 0
