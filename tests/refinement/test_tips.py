"""Tips: end branches extended to the center of the last inscribed ball."""

import numpy as np
import pytest
from helpers import path_in

from lbskel import Mesh, Skeleton, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.tips import extend_ends, extend_tips, trace_centerline
from lbskel.shapes import capsule, mesh_solid, solid_of, sphere, tube


@pytest.mark.parametrize("stops_at", [0.2, 0.6, 1.4])
def test_tips_go_to_the_centers_of_the_last_balls(stops_at):
    mesh = capsule(4.0, 0.5, 32)
    short = path_in(mesh, np.stack([np.zeros(9), np.zeros(9), np.linspace(-stops_at, stops_at, 9)], axis=1))
    skeleton = extend_tips(short, Surface(mesh))
    ends = np.sort(skeleton.nodes[skeleton.tips][:, 2])
    # a step may pass the center by the slack of 5 % of the radius
    assert np.abs(ends - [-2, 2]).max() < 0.06 * 0.5
    assert len(skeleton.edges) == len(skeleton.nodes) - 1


@pytest.mark.parametrize(("aside", "moves"), [(0.3, True), (0.7, False)])
def test_a_tip_beside_the_axis_is_centered(aside, moves):
    """In a capsule of radius 0.5; a tip outside is in no section of its own."""
    mesh = capsule(4.0, 0.5, 32)
    path = np.stack([np.zeros(9), np.zeros(9), np.linspace(-1.5, 1.5, 9)], axis=1)
    path[-1, 0] = aside
    skeleton = extend_tips(path_in(mesh, path), Surface(mesh))
    # the plane across the last four nodes, which lean by the shift, cuts an ellipse whose center is on the axis
    assert (np.abs(skeleton.nodes[:, 0]).max() < 0.05 * 0.5) == moves
    assert (skeleton.nodes[:, 2].max() > 1.9) == moves


def test_an_end_without_a_direction_is_kept():
    mesh = sphere(2)
    point = Skeleton(np.zeros((2, 3)), [[0, 1]], np.ones(2), np.zeros(len(mesh.vertices)))
    assert np.array_equal(extend_tips(point, Surface(mesh)).nodes, point.nodes)


def test_tips_follow_a_bend():
    t = np.linspace(0, np.pi / 2, 40)
    axis = np.stack([2 * np.sin(t), 0 * t, 2 - 2 * np.cos(t)], axis=1)
    mesh = tube(axis, 0.2)
    skeleton = extend_tips(path_in(mesh, axis[4:26]), Surface(mesh))
    from_center = np.hypot(skeleton.nodes[:, 0], skeleton.nodes[:, 2] - 2)
    assert np.abs(from_center - 2).max() < 0.1 * 0.2
    # the end of the tube is flat, so its last ball lies one radius in
    last = skeleton.nodes[skeleton.tips]
    assert np.linalg.norm(last - axis[-1], axis=1).min() == pytest.approx(0.2, rel=0.2)


def test_the_vertices_of_an_end_go_to_its_new_nodes():
    mesh = capsule(4.0, 0.5, 32)
    short = path_in(mesh, np.stack([np.zeros(9), np.zeros(9), np.linspace(-1, 1, 9)], axis=1))
    skeleton = extend_tips(short, Surface(mesh))
    top = mesh.vertices[:, 2] > 1.9
    assert skeleton.nodes[skeleton.node_of_vertex[top]][:, 2].min() > 1.5


def test_the_vertices_of_an_end_go_to_the_nearest_node_of_its_path():
    mesh = capsule(4.0, 0.5, 16)
    path = path_in(mesh, [[0, 0, -2], [0, 0, 0]])
    longer = extend_ends(path, Surface(mesh), np.array([1, 0]), [[np.array([0, 0, 1.0]), np.array([0, 0, 2.0])], []])
    assert longer.edges.tolist() == [[0, 1], [1, 2], [2, 3]]
    z = mesh.vertices[:, 2]
    for node, at in ((1, z < 0.4), (2, (z > 0.6) & (z < 1.4)), (3, z > 1.6)):
        assert (longer.node_of_vertex[at & (path.node_of_vertex == 1)] == node).all()
    assert np.array_equal(longer.node_of_vertex == 0, path.node_of_vertex == 0)
    assert longer.radii[2:] == pytest.approx(0.5, rel=0.05)


