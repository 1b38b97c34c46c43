"""Centerlines: cross-sections that belong to one branch only."""

import itertools

import numpy as np
from helpers import STAR_RADIUS, graph_of_star

from lbskel import Skeleton
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.centerlines import _is_continuous, branch_of_node, find_section_centers


def test_sections_are_known_along_the_arms_and_not_where_they_meet(star):
    skeleton = graph_of_star(star, np.zeros(3))
    axes = find_section_centers(skeleton, Surface(star))
    distances = np.linalg.norm(skeleton.nodes, axis=1)
    assert axes.is_known[(distances > 0.4) & (skeleton.degrees == 2)].all()
    assert not axes.is_known[distances < 0.8 * STAR_RADIUS].any()
    assert np.array_equal(branch_of_node(skeleton) < 0, skeleton.degrees >= 3)


def test_sections_beyond_a_jump_in_size_or_position_are_rejected():
    """As for two fused fingers: most sections cut both and lie between them, so those next to the tip decide."""
    k = np.arange(12)
    nodes = np.concatenate([np.stack([k / 4, 0 * k, 0 * k], axis=1), [[-1, 0, 0], [0, 1, 0]]])
    skeleton = Skeleton(nodes, [*itertools.pairwise(k), (0, 12), (0, 13)], np.full(14, 0.3), np.zeros(1))
    is_own, even = skeleton.degrees == 2, np.full(14, 0.3)
    between, wide = np.array(nodes), np.where(k < 3, 0.5, 0.3)
    between[1:8, 1] = 0.3
    assert np.flatnonzero(_is_continuous(skeleton, is_own, even, nodes)).tolist() == [*range(1, 11)]
    assert np.flatnonzero(_is_continuous(skeleton, is_own, even, between)).tolist() == [8, 9, 10]
    assert np.flatnonzero(_is_continuous(skeleton, is_own, np.append(wide, [0, 0]), nodes)).tolist() == [*range(3, 11)]
