"""Distances to a known skeleton: zero for the same, in local radii for a shift, one-sided where one is longer."""

import numpy as np
import pytest

from lbskel import MeshError, Skeleton, ground_truth_distances
from lbskel.skeleton.edge_sampling import sample_edges


def line(z0, z1, x=0.0, radius=0.5):
    return Skeleton(np.array([[x, 0, z0], [x, 0, z1]]), [[0, 1]], np.full(2, radius))


def test_the_same_skeleton_is_at_no_distance():
    distances = ground_truth_distances(line(0, 2), line(0, 2))
    rounding = 1e-15  # of coordinates up to 2
    assert distances.accuracy < rounding
    assert distances.coverage < rounding
    assert abs(distances.length_error) < rounding
    assert distances.is_topology_right
    assert (distances.n_tips, distances.n_true_tips) == (2, 2)


def test_a_shift_is_measured_in_radii():
    distances = ground_truth_distances(line(0, 2, x=0.1), line(0, 2))
    for value in (distances.accuracy, distances.accuracy_95, distances.coverage, distances.coverage_95):
        assert value == pytest.approx(0.1 / 0.5, rel=1e-12)


def test_the_unit_is_the_local_radius():
    z = np.linspace(0, 2, 81)
    edges = np.stack([np.arange(80), np.arange(1, 81)], axis=1)
    nodes = np.stack([0 * z, 0 * z, z], axis=1)
    cone = Skeleton(nodes, edges, 0.1 + 0.4 * z)
    distances = ground_truth_distances(Skeleton(nodes + [0.05, 0, 0], edges, np.zeros(81)), cone)
    mean = (
        0.05 * np.log(0.9 / 0.1) / 0.8
    )  # of 0.05 / (0.1 + 0.4 z) over z from 0 to 2; 0.05 over the mean radius is 0.1
    worst = 0.05 / (0.1 + 0.8 * 0.05)  # a twentieth of the length has smaller radii
    assert mean > 1.3 * 0.05 / 0.5  # in mean radii it would be less
    assert (distances.accuracy, distances.coverage) == pytest.approx((mean, mean), rel=1e-3)
    assert (distances.accuracy_95, distances.coverage_95) == pytest.approx((worst, worst), rel=1e-2)


def test_distances_are_to_segments_however_long_they_are():
    """A zigzag around a long thin axis: its distance runs evenly from 0 to 0.3 radii, below the spacing."""
    radius, n = 1e-3, 31_000  # samples are 1.55 edges apart, so that they fall on all phases
    x = np.arange(n + 1) * 5 * radius
    y = 0.3 * radius * (np.arange(n + 1) % 2)
    zigzag = Skeleton(
        np.stack([x, y, 0 * x], axis=1), np.stack([np.arange(n), np.arange(1, n + 1)], 1), np.zeros(n + 1)
    )
    axis = Skeleton(np.array([[0, 0, 0], [x[-1], 0, 0]]), [[0, 1]], np.full(2, radius))
    distances = ground_truth_distances(zigzag, axis)
    assert x[-1] / 20_000 > 5 * radius
    assert distances.accuracy == pytest.approx(0.15, rel=0.02)  # at the midpoints of its edges
    # over the axis the distance to the zigzag is that to a line of slope 0.06, by a cosine
    assert distances.coverage == pytest.approx(0.15 / np.hypot(1, 0.06), rel=0.02)
    assert distances.length_error == pytest.approx(np.hypot(1, 0.06) - 1, rel=1e-9)


