"""Pruning, merging, resampling: what stays, where the vertices go, and that no cycle is ever lost."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from lbskel import Mesh, Skeleton, UnknownChoice, merge_junctions, prune, resample
from lbskel.skeleton.pruning import prune_contained_branches


def star(lengths, radius=0.5):
    """A junction at the origin with arms along different directions, a node each 0.25, and a vertex at each node."""
    directions = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
    nodes, edges = [np.zeros(3)], []
    for direction, length in zip(directions, lengths, strict=False):
        last = 0
        for s in np.arange(0.25, length + 1e-9, 0.25):
            nodes.append(direction * s)
            edges.append((last, len(nodes) - 1))
            last = len(nodes) - 1
    nodes = np.array(nodes)
    mesh = Mesh(nodes, [[0, 1, 2]])
    return Skeleton(nodes, np.array(edges), np.full(len(nodes), radius), np.arange(len(nodes))), mesh


def theta(lengths=(4, 4, 4)):
    """Two junctions joined by three paths of so many edges."""
    nodes, edges = [[0.0, 0, 0], [4.0, 0, 0]], []
    for number, n in enumerate(lengths):
        chain = [0]
        for k in range(1, n):
            nodes.append([4 * k / n, np.sin(np.pi * k / n) * (number - 1), 0.1 * number])
            chain.append(len(nodes) - 1)
        chain.append(1)
        edges += itertools.pairwise(chain)
    nodes = np.array(nodes)
    return Skeleton(nodes, np.array(edges), np.full(len(nodes), 0.1), np.arange(len(nodes)))


def test_a_spur_goes_and_a_limb_stays():
    skeleton, mesh = star([3, 3, 0.5, 2])
    pruned = prune(skeleton, mesh, min_branch_ratio=1.5)
    assert len(pruned.tips) == 3
    assert pruned.nodes[:, 1].max() == 0
    assert pruned.nodes[:, 1].min() == -2
    # the spur's vertices go to the junction
    spur = np.flatnonzero(skeleton.nodes[:, 1] > 0)
    assert np.array_equal(pruned.nodes[pruned.node_of_vertex[spur]], np.zeros((len(spur), 3)))


def test_the_ratio_is_in_radii_of_the_junction():
    for radius, n_tips in ((0.3, 4), (0.7, 3)):
        skeleton, mesh = star([3, 3, 0.75, 2], radius)
        assert len(prune(skeleton, mesh, min_branch_ratio=1.5).tips) == n_tips


def test_pruning_never_cuts_a_cycle():
    skeleton = theta()
    mesh = Mesh(skeleton.nodes, [[0, 1, 2]])
    assert prune(skeleton, mesh, min_branch_ratio=1e9).cycle_rank == 2


def test_near_junctions_become_one():
    nodes = np.array([[0.0, 0, 0], [0.3, 0, 0], [-1, 1, 0], [-1, -1, 0], [1.3, 1, 0], [1.3, -1, 0]])
    skeleton = Skeleton(
        nodes, [[0, 1], [0, 2], [0, 3], [1, 4], [1, 5]], np.array([0.5, 0.4, 0.1, 0.1, 0.1, 0.1]), [0, 1]
    )
    merged = merge_junctions(skeleton, ratio=1.0)
    assert len(merged.junctions) == 1
    assert np.array_equal(merged.nodes[merged.junctions[0]], [0, 0, 0])
    assert len(set(merged.node_of_vertex)) == 1
    assert len(merge_junctions(skeleton, ratio=0.5).junctions) == 2


@pytest.mark.parametrize("lengths", [(1, 2, 3), (1, 4, 4), (2, 2, 2), (1, 3, 2)])
def test_merging_keeps_the_cycles(lengths):
    assert merge_junctions(theta(lengths), ratio=1e9).cycle_rank == 2


@pytest.mark.parametrize("spacing", [0.01, 0.3, 1.0, 9.0, 10.0])
def test_resampling_keeps_the_graph(spacing):
    thick = replace(theta((1, 2, 3)), radii=np.full(5, 2.0))  # ten radii are longer than every path
    for skeleton in (theta(), theta((1, 2, 3)), thick, star([3, 3, 2, 2])[0]):
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


def test_new_nodes_lie_on_the_bend_that_the_old_ones_follow():
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
    """The curve swings next to a corner only, by less than a tenth of the way between nodes."""
    nodes = [[x, 0, 0] for x in range(6)] + [[5, y, 0] for y in range(1, 6)]
    bent = Skeleton(nodes, [*itertools.pairwise(range(11))], np.ones(11), np.arange(11))
    x, y, _ = resample(bent, n_nodes=24).nodes.T
    off = np.minimum(np.abs(y), np.abs(x - 5))
    assert off.max() < 0.1
    assert off[(x < 3.9) | (y > 1.1)].max() < 1e-12


def test_a_spacing_must_be_positive():
    with pytest.raises(UnknownChoice, match="positive"):
        resample(theta(), spacing=0.0)


def test_a_spacing_meant_as_a_length_is_refused():
    """The paths are 40 radii of 0.1 long and more; 100 radii would leave nothing between the junctions."""
    with pytest.raises(
        UnknownChoice, match=r"spacing is in local radii, and 100 .* give d / 0\.1, which is its median"
    ):
        resample(theta(), spacing=100)
    chords = theta((1, 2, 2))  # already as few pieces as keep the cycles
    assert len(resample(chords, spacing=1e9).nodes) == len(chords.nodes)


@pytest.mark.parametrize("n_nodes", [9.5, "9", [9]])
def test_a_number_of_nodes_that_is_no_whole_number_is_refused(n_nodes):
    with pytest.raises(UnknownChoice, match="n_nodes must be a whole number"):
        resample(theta(), n_nodes=n_nodes)


@pytest.mark.parametrize(
    ("length", "radius", "reach", "is_cut"),
    [
        (0.4, 0.9, 1.7, True),
        (0.7, 1.0, 1.7, True),
        (0.9, 1.0, 1.7, False),  # its balls stand out
        (2.0, 0.5, 1.7, False),
        (0.7, 1.0, 1.8, False),  # what it stands for does
        (0.6, 1.0, 1.8, True),  # so it does, but the tip is nowhere near
    ],
)
def test_an_end_branch_that_hardly_stands_out_of_the_junction_is_cut(length, radius, reach, is_cut):
    nodes = [[0, 0, 0], [-3, 0, 0], [3, 0, 0], [0, length / 2, 0], [0, length, 0]]
    skeleton = Skeleton(nodes, [[0, 1], [0, 2], [0, 3], [3, 4]], [1, 1, 1, radius, radius], [0, 1, 2, 3, 4])
    mesh = Mesh([*nodes[:4], [0, reach, 0]], [[0, 1, 2], [2, 3, 4]])
    cut = prune_contained_branches(skeleton, mesh)
    assert len(cut.tips) == (2 if is_cut else 3)
    assert cut.node_of_vertex[4] == (0 if is_cut else 4)
    assert len(prune_contained_branches(replace(skeleton, anchors=[4]), mesh).tips) == 3


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


def test_of_three_junctions_in_a_ring_no_two_become_one():
    """They have no branch beside the one between them, but the way round by the third."""
    ring = np.array([[np.cos(angle), np.sin(angle), 0.0] for angle in 2 * np.pi * np.arange(3) / 3])
    edges = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 4], [2, 5]]
    tailed = Skeleton(np.concatenate([ring, 3 * ring]), np.array(edges), np.full(6, 5.0))
    merged = merge_junctions(tailed)
    assert (merged.cycle_rank, len(merged.nodes)) == (1, 6)
