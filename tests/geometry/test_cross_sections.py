"""Cross-sections: exact on known polygons, and of the right curve where a plane has several."""

import numpy as np
import pytest
import trimesh
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lbskel import Mesh
from lbskel.geometry.cross_sections import cross_sections
from lbskel.shapes import capsule, cylinder, make, torus, tube

Z = np.array([[0.0, 0.0, 1.0]])


def polygon_area(n, radius):
    return 0.5 * n * radius**2 * np.sin(2 * np.pi / n)


def test_the_section_of_a_prism_is_its_polygon():
    mesh = capsule(2.0, 0.5, 16)
    section = cross_sections(mesh, np.array([[0.1, -0.05, 0.2]]), Z)
    # exact cuts of planar facets: only rounding is left
    assert section.surrounds[0]
    assert section.areas[0] == pytest.approx(polygon_area(16, 0.5), rel=1e-12)
    assert np.abs(section.centroids[0] - [0, 0, 0.2]).max() < 1e-12
    assert section.lengths[0] == pytest.approx(32 * 0.5 * np.sin(np.pi / 16), rel=1e-12)


def test_of_two_curves_the_one_around_the_point_is_taken():
    mesh = torus(1.0, 0.3, 64, 24)
    points = np.array([[1.05, 0, 0.02], [-1.05, 0, 0.02]])
    normals = np.array([[0.0, 1, 0], [0.0, 1, 0]])
    section = cross_sections(mesh, points, normals)
    assert section.surrounds.all()
    assert np.abs(section.centroids[:, 0] - [1, -1]).max() < 1e-12


def test_from_outside_the_nearest_curve_is_taken():
    mesh = torus(1.0, 0.3, 64, 24)
    section = cross_sections(mesh, np.array([[1.5, 0, 0]]), np.array([[0.0, 1, 0]]))
    assert section.is_cut[0]
    assert not section.surrounds[0]
    assert np.abs(section.centroids[0] - [1, 0, 0]).max() < 1e-12


def test_a_plane_that_misses_the_mesh_has_no_section():
    section = cross_sections(capsule(), np.array([[0, 0, 9.0]]), Z)
    assert not section.is_cut[0]
    assert np.array_equal(section.centroids[0], [0, 0, 9])


def test_an_open_curve_has_the_centroid_of_its_points():
    whole = cylinder(0.5, 2.0, 32, 5)
    angle = np.arctan2(*whole.vertices[whole.faces].mean(axis=1)[:, [1, 0]].T)
    half = Mesh(whole.vertices, whole.faces[np.abs(angle) < np.pi / 2])
    section = cross_sections(half, np.array([[0.1, 0.0, 0.13]]), Z)
    # the centroid of a half circle's arc lies 2 r / pi from its center; 16 chords come within a part in 100
    assert section.centroids[0, 0] == pytest.approx(2 * 0.5 / np.pi, rel=0.01)
    assert section.centroids[0, 1] == pytest.approx(0, abs=1e-12)


def test_sampling_density_does_not_move_the_centroid():
    angle = np.concatenate(
        [np.linspace(0, np.pi, 40, endpoint=False), np.linspace(np.pi, 2 * np.pi, 5, endpoint=False)]
    )
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    n = len(ring)
    V = np.concatenate([ring, ring + [0, 0, 1.0], [[0, 0, 0], [0, 0, 1.0]]])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    side = np.concatenate([np.stack([i, j, n + i], 1), np.stack([j, n + j, n + i], 1)])
    caps = np.concatenate([np.stack([j, i, 0 * i + 2 * n], 1), np.stack([n + i, n + j, 0 * i + 2 * n + 1], 1)])
    mesh = Mesh(V, np.concatenate([side, caps]))
    assert mesh.is_closed_manifold
    section = cross_sections(mesh, np.array([[0.0, 0, 0.4]]), Z)
    a, b = ring[i, :2], ring[j, :2]
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    exact = ((a + b) * cross[:, None]).sum(axis=0) / (3 * cross.sum())
    assert np.abs(section.centroids[0, :2] - exact).max() < 1e-12
    assert np.abs(exact).max() < 0.25 < np.abs(V[:n, :2].mean(axis=0)).max()


def test_the_label_fraction_is_the_part_of_the_curve_with_the_label():
    mesh = capsule(2.0, 0.5, 16)
    labels = (mesh.vertices[mesh.faces].mean(axis=1)[:, 0] > 0).astype(np.int64)
    section = cross_sections(mesh, np.array([[0, 0, 0.2]]), Z, face_labels=labels, labels=np.array([1]))
    assert section.label_fractions[0] == pytest.approx(0.5, abs=1e-12)


