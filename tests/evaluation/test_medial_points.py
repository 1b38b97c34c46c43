"""Distances to medial points: known values on tubes, ends that are cut off, and what is no end."""

from dataclasses import replace

import numpy as np
import pytest

from lbskel import Mesh, Skeleton, score
from lbskel.evaluation.medial_points import MedialDistances, _area_vectors, _n_parts, medial_distances
from lbskel.geometry.deadline import NEVER, Deadline, OutOfTime
from lbskel.shapes import capsule, make, with_local_noise
from lbskel.shapes.hard import HARD_SHAPES
from lbskel.skeleton.editing import contract_nodes


def measured(skeleton, mesh):
    found = score(skeleton, mesh, preprocess=None)
    return MedialDistances(found.medial_accuracy_95, found.medial_coverage_98, found.uncovered_parts)


def line(start, end, n=30):
    return Skeleton(np.linspace(start, end, n), np.stack([np.arange(n - 1), np.arange(1, n)], axis=1), np.ones(n))


def without_branch(skeleton, branch):
    target = np.arange(len(skeleton.nodes))
    target[branch[1:]] = branch[0]
    return contract_nodes(skeleton, target)


@pytest.fixture(scope="module")
def rod():
    """A rod of radius 1 with the axis from -6 to 6 along x."""
    mesh = capsule(12.0, 1.0)
    return Mesh(mesh.vertices[:, [2, 0, 1]], mesh.faces)


@pytest.fixture(scope="module")
def limbs():
    return make("limbs", n_vertices=1200)


def test_the_axis_of_a_rod_is_at_its_medial_points(rod):
    found = measured(line([-6, 0, 0], [6, 0, 0]), rod)
    assert found.accuracy_95 < 0.02
    assert found.coverage_98 < 0.15  # the points of the caps lie up to a chord of their faces off the axis
    assert found.uncovered_parts == 0


@pytest.mark.parametrize("aside", [0.3, 0.6])
def test_a_line_beside_the_axis_is_as_far_from_the_medial_points(rod, aside):
    found = measured(line([-6, aside, 0], [6, aside, 0]), rod)
    assert found.accuracy_95 == pytest.approx(aside, abs=0.03)
    assert found.coverage_98 == pytest.approx(aside, abs=0.1)


def test_distances_do_not_depend_on_the_size(rod):
    axis = line([-6, 0.3, 0], [4, 0.3, 0])
    small = measured(replace(axis, nodes=axis.nodes * 1e-3), Mesh(rod.vertices * 1e-3, rod.faces))
    large = measured(axis, rod)
    assert small.accuracy_95 == pytest.approx(large.accuracy_95, rel=1e-6)
    assert small.coverage_98 == pytest.approx(large.coverage_98, rel=1e-6)


def test_long_edges_count_by_their_length(rod):
    """One long edge beside the axis, and a hundred on the axis that are too short to count."""
    aside = Skeleton([[-6.0, 0.5, 0], [6, 0.5, 0]], [[0, 1]], [1, 1])
    on_axis = line([0, 0, 0], [1e-3, 0, 0], 100)
    nodes = np.concatenate([aside.nodes, on_axis.nodes])
    edges = np.concatenate([aside.edges, on_axis.edges + 2])
    both = measured(Skeleton(nodes, edges, np.ones(len(nodes))), rod)
    assert both.accuracy_95 == pytest.approx(measured(aside, rod).accuracy_95, rel=1e-3)


def test_a_single_node_is_compared_too(rod):
    found = measured(Skeleton([[0.0, 0.25, 0]], [], [1]), rod)
    assert found.accuracy_95 == pytest.approx(0.25, abs=0.03)
    assert found.uncovered_parts == 2


def test_half_a_rod_is_an_uncovered_end(rod):
    found = measured(line([-6, 0, 0], [0, 0, 0]), rod)
    assert found.uncovered_parts == 1
    assert found.coverage_98 > 3
    both = measured(line([-2, 0, 0], [2, 0, 0]), rod)
    assert both.uncovered_parts == 2


