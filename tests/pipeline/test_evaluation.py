"""The score of a skeleton on the user's mesh: the same as in the report, whatever form the mesh has."""

import numpy as np
import pytest
from helpers import without_faces

import lbskel
from lbskel import MeshError, Skeleton
from lbskel.pipeline.evaluation import score
from lbskel.shapes import cylinder, tube


def test_the_score_is_that_of_the_report_on_a_prepared_mesh_too(ring):
    skeleton = lbskel.skeletonize(ring)
    assert score(skeleton, ring).report() == skeleton.report["score"]
    assert score(skeleton, lbskel.prepare(ring)) == score(skeleton, ring)


def test_units_do_not_change_the_score(ring):
    """Powers of two are exact."""
    skeleton = lbskel.skeletonize(ring)
    larger = Skeleton(4 * skeleton.nodes, skeleton.edges, 4 * skeleton.radii, skeleton.node_of_vertex)
    assert score(larger, ring.with_vertices(4 * ring.vertices)) == score(skeleton, ring)


def test_a_skeleton_without_a_map_says_what_is_not_measured(ring):
    skeleton = lbskel.skeletonize(ring)
    found = score(Skeleton(skeleton.nodes, skeleton.edges, skeleton.radii), ring)
    assert found.not_measured == ("connected_regions", "adjacent_regions")
    assert "not measured, since the skeleton has no vertex map: connected regions, adjacent regions" in str(found)
    assert found.verdict == "pass"


def test_a_cycle_lost_in_one_body_is_not_made_up_for_in_another(ring):
    """Two rings, one skeleton opened and one with a chord: the total is right, the score is not."""
    far = ring.with_vertices(ring.vertices + [6.0, 0.0, 0.0])
    mesh = lbskel.Mesh(
        np.concatenate([ring.vertices, far.vertices]), np.concatenate([ring.faces, far.faces + len(ring.vertices)])
    )
    skeleton = lbskel.skeletonize(mesh, preprocess=None)
    first = np.flatnonzero(skeleton.component_of_node == 0)
    cut = next(row for row, edge in enumerate(skeleton.edges) if edge[0] in first)
    other = np.flatnonzero(skeleton.component_of_node == 1)
    chord = [other[0], other[len(other) // 2]]
    wrong = Skeleton(
        skeleton.nodes,
        np.concatenate([np.delete(skeleton.edges, cut, axis=0), [chord]]),
        skeleton.radii,
        skeleton.node_of_vertex,
    )
    assert wrong.cycle_rank == skeleton.cycle_rank == 2
    assert score(skeleton, mesh, preprocess=None).extra_cycles == 0
    assert score(wrong, mesh, preprocess=None).extra_cycles == 2
    assert not score(wrong, mesh, preprocess=None).passed


def test_the_arguments_in_the_wrong_order_are_named(ring):
    with pytest.raises(MeshError, match="a score needs a Skeleton and its mesh, in this order"):
        score(ring, lbskel.skeletonize(ring))


@pytest.mark.parametrize("length", [5.0, 8.0, 12.0])
def test_tips_in_the_centers_of_cuts_are_no_fault(length):
    """The cuts of the shorter tubes stay open, as they are wide beside the tube."""
    tube = cylinder(1.0, length, 24, int(5 * length))
    skeleton = lbskel.skeletonize(tube)
    assert np.sort(skeleton.nodes[skeleton.tips, 2]) == pytest.approx([-length / 2, length / 2], abs=1e-9)
    found = score(skeleton, tube)
    assert (found.nodes_inside_fraction, found.inside_fraction, found.near_surface_fraction) == (1, 1, 0)


def test_a_branch_that_goes_on_beyond_a_cut_is_outside():
    pipe = cylinder(1.0, 12.0, 24, 60)
    path = np.linspace([0, 0, -6], [0, 0, 9.6], 17)  # the 14th node is 0.675 radii beyond the cut, which has no tip
    skeleton = Skeleton(path, np.stack([np.arange(16), np.arange(1, 17)], axis=1), np.ones(17))
    assert score(skeleton, pipe).nodes_inside_fraction == pytest.approx(13 / 17)
    assert score(skeleton, pipe).inside_fraction == pytest.approx(12 / 15.6, abs=0.01)  # twelve samples an edge


def test_what_leaves_a_tube_beside_a_slit_is_outside():
    """Within the mean radius of the slit, where no tip is."""
    z, angles = np.linspace(0, 10, 101), np.linspace(0, 2 * np.pi, 25)[:-1]
    vessel = tube(np.outer(z, [0, 0, 1]), 0.2, sides=24, rounded=True)
    x, y, height = vessel.vertices[vessel.faces].mean(axis=1).T
    is_slit = (np.abs(height - 5) < 2) & (np.abs(np.arctan2(y, x)) < 2 * angles[1])
    nodes = np.linspace([0, 0, 0.2], [0, 0, 9.8], 60)
    nodes[np.abs(nodes[:, 2] - 5) < 0.9, 0] = -0.45
    skeleton = Skeleton(nodes, np.stack([np.arange(59), np.arange(1, 60)], axis=1), np.full(60, 0.2))
    for mesh in (vessel, without_faces(vessel, np.flatnonzero(is_slit))):
        assert score(skeleton, mesh).inside_fraction < 0.8
