"""Tips: end branches extended to the center of the last inscribed ball."""

import itertools

import numpy as np
import pytest
from helpers import nearest_rows, path_in, reversed_proxy

from lbskel import Mesh, Skeleton
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement import tips
from lbskel.refinement.level_sets import find_geodesic_caps, interior_axes
from lbskel.refinement.tips import extend_ends, extend_tips, trace_centerline
from lbskel.shapes import capsule, make, mesh_solid, solid_of, sphere, tube


@pytest.mark.parametrize("stops_at", [0.2, 0.6, 1.4])
def test_tips_go_to_the_centers_of_the_last_balls(stops_at):
    mesh = capsule(4.0, 0.5, 32)
    short = path_in(mesh, np.stack([np.zeros(9), np.zeros(9), np.linspace(-stops_at, stops_at, 9)], axis=1))
    skeleton = extend_tips(short, Surface(mesh))
    ends = np.sort(skeleton.nodes[skeleton.tips][:, 2])
    # a step may pass the center by the slack of 5 % of the radius
    assert np.abs(ends - [-2, 2]).max() < 0.06 * 0.5
    assert len(skeleton.edges) == len(skeleton.nodes) - 1


@pytest.mark.parametrize(("aside", "moves"), [(0.3, True), (0.7, True), (1.1, False)])
def test_a_tip_beside_the_axis_is_centered(aside, moves):
    """In a capsule of radius 0.5; a tip outside is moved to its section where that is within two radii."""
    mesh = capsule(4.0, 0.5, 32)
    path = np.stack([np.zeros(9), np.zeros(9), np.linspace(-1.5, 1.5, 9)], axis=1)
    path[-1, 0] = aside
    skeleton = extend_tips(path_in(mesh, path), Surface(mesh))
    # the plane across the last four nodes, which lean by the shift, cuts an ellipse whose center is on the axis
    assert (np.abs(skeleton.nodes[:, 0]).max() < 0.05 * 0.5) == moves
    assert (skeleton.nodes[:, 2].max() > 1.9) == moves


def test_a_tip_at_its_junction_is_extended_towards_its_vertices():
    """A tip that points away from the arm whose vertices are mapped to it: the axis of the arm takes its place."""
    mesh = make("tripod", n_vertices=2000)
    V, arm = mesh.mesh.vertices, mesh.truth.nodes[mesh.truth.tips]
    center = mesh.truth.nodes[mesh.truth.junctions[0]]
    arms = [center + (end - center) * np.linspace(0, 0.8, 9)[1:, None] for end in arm[:2]]
    nodes = np.concatenate([center[None], *arms, (center + 0.02 * (center - arm[2]))[None]])
    edges = [[0, 1], [0, 9], *([k, k + 1] for k in range(1, 8)), *([k, k + 1] for k in range(9, 16)), [0, 17]]
    at = np.concatenate([nodes[:17], [arm[2]]])
    nearest = nearest_rows(V, at)
    skeleton = extend_tips(Skeleton(nodes, edges, np.full(18, 0.1), nearest), Surface(mesh.mesh))
    distances = np.linalg.norm(skeleton.nodes[skeleton.tips][:, None] - arm, axis=2).min(axis=0)
    assert distances.max() < 0.5 * mesh.truth.radii.min()  # the points of the axis are half a radius apart


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


def test_an_end_is_traced_on_where_its_limb_bends():
    """The last limb leans by 70 degrees over two of its radii, so that straight ahead is its side."""
    lean = np.radians(70)
    points = np.array([*([0.0, 0, z] for z in np.linspace(0, 4, 41)), [np.sin(lean), 0, 4 + np.cos(lean)]])
    mesh = mesh_solid(solid_of([(points[[0, 40]], 0.5), (points[40:], [0.5, 0.3])]), n_vertices=4000)
    long = extend_tips(path_in(mesh, points[:36]), Surface(mesh))
    assert np.linalg.norm(long.nodes[long.tips] - points[-1], axis=1).min() < 0.15  # half of the radius there
    assert (long.n_components, len(long.tips)) == (1, 2)


def test_an_end_that_is_traced_on_to_the_end_of_its_limb_keeps_its_nodes():
    """A tube that turns by 100 degrees, of which the first trace follows 60: level sets lie outside of its axis."""
    t = np.radians(np.linspace(0, 100, 40))
    axis = np.stack([2 * np.sin(t), 0 * t, 2 - 2 * np.cos(t)], axis=1)
    short = path_in(tube(axis, 0.2), axis[2:10])
    long = extend_tips(short, Surface(tube(axis, 0.2)))
    from_center = np.hypot(long.nodes[:, 0], long.nodes[:, 2] - 2)
    assert np.abs(from_center - 2).max() < 0.05 * 0.2
    assert np.linalg.norm(long.nodes[long.tips] - axis[-1], axis=1).min() == pytest.approx(0.2, rel=0.1)


