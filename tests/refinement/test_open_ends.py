"""Open ends: tips in cut tubes end at the centers of the cuts, with their radii."""

import numpy as np
import pytest
from helpers import nearest_rows, path_in, without_faces

from lbskel import Skeleton, score, simplify_branches, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.open_ends import cuts_with_tips, extend_to_open_ends, normals_of_cuts
from lbskel.shapes import capsule, cylinder, tube

PIPE = capsule(8.0, 0.5, 32)  # closed, from -4.5 to 4.5 along z
POINTS = np.linspace([0, 0, -3], [0, 0, 3], 13)


@pytest.fixture(scope="module")
def path():
    return path_in(PIPE, POINTS, radius=0.5)


def cuts(*ends, normal=(0, 0, 1)):
    """Round cuts across z, or across a normal, each given by its center and radius."""
    ends = np.array(ends, dtype=float)
    return np.column_stack([ends, np.pi * ends[:, 3:] ** 2 * normal])


def test_a_tip_is_extended_to_the_center_of_the_cut(path):
    extended = extend_to_open_ends(path, Surface(PIPE), cuts([0.1, 0.0, 4.0, 0.45]))
    added = extended.nodes[len(path.nodes) :]
    assert len(added) > 0
    assert np.array_equal(extended.nodes[: len(path.nodes)], path.nodes)
    last = np.linalg.norm(extended.nodes - [0.1, 0, 4.0], axis=1).argmin()
    assert extended.nodes[last] == pytest.approx([0.1, 0, 4.0], abs=1e-12)
    assert extended.degrees[last] == 1
    assert extended.radii[last] == 0.45
    assert (extended.n_components, extended.cycle_rank, len(extended.tips)) == (1, 0, 2)
    assert np.isin([0, 12], np.flatnonzero(extended.degrees == 1)).tolist() == [True, False]


