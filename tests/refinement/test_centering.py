"""Refinement: nodes on the axis, junctions where the axes meet, tips one radius in, and all of it inside."""

import numpy as np
import pytest

from lbskel import Skeleton, collapse_mesh, contract
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement import containment as inside
from lbskel.refinement.centering import recenter
from lbskel.refinement.containment import inside_fraction, reroute_inside, segments_outside
from lbskel.refinement.radii import inscribed_radii, mean_radii
from lbskel.refinement.region_map import reassign_to_nearest_node
from lbskel.refinement.tips import extend_tips
from lbskel.shapes import capsule, make, sphere, torus, tube


def chain(points, mesh, radius=0.1):
    """A path of nodes; each vertex of the mesh mapped to the nearest."""
    points = np.asarray(points, dtype=float)
    nearest = np.linalg.norm(mesh.vertices[:, None] - points, axis=2).argmin(axis=1)
    k = np.arange(len(points) - 1)
    return Skeleton(points, np.stack([k, k + 1], axis=1), np.full(len(points), radius), nearest)


def test_a_crooked_path_in_a_capsule_goes_to_its_axis():
    mesh = capsule(4.0, 0.5, 32)
    rng = np.random.default_rng(0)
    z = np.linspace(-2, 2, 17)
    off = chain(np.stack([0.1 * rng.standard_normal(17), 0.1 * rng.standard_normal(17), z], axis=1), mesh)
    skeleton = recenter(off, Surface(mesh))
    # sections are nearly circles round the axis; the smoothing and the free ends leave a hundredth of the radius
    assert np.hypot(*skeleton.nodes[1:-1, :2].T).max() < 0.01 * 0.5


def test_a_surface_answers_the_same_question_with_the_same_answer():
    mesh = torus(1.0, 0.3, 48, 16)
    points = np.random.default_rng(0).uniform(-1, 1, (50, 3))
    surface, other = Surface(mesh), Surface(torus(1.0, 0.3, 48, 16))
    first, inside = surface.distance(points), surface.contains(points)
    assert surface.closest(points.copy())[0] is surface.closest(points)[0]
    assert not first.flags.writeable
    assert not inside.flags.writeable
    for shift in np.linspace(0, 1, 40):  # more questions than are remembered
        assert np.array_equal(surface.distance(points + shift), other.closest(points + shift)[0])
    assert np.array_equal(surface.distance(points), first)
    assert np.array_equal(surface.contains(points), inside)


def test_an_edge_leaves_where_its_middle_or_either_end_is_outside():
    """In a torus of radii 1 and 0.3; a chord over a sixth of it sinks to 0.87 of the circle, over a third to 0.5."""
    turn = np.array([0, np.pi / 3, 2 * np.pi / 3, 0])
    nodes = np.stack([np.cos(turn), np.sin(turn), [0, 0, 0, 1.0]], axis=1)
    edges = np.array([[0, 1], [0, 2], [0, 3], [3, 0]])
    assert segments_outside(nodes, edges, Surface(torus(1.0, 0.3, 96, 32))).tolist() == [False, True, True, True]


def test_a_bare_loop_goes_to_the_circle_of_its_torus():
    mesh = torus(1.0, 0.3, 64, 24)
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    loop = np.stack([0.9 * np.cos(angle), 0.9 * np.sin(angle), 0.1 + 0 * angle], axis=1)
    nearest = np.linalg.norm(mesh.vertices[:, None] - loop, axis=2).argmin(axis=1)
    edges = np.stack([np.arange(24), (np.arange(24) + 1) % 24], axis=1)
    skeleton = recenter(Skeleton(loop, edges, np.full(24, 0.3), nearest), Surface(mesh))
    # sections of a torus are centered r^2 / (8 R) inside at most; the smoothing of 24 nodes adds as much again
    assert np.abs(np.hypot(*skeleton.nodes[:, :2].T) - 1).max() < 0.03
    assert np.abs(skeleton.nodes[:, 2]).max() < 0.01


@pytest.mark.parametrize("stops_at", [0.2, 0.6, 1.4])
def test_tips_go_to_the_centers_of_the_last_spheres(stops_at):
    mesh = capsule(4.0, 0.5, 32)
    short = chain(np.stack([np.zeros(9), np.zeros(9), np.linspace(-stops_at, stops_at, 9)], axis=1), mesh)
    skeleton = extend_tips(short, Surface(mesh))
    ends = np.sort(skeleton.nodes[skeleton.tips][:, 2])
    # one step of half a radius may pass the center by the slack of 5 % of the radius
    assert np.abs(ends - [-2, 2]).max() < 0.06 * 0.5
    assert len(skeleton.edges) == len(skeleton.nodes) - 1


