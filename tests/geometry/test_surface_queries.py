"""Surface queries against a sphere and a torus, with and without a proxy, and the cache of results."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.geometry.surface_queries import MAX_CACHED_RESULTS, Proxy, Surface
from lbskel.geometry.vertex_map import VertexMap
from lbskel.shapes import flat_grid, sphere, torus

BALL = sphere(4)
SAGITTA = 0.002  # the chords of 0.07 of a unit sphere lie up to 0.07^2 / 4 below it
POINTS = np.array([[0.0, 0, 0.5], [0, 0.2, 0], [0, 0, 3]])


def test_distance_and_closest_point_of_a_sphere():
    distance, nearest = Surface(BALL).closest(POINTS)
    assert distance == pytest.approx([0.5, 0.8, 2.0], abs=SAGITTA)
    assert np.linalg.norm(nearest - POINTS, axis=1) == pytest.approx(distance, rel=1e-12)
    assert np.array_equal(Surface(BALL).distance(POINTS), distance)


def test_rays_measure_the_distance_along_their_direction():
    up = np.tile([0.0, 0, 1], (3, 1))
    expected = [0.5, np.sqrt(1 - 0.2**2), np.inf]
    assert Surface(BALL).ray_distance(POINTS, up) == pytest.approx(expected, abs=SAGITTA)


@pytest.mark.parametrize("mesh", [BALL, Mesh(BALL.vertices, BALL.faces[:, ::-1]), Mesh(BALL.vertices, BALL.faces[1:])])
def test_the_inside_of_a_sphere_also_reversed_or_with_a_hole(mesh):
    assert Surface(mesh).contains(POINTS).tolist() == [True, True, False]


def test_the_hole_of_a_torus_is_outside():
    ring = torus(1.0, 0.3, 40, 20)
    assert Surface(ring).contains(np.array([[0.0, 0, 0], [1, 0, 0]])).tolist() == [False, True]


def test_inner_rays_start_under_the_vertices_and_cross_the_sphere():
    vertices = np.arange(0, len(BALL.vertices), 100)
    for mesh in (BALL, Mesh(BALL.vertices, BALL.faces[:, ::-1])):
        entry, inward, thickness = Surface(mesh).inner_offset(vertices)
        assert np.linalg.norm(inward, axis=1) == pytest.approx(np.ones(len(vertices)))
        assert np.einsum("ij,ij->i", inward, BALL.vertices[vertices]) == pytest.approx(
            -np.ones(len(vertices)), abs=0.01
        )
        assert Surface(mesh).contains(entry).all()
        assert thickness == pytest.approx(np.full(len(vertices), 2.0), abs=0.02)


def test_inner_rays_of_a_sheet_hit_nothing():
    assert not Surface(flat_grid()).inner_offset(np.array([0, 5]))[2].any()


def proxied(deviation):
    coarse = sphere(1)
    sources = np.linalg.norm(coarse.vertices[:, None] - BALL.vertices, axis=2).argmin(axis=1)
    targets = np.linalg.norm(BALL.vertices[:, None] - coarse.vertices, axis=2).argmin(axis=1)
    return Surface(BALL, Proxy(coarse, VertexMap(targets), sources, deviation))


def test_the_clearance_with_a_proxy_is_a_lower_bound_of_the_distance():
    surface = proxied(0.2)
    assert Surface(BALL).clearance(POINTS) == pytest.approx(Surface(BALL).distance(POINTS))
    clearance, distance = surface.clearance(POINTS), surface.distance(POINTS)
    assert (clearance <= distance).all()
    assert clearance == pytest.approx(surface.proxy.distance(POINTS) - 0.2)
    assert proxied(10.0).clearance(POINTS).tolist() == [0, 0, 0]


def test_values_are_transferred_to_the_proxy_and_back():
    surface = proxied(0.2)
    labels = (BALL.vertices[:, 2] > 0.0).astype(np.int64)
    on_proxy = surface.on_proxy(labels)
    assert np.array_equal(on_proxy, surface.proxy.mesh.vertices[:, 2] > 0.0)
    back = surface.from_proxy(on_proxy)
    is_clear = np.abs(BALL.vertices[:, 2]) > 0.4  # edges of the proxy are 0.6 long
    assert np.array_equal(back[is_clear], labels[is_clear])
    plain = Surface(BALL)
    assert plain.proxy is plain
    assert plain.on_proxy(labels) is labels
    assert plain.from_proxy(labels) is labels


def test_surfaces_of_one_mesh_share_a_cache_of_bounded_size():
    mesh = sphere(1)
    first = Surface(mesh).closest(POINTS)
    assert Surface(mesh).closest(POINTS.copy())[0] is first[0]
    assert Surface(mesh).contains(POINTS) is Surface(mesh).contains(POINTS)
    for k in range(MAX_CACHED_RESULTS):
        Surface(mesh).closest(POINTS + k + 1)
    assert len(Surface(mesh).memoize("results of closest", dict)) == MAX_CACHED_RESULTS
    assert Surface(mesh).closest(POINTS)[0] is not first[0]
    moved = mesh.with_vertices(2 * mesh.vertices)
    assert Surface(moved).distance(POINTS) != pytest.approx(first[0])


def test_cached_results_are_read_only_and_equal_to_new_ones():
    mesh = torus(1.0, 0.3, 48, 16)
    points = np.random.default_rng(0).uniform(-1, 1, (50, 3))
    surface, other = Surface(mesh), Surface(torus(1.0, 0.3, 48, 16))
    first, inside = surface.distance(points), surface.contains(points)
    assert surface.closest(points.copy())[0] is surface.closest(points)[0]
    assert not first.flags.writeable
    assert not inside.flags.writeable
    for shift in np.linspace(0, 1, 40):  # more queries than are cached
        assert np.array_equal(surface.distance(points + shift), other.closest(points + shift)[0])
    assert np.array_equal(surface.distance(points), first)
    assert np.array_equal(surface.contains(points), inside)


def test_a_coarse_sphere():
    surface = Surface(sphere(3))
    assert np.array_equal(surface.contains(np.array([[0, 0, 0], [0, 0, 2.0]])), [True, False])
    distance = surface.ray_distance(np.array([[0.0, 0, 0], [0, 0, 2]]), np.array([[0.0, 0, 1], [0, 0, 1]]))
    assert distance[0] == pytest.approx(1, rel=0.02)
    assert np.isinf(distance[1])