@pytest.mark.parametrize("beyond", [0.0, 0.2, 0.45])
def test_a_branch_that_ends_beside_or_beyond_the_cut_does_not_turn_back(path, beyond):
    """The last node is up to 0.45 past the center of a cut of radius 0.5, and 0.2 beside it."""
    center = np.array([0.2, 0.0, 3.0 - beyond])
    extended = extend_to_open_ends(path, Surface(PIPE), cuts([*center, 0.5]))
    [way] = (b if b[0] == 0 else b[::-1] for b in extended.branches)
    assert extended.nodes[way[-1]] == pytest.approx(center, abs=1e-12)
    steps = np.diff(extended.nodes[way], axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    assert (steps[1:] * steps[:-1]).sum(axis=1).min() > np.cos(np.radians(30))
    assert len(extended.node_of_vertex) == len(path.node_of_vertex)
    assert extended.node_of_vertex.max() < len(extended.nodes)


@pytest.mark.parametrize(
    ("end", "normal"),
    [
        pytest.param([0, 0, 4.0, 5.0], [0, 0, 1], id="a cut ten times as wide"),
        pytest.param([0, 0, 4.0, 0.05], [0, 0, 1], id="a hole in the wall"),
        pytest.param([40.0, 0, 4.0, 0.5], [0, 0, 1], id="a cut far away"),
        pytest.param([0.6, 0, 2.6, 0.4], [1, 0, 0], id="a window behind the tip"),
        pytest.param([0.5, 0, 3.2, 0.4], [1, 0, 0], id="a window beside the tip"),
    ],
)
def test_cuts_of_other_limbs_change_nothing(path, end, normal):
    assert extend_to_open_ends(path, Surface(PIPE), cuts(end, normal=normal)) is path


@pytest.mark.parametrize(("degrees", "is_end"), [(0, True), (55, True), (65, False), (90, False)])
def test_a_hole_that_does_not_go_around_the_limb_changes_nothing(path, degrees, is_end):
    """A hole as wide as the limb: its area across the limb is the cosine of its angle as a share of the section."""
    turn = np.radians(degrees)
    hole = cuts([0, 0, 4.0, 0.5], normal=(np.sin(turn), 0, np.cos(turn)))
    assert (extend_to_open_ends(path, Surface(PIPE), hole) is not path) == is_end


def test_a_face_missing_near_the_end_of_a_coarse_tube_does_not_move_its_tip():
    coarse = tube(np.arange(0, 31, 1.5)[:, None] * [0, 0, 1], 1.0, sides=5)
    corners = coarse.vertices[coarse.faces][:, :, 2]
    at_side = np.flatnonzero((np.ptp(corners, axis=1) > 1) & (corners.max(axis=1) < 7))
    tip = skeletonize(coarse).nodes[:, 2].min()
    ends = [skeletonize(without_faces(coarse, [face])).nodes[:, 2].min() for face in at_side]
    assert ends == pytest.approx([tip] * len(at_side), abs=0.5)


def test_both_ends_of_a_short_branch_keep_their_cuts():
    pill = capsule(0.4, 0.5, 16)
    path = path_in(pill, np.array([[0, 0, -0.1], [0, 0, 0.1]]), radius=0.5)
    extended = extend_to_open_ends(path, Surface(pill), cuts([0, 0, -0.3, 0.5], [0, 0, 0.3, 0.5]))
    [branch] = extended.branches
    assert np.abs(np.diff(extended.nodes[branch][:, 2], axis=0)) == pytest.approx([0.2, 0.2, 0.2])
    assert abs(extended.nodes[branch[-1], 2] - extended.nodes[branch[0], 2]) == pytest.approx(0.6)


def test_a_branch_of_two_nodes_goes_back_from_beside_its_cut():
    """Its tip and its junction are within a radius of the cut's center, which lies sideways."""
    pill = capsule(0.6, 0.5, 16)
    nodes = np.array([[0.0, 0, 0], [0, 0, -0.7], [-0.3, 0, -0.5], [0.3, 0, 0.1]])
    skeleton = Skeleton(nodes, [[0, 1], [0, 2], [0, 3]], np.full(4, 0.5), nearest_rows(pill.vertices, nodes))
    cut = np.array([0.1, 0, 0.4])
    extended = extend_to_open_ends(skeleton, Surface(pill), cuts([*cut, 0.5]))
    assert np.linalg.norm(extended.nodes[extended.tips] - cut, axis=1).min() == pytest.approx(0, abs=1e-12)
    assert not (extended.nodes == nodes[3]).all(axis=1).any()


def test_without_cuts_or_tips_nothing_changes(path, ring):
    assert extend_to_open_ends(path, Surface(PIPE), np.empty((0, 7))) is path
    loop = skeletonize(ring)
    assert extend_to_open_ends(loop, Surface(ring), cuts([1.0, 0, 0, 0.25])) is loop


@pytest.mark.parametrize("n", [12, 24])
def test_a_cut_tube_has_tips_at_the_centers_of_its_cuts(n):
    mesh = cylinder(0.3, 3.0, n, 12)
    moved = mesh.with_vertices(100 * mesh.vertices + [7.0, -20.0, 3.0])
    skeleton = skeletonize(moved)
    assert len(skeleton.tips) == 2
    ends = skeleton.nodes[skeleton.tips]
    ends = ends[np.argsort(ends[:, 2])]
    # the rims are planar and regular: their centers are exact but for the rounding of coordinates of 1e2
    np.testing.assert_allclose(ends, [[7, -20, -147], [7, -20, 153]], atol=1e-10)
    # the inscribed radius is that to the middles of the tube's flat faces
    np.testing.assert_allclose(skeleton.radii[skeleton.tips], 30.0 * np.cos(np.pi / n), rtol=1e-9)


@pytest.mark.parametrize("degrees", [30, 60])
def test_a_tube_cut_obliquely_ends_at_the_center_of_the_cut_with_its_own_radii(degrees):
    """The faces that close the cut are no surface, and the thin wedge at its far side is no thinner limb."""
    mesh = cylinder(1.0, 12.0, 32, 81)
    x, _, z = mesh.vertices.T
    sheared = np.array(mesh.vertices)
    sheared[:, 2] += z / 6 * np.tan(np.radians(degrees)) * x
    skeleton = skeletonize(mesh.with_vertices(sheared))
    ends = skeleton.nodes[skeleton.tips]
    np.testing.assert_allclose(ends[np.argsort(ends[:, 2])], [[0, 0, -6], [0, 0, 6]], atol=0.02)
    np.testing.assert_allclose(skeleton.radii, 1.0, rtol=0.03)


def test_a_tube_cut_at_one_end_has_a_round_end_at_the_other():
    rod = capsule(6.0, 0.5, 24)
    cut = rod.vertices[rod.faces].mean(axis=1)[:, 2] < 2.0
    skeleton = skeletonize((rod.vertices, rod.faces[cut]))
    low, high = skeleton.nodes[skeleton.tips][np.argsort(skeleton.nodes[skeleton.tips, 2])]
    rim = rod.vertices[np.intersect1d(rod.faces[cut], rod.faces[~cut])]
    assert high == pytest.approx(rim.mean(axis=0), abs=0.05)  # a tenth of the radius: the rim is no plane
    assert low[2] == pytest.approx(-3.0, abs=0.25)  # half a radius from the center of the cap, inside it


def test_a_cut_keeps_its_tip_when_the_nodes_before_it_are_left_out():
    mesh = cylinder(1.0, 12.0, 24, 40)
    skeleton = simplify_branches(skeletonize(mesh), tolerance=0.5)
    assert len(skeleton.nodes) == 2
    ends = cuts([0, 0, -6, 1.0], [0, 0, 6, 1.0])
    assert len(cuts_with_tips(skeleton, Surface(mesh), ends)) == 2
    assert score(skeleton, mesh).nodes_inside_fraction == 1.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_normal_of_a_cut_is_that_out_of_its_branch(path, side):
    ends = cuts([0, 0, 3, 0.5], [0, 0.3, -3, 0.5], normal=(0, 0.6 * side, 0.8 * side))
    normals = normals_of_cuts(path, ends)
    tip = path.nodes[:, 2].argmax()
    assert normals[tip] == pytest.approx([0, 0.6, 0.8])
    assert np.count_nonzero(normals.any(axis=1)) == 1  # the other cut is beside its tip
    assert not normals_of_cuts(path, ends[:0]).any()


def test_the_far_corner_of_an_oblique_cut_is_no_missed_limb():
    mesh = cylinder(1.0, 30.0, 48, 201)
    x, _, z = mesh.vertices.T
    sheared = np.array(mesh.vertices)
    sheared[:, 2] += z / 15 * np.tan(np.radians(70)) * x
    skeleton = skeletonize(mesh.with_vertices(sheared))
    assert skeleton.report["score"]["measures"]["missed_limb_fraction"] == 0
    assert skeleton.mean_radii == pytest.approx(np.ones(len(skeleton.nodes)), abs=0.05)  # faces are slender there