@pytest.mark.parametrize(("aside", "moves"), [(0.3, True), (0.7, True), (1.1, False)])
def test_a_tip_beside_the_axis_goes_to_it(aside, moves):
    """In a capsule of radius 0.5; a tip outside is led back where it is within two radii of the section beside it."""
    mesh = capsule(4.0, 0.5, 32)
    path = np.stack([np.zeros(9), np.zeros(9), np.linspace(-1.5, 1.5, 9)], axis=1)
    path[-1, 0] = aside
    skeleton = extend_tips(chain(path, mesh), Surface(mesh))
    # the plane across the last four nodes, which lean by the shift, cuts an ellipse whose center is on the axis
    assert (np.abs(skeleton.nodes[:, 0]).max() < 0.05 * 0.5) == moves
    assert (skeleton.nodes[:, 2].max() > 1.9) == moves


def test_a_tip_that_has_hardly_left_its_junction_goes_where_its_vertices_are():
    """A junction in the middle of a ball, and a tip that points away from the arm it stands for."""
    mesh = make("tripod", n_vertices=2000)
    V, arm = mesh.mesh.vertices, mesh.truth.nodes[mesh.truth.tips]
    center = mesh.truth.nodes[mesh.truth.junctions[0]]
    ways = [center + (end - center) * np.linspace(0, 0.8, 9)[1:, None] for end in arm[:2]]
    nodes = np.concatenate([center[None], *ways, (center + 0.02 * (center - arm[2]))[None]])
    edges = [[0, 1], [0, 9], *([k, k + 1] for k in range(1, 8)), *([k, k + 1] for k in range(9, 16)), [0, 17]]
    at = np.concatenate([nodes[:17], [arm[2]]])
    nearest = np.linalg.norm(V[:, None] - at, axis=2).argmin(axis=1)
    skeleton = extend_tips(Skeleton(nodes, edges, np.full(18, 0.1), nearest), Surface(mesh.mesh))
    far = np.linalg.norm(skeleton.nodes[skeleton.tips][:, None] - arm, axis=2).min(axis=0)
    assert far.max() < 0.2 * mesh.truth.radii.min()


def test_an_end_without_a_direction_stays():
    mesh = sphere(2)
    point = Skeleton(np.zeros((2, 3)), [[0, 1]], np.ones(2), np.zeros(len(mesh.vertices)))
    assert np.array_equal(extend_tips(point, Surface(mesh)).nodes, point.nodes)


def test_tips_follow_a_bend():
    t = np.linspace(0, np.pi / 2, 40)
    axis = np.stack([2 * np.sin(t), 0 * t, 2 - 2 * np.cos(t)], axis=1)
    mesh = tube(axis, 0.2)
    skeleton = extend_tips(chain(axis[4:26], mesh), Surface(mesh))
    from_center = np.hypot(skeleton.nodes[:, 0], skeleton.nodes[:, 2] - 2)
    assert np.abs(from_center - 2).max() < 0.1 * 0.2
    # the end of the tube is flat, so its last ball lies one radius in
    last = skeleton.nodes[skeleton.tips]
    assert np.linalg.norm(last - axis[-1], axis=1).min() == pytest.approx(0.2, rel=0.2)


def test_vertices_at_an_end_go_to_the_new_nodes():
    mesh = capsule(4.0, 0.5, 32)
    short = chain(np.stack([np.zeros(9), np.zeros(9), np.linspace(-1, 1, 9)], axis=1), mesh)
    skeleton = extend_tips(short, Surface(mesh))
    top = mesh.vertices[:, 2] > 1.9
    assert skeleton.nodes[skeleton.node_of_vertex[top]][:, 2].min() > 1.5


def test_junctions_go_where_the_axes_meet():
    shape = make("tripod", n_vertices=2000)
    truth = shape.truth
    junction = truth.nodes[truth.junctions[0]]
    from lbskel import skeletonize

    skeleton = skeletonize(shape.mesh)
    found = skeleton.nodes[skeleton.junctions]
    assert len(found) == 1
    # sections of the arms are known to a hundredth of the radius, from where the axes are carried on for two radii
    assert np.linalg.norm(found[0] - junction) < 0.05 * truth.radii[truth.junctions[0]]