def test_every_limb_that_is_cut_off_is_found(limbs):
    truth = Skeleton(limbs.truth.nodes, limbs.truth.edges, limbs.truth.radii)
    whole = measured(truth, limbs.mesh)
    assert whole.uncovered_parts == 0
    assert whole.coverage_98 < 0.2
    assert len(truth.end_branches) == 6
    for branch in truth.end_branches:
        cut = measured(without_branch(truth, branch), limbs.mesh)
        assert cut.uncovered_parts == 1
        assert cut.coverage_98 > 1


def test_noise_leaves_the_axis_central(limbs):
    truth = Skeleton(limbs.truth.nodes, limbs.truth.edges, limbs.truth.radii)
    found = measured(truth, with_local_noise(limbs.mesh, 0.25))
    assert found.accuracy_95 < 0.1
    assert found.coverage_98 < 0.3  # 0.35 by the normals of single vertices
    assert found.uncovered_parts == 0


def test_the_sheet_of_a_ribbon_counts_little():
    """The medial points of a ribbon of ratio 10 are up to nine of its radii from the line in its middle."""
    shape = HARD_SHAPES["ribbon"]()
    truth = Skeleton(shape.truth.nodes, shape.truth.edges, shape.truth.radii)
    found = measured(truth, shape.mesh)
    assert found.coverage_98 < 0.35
    assert found.uncovered_parts == 0
    nothing = np.zeros(len(shape.mesh.vertices))
    no_sheet = medial_distances(truth, shape.mesh, nothing, nothing, deadline=NEVER)
    assert no_sheet.coverage_98 > 5


def test_a_stretch_of_a_limb_that_the_line_leaves_is_uncovered(rod):
    axis = line([-6, 0, 0], [6, 0, 0], 60)
    nodes = np.array(axis.nodes)
    nodes[:, 1] += 3.0 * np.exp(-((nodes[:, 0] / 2) ** 2))
    found = measured(replace(axis, nodes=nodes), rod)
    assert found.coverage_98 > 1
    assert found.uncovered_parts == 1


@pytest.mark.parametrize(
    ("is_within", "radius", "n"),
    [
        (lambda x, y, z: x > 3, 1.0, 1),
        (lambda x, y, z: abs(x) > 3, 1.0, 2),
        (lambda x, y, z: y > 0.3, 1.0, 0),  # a patch along one side
        (lambda x, y, z: x > 3, 3.0, 0),  # 25 / 9 squared radii, less than a section of pi
        (lambda x, y, z: x > 20, 1.0, 0),
    ],
)
def test_parts_close_around_and_are_as_large_as_a_section(rod, is_within, radius, n):
    radii = np.full(len(rod.vertices), radius)
    assert _n_parts(rod, is_within(*rod.vertices.T), _area_vectors(rod), radii) == n


def test_crumbs_do_not_count(rod):
    """A component of few faces and little area has no skeleton, and is no end."""
    crumb = rod.vertices[:4] * 0 + [[20, 0, 0], [20.01, 0, 0], [20, 0.01, 0], [20, 0, 0.01]]
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]) + len(rod.vertices)
    both = Mesh(np.concatenate([rod.vertices, crumb]), np.concatenate([rod.faces, faces]))
    axis = line([-6, 0, 0], [6, 0, 0])
    assert measured(axis, both).coverage_98 == pytest.approx(measured(axis, rod).coverage_98, abs=0.02)
    assert measured(axis, both).uncovered_parts == 0


def test_vertices_without_a_face_do_not_count(rod):
    spare = Mesh(np.concatenate([rod.vertices, np.linspace([-6, 0.3, 0], [6, 0.3, 0], 50)]), rod.faces)
    axis = line([-6, 0.3, 0], [6, 0.3, 0])
    assert measured(axis, spare).accuracy_95 == pytest.approx(measured(axis, rod).accuracy_95, rel=1e-9)


def test_time_may_run_out(rod):
    ones = np.ones(len(rod.vertices))
    with pytest.raises(OutOfTime):
        medial_distances(line([-6, 0, 0], [6, 0, 0]), Mesh(rod.vertices, rod.faces), ones, ones, deadline=Deadline(0.0))
