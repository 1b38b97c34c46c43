"""Many small bodies at once have the skeletons that each has alone."""

import numpy as np
import pytest
from helpers import is_whole, joined, moved

from lbskel import Skeleton, skeletonize
from lbskel.pipeline import grouping
from lbskel.shapes import capsule, sphere, torus


@pytest.fixture(autouse=True)
def few(monkeypatch):
    """Groups of small numbers."""
    monkeypatch.setattr(grouping, "MIN_BODIES", 6)
    monkeypatch.setattr(grouping, "MAX_VERTICES", 300)


@pytest.fixture
def calls(monkeypatch):
    """Numbers of vertices of the surfaces that were contracted."""
    sizes, skeletonize_body = [], grouping.skeletonize_bodies

    def watched(bodies, of_body):
        return skeletonize_body(bodies, lambda body: sizes.append(body.mesh.n_components) or of_body(body))

    monkeypatch.setattr("lbskel.pipeline.stages.skeletonize_bodies", watched)
    return sizes


def test_rods_in_groups_have_the_skeletons_that_they_have_alone(calls):
    rods = [capsule(2.0 + 0.1 * number, 0.3, 10) for number in range(8)]
    mesh = joined(*(moved(rod, 3.0 * number) for number, rod in enumerate(rods)))
    skeleton = skeletonize(mesh, preprocess=None)
    assert is_whole(skeleton, mesh)
    assert (len(calls), sum(calls)) == (5, 8)
    assert (skeleton.n_components, skeleton.cycle_rank, len(skeleton.tips)) == (8, 0, 16)
    parts = skeleton.report["components"]
    assert sorted(part["vertices"] for part in parts) == sorted(len(rod.vertices) for rod in rods)
    assert [(part["tips"], part["cycle_rank"], part["genus"]) for part in parts] == [(2, 0, 0)] * 8
    first = np.cumsum([0, *(len(rod.vertices) for rod in rods)])
    for number, rod in enumerate(rods):
        alone = skeletonize(rod, preprocess=None)
        nodes = skeleton.nodes[np.unique(skeleton.node_of_vertex[first[number] : first[number + 1]])]
        offset = nodes - [3.0 * number, 0, 0]
        distances = np.linalg.norm(offset[:, None] - alone.nodes, axis=2).min(axis=1)
        assert distances.max() < 0.3 * rod.diameter_bound  # within a radius of the rod


def test_handles_nested_and_large_bodies_are_treated_alone(calls, monkeypatch):
    monkeypatch.setattr(grouping, "MAX_FACES", 400)
    balls = [moved(sphere(1), 3.0 * number) for number in range(6)]
    inner = moved(sphere(1).with_vertices(0.5 * sphere(1).vertices), 0.0)
    large, ring = moved(sphere(3), -4.0), moved(torus(1.0, 0.3, 12, 8), -9.0)
    skeleton = skeletonize(joined(*balls, inner, large, ring), preprocess=None)
    assert sorted(calls) == [1, 1, 1, 6]
    assert (skeleton.n_components, skeleton.cycle_rank) == (9, 1)


def test_a_body_whose_part_of_the_group_is_no_tree_of_its_own_is_done_again(calls, monkeypatch):
    parts = grouping._parts
    monkeypatch.setattr(grouping, "_parts", lambda whole, sizes: [None, *parts(whole, sizes)[1:]])
    mesh = joined(*(moved(sphere(1), 3.0 * number) for number in range(6)))
    skeleton = skeletonize(mesh, preprocess=None)
    assert calls == [6, 1]
    assert skeleton.n_components == 6


def test_parts_are_trees_of_one_body():
    """Of four bodies, two share a graph, one has a cycle, and one is a tree alone."""
    nodes = np.arange(8)[:, None] * np.array([1.0, 0, 0])
    edges = [[0, 1], [2, 3], [3, 4], [4, 2], [6, 5], [7, 6]]
    whole = Skeleton(nodes, edges, np.arange(8.0), [0, 1, 2, 3, 1, 7, 5], mean_radii=np.arange(8.0))
    first, cycle, shared, alone = grouping._parts(whole, np.array([2, 2, 1, 2]))
    assert (first, cycle, shared) == (None, None, None)
    assert alone.nodes.tolist() == nodes[5:].tolist()
    assert alone.edges.tolist() == [[0, 1], [1, 2]]
    assert alone.radii.tolist() == [5, 6, 7]
    assert alone.node_of_vertex.tolist() == [2, 0]


def test_few_bodies_are_treated_one_by_one(calls):
    skeletonize(joined(*(moved(sphere(1), 3.0 * number) for number in range(5))), preprocess=None)
    assert calls == [1] * 5