def test_radii_are_compared_away_from_the_ends():
    z = np.linspace(0, 8, 81)
    nodes, edges = np.stack([0 * z, 0 * z, z], axis=1), np.stack([np.arange(80), np.arange(1, 81)], axis=1)
    radii = np.where(np.abs(z - 4) > 2.6, 9.0, 0.55)  # wrong near the ends, and a tenth too thick elsewhere
    measured = Skeleton(nodes, edges, radii)
    assert ground_truth_distances(measured, line(0, 8)).radius_error == pytest.approx(0.1)
    assert (
        ground_truth_distances(measured, line(0, 8, radius=0.4)).radius_error > 0.375
    )  # 1.2 from the ends is included
    assert np.isnan(ground_truth_distances(line(0, 8, radius=np.nan), line(0, 8)).radius_error)
    assert np.isnan(ground_truth_distances(line(0, 2), line(0, 2)).radius_error)  # no part is far from the ends


def test_what_is_missing_counts_for_coverage_alone():
    distances = ground_truth_distances(line(0, 1), line(0, 2))
    assert distances.accuracy < 1e-3
    # half the axis is missing, its distances run evenly from 0 to 1: a mean of 1/4 over the whole, in radii of 1/2
    assert distances.coverage == pytest.approx(0.25 / 0.5, rel=0.01)
    assert distances.coverage_95 == pytest.approx(0.9 / 0.5, rel=0.01)


def test_another_topology_is_seen():
    ring = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    loop = Skeleton(ring, [[0, 1], [1, 2], [0, 2]], np.full(3, 0.1))
    open_loop = Skeleton(ring, [[0, 1], [1, 2]], np.full(3, 0.1))
    assert not ground_truth_distances(open_loop, loop).is_topology_right


def test_components_are_counted():
    nodes = np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 1.1], [0, 0, 2]])
    whole = Skeleton(nodes, [[0, 1], [1, 2], [2, 3]], np.full(4, 0.1))
    broken = Skeleton(nodes, [[0, 1], [2, 3]], np.full(4, 0.1))
    assert ground_truth_distances(whole, whole).is_topology_right
    assert not ground_truth_distances(broken, whole).is_topology_right
    assert ground_truth_distances(broken, whole).n_tips == 4


def test_samples_lie_on_the_edges_no_further_apart_than_asked():
    points, radii = sample_edges(line(0, 1, radius=0.3), 0.3)
    assert np.allclose(np.diff(points[:, 2]), 0.25)
    assert np.allclose(radii, 0.3)
    alone = Skeleton(np.zeros((1, 3)), np.empty((0, 2)), np.ones(1))
    assert len(sample_edges(alone, 0.1)[0]) == 1


def test_a_skeleton_in_other_units_is_measured_with_a_bounded_number_of_samples():
    distances = ground_truth_distances(line(0, 2e9), line(0, 2))
    assert distances.length_error == pytest.approx(1e9)
    assert distances.accuracy == pytest.approx(1e9 / 0.5)


@pytest.mark.parametrize("radius", [0.0, np.nan, -1.0])
def test_a_truth_without_radii_is_refused(radius):
    with pytest.raises(MeshError, match="the true skeleton needs a positive radius at every node"):
        ground_truth_distances(line(0, 1), Skeleton([[0, 0, 0], [0, 0, 1]], [[0, 1]], [1.0, radius]))


def test_a_skeleton_without_nodes_is_refused():
    with pytest.raises(MeshError, match="the skeleton to measure has no nodes"):
        ground_truth_distances(Skeleton(np.empty((0, 3)), [], []), line(0, 1))


def test_a_node_without_an_edge_counts_for_coverage_and_topology():
    with_point = Skeleton([[0, 0, 0], [0, 0, 1], [0, 0, 2]], [[0, 1]], np.ones(3))
    distances = ground_truth_distances(with_point, line(0, 2))
    assert (distances.accuracy < 1e-12, distances.is_topology_right) == (True, False)
    assert distances.coverage == pytest.approx(0.125 / 0.5, rel=0.01)  # half of the distance of a half to the point


@pytest.mark.parametrize("edges", [[], [[0, 1]]])
def test_a_truth_without_length_is_refused(edges):
    with pytest.raises(MeshError, match="the true skeleton has no length"):
        ground_truth_distances(line(0, 1), Skeleton(np.zeros((2, 3)), edges, [1.0, 1.0]))
