"""The heat method, unfolded and as in its paper: closed forms, libigl's exact distances, invariances, components."""

import igl
import numpy as np
import pytest
from helpers import joined, moved

import lbskel
from lbskel import HeatMethod, Mesh, MeshError
from lbskel.operators import OPERATORS
from lbskel.shapes import capsule, flat_grid, sphere, torus


def exact_distances(mesh, source):
    """Distances along the polyhedron, by libigl: Mitchell, Mount, Papadimitriou 1987."""
    V, F = np.array(mesh.vertices), np.array(mesh.faces)
    none = np.empty(0, dtype=np.int64)
    return igl.exact_geodesic(V, F, np.array([source]), none, np.arange(len(V)), none)


@pytest.mark.parametrize("operator", ["robust", "cotangent", "intrinsic_delaunay", "mollified"])
def test_distances_on_the_sphere_are_angles(operator):
    mesh = sphere(4)
    V = mesh.vertices
    method = HeatMethod(mesh, operator)
    for source in (0, 100):
        angles = np.arccos(np.clip(V @ V[source], -1, 1))
        assert np.abs(method.distance(source) - angles).mean() < 0.004 * np.pi  # half of it, measured
        assert np.abs(method.distance(source, unfolded=False) - angles).mean() < 0.01 * np.pi  # the same


@pytest.mark.parametrize("unfolded", [True, False])
def test_the_error_on_the_sphere_is_about_of_the_first_order(unfolded):
    errors = []
    for level in (3, 4, 5):
        W = sphere(level).vertices
        found = lbskel.geodesic_distance(sphere(level), 0, unfolded=unfolded)
        errors.append(np.abs(found - np.arccos(np.clip(W @ W[0], -1, 1))).mean())
    assert errors[0] > 1.5 * errors[1] > 2 * errors[2]


def test_distances_in_the_plane_are_straight():
    grid = flat_grid(50, 50)
    V = grid.vertices
    middle = 25 * 50 + 25
    exact = np.linalg.norm(V - V[middle], axis=1)
    assert np.abs(HeatMethod(grid).distance(middle) - exact).max() < 1e-5  # what keeps thin triangles from being flat
    assert np.abs(HeatMethod(grid).distance(middle, unfolded=False) - exact).max() < 0.03


def test_an_obtuse_triangle_at_a_boundary_makes_no_path_shorter():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 1, 0], [2, -0.3, 0]], [[0, 1, 2], [1, 0, 3]])
    expected = [np.hypot(2, 0.3), np.hypot(1, 0.3)]
    assert HeatMethod(mesh).distance(3)[:2] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("height", [0.3, 3.0])
