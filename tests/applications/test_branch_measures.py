"""Polylines, sections and shares of a mesh: closed forms."""

import numpy as np
import pytest
from helpers import mesh_of_branches, nearest_rows, path_in

from lbskel import MeshError, Skeleton
from lbskel.applications.branch_measures import Polyline, section_areas, shared_among_branches
from lbskel.shapes import capsule, sphere, torus


def test_cones_of_a_polyline():
    line = Polyline(np.array([[0.0, 0, 0], [0, 0, 3], [0, 0, 7]]), np.array([4.0, 0, 0]), np.array([0.0, 3, 7]))
    assert line.cones() == pytest.approx((np.pi * 4 * 5, np.pi * 16 * 3 / 3))
    assert line.mean_radius == pytest.approx(6 / 7)
    assert Polyline(np.zeros((2, 3)), np.array([1.0, 3.0]), np.zeros(2)).mean_radius == 2


@pytest.mark.parametrize("orientation", [1, -1])
def test_volumes_and_areas_sum_to_those_of_the_mesh(orientation):
    mesh = capsule(4.0, 0.5, 16)
    mesh = mesh if orientation == 1 else type(mesh)(mesh.vertices, mesh.faces[:, ::-1])
    skeleton = path_in(mesh, [[0, 0, z] for z in np.linspace(-2, 2, 9)])
    area, volume = shared_among_branches(skeleton, mesh, skeleton.branches)
    assert area == pytest.approx([mesh.area])
    assert volume == pytest.approx([abs(mesh.volume)])  # nodes on a line enclose nothing


def test_a_ball_is_shared_by_opposite_rays_in_equal_parts():
    mesh = sphere(3)
    nodes = 0.5 * np.array([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    skeleton = Skeleton(nodes, [[0, 1], [0, 2], [0, 3], [0, 4]], np.ones(5), nearest_rows(mesh.vertices, nodes))
    area, _ = shared_among_branches(skeleton, mesh, skeleton.branches)
    assert area == pytest.approx(np.full(4, mesh.area / 4), rel=0.05)  # ties go to one of two rays
    assert area.sum() == pytest.approx(mesh.area)


def test_a_map_of_another_mesh_is_an_error():
    with pytest.raises(MeshError, match="maps 0 vertices to its nodes, and the mesh has 642"):
        shared_among_branches(Skeleton([[0, 0, 0]], [], [1.0]), sphere(3), ())


def test_sections_of_a_ring_are_those_of_its_tube():
    mesh, angles = torus(1.0, 0.25, 48, 48), np.linspace(0, 2 * np.pi, 48, endpoint=False)
    nodes = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    ring = Skeleton(nodes, np.stack([np.arange(48), (np.arange(48) + 1) % 48], axis=1), np.full(48, 0.25))
    path = ring.branches[0]
    line = Polyline.of(ring, path)
    means, profiles = section_areas(ring, (path,), [line], mesh)
    exact = 48 / 2 * 0.25**2 * np.sin(2 * np.pi / 48)  # of the polygon; at the seam the chord has half its length
    assert means == pytest.approx([exact], rel=0.02)
    assert profiles[0] == pytest.approx(exact, rel=0.02)


def test_a_branch_without_length_or_outside_of_the_mesh_has_no_section():
    mesh = sphere(2)
    for points in (np.zeros((2, 3)), np.array([[5.0, 0, 0], [6, 0, 0]])):
        skeleton = Skeleton(points, [[0, 1]], [np.nan, np.nan])
        path = np.array([0, 1])
        means, profiles = section_areas(skeleton, (path,), [Polyline.of(skeleton, path)], mesh)
        assert np.isnan(means).all()
        assert np.isnan(profiles).all()


@pytest.mark.parametrize(("length", "has_section"), [(1.9, False), (3.0, True)])
def test_a_twig_no_longer_than_the_reach_of_its_junction_has_no_section(length, has_section):
    """Planes across its part in the trunk would cut that lengthwise."""
    nodes = np.array([[0, 0, -4], [0, 0, 0], [0, 0, 4], *np.linspace([1, 0, 0], [length, 0, 0], 6)])
    edges = [[0, 1], [1, 2], [1, 3], *([k, k + 1] for k in range(3, 8))]
    radii = np.array([1.0] * 3 + [0.2] * 6)
    skeleton = Skeleton(nodes, edges, radii)
    trunk, twig = (nodes[[0, 2]], 1.0), (nodes[[1, 8]], 0.2)
    [path] = (branch for branch in skeleton.branches if 8 in branch)
    path = path if path[0] == 1 else path[::-1]
    mesh = mesh_of_branches([trunk, twig], step=0.1)
    means, profiles = section_areas(skeleton, (path,), [Polyline.of(skeleton, path)], mesh)
    assert np.isfinite(means).tolist() == [has_section]
    assert not has_section or means[0] == pytest.approx(np.pi * 0.2**2, rel=0.1)
    assert np.isfinite(profiles).all()
