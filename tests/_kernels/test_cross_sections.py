"""Plane sections, of boxes whose sections are rectangles."""

import numpy as np
import pytest

from lbskel.geometry.cross_sections import cross_sections
from lbskel.geometry.mesh import Mesh
from lbskel.shapes import capsule

NO_LABELS = np.empty(0, dtype=np.int64)
X_PLANE = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # first axis y, second z, normal x


def sections(kernel, V, F, points, *, frame=X_PLANE, face_labels=NO_LABELS, labels=None):
    mesh = Mesh(V, F)
    tree = mesh.aabb_tree
    curves = kernel.SectionCurves(
        mesh.edge_of_half_edge, mesh.faces_per_edge, tree.order, tree.corners, tree.bounds, face_labels
    )
    points = np.array(points, dtype=np.float64)
    labels = np.zeros(len(points), dtype=np.int64) if labels is None else np.array(labels)
    reaches = np.full(len(points), np.inf)
    return curves.measure(points, np.tile(frame, (len(points), 1, 1)), labels, reaches)


def test_a_section_of_a_box_is_a_rectangle(kernel, box):
    """Diagonals cut each side of the rectangle at half its length, where x is one half."""
    V, F = box
    ((is_cut, surrounds, y, z, area, length, radius, own),) = sections(kernel, V * [1, 2, 6], F, [[0.5, 0.75, 1]])
    assert (is_cut, surrounds, own) == (1, 1, 1)
    assert (y, z) == pytest.approx((0.25, 2))
    assert (area, length) == pytest.approx((12, 16))
    # eight segments, four of length 1 and 3 from the centroid, four of length 3 and 1 from it
    assert radius == pytest.approx((4 * 1 * np.hypot(3, 0.5) + 4 * 3 * np.hypot(1, 1.5)) / 16)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_orientation_of_faces_and_normals_does_not_count(kernel, box, sign):
    V, F = box
    for frame in (X_PLANE, X_PLANE * [[1], [-1], [-1]]):
        (found,) = sections(kernel, V, np.ascontiguousarray(F[:, ::sign]), [[0.5, 0.25, 0.5]], frame=frame)
        assert found[:6] == pytest.approx([1, 1, 0.25, 0, 1, 4])


def test_no_section_where_the_plane_misses_the_mesh(kernel, box):
    assert (sections(kernel, *box, [[1.5, 0.5, 0.5], [-0.1, 0.5, 0.5]]) == 0).all()


def boxes(box, *placed):
    """Boxes by their lowest corner and size, as one mesh."""
    V, F = box
    corners = [np.array(low) + np.array(size) * V for low, size in placed]
    return np.concatenate(corners), np.concatenate([F + 8 * k for k in range(len(placed))])


def test_the_smallest_curve_around_the_point_counts(kernel, box):
    nested = boxes(box, ((0, 0, 0), (1, 9, 9)), ((0, 2, 2), (1, 5, 5)), ((0, 4, 4), (1, 1, 1)))
    found = sections(kernel, *nested, [[0.5, 4.5, 4.5], [0.5, 2.5, 2.5], [0.5, 0.5, 8.5]])
    assert found[:, 4] == pytest.approx([1, 25, 81])
    assert (found[:, 1] == 1).all()


def test_the_nearest_curve_counts_where_none_is_around_the_point(kernel, box):
    row = boxes(box, ((0, 0, 0), (1, 1, 1)), ((0, 4, 0), (1, 2, 2)), ((0, 9, 0), (1, 3, 3)))
    found = sections(kernel, *row, [[0.5, 1.5, 0.5], [0.5, 3.5, 0.5], [0.5, 30, 0.5]])
    assert found[:, 4] == pytest.approx([1, 4, 9])
    assert (found[:, 1] == 0).all()
    assert (found[:, 0] == 1).all()
    assert found[:, 2] == pytest.approx([0.5 - 1.5, 5 - 3.5, 10.5 - 30])


def test_a_curve_is_followed_to_its_end_far_from_the_point(kernel):
    """A capsule cut along its axis, from a point near its tip: what is near it already spans more than half a turn."""
    long = capsule(8.0, 0.5, 32)
    (found,) = sections(kernel, long.vertices, long.faces, [[0.001, 0.0, 4.1]])
    assert found[1] == 1
    assert found[3] == pytest.approx(-4.1, abs=1e-9)
    assert found[4:6] == pytest.approx([8 + 0.25 * np.pi, 16 + np.pi], rel=0.01)


def test_a_curve_that_is_not_closed_has_the_centroid_of_its_length(kernel, box):
    """A box without its top is cut in three sides of a square."""
    V, F = box
    is_top = (V[F][:, :, 2] == 1).all(axis=1)
    (found,) = sections(kernel, V, F[~is_top], [[0.5, 0.5, 0.25]])
    assert found[1] == 1  # the three sides subtend more than half a turn
    assert found[5] == pytest.approx(3)
    assert found[2:4] == pytest.approx([0, (2 * 0.5 + 0) / 3 - 0.25])
    (found,) = sections(kernel, V, F[~is_top], [[0.5, 0.5, 0.95]])
    assert found[1] == 1
    (found,) = sections(kernel, V, F[~is_top], [[0.5, 0.5, 1.05]])
    assert found[1] == 0


def test_the_fraction_on_faces_of_the_label(kernel, box):
    V, F = box
    labels = np.full(len(F), 5)
    labels[(V[F][:, :, 1] == 0).all(axis=1)] = 3
    labels[(V[F][:, :, 2] == 0).all(axis=1)] = -1  # counts for every label
    found = sections(kernel, V, F, [[0.5, 0.5, 0.5]] * 3, face_labels=labels, labels=[3, 5, 4])
    assert found[:, 7] == pytest.approx([0.5, 0.75, 0.25])


def test_arrays_of_other_lengths_are_errors(kernel, box):
    with pytest.raises(ValueError, match="a label for each face"):
        sections(kernel, *box, [[0.5, 0.5, 0.5]], face_labels=np.zeros(3, dtype=np.int64))
    with pytest.raises(ValueError, match="a frame, a label and a reach for each point"):
        sections(kernel, *box, [[0.5, 0.5, 0.5]], labels=[1, 2])


def test_the_search_ends_at_a_vertex_and_for_planes_that_are_not_finite(limbs):
    at = limbs.vertices[limbs.aabb_tree.order[:1]]
    points = np.concatenate([limbs.vertices[limbs.faces[:3, 0]], at, [[np.nan, 0, 0], [0, 0, 0]]])
    normals = np.array([[0, 0, 1.0]] * 5 + [[np.nan, 0, 0]])
    found = cross_sections(limbs, points, normals)
    assert found.is_cut.tolist() == [True] * 4 + [False] * 2
    assert np.array_equal(found.centroids[4:], points[4:], equal_nan=True)


def test_compiled_or_not_is_the_same(assert_same, limbs):
    rng = np.random.default_rng(2)
    points, frame = 0.3 * rng.normal(size=(12, 3)), np.linalg.qr(rng.normal(size=(3, 3)))[0].T
    face_labels, labels = rng.integers(-1, 3, size=len(limbs.faces)), rng.integers(3, size=12)
    assert_same(lambda kernel: sections(kernel, limbs.vertices, limbs.faces, points, frame=frame))
    assert_same(
        lambda kernel: sections(kernel, limbs.vertices, limbs.faces, points, face_labels=face_labels, labels=labels)
    )