def test_outer_nodes_and_edges_are_brought_in():
    t = np.linspace(0, np.pi, 60)
    mesh = tube(np.stack([np.cos(t), np.sin(t), 0 * t], axis=1), 0.1)
    surface = Surface(mesh)
    straight = chain([[1, 0.15, 0], [0, 1.3, 0], [-1, 0.15, 0]], mesh)
    assert inside_fraction(straight, surface) < 0.5
    led = reroute_inside(straight, surface)
    assert surface.contains(led.nodes).all()
    assert inside_fraction(led, surface) == 1.0
    assert np.array_equal(led.radii[2:], surface.distance(led.nodes[2:]))  # of the two that stayed they are as given
    assert (led.n_components, led.cycle_rank) == (1, 0)
    assert len(led.tips) == 2


def test_radii_of_a_ball_and_of_a_cloud():
    mesh = sphere(3)
    center = Skeleton(np.zeros((1, 3)), np.empty((0, 2)), np.zeros(1), np.zeros(len(mesh.vertices)))
    assert mean_radii(center, mesh).radii[0] == pytest.approx(1, rel=1e-12)
    inscribed = inscribed_radii(center, Surface(mesh)).radii[0]
    assert 0.98 < inscribed < 1  # facets lie a little inside their sphere: 1 - h^2 / 8 at edges of h = 0.14 to 0.2


def test_nodes_without_vertices_take_the_radius_of_their_neighbors():
    mesh = sphere(1)
    skeleton = Skeleton(np.zeros((3, 3)), [[0, 1], [1, 2]], np.zeros(3), np.zeros(len(mesh.vertices)))
    assert mean_radii(skeleton, mesh).radii == pytest.approx([1, 1, 1])


def test_surface_queries():
    surface = Surface(sphere(3))
    assert np.array_equal(surface.contains(np.array([[0, 0, 0], [0, 0, 2.0]])), [True, False])
    ahead = surface.ray_distance(np.array([[0.0, 0, 0], [0, 0, 2]]), np.array([[0.0, 0, 1], [0, 0, 1]]))
    assert ahead[0] == pytest.approx(1, rel=0.02)
    assert np.isinf(ahead[1])


def test_recentering_moves_a_contracted_shape_nearer_to_its_axis():
    mesh = torus(1.0, 0.3, 64, 24)
    graph = collapse_mesh(contract(mesh).mesh, mesh)
    raw = Skeleton(graph.nodes, graph.edges, np.full(len(graph.nodes), 0.3), graph.node_of_vertex)
    error = [np.abs(np.hypot(*s.nodes[:, :2].T) - 1).mean() for s in (raw, recenter(raw, Surface(mesh)))]
    assert error[1] < 0.5 * error[0]


def test_vertices_settle_at_the_nearest_node_along_the_skeleton():
    mesh = capsule(4.0, 0.5, 32)
    path = chain(np.stack([np.zeros(9), np.zeros(9), np.linspace(-2, 2, 9)], axis=1), mesh)
    nearest = path.node_of_vertex
    astray = Skeleton(path.nodes, path.edges, path.radii, np.clip(nearest + 3, 0, 8))
    assert np.array_equal(reassign_to_nearest_node(astray, mesh).node_of_vertex, nearest)


def test_a_loop_that_is_led_another_way_stays_a_loop():
    mesh = torus(1.0, 0.1, 64, 16)
    surface = Surface(mesh)
    angle = np.linspace(0, 2 * np.pi, 9, endpoint=False)
    edges = np.stack([np.arange(9), (np.arange(9) + 1) % 9], axis=1)
    for shift in (0.0, 0.25):  # edges cut across the hole; every node lies outside too
        loop = np.stack([np.cos(angle) + shift, np.sin(angle), 0 * angle], axis=1)
        nearest = np.linalg.norm(mesh.vertices[:, None] - loop, axis=2).argmin(axis=1)
        led = reroute_inside(Skeleton(loop, edges, np.full(9, 0.1), nearest), surface)
        assert led.cycle_rank == 1
        if shift == 0:
            assert inside_fraction(led, surface) == 1.0


@pytest.mark.parametrize("at_first", [0.01, 1e9])
def test_a_way_under_the_surface_is_the_shortest_wherever_it_is_looked_for_first(monkeypatch, at_first):
    t = np.linspace(0, 1.9 * np.pi, 120)
    mesh = tube(np.stack([np.cos(t), np.sin(t), 0 * t], axis=1), 0.1)
    P = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)[[2, 117, 60, 90, 61]]
    pairs = np.array([[0, 1], [0, 2], [2, 3], [2, 4]])  # the first two points are near, but far round the tube
    ways = inside.interior_paths(P, pairs, Surface(mesh))
    assert [len(way) > 1 for way in ways] == [True, True, True, False]
    monkeypatch.setattr(inside, "SEARCH_FACTOR", at_first)
    assert all(map(np.array_equal, inside.interior_paths(P, pairs, Surface(mesh)), ways))
