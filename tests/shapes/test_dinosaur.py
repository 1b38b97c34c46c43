"""The dinosaur: tips, mirror symmetry, and curves through their control points."""

from itertools import pairwise

import numpy as np

from lbskel.shapes.dinosaur import FORE_LEG, HIND_LEG, HIPS, N_STEPS, SHOULDERS, SPINE, dinosaur


def test_it_has_six_tips_where_the_tables_end():
    truth = dinosaur().truth
    assert (truth.genus, truth.n_tips, len(truth.junctions), truth.n_components) == (0, 6, 2, 1)
    expected = [[SPINE[row][0], 0.0, SPINE[row][1]] for row in (0, -1)]
    for root, leg in ((HIPS, HIND_LEG), (SHOULDERS, FORE_LEG)):
        x, y, z, _ = leg[-1]
        expected += [[SPINE[root][0] + x, side * y, SPINE[root][1] + z] for side in (1, -1)]
    tips = truth.nodes[truth.tips]
    assert np.abs(np.sort(tips, axis=0) - np.sort(expected, axis=0)).max() < 1e-9


def test_left_and_right_are_mirror_images():
    nodes = dinosaur().truth.nodes
    mirrored = nodes * [1, -1, 1]
    assert np.linalg.norm(mirrored[:, None] - nodes, axis=2).min(axis=1).max() < 1e-9


def test_the_spine_passes_through_its_control_points_with_radii_between_theirs():
    solid = dinosaur()
    for (x0, z0, r0), (x1, _, r1) in pairwise(SPINE):
        distances = np.linalg.norm(solid.centers - [x0, 0, z0], axis=1)
        assert distances.min() < 1e-9
        spine = (np.abs(solid.centers[:, 1]) < 1e-9) & (solid.centers[:, 0] > x0) & (solid.centers[:, 0] < x1)
        row = solid.segments[:, 0]
        between = spine[row] & (solid.branch_of_segment == solid.branch_of_segment[0])
        assert between.sum() >= N_STEPS - 1
        assert solid.radii[between, 0].min() >= min(r0, r1) - 1e-12
        assert solid.radii[between, 0].max() <= max(r0, r1) + 1e-12
