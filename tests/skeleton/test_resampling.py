"""Resampling: evenly spaced nodes on the same graph, and where the vertices go."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from helpers import star_skeleton, theta_skeleton

from lbskel import (
    Skeleton,
    UnknownChoice,
    branch_table,
    join_components,
    merge_junctions,
    open_short_loops,
    resample,
    simplify_branches,
)
from lbskel.skeleton.resampling import space_evenly


@pytest.mark.parametrize("spacing", [0.01, 0.3, 1.0, 9.0, 10.0])
def test_resampling_keeps_the_graph(spacing):
    thick = replace(theta_skeleton((1, 2, 3)), radii=np.full(5, 2.0))  # ten radii are longer than every path
    for skeleton in (theta_skeleton(), theta_skeleton((1, 2, 3)), thick, star_skeleton([3, 3, 2, 2])[0]):
        resampled = resample(skeleton, spacing=spacing)
        assert resampled.cycle_rank == skeleton.cycle_rank
        assert len(resampled.tips) == len(skeleton.tips)
        assert np.array_equal(resampled.nodes[: len(skeleton.junctions)], skeleton.nodes[: len(skeleton.junctions)])
        assert resampled.node_of_vertex.shape == skeleton.node_of_vertex.shape


def test_resampling_spaces_evenly_and_maps_to_the_nearest():
    line = np.array([[0.0, 0, 0], [0.1, 0, 0], [3, 0, 0], [4, 0, 0]])
    skeleton = Skeleton(line, [[0, 1], [1, 2], [2, 3]], np.full(4, 1.0), [0, 1, 2, 3])
    resampled = resample(skeleton, spacing=0.5)
    assert len(resampled.edges) == 8
    assert np.ptp(resampled.edge_lengths) < 1e-12
    assert np.allclose(resampled.nodes[resampled.node_of_vertex][:, 0], [0, 0, 3, 4])


def test_a_bare_loop_stays_a_loop():
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    skeleton = Skeleton(
        ring, np.stack([np.arange(12), (np.arange(12) + 1) % 12], axis=1), np.full(12, 50.0), np.arange(12)
    )
    assert resample(skeleton, spacing=1.0).cycle_rank == 1


def test_new_nodes_lie_on_the_curve_through_the_old_ones():
    """Chords of 24 nodes to the circle are off by 1 - cos(pi / 24), 0.0086, in their middle."""
    angle = np.linspace(0, 1.5 * np.pi, 19)
    arc = Skeleton(
        np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1),
        [*itertools.pairwise(range(19))],
        np.full(19, 0.3),
        np.arange(19),
    )
    inner = np.linalg.norm(resample(arc, n_nodes=14).nodes, axis=1)
    assert np.abs(inner - 1).max() < 0.001


def test_a_corner_stays_a_corner_between_new_nodes():
    """The curve overshoots next to a corner only, by less than a tenth of the distance between nodes."""
    nodes = [[x, 0, 0] for x in range(6)] + [[5, y, 0] for y in range(1, 6)]
    bent = Skeleton(nodes, [*itertools.pairwise(range(11))], np.ones(11), np.arange(11))
    x, y, _ = resample(bent, n_nodes=24).nodes.T
    off = np.minimum(np.abs(y), np.abs(x - 5))
    assert off.max() < 0.1
    assert off[(x < 3.9) | (y > 1.1)].max() < 1e-12


def test_short_pieces_beside_long_ones_make_no_overshoot():
    """A zigzag of a tenth of the long pieces between them: differences of slopes would reach far beyond it."""
    x = np.array([0, 5, 10, 10.1, 10.2, 15, 20])
    y = np.array([0, 0, 0, 0.1, 0, 0, 0])
    bent = Skeleton(np.stack([x, y, 0 * x], axis=1), [*itertools.pairwise(range(7))], np.ones(7))
    after = resample(bent, n_nodes=200).nodes
    # a tangent of slope 1 at most, over the length of the short pieces
    assert after[:, 1].min() > -0.05
    assert after[:, 1].max() < 0.15


def test_several_paths_are_divided_each_for_itself():
    """Three arms of a star with curved arms, resampled at once and one at a time."""
    t = np.linspace(0, 1, 9)[1:]
    arms = [np.stack([np.cos(a) * t, np.sin(a) * t, t**2 * (1 + k)], axis=1) for k, a in enumerate((0.0, 2.0, 4.0))]
    nodes = np.concatenate([np.zeros((1, 3)), *arms])
    chains = [[0, *range(1 + 8 * k, 9 + 8 * k)] for k in range(3)]
    star = Skeleton(nodes, [pair for chain in chains for pair in itertools.pairwise(chain)], np.full(25, 0.3))
    together = resample(star, spacing=0.4).nodes
    for chain in chains:
        alone = Skeleton(nodes[chain], [*itertools.pairwise(range(9))], np.full(9, 0.3))
        single = resample(alone, spacing=0.4).nodes
        assert len(single) > 5
        assert np.linalg.norm(together[:, None] - single, axis=2).min(axis=0).max() < 1e-12


def test_a_path_with_a_piece_of_no_length_is_divided_on_its_chords():
    x = np.array([0, 1, 1, 2, 3.0])
    line = Skeleton(np.stack([x, x**2, 0 * x], axis=1), [*itertools.pairwise(range(5))], np.ones(5))
    after = resample(line, n_nodes=30).nodes
    # between (0, 0) and (1, 1) the chord is y = x
    first = after[after[:, 0] < 1]
    assert first[:, 1] == pytest.approx(first[:, 0])


def test_a_spacing_must_be_positive():
    with pytest.raises(UnknownChoice, match="positive"):
        resample(theta_skeleton(), spacing=0.0)


def test_a_spacing_meant_as_a_length_is_refused():
    """The paths are 40 radii of 0.1 long and more; 100 radii would leave nothing between the junctions."""
    with pytest.raises(
        UnknownChoice, match=r"spacing is in local radii, and 100 .* give d / 0\.1, which is its median"
    ):
        resample(theta_skeleton(), spacing=100)
    chords = theta_skeleton((1, 2, 2))  # already as few pieces as keep the cycles
    assert len(resample(chords, spacing=1e9).nodes) == len(chords.nodes)


@pytest.mark.parametrize("n_nodes", [9.5, "9", [9]])
def test_a_number_of_nodes_that_is_no_whole_number_is_refused(n_nodes):
    with pytest.raises(UnknownChoice, match="n_nodes must be a whole number"):
        resample(theta_skeleton(), n_nodes=n_nodes)


def test_resampling_keeps_anchors_and_makes_as_many_nodes_as_asked():
    loop = Skeleton(
        [[np.cos(a), np.sin(a), 0] for a in 2 * np.pi * np.arange(12) / 12],
        [[k, (k + 1) % 12] for k in range(12)],
        np.full(12, 0.2),
        np.arange(12),
        mean_radii=np.full(12, 0.3),
        anchors=[5],
    )
    for n in (3, 4, 7, 50):
        even = resample(loop, n_nodes=n)
        assert (len(even.nodes), even.cycle_rank, even.n_components) == (n, 1, 1)
        assert np.array_equal(even.nodes[even.anchors], loop.nodes[[5]])
        assert even.mean_radii == pytest.approx(0.3)
    with pytest.raises(UnknownChoice, match="at least 3"):
        resample(loop, n_nodes=2)
    with pytest.raises(UnknownChoice, match="either spacing or n_nodes"):
        resample(loop)


@pytest.mark.parametrize(("radius", "n_edges"), [(0.5, 16), (1.0, 8), (2.0, 4)])
def test_the_spacing_is_in_median_radii_of_the_branch(radius, n_edges):
    line = Skeleton(np.linspace([0, 0, 0], [4, 0, 0], 9), [*itertools.pairwise(range(9))], [*[radius] * 8, 99])
    assert len(resample(line, spacing=0.5).edges) == n_edges


def test_refinement_divides_no_edge_into_more_than_three_pieces():
    """Where a flat part has a radius near zero."""
    line = Skeleton([[0, 0, 0], [4, 0, 0], [8, 0, 0]], [[0, 1], [1, 2]], np.full(3, 1e-9))
    spaced = space_evenly(line, 0.5, lambda olds, news: np.zeros(len(olds), dtype=bool))
    assert len(spaced.edges) == 6


@pytest.mark.parametrize(("spacing", "n_edges"), [(0.5, 200), (5.0, 20), (20.0, 5)])
def test_a_single_edge_is_divided_as_often_as_the_spacing_asks_for(spacing, n_edges):
    line = Skeleton([[0, 0, 0], [100, 0, 0]], [[0, 1]], [1.0, 1.0])
    once = resample(line, spacing=spacing)
    assert len(once.edges) == n_edges
    assert np.allclose(resample(once, spacing=spacing).nodes, once.nodes)


def test_a_branch_without_thickness_keeps_its_number_of_nodes():
    """As that of a sheet beside a tube."""
    nodes = [[0, 0, 0], [1, 0, 0], [4, 0, 0], [0, 9, 0], [4, 9, 0]]
    skeleton = Skeleton(nodes, [[0, 1], [1, 2], [3, 4]], [0, 0, 0, 1, 1])
    resampled = resample(skeleton, spacing=0.5)
    counts = np.bincount(resampled.component_of_node)
    assert sorted(counts.tolist()) == [3, 9]


def test_a_spacing_that_would_make_too_many_nodes_is_refused():
    line = Skeleton([[0, 0, 0], [4, 0, 0], [8, 0, 0]], [[0, 1], [1, 2]], np.full(3, 1e-300))
    with pytest.raises(UnknownChoice, match="more than 10,000,000 nodes; give n_nodes"):
        resample(line, spacing=0.5)


def test_a_skeleton_without_branches_has_no_other_number_of_nodes():
    points = Skeleton([[0, 0, 0], [1, 0, 0]], [], [1.0, 1.0])
    assert len(resample(points, n_nodes=2).nodes) == 2
    with pytest.raises(UnknownChoice, match="n_nodes must be 2 for a skeleton without branches"):
        resample(points, n_nodes=5)


def test_a_path_that_must_stay_gets_nodes_on_its_chords_alone():
    """Of a stem and two limbs, one of a hundred nodes, the other of one node at a corner, neither limb may change."""
    steps = np.linspace(0, 4, 101)[1:]
    stem, up = np.array([[0.0, 0, 0], [1, 0, 0]]), np.stack([steps * 0 + 1, steps, steps * 0], axis=1)
    bent = np.array([[1.0, -2, 0], [3, -2, 0]])
    edges = [[0, 1], [1, 2], [1, 102], [102, 103], *([k, k + 1] for k in range(2, 101))]
    nodes = np.concatenate([stem, up, bent])
    star = Skeleton(nodes, edges, np.ones(104), mean_radii=np.ones(104))
    spaced = space_evenly(star, 0.5, lambda olds, news: np.array([len(old) > 2 for old in olds]))
    assert np.array_equal(spaced.nodes[spaced.nodes[:, 1] > 0], up[np.r_[99, :99]])
    [branch] = [branch for branch in spaced.branches if spaced.nodes[branch, 1].min() < 0]
    along = spaced.nodes[branch] if spaced.nodes[branch[0], 1] == 0 else spaced.nodes[branch[::-1]]
    thirds = 2 / 3 * np.arange(4)  # at most three pieces in the place of one
    assert np.allclose(along, [[1, -y, 0] for y in thirds] + [[1 + x, -2, 0] for x in thirds[1:]])
    assert np.allclose(spaced.mean_radii, 1.0)


def test_paths_that_may_change_are_spaced_as_by_resampling():
    star = theta_skeleton()
    spaced = space_evenly(star, 5.0, lambda olds, news: np.zeros(len(olds), dtype=bool))
    assert np.array_equal(spaced.nodes, resample(star, spacing=5.0).nodes)


def test_a_spacing_in_unknown_radii_is_refused():
    nodes = np.stack([np.arange(20.0), np.zeros(20), np.zeros(20)], axis=1)
    path = Skeleton(nodes, [[k, k + 1] for k in range(19)], np.full(20, np.nan))
    with pytest.raises(UnknownChoice, match="give n_nodes"):
        resample(path, spacing=0.5)
    assert len(resample(path, n_nodes=10).nodes) == 10


def test_a_ring_is_as_round_at_its_first_node_as_elsewhere():
    angles = np.linspace(0, 2 * np.pi, 9)[:-1]
    nodes = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    octagon = Skeleton(nodes, [[k, (k + 1) % 8] for k in range(8)], np.ones(8))
    around = resample(octagon, n_nodes=64).nodes
    assert np.abs(np.linalg.norm(around, axis=1) - 1).max() < 0.009  # 0.0085 between all nodes of the octagon


def test_the_node_at_the_junction_of_a_loop_has_no_tangent_across_it():
    tail = Skeleton(
        [[0, 0, 0], [1, 1, 0], [2, 0, 0], [1, -1, 0], [-1, 0, 0]],
        [[0, 1], [1, 2], [2, 3], [0, 3], [0, 4]],
        np.ones(5),
    )
    even = resample(tail, n_nodes=60)
    assert even.nodes[:, 0].min() == -1
    assert (np.abs(even.nodes[even.nodes[:, 0] < 0, 1]) < 1e-12).all()  # the curve does not swing past the junction


@pytest.mark.parametrize("wrong", ["0.5", None, True, 1j])
@pytest.mark.parametrize(
    ("edit", "name"),
    [
        (lambda s, x: resample(s, spacing="none" if x is None else x), "spacing"),
        (lambda s, x: resample(s, n_nodes="none" if x is None else x), "n_nodes"),
        (lambda s, x: simplify_branches(s, tolerance=x), "tolerance"),
        (lambda s, x: join_components(s, reach="none" if x is None else x), "reach"),
        (lambda s, x: join_components(s, max_angle="none" if x is None else x), "max_angle"),
        (lambda s, x: open_short_loops(s, x), "min_loop"),
        (lambda s, x: merge_junctions(s, ratio=x), "ratio"),
        (lambda s, x: branch_table(s, scale=x), "scale"),
    ],
)
def test_what_is_no_number_is_refused(edit, name, wrong):
    with pytest.raises(UnknownChoice, match=f"{name} must be "):
        edit(theta_skeleton(), wrong)