def test_sections_of_many_planes_equal_those_of_each_alone():
    mesh = tube([[0, 0, 0], [1, 0.2, 0], [2, 0, 0.3]], 0.2)
    points = np.linspace([0.1, 0, 0], [1.9, 0, 0.2], 17)
    normals = np.tile([[1.0, 0, 0]], (17, 1))
    together = cross_sections(mesh, points, normals)
    for i in range(17):
        alone = cross_sections(mesh, points[i : i + 1], normals[i : i + 1])
        for name in ("centroids", "areas", "lengths", "radii", "label_fractions", "surrounds"):
            assert np.array_equal(getattr(together, name)[i], getattr(alone, name)[0])


def every_curve(mesh, point, normal):
    """Area of each curve of a plane, and whether it surrounds the point; cut by trimesh and joined by position."""
    segments = trimesh.intersections.mesh_plane(
        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False), normal, point
    )
    if len(segments) == 0:
        return []
    ends = np.round(segments.reshape(-1, 3), 9)
    number = np.unique(ends, axis=0, return_inverse=True)[1].reshape(-1, 2)
    graph = coo_array((np.ones(len(number)), number.T), shape=(number.max() + 1,) * 2)
    curve = connected_components(graph, directed=False)[1][number[:, 0]]
    first = np.cross(normal, [0.6, 0.0, 0.8])
    frame = np.stack([first, np.cross(normal, first)]) / np.linalg.norm(first)
    curves = []
    for each in np.unique(curve):
        polygon = walked(number[curve == each])
        place = dict(zip(number[curve == each].ravel(), segments[curve == each].reshape(-1, 3), strict=True))
        P = (np.array([place[n] for n in polygon]) - point) @ frame.T
        Q = np.roll(P, -1, axis=0)
        cross, dot = P[:, 0] * Q[:, 1] - P[:, 1] * Q[:, 0], (P * Q).sum(axis=1)
        curves.append((abs(cross.sum() / 2), abs(np.arctan2(cross, dot).sum()) > np.pi))
    return curves


def walked(pairs):
    """The vertices of a closed curve in their order."""
    beside = {}
    for i, j in pairs:
        beside.setdefault(i, []).append(j)
        beside.setdefault(j, []).append(i)
    way = [pairs[0, 0], pairs[0, 1]]
    while way[-1] != way[0]:
        a, b = beside[way[-1]]
        way.append(b if a == way[-2] else a)
    return way[:-1]


def test_the_local_search_finds_the_smallest_curve_of_the_whole_plane():
    """Planes of a knot intersect several of its strands; at points off the axis the search has to be extended."""
    shape = make("knot", n_vertices=4000)
    rng = np.random.default_rng(0)
    at = rng.integers(len(shape.truth.nodes), size=60)
    points = shape.truth.nodes[at] + rng.normal(size=(60, 3)) * shape.truth.radii[at, None]
    normals = rng.normal(size=(60, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = cross_sections(shape.mesh, points, normals)
    assert 0.2 < found.surrounds.mean() < 0.8
    for point, normal, area, surrounds in zip(points, normals, found.areas, found.surrounds, strict=True):
        curves = every_curve(shape.mesh, point, normal)
        around = [size for size, surrounds_point in curves if surrounds_point]
        assert surrounds == bool(around)
        if around:
            assert area == pytest.approx(min(around), rel=1e-6)  # ends were joined at nine digits


@pytest.mark.parametrize(("reach", "is_found"), [(0.9, False), (1.1, True)])
def test_no_curve_is_searched_beyond_the_reach(reach, is_found):
    """The first search goes half as far again as a nearby vertex."""
    mesh = cylinder(1.0, 8.0, 32, 65)
    found = cross_sections(mesh, np.zeros((1, 3)), np.array([[0.0, 0, 1]]), max_reaches=np.array([reach]))
    assert found.is_cut.tolist() == [is_found]


def test_a_curve_is_followed_no_farther_than_asked():
    """A plane along a ring cuts it at two circles of radii 0.7 and 1.3; one across it at a circle of radius 0.3."""
    mesh = torus(1.0, 0.3, 96, 32)
    P, normals = np.array([[1.0, 0, 0], [1.0, 0, 0]]), np.array([[0.0, 0, 1], [0, 1, 0]])
    near = cross_sections(mesh, P, normals, max_reaches=np.full(2, 0.5))
    assert near.is_cut.tolist() == [False, True]
    whole, far = cross_sections(mesh, P, normals), cross_sections(mesh, P, normals, max_reaches=np.full(2, 9.0))
    assert whole.is_cut.all()
    for name in ("is_cut", "centroids", "areas", "lengths", "radii", "surrounds"):
        assert np.array_equal(getattr(whole, name), getattr(far, name))
        assert np.array_equal(getattr(whole, name)[1], getattr(near, name)[1])
