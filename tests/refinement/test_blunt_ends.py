"""Blunt ends: branches shorter than their radius are removed, limbs and the ends of bodies are kept."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from helpers import mesh_of_branches, nearest_rows, slab, without_faces

from lbskel import Skeleton, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.blunt_ends import prune_blunt_ends
from lbskel.refinement.extrema import find_extrema
from lbskel.refinement.open_ends import NO_CUTS
from lbskel.shapes import make, mesh_solid, solid_of, sphere


def star(mesh, *ends):
    """A skeleton of straight branches in the plane z = 0 from the origin, each of four edges."""
    shares = np.linspace(0, 1, 5)[1:, None]
    nodes = np.concatenate([np.zeros((1, 3)), *(shares * [*end, 0] for end in ends)])
    edges = [[0 if k % 4 == 0 else k, k + 1] for k in range(len(nodes) - 1)]
    return Skeleton(nodes, edges, np.ones(len(nodes)), nearest_rows(mesh.vertices, nodes))


def pruned(skeleton, mesh, ratio=1.5, open_ends=NO_CUTS):
    return prune_blunt_ends(skeleton, Surface(mesh), min_branch_ratio=ratio, open_ends=open_ends)


def with_heel(first, second, heel=(-0.6, -0.3)):
    """Two limbs from the origin and a ball beside it, and a branch of their solid for each."""
    balls = [(np.array([[0, 0, 0], [*end, 0]]), radius) for end, radius in ((first, 0.6), (second, 0.6), (heel, 0.8))]
    mesh = mesh_solid(solid_of(balls), n_vertices=2000)
    return star(mesh, first, second, heel), mesh


@pytest.mark.parametrize(("aside", "n_tips"), [(0.8, 2), (1.8, 3)])
def test_a_fork_is_removed_where_its_branches_are_shorter_than_wide(aside, n_tips):
    """A bar of 2 by 4, whose corners have axes of 1 and 1.9, and surfaces at mean distances of 1.2 and 1.4."""
    mesh = slab(8.0, 4.0, 2.0)
    shape = star(mesh, (0.6, aside), (0.6, -aside), (-5.0, 0.0))
    nodes = shape.nodes + [2.0, 0, 0]
    forked = replace(shape, nodes=nodes, node_of_vertex=nearest_rows(mesh.vertices, nodes))
    skeleton = pruned(forked, mesh)
    assert len(skeleton.tips) == n_tips
    if n_tips == 2:  # and the limb goes on to its last ball
        end = skeleton.nodes[skeleton.nodes[:, 0].argmax()]
        assert end == pytest.approx([4 - 2 * 8 / 12, 0, 0])  # as far below the end as twice area over length
        assert (skeleton.node_of_vertex[mesh.vertices[:, 0] > 3.9] == skeleton.nodes[:, 0].argmax()).all()


@pytest.mark.parametrize(("second", "n_tips"), [((-2.0, 4.0), 2), ((2.0, 4.0), 3)])
def test_the_end_of_a_body_is_kept_where_its_limbs_leave_at_an_acute_angle(second, n_tips):
    """Without it, the one limb would turn back into the other."""
    skeleton, mesh = with_heel((4.0, 0.0), second)
    assert len(pruned(skeleton, mesh).tips) == n_tips


def test_a_short_branch_to_an_end_of_the_surface_is_kept(tripod):
    """Of a limb whose branch was contracted to its first edge."""
    truth = make("tripod").truth
    end = truth.end_branches[0]
    is_left = ~np.isin(np.arange(len(truth.nodes)), end[2:])
    edges = truth.edges[is_left[truth.edges].all(axis=1)]
    nodes, number = truth.nodes[is_left], np.cumsum(is_left) - 1
    nodes[number[end[1]]] = 0.8 * nodes[number[end[0]]] + 0.2 * truth.nodes[end[1]]
    skeleton = Skeleton(nodes, number[edges], truth.radii[is_left], nearest_rows(tripod.vertices, nodes))
    assert pruned(skeleton, tripod) is skeleton


def test_a_branch_to_a_cut_is_kept():
    skeleton, mesh = with_heel((4.0, 0.0), (-2.0, 4.0))
    cut = np.array([[-1.2, -0.6, 0.0, 0.8, 0.0, 0.0, 0.0]])
    assert pruned(skeleton, mesh, open_ends=cut) is skeleton


def test_of_branches_to_the_teeth_of_a_cut_one_is_kept():
    """A tube cropped by whole faces, whose axis forks before the cut to the two teeth that are its extrema there."""
    axis = np.array([0.878, 0.083, 0.471])
    whole = mesh_of_branches([([[0, 0, 0], 12 * axis], 1.0)], step=0.3)
    along = whole.vertices[whole.faces].mean(axis=1) @ axis
    tube = without_faces(whole, np.flatnonzero((along < 2) | (along > 10)))
    found = tube.vertices[find_extrema(tube).vertices]
    first, second, *_ = found[found @ axis > 9]
    fork = 9.4 * axis
    ends = [fork + 0.6 * (tooth - fork) for tooth in (first, second)]
    nodes = np.stack([*(z * axis for z in (2.5, 5.0, 7.5)), fork, *ends])
    edges = [[0, 1], [1, 2], [2, 3], [3, 4], [3, 5]]
    skeleton = Skeleton(nodes, edges, np.ones(6), nearest_rows(tube.vertices, nodes))
    cut = np.array([[*(10 * axis), 1.0, *(np.pi * axis)]])
    assert pruned(skeleton, tube) is skeleton
    assert len(pruned(skeleton, tube, open_ends=cut).tips) == 2


@pytest.mark.parametrize(("ratio", "n_tips"), [(3.0, 2), (1.5, 2), (0.5, 3), (0.0, 3)])
def test_whoever_asks_for_shorter_branches_gets_shorter_ends(ratio, n_tips):
    skeleton, mesh = with_heel((4.0, 0.0), (-2.0, 4.0))
    assert len(pruned(skeleton, mesh, ratio).tips) == n_tips


def test_two_of_the_branches_of_a_ball_are_kept():
    """The longest, though all are shorter than the ball's radius."""
    ball = sphere(3)
    skeleton = pruned(star(ball, (0.2, 0.0), (-0.1, 0.3), (-0.1, -0.35), (0.3, -0.2)), ball)
    assert len(skeleton.tips) == 2
    ends = skeleton.nodes[skeleton.tips]
    assert {tuple(end) for end in ends.round(9)} == {(-0.1, -0.35, 0.0), (0.3, -0.2, 0.0)}


def test_limbs_of_round_shapes_are_kept(tripod):
    truth = make("tripod").truth
    skeleton = Skeleton(truth.nodes, truth.edges, truth.radii, nearest_rows(tripod.vertices, truth.nodes))
    assert pruned(skeleton, tripod) is skeleton


def test_a_bar_of_twelve_faces_has_two_ends():
    """Each of its eight vertices had a branch."""
    corners = np.array(list(itertools.product([-1.0, 1.0], [-0.5, 0.5], [-1.1, 1.1])))
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    assert len(skeletonize((corners, faces)).tips) == 2
