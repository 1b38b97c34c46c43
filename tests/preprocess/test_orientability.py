"""Surfaces without an inside: distinguished from sheets and from bodies with a defect, named, and skipped."""

import igl
import numpy as np
import pytest
from helpers import joined, moved

from benchmarks.damage import damaged
from lbskel import Mesh, MeshError, Skeleton, check, score, skeletonize
from lbskel.preprocess.orientability import _orientation_seam, is_flat_sheet, is_sheet, no_inside
from lbskel.refinement.radii import own_radii
from lbskel.shapes import capsule, cylinder, flat_grid, sphere, torus

RING = torus(1.0, 0.3, 30, 16)
BROKEN = damaged("Moebius strip", RING)
STRIP = Mesh(BROKEN.vertices, BROKEN.faces)


def flattened(height):
    return RING.with_vertices(RING.vertices * [1, 1, height])


def klein_bottle(k=60, m=30):
    """A figure of eight swept around with half a twist; it intersects itself along a circle."""
    u, v = np.meshgrid(2 * np.pi * np.arange(k) / k, 2 * np.pi * np.arange(m) / m, indexing="ij")
    reach = 3 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    height = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    a = np.arange(k * m).reshape(k, m)
    b = np.concatenate([a[1:], a[:1, -np.arange(m) % m]])
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    faces = np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3)
    return Mesh(np.stack([reach * np.cos(u), reach * np.sin(u), height], axis=2).reshape(-1, 3), faces)


@pytest.mark.parametrize("mesh", [flattened(0.0), flattened(1e-6), STRIP])
def test_a_surface_without_an_inside_is_rejected_with_its_position(mesh):
    assert no_inside(mesh) is not None
    message = r"component 0, at \(.*\), (is flat, its two sides only .* apart|is non-orientable).*: give it a thickness"
    with pytest.raises(MeshError, match=message):
        skeletonize(mesh)
    report = check(mesh)
    assert not report.is_advised
    assert "not advised: component 0, at" in report.findings[-1]


def test_a_vertex_of_the_orientation_seam_is_named():
    """The faces have opposite orientation along the last row, and after any reorientation across the strip."""
    _, vertex = no_inside(STRIP)
    turned = Mesh(STRIP.vertices, igl.bfs_orient(STRIP.faces)[0])
    start, end = turned.half_edges.T
    balance = np.bincount(turned.edge_of_half_edge, np.where(start < end, 1, -1))
    assert vertex in turned.edges[(turned.faces_per_edge == 2) & (balance != 0)]


@pytest.mark.parametrize("mesh", [RING, flattened(1e-3), flat_grid(), Mesh(RING.vertices, RING.faces[9:])])
def test_bodies_and_sheets_are_accepted(mesh):
    assert no_inside(mesh) is None


def test_a_surface_that_faces_one_way_is_a_sheet_and_a_tube_is_none():
    ground, tube = flat_grid(), cylinder(1.0, 4.0)
    hills = ground.with_vertices(ground.vertices + 0.1 * np.sin(6 * ground.vertices[:, :1]) * [0, 0, 1])
    assert [is_sheet(mesh) for mesh in (ground, hills, tube, RING)] == [True, True, False, False]
    assert [is_flat_sheet(mesh) for mesh in (ground, hills, tube, RING)] == [True, False, False, False]


def test_a_body_with_a_twisted_handle_is_contracted():
    """A handle between two ends of a ball, glued the wrong way round: most of the surface separates an inside."""
    ball = sphere(3)
    height = ball.vertices[ball.faces].mean(axis=1)[:, 2]
    ends = height.argmax(), height.argmin()
    A, B = ball.faces[list(ends)]
    handle = [q for i in range(3) for q in ([A[i], A[i - 2], B[i]], [A[i - 2], B[i - 2], B[i]])]
    given = Mesh(ball.vertices, np.concatenate([np.delete(ball.faces, ends, axis=0), handle]))
    assert no_inside(given) is None
    assert check(given).is_advised
    assert len(skeletonize(given).nodes) > 0


def test_a_body_with_a_one_sided_defect_is_accepted_far_from_the_origin():
    """Two faces of a ball are joined by a handle that is glued the wrong way round."""
    ball = sphere(3)
    (a, b, c), (d, e, f) = ball.faces[[100, 700]]
    handle = [[a, d, e], [a, e, b], [b, e, f], [b, f, c], [c, f, d], [c, d, a]]
    mesh = Mesh(ball.vertices, np.concatenate([np.delete(ball.faces, [100, 700], axis=0), handle]))
    assert len(_orientation_seam(mesh))
    assert no_inside(mesh) is None
    assert no_inside(mesh.with_vertices(mesh.vertices + 1e6)) is None


def test_randomly_reversed_faces_are_accepted():
    F = np.array(RING.faces)
    turned = np.random.default_rng(0).random(len(F)) < 0.3
    F[turned] = F[turned][:, ::-1]
    assert no_inside(Mesh(RING.vertices, F)) is None


def test_a_non_orientable_surface_around_a_volume_is_accepted():
    bottle = klein_bottle()
    assert bottle.is_closed
    assert not bottle.is_closed_manifold
    assert no_inside(bottle) is None


def test_a_flat_component_is_skipped():
    rod = capsule(3.0, 0.4, 12)
    skeleton = skeletonize(joined(rod, moved(flattened(0.0), 4.0)))
    assert (skeleton.n_components, len(skeleton.tips)) == (1, 2)
    assert "component 1, at (5." in skeleton.report["notes"][-1]
    assert skeleton.report["passed"] is False  # a component has none


def test_intersecting_bodies_are_measured_alone():
    """Two intersecting rings: the radii of each skeleton are measured on its own surface."""
    both = joined(RING, moved(RING, 0.9))
    skeleton = skeletonize(both)
    assert (skeleton.n_components, skeleton.cycle_rank) == (2, 2)
    assert skeleton.report["passed"]
    # nodes lie within 2 % of a radius of the circle, whose distance to its ring is 0.3 less what 16 sides take off
    assert own_radii(skeleton, both).radii == pytest.approx(np.full(len(skeleton.nodes), 0.29), rel=0.03)
    bare = Skeleton(skeleton.nodes, skeleton.edges, skeleton.radii)
    assert score(bare, both).passed


def test_a_skeleton_that_fails_its_score_has_not_passed():
    leaf = skeletonize(flat_grid())
    assert leaf.report["score"]["verdict"] == "fail"
    assert leaf.report["passed"] is False
