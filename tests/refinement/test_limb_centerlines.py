"""Centerlines of limbs: known axes of tubes, straight, bent and of uneven triangles."""

import itertools

import numpy as np
import pytest
from helpers import mesh_of_branches

from lbskel import Mesh
from lbskel.refinement.limb_centerlines import MAX_RINGS, trace_limbs
from lbskel.refinement.uncovered_limbs import Limbs
from lbskel.shapes import capsule


def limb_of(mesh, is_limb, radius, end=None):
    rows = np.flatnonzero(is_limb)
    return Limbs(np.array([rows[0] if end is None else end]), np.array([radius]), np.where(is_limb, 0, -1))


@pytest.fixture(scope="module")
def rod():
    """From z = -4.5 to 4.5, of radius 0.5."""
    return capsule(8.0, 0.5, 32)


def test_the_centerline_of_a_rod_goes_up_its_axis_to_the_center_of_its_cap(rod):
    [(line, _)] = trace_limbs(rod, limb_of(rod, rod.vertices[:, 2] > 0, 0.5))
    assert np.abs(line[:, :2]).max() < 1e-9
    assert (np.diff(line[:, 2]) > 0).all()
    assert 0.1 < line[0, 2] < 0.35  # half the distance of two rings above the lowest ring of vertices above 0
    assert line[-1, 2] == pytest.approx(4.0, abs=0.05)


def test_the_way_around_a_bend_leads_to_the_end_of_the_limb():
    """The end that is given is at the bend, which is farther from the foot than the end of the limb."""
    axis = np.array([[0.0, 0, 0], [0, 0, 4], [3, 0, 4], [3, 0, 1]])
    mesh = mesh_of_branches([(axis, 0.4)], step=0.1)
    bend = int(np.linalg.norm(mesh.vertices - [3.4, 0, 4.4], axis=1).argmin())
    [(line, _)] = trace_limbs(mesh, limb_of(mesh, (mesh.vertices[:, 2] > 0.5) | (mesh.vertices[:, 0] > 1), 0.4, bend))
    assert line[-1] == pytest.approx([3, 0, 1], abs=0.25)  # half the distance of two rings, and the noise of edges
    assert line[0] == pytest.approx([0, 0, 0.5], abs=0.2)  # half the distance of two rings from the rim
    points = np.concatenate([a + np.linspace(0, 1, 50)[:, None] * (b - a) for a, b in itertools.pairwise(axis)])
    assert np.linalg.norm(line[:, None] - points, axis=2).min(axis=1).max() < 0.2  # half the radius, in the bends


def test_the_radii_are_those_of_the_rings(rod):
    [(line, radii)] = trace_limbs(rod, limb_of(rod, rod.vertices[:, 2] > 0, 0.5))
    assert radii[line[:, 2] < 3.5] == pytest.approx(0.5, rel=0.1)  # rings of edge distances are jagged


def test_the_centerline_goes_on_beyond_an_oblique_rim(rod):
    """The rim leads across the rod, from z = 0 to 2: the limb is as thick below its highest point."""
    [(line, _)] = trace_limbs(rod, limb_of(rod, rod.vertices[:, 2] > 1 + 2 * rod.vertices[:, 0], 0.5))
    assert 0 < line[0, 2] < 0.5
    assert np.abs(line[:, :2]).max() < 0.05  # a tenth of the radius: ways along edges are longer in some directions


def test_the_centerline_ends_where_the_body_begins():
    """The limb's vertices include some of the body, whose radius is five times that of the limb."""
    axis, twig = np.array([[-2.0, 0, 0], [2, 0, 0]]), np.array([[0.0, 0, 0], [0, 0, 2.5]])
    mesh = mesh_of_branches([(axis, 1.0), (twig, 0.2)], step=0.08)
    [(line, _)] = trace_limbs(mesh, limb_of(mesh, np.linalg.norm(mesh.vertices - [0, 0, 2], axis=1) < 1.9, 0.2))
    assert line[0] == pytest.approx([0, 0, 1], abs=0.15)
    assert line[-1] == pytest.approx([0, 0, 2.5], abs=0.1)


def test_the_centerline_ends_where_the_vertices_of_another_limb_begin(rod):
    """A limb on the side of the rod is nearer to one side of the rings around the rod."""
    x, _, z = rod.vertices.T
    limb_of_vertex = np.where(z > 1, 0, np.where((x > 0.2) & (z > -1), 1, -1))
    limbs = Limbs(np.array([z.argmax(), np.flatnonzero(limb_of_vertex == 1)[0]]), np.array([0.5, 0.5]), limb_of_vertex)
    (line, _), _ = trace_limbs(rod, limbs)
    assert len(line) > 2
    assert np.abs(line[:, :2]).max() < 0.05


def test_uneven_triangles_do_not_draw_the_centerline_to_one_side():
    """Vertices of one side are five times as dense as those of the other."""
    around = np.concatenate(
        [np.linspace(0, np.pi, 50, endpoint=False), np.linspace(np.pi, 2 * np.pi, 10, endpoint=False)]
    )
    z = np.linspace(0, 4, 41)
    V = np.stack([np.tile(np.cos(around), 41), np.tile(np.sin(around), 41), np.repeat(z, 60)], axis=1)
    i, j = np.meshgrid(np.arange(40), np.arange(60), indexing="ij")
    a, b = (60 * i + j).ravel(), (60 * i + (j + 1) % 60).ravel()
    F = np.concatenate([np.stack([a, b, a + 60], axis=1), np.stack([b, b + 60, a + 60], axis=1)])
    top = len(V)
    F = np.concatenate([F, np.stack([2400 + np.arange(60), 2400 + (np.arange(60) + 1) % 60, np.full(60, top)], axis=1)])
    mesh = Mesh(np.concatenate([V, [[0.0, 0, 4]]]), F)
    [(line, _)] = trace_limbs(mesh, limb_of(mesh, np.arange(top + 1) >= 60, 1.0))
    straight = line[line[:, 2] < 2.5]
    assert len(straight) > 1
    assert np.abs(straight[:, :2]).max() < 0.1  # the mean of the vertices is 0.4 off the axis


def test_a_limb_without_a_whole_ring_has_no_centerline(rod):
    [(line, _)] = trace_limbs(rod, limb_of(rod, np.arange(len(rod.vertices)) == rod.vertices[:, 2].argmax(), 0.5))
    assert len(line) == 0


def test_the_number_of_rings_is_bounded(rod):
    [(line, _)] = trace_limbs(rod, limb_of(rod, rod.vertices[:, 2] > 0, 1e-9))
    assert 1 < len(line) <= MAX_RINGS


def test_each_limb_has_its_own_centerline(rod):
    z = rod.vertices[:, 2]
    both = Limbs(np.array([z.argmax(), z.argmin()]), np.array([0.5, 0.5]), np.where(z > 2, 0, np.where(z < -1, 1, -1)))
    (up, _), (down, _) = trace_limbs(rod, both)
    assert up[[0, -1], 2] == pytest.approx([2, 4], abs=0.2)
    assert down[[0, -1], 2] == pytest.approx([-1, -4], abs=0.2)