@pytest.mark.parametrize(("direction", "goes_on"), [([1.0, 0, 0], False), ([0.8, 0, 0.6], True)])
def test_an_end_is_not_traced_on_towards_a_side(direction, goes_on):
    """In a rod, towards its end: at a right angle, or at 53 degrees."""
    mesh, start = capsule(3.0, 0.3, 24), np.array([0.0, 0, 0.5])
    paths = [[start]]
    paths = tips._traced_on(paths, start[None], np.array([direction]), {0: np.array([0, 0, 1.8])}, Surface(mesh))
    assert (len(paths[0]) > 1) == goes_on
    assert paths[0][-1] == pytest.approx([0, 0, 1.5 if goes_on else 0.5], abs=0.05)


def test_the_vertices_of_an_end_go_to_its_new_nodes():
    mesh = capsule(4.0, 0.5, 32)
    short = path_in(mesh, np.stack([np.zeros(9), np.zeros(9), np.linspace(-1, 1, 9)], axis=1))
    skeleton = extend_tips(short, Surface(mesh))
    top = mesh.vertices[:, 2] > 1.9
    assert skeleton.nodes[skeleton.node_of_vertex[top]][:, 2].min() > 1.5


def hook():
    """A thick body with a thin limb that bends by 150 degrees, and the axis of the limb."""
    body = np.array([[-1.0, 0, 0], [0, 0, 0]])
    angle = np.linspace(0, np.radians(150), 12)
    bend = np.stack([0.5 + 0.3 * np.sin(angle), 0.3 - 0.3 * np.cos(angle), 0 * angle], axis=1)
    ahead = (bend[-1] - bend[-2]) / np.linalg.norm(bend[-1] - bend[-2])
    limb = np.concatenate([[[0.0, 0, 0]], bend, bend[-1] + np.linspace(0.05, 0.4, 8)[:, None] * ahead])
    return mesh_solid(solid_of([(body, 0.3), (limb, 0.1)]), n_vertices=1200), limb


@pytest.mark.parametrize("surface_of", [Surface, reversed_proxy])
def test_a_tip_follows_a_limb_that_bends_back(surface_of):
    mesh, limb = hook()
    distances = np.linalg.norm(mesh.vertices[:, None] - limb, axis=2)
    on_limb = (distances.min(axis=1) < 0.15) & (distances.argmin(axis=1) > 0)
    # pulled back to the base of the limb, and outside of it
    nodes = np.array([[-1.0, 0, 0], [-0.5, 0, 0], [0, 0, 0], [0.4, -0.2, 0]])
    node = np.where(on_limb, 3, np.abs(mesh.vertices[:, :1] - nodes[:3, 0]).argmin(axis=1))
    short = Skeleton(nodes, [[0, 1], [1, 2], [2, 3]], np.zeros(4), node)
    long = extend_tips(short, surface_of(mesh))
    assert len(long.tips) == 2
    axis = np.concatenate([np.linspace(*each, 50) for each in itertools.pairwise(limb)])
    off_axis = np.linalg.norm(long.nodes[:, None] - axis, axis=2).min(axis=1)
    assert np.count_nonzero(long.nodes[:, 0] > 0.2) > 4
    assert off_axis[long.nodes[:, 0] > 0.2].max() < 0.07 * 0.1  # of the radius; centroids of level sets are 0.09 off
    assert np.linalg.norm(long.nodes[long.tips] - limb[-1], axis=1).min() < 0.05
    assert long.n_components == 1
    assert np.linalg.norm(mesh.vertices - long.nodes[long.node_of_vertex], axis=1)[on_limb].max() < 0.25


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


def test_the_axis_of_a_limb_is_clipped_to_its_part_inside():
    """The lower part of the surface is moved aside, so that the first points of the axis lie outside."""
    mesh = capsule(4.0, 0.5, 48)
    [half] = find_geodesic_caps(mesh, np.where(mesh.vertices[:, 2] > 0.3, 0, -1)).values()
    [whole] = interior_axes([half], Surface(mesh))
    assert len(whole) == len(half.axis) > 2
    aside = Surface(mesh.with_vertices(mesh.vertices + np.where(mesh.vertices[:, 2:] < 1.0, [2.0, 0, 0], 0)))
    [clipped] = interior_axes([half], aside)
    assert 0 < len(clipped) < len(whole)
    assert aside.contains(clipped).all()
    assert np.array_equal(clipped, whole[-len(clipped) :])


def test_a_sheet_has_no_axis():
    mesh = capsule(4.0, 0.5, 48)
    sheet = mesh.with_vertices(mesh.vertices * [1, 1e-6, 1])
    [half] = find_geodesic_caps(sheet, np.where(sheet.vertices[:, 2] > 0.3, 0, -1)).values()
    assert len(half.axis) > 2
    assert len(interior_axes([half], Surface(sheet))[0]) == 0


def test_a_tip_outside_the_surface_near_its_end_is_brought_inside():
    """So near the end of its limb that its axis is not looked for."""
    mesh = capsule(4.0, 0.5, 32)
    path = np.stack([np.zeros(9), np.zeros(9), np.linspace(-1.5, 1.7, 9)], axis=1)
    path[-1, 0] = 0.6
    skeleton = extend_tips(path_in(mesh, path), Surface(mesh))
    assert Surface(mesh).contains(skeleton.nodes).all()
    assert skeleton.nodes[8, 0] < 0.3