def test_a_fin_on_an_edge_makes_no_path_shorter(height):
    mesh = capsule(3.0, 0.4, 8)
    n, method = len(mesh.vertices), HeatMethod(mesh)
    for face in mesh.faces[:: len(mesh.faces) // 7]:
        middle = mesh.vertices[face[:2]].mean(axis=0)
        outwards = middle * [1, 1, 0] / np.linalg.norm(middle[:2])
        fin = Mesh(np.vstack([mesh.vertices, middle + height * outwards]), np.vstack([mesh.faces, [*face[:2], n]]))
        with_fin = HeatMethod(fin)
        for source in (0, n // 3, n - 1):
            found = with_fin.distance(source)
            straight = np.linalg.norm(fin.vertices - fin.vertices[source], axis=1)
            assert (found >= straight - 1e-9).all()
            assert np.abs(found[:n] - method.distance(source)).max() < 1e-9


def test_distances_are_those_of_the_oriented_surface_without_repeated_faces(ring):
    F = np.where(np.arange(len(ring.faces))[:, None] % 3 == 0, ring.faces[:, ::-1], ring.faces)
    soup = Mesh(ring.vertices, np.vstack([F, F[:5, [1, 2, 0]], [[0, 0, 1], [2, 2, 2]]]))
    expected = HeatMethod(ring).distance(7)
    # another order of the faces, another diagonal of cocircular vertices
    assert np.abs(HeatMethod(soup).distance(7) - expected).max() < 0.02 * expected.max()


def test_faces_that_use_a_vertex_twice_connect_nothing():
    lines = Mesh(np.eye(3), [[0, 0, 1], [1, 1, 2]])
    assert HeatMethod(lines, "random_walk").distance(0).tolist() == [0, np.inf, np.inf]


@pytest.mark.parametrize("shape", [lambda: torus(1.0, 0.4, 60, 30), lambda: flat_grid(20, 30)], ids=["torus", "open"])
def test_the_mean_error_against_exact_distances_is_small(shape):
    mesh = shape()
    exact = exact_distances(mesh, 7)
    method = HeatMethod(mesh)
    assert np.abs(method.distance(7) - exact).mean() < 0.005 * exact.max()
    assert np.abs(method.distance(7, unfolded=False) - exact).mean() < 0.02 * exact.max()


def test_several_sources_are_the_least_of_each():
    mesh = torus(1.0, 0.3, 48, 24)
    method = HeatMethod(mesh)
    sources = [0, 300, 700]
    for unfolded, bound in ((True, 0.005), (False, 0.05)):  # the heat blends them where two are equally near
        each = method.distances(sources, unfolded=unfolded)
        assert each.shape == (len(mesh.vertices), 3)
        together = method.distance(sources, unfolded=unfolded)
        assert np.abs(together - each.min(axis=1)).mean() < bound
        assert (together[sources] == 0).all()
        assert np.array_equal(each[:, 1], method.distance(300, unfolded=unfolded))


def test_moving_turning_scaling_and_renumbering():
    mesh = torus(1.0, 0.3, 30, 15)
    expected = HeatMethod(mesh).distance(17)
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    order = np.random.default_rng(1).permutation(len(mesh.vertices))
    place = np.argsort(order)
    moved_mesh = Mesh(1e3 * (mesh.vertices @ turn.T)[order] + 50.0, place[mesh.faces])
    found = HeatMethod(moved_mesh).distance(int(place[17]))
    # cocircular vertices of the torus are triangulated by chance, which costs the accuracy of the method
    assert np.abs(found / 1e3 - expected[order]).max() < 0.02
    exactly = HeatMethod(mesh.with_vertices(2.0**40 * mesh.vertices)).distance(17)
    assert np.array_equal(exactly, 2.0**40 * expected)


def test_a_mask_stands_for_its_vertices_as_sources(ring):
    method, mask = HeatMethod(ring), ring.vertices[:, 0] > np.quantile(ring.vertices[:, 0], 0.9)
    vertices = np.flatnonzero(mask)
    assert np.array_equal(method.distance(mask), method.distance(vertices))
    assert np.array_equal(method.extend(mask, vertices), method.extend(vertices, vertices))
    assert np.array_equal(method.distances(mask), method.distances(vertices))


def test_a_source_that_is_given_twice_has_the_mean_of_its_values(ring):
    method = HeatMethod(ring)
    assert np.array_equal(method.distance([3, 3, 40]), method.distance([3, 40]))
    assert method.extend([3, 3], [1.0, 2.0]) == pytest.approx(1.5)


def test_components_without_a_source_are_infinitely_far(ring):
    large = ring.with_vertices(16.0 * ring.vertices + 50.0)
    two = joined(ring, large)
    mesh = Mesh(np.concatenate([two.vertices, [[99.0, 0, 0]]]), two.faces)
    method = HeatMethod(mesh)
    n = len(ring.vertices)
    for unfolded in (True, False):
        distance = method.distance(3, unfolded=unfolded)
        assert np.isfinite(distance[:n]).all()
        assert np.isinf(distance[n:]).all()
        # each has a time of its own; lengths are mollified relative to the whole
        alone = HeatMethod(ring).distance(3, unfolded=unfolded)
        assert np.abs(distance[:n] - alone).max() < (1e-4 if unfolded else 1e-9)
        both = method.distance([3, n + 3], unfolded=unfolded)
        assert np.abs(both[n : 2 * n] - 16 * both[:n]).max() < (1e-3 if unfolded else 1e-7)
    alone = method.distance(2 * n)
    assert alone[-1] == 0
    assert np.isinf(alone[:-1]).all()


@pytest.mark.parametrize("operator", [name for name in OPERATORS if name != "mean_value"])  # which is not symmetric
def test_distances_as_published_have_the_unit_of_lengths_with_every_operator(operator):
    V = sphere(3).vertices
    angles = np.arccos(np.clip(V @ V[7], -1, 1))
    found = HeatMethod(sphere(3), operator).distance(7, unfolded=False)
    assert np.abs(found - angles).mean() < 0.015 * np.pi  # 0.009 by random_walk, the most, measured


@pytest.mark.parametrize("operator", ["random_walk", "graph", "inverse_distance", "robust"])
def test_the_time_is_in_squared_edges_whatever_the_mass_is(operator):
    """Where masses are degrees, a time in squared lengths would change with the unit and the place of the mesh."""
    mesh = sphere(3)
    there = mesh.with_vertices(1.7 * mesh.vertices + 20.0)
    sources, values = [0, 50, 300], [1.0, 2.0, 7.0]
    expected = HeatMethod(mesh, operator).extend(sources, values)
    assert np.abs(HeatMethod(there, operator).extend(sources, values) - expected).max() < 1e-9


def test_an_operator_that_connects_components_leaves_them_apart():
    """Heat of ``heat_kernel`` passes between spheres at a distance of half an edge."""
    mesh = joined(sphere(3), sphere(3).with_vertices(sphere(3).vertices + [2.05, 0, 0]))
    method = HeatMethod(mesh, "heat_kernel")
    n = len(mesh.vertices) // 2
    for unfolded in (True, False):
        found = method.distance(0, unfolded=unfolded)
        assert np.isinf(found[n:]).all()
        alone = HeatMethod(sphere(3), "heat_kernel").distance(0, unfolded=unfolded)
        assert np.abs(found[:n] - alone).max() < 0.1


def test_vertices_that_the_operator_couples_with_no_other_are_reached_too():
    """``heat_kernel`` has the radius of the fine part of a mesh; an operator without couplings has no heat at all."""
    fine = flat_grid(9, 8)
    n, side = len(fine.vertices), np.flatnonzero(fine.vertices[:, 0] > 1 - 1e-9)
    wing = [[side[0], n, side[-1]], [n, n + 1, side[-1]], [n, n + 2, n + 1]]
    corners = [[3, 0, 0], [3, 1, 0], [6, 0.5, 0]]
    mesh = Mesh(np.concatenate([fine.vertices, corners]), np.concatenate([fine.faces, wing]))

    def uncoupled(given):
        return lbskel.Laplacian(0.0 * lbskel.laplacian(given).stiffness, lbskel.laplacian(given).mass)

    for operator in ("heat_kernel", uncoupled):
        for source in (0, n + 2):
            assert np.abs(HeatMethod(mesh, operator).distance(source) - HeatMethod(mesh).distance(source)).max() < 1e-9
    assert np.isinf(HeatMethod(mesh, "heat_kernel").distance(0, unfolded=False)[n:]).all()
    assert np.isinf(HeatMethod(mesh, uncoupled).distance(0, unfolded=False)[1:]).all()


def test_long_shapes_do_not_underflow():
    """3,000 edges from end to end: exp(-3000) is zero, so the time has to grow."""
    n = 3000
    strip = flat_grid(n, 2)
    V = np.stack([np.repeat(np.arange(n), 2), np.tile([0.0, 1.0], n), np.zeros(2 * n)], axis=1)
    order = np.lexsort((strip.vertices[:, 1], strip.vertices[:, 0]))
    mesh = strip.with_vertices(V[np.argsort(order)])
    first = int(order[0])
    exact = np.linalg.norm(mesh.vertices - mesh.vertices[first], axis=1)
    method = HeatMethod(mesh)
    for unfolded in (True, False):
        found = method.distance(first, unfolded=unfolded)
        assert np.isfinite(found).all()
        assert np.abs(found - exact).max() < 0.01 * n


def test_the_gradient_has_length_one_nearly_everywhere():
    method = HeatMethod(sphere(4))
    distance = method.distance(0)
    assert method.gradient_error(distance) < 0.03
    assert method.gradient_error(method.distance(0, unfolded=False)) < 0.03
    assert method.gradient_error(2 * distance) == pytest.approx(1.0, abs=0.06)


def test_values_are_extended_from_the_nearest_source():
    mesh = torus(1.0, 0.3, 48, 24)
    method = HeatMethod(mesh)
    sources = np.array([0, 300, 700])
    colors = np.eye(3)
    extended = method.extend(sources, colors)
    assert np.abs(extended.sum(axis=1) - 1.0).max() < 1e-9
    assert extended.min() >= -1e-12
    nearest = method.distances(sources).argmin(axis=1)
    assert (extended.argmax(axis=1) == nearest).mean() > 0.97  # all but the vertices between two
    assert np.abs(method.extend(sources, [2.0, 2.0, 2.0]) - 2.0).max() < 1e-9
    single = method.extend(sources, [1.0, 2.0, 4.0])
    assert np.abs(single - extended @ [1.0, 2.0, 4.0]).max() < 1e-9


def test_values_are_not_extended_to_other_components(ring):
    mesh = joined(ring, moved(ring, 5.0))
    extended = HeatMethod(mesh).extend([0], [3.0])
    n = len(ring.vertices)
    assert np.abs(extended[:n] - 3.0).max() < 1e-9
    assert np.isnan(extended[n:]).all()
    isolated = Mesh(np.concatenate([ring.vertices, [[9.0, 9, 9]]]), ring.faces)
    assert HeatMethod(isolated).extend([n], [5.0])[n] == 5.0


def test_what_cannot_be_is_refused(ring):
    method = HeatMethod(ring)
    with pytest.raises(MeshError, match="no vertices of the mesh"):
        method.distance(10**6)
    with pytest.raises(MeshError, match="no vertices of the mesh"):
        method.distance([-1])
    for nothing in ([], np.zeros(len(ring.vertices), dtype=bool)):
        with pytest.raises(MeshError, match="no source"):
            method.distance(nothing)
    for wrong in ([0.5], [[1]], [[1], [2, 3]], "a", True):
        with pytest.raises(MeshError, match="sources must be a list of vertex indices"):
            method.distance(wrong)
    with pytest.raises(MeshError, match="finite value"):
        method.extend([0, 1], [1.0])
    for value in (np.nan, "a"):
        with pytest.raises(MeshError, match=r"values must be (finite|an array of) numbers"):
            method.extend([0], [value])
    with pytest.raises(MeshError, match="not symmetric"):
        HeatMethod(ring, "mean_value")
    with pytest.raises(MeshError, match="no area"):
        HeatMethod(ring.with_vertices(np.ones_like(ring.vertices)))