def test_a_centerline_ends_at_the_last_inscribed_ball():
    mesh = capsule(4.0, 0.5, 48)
    starts = np.array([[0.1, 0, 0], [0, 0, 1.99], [0, 0, 0]])
    up, stays, down = trace_centerline(Surface(mesh), starts, np.array([[0, 0, 3.0], [0, 0, 1], [0, 0, -1]]))
    assert len(stays) == 0  # 0.51 from the pole, a step would be shorter than the shortest
    for path, pole in ((up, 2.5), (down, -2.5)):
        assert np.abs(np.array(path)[:, :2]).max() < 0.01
        assert np.abs(path[-1][2] - pole) == pytest.approx(0.5, rel=0.06)
        assert np.diff(np.abs(np.array(path)[:, 2])).max() == pytest.approx(0.5, rel=0.03)  # a radius


def test_a_centerline_to_an_apex_takes_few_steps():
    """In a pyramid the section shrinks in proportion to the way that is left."""
    corners = [[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0], [0, 0, 1.4], [0, 0, -1.4]]
    sides = [[a, (a + 1) % 4, 4] for a in range(4)]
    bipyramid = Mesh(corners, [*sides, *([b, a, 5] for a, b, _ in sides)])
    [path] = trace_centerline(Surface(bipyramid), np.zeros((1, 3)), np.array([[0.0, 0, 1]]))
    assert 1 < len(path) < 12
    assert 1.1 < path[-1][2] < 1.4


def test_a_centerline_leads_into_a_wider_part():
    """A rod of radius 0.1 that ends in the middle of a ball of radius 0.5."""
    axis = [np.array([-1.5, 0, 0]), np.zeros(3)]
    mesh = mesh_solid(solid_of([(np.array(axis), 0.1), (np.array([[0.0, 0, 0], [0.01, 0, 0]]), 0.5)]), n_vertices=2500)
    [path] = trace_centerline(Surface(mesh), np.array([[-1.2, 0, 0]]), np.array([[1.0, 0, 0]]))
    assert abs(path[-1][0]) < 0.05


@pytest.mark.parametrize(
    ("sides", "n_rings", "length"), [(24, 80, 20.0), (12, 400, 200.0), (24, 20, 2.5), (24, 20, 3.0)]
)
def test_tips_in_flat_ends_are_one_radius_below_them(sides, n_rings, length):
    """Contraction leaves them at 0.4 to 0.7 radii."""
    x = np.linspace(0, length, n_rings)
    skeleton = skeletonize(tube(np.outer(x, [1, 0, 0]), 1.0, sides=sides))
    assert np.sort(skeleton.nodes[skeleton.tips, 0]) == pytest.approx([1, length - 1], abs=0.05)


def test_of_two_tips_of_a_short_branch_none_goes_beyond_its_middle():
    """In a longer one they go back along it, past its nodes."""
    mesh = tube(np.linspace([-4.0, 0, 0], [4.0, 0, 0], 81), 1.0, sides=24)
    short = path_in(mesh, np.linspace([3.4, 0, 0], [3.9, 0, 0], 6), radius=1.0)
    assert extend_tips(short, Surface(mesh)).nodes[:, 0].max() == pytest.approx(3.9)
    long = path_in(mesh, np.linspace([-3.9, 0, 0], [3.9, 0, 0], 17), radius=1.0)
    shortened = extend_tips(long, Surface(mesh))
    assert np.sort(shortened.nodes[shortened.tips, 0]) == pytest.approx([-3, 3], abs=0.05)
    assert len(shortened.nodes) == 15
    assert shortened.length == pytest.approx(6, abs=0.1)
