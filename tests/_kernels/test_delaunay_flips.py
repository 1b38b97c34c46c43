"""Cotangents of edge lengths and intrinsic flips, in the plane, where both are known."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from lbskel.geometry.intrinsic_triangulation import IntrinsicTriangulation, delaunay, half_edge_twins
from lbskel.geometry.mesh import Mesh
from lbskel.operators.intrinsic_delaunay import intrinsic_delaunay


def lengths_of(V, F):
    return np.linalg.norm(V[F[:, [1, 2, 0]]] - V[F[:, [2, 0, 1]]], axis=2)


def flipped(kernel, faces, lengths, max_flips=1000):
    """Number of flips, and the arrays after them."""
    F, L, T = faces.ravel().copy(), lengths.ravel().copy(), half_edge_twins(faces).copy()
    return kernel.flip_to_delaunay(F, L, T, max_flips), F, L, T


def test_cotangents_of_a_right_triangle_and_of_one_without_area(kernel):
    cotangents = np.empty(6)
    kernel.cotangents(np.array([3.0, 4, 5, 1, 2, 3]), cotangents)
    assert cotangents[:3] == pytest.approx([4 / 3, 3 / 4, 0], rel=1e-14)
    assert cotangents[3:].tolist() == [np.inf, np.inf, -np.inf]


RHOMBUS = np.array([[-2.0, 0, 0], [2, 0, 0], [0, 1, 0], [0, -1, 0]])
LONG_DIAGONAL = np.array([[0, 1, 2], [1, 0, 3]])


def test_the_long_diagonal_of_a_rhombus_is_flipped_to_the_short_one(kernel):
    n_flips, F, L, T = flipped(kernel, LONG_DIAGONAL, lengths_of(RHOMBUS, LONG_DIAGONAL))
    assert n_flips == 1
    assert L.reshape(-1, 3) == pytest.approx(lengths_of(RHOMBUS, F.reshape(-1, 3)), rel=1e-14)
    assert sorted(L) == pytest.approx([2, 2, *4 * [np.sqrt(5)]])
    inner = np.flatnonzero(T >= 0)
    assert T[T[inner]].tolist() == inner.tolist()
    assert L[inner] == pytest.approx(2)
    assert np.cross(*(RHOMBUS[F.reshape(-1, 3)][:, k] - RHOMBUS[F.reshape(-1, 3)][:, 0] for k in (1, 2)))[:, 2] == (
        pytest.approx([4, 4])  # the orientation, and twice the area
    )


def test_two_triangles_glued_along_all_their_edges(kernel):
    """Both sides of an obtuse triangle: its base is flipped to a loop of twice its height at the apex."""
    n_flips, F, L, T = flipped(kernel, np.array([[0, 1, 2], [1, 0, 2]]), np.sqrt([[5.0, 5, 16], [5, 5, 16]]))
    assert n_flips == 1
    assert sorted(L) == pytest.approx([2, 2, *4 * [np.sqrt(5)]])
    assert T[T].tolist() == list(range(6))
    assert L[T].tolist() == L.tolist()
    (loop,) = [edge for edge in range(3) if T[edge] >= 3]
    assert L[loop] == pytest.approx(2)
    starts, ends = F.reshape(2, 3)[:, [1, 2, 0]].ravel(), F.reshape(2, 3)[:, [2, 0, 1]].ravel()
    assert np.array_equal(starts[T], ends)


def test_no_more_flips_than_allowed(kernel):
    lengths = lengths_of(RHOMBUS, LONG_DIAGONAL)
    n_flips, F, L, _ = flipped(kernel, LONG_DIAGONAL, lengths, 0)
    assert n_flips == 0
    assert np.array_equal(F, LONG_DIAGONAL.ravel())
    assert np.array_equal(L, lengths.ravel())


def test_an_edge_between_cocircular_vertices_stays(kernel):
    V = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    assert flipped(kernel, faces, lengths_of(V, faces))[0] == 0


def test_flips_in_the_plane_end_in_the_delaunay_triangulation(kernel):
    """From the Delaunay triangulation of the points squeezed along an axis."""
    rng = np.random.default_rng(7)
    for _ in range(5):
        points = rng.random((30, 2))
        faces = Delaunay(points * [0.3, 1]).simplices.astype(np.int64)
        V = np.column_stack([points, np.zeros(30)])
        turned = np.cross(V[faces[:, 1]] - V[faces[:, 0]], V[faces[:, 2]] - V[faces[:, 0]])[:, 2] < 0
        faces[turned] = faces[turned][:, ::-1]
        n_flips, F, L, T = flipped(kernel, faces, lengths_of(V, faces))
        assert n_flips > 0
        assert L.reshape(-1, 3) == pytest.approx(lengths_of(V, F.reshape(-1, 3)), rel=1e-9)
        assert np.array_equal(T, half_edge_twins(F.reshape(-1, 3)))
        cotangents = np.empty_like(L)
        kernel.cotangents(L, cotangents)
        inner = T >= 0
        assert (cotangents[inner] + cotangents[T[inner]]).min() > -1e-6


def test_flips_keep_the_boundary():
    rng = np.random.default_rng(6)
    for _ in range(30):
        flat = rng.random((14, 2)) * [1, 0.05]
        faces = Delaunay(flat * [0.05, 1]).simplices.astype(np.int64)
        V = np.column_stack([flat, np.zeros(14)])
        turned = np.cross(V[faces[:, 1]] - V[faces[:, 0]], V[faces[:, 2]] - V[faces[:, 0]])[:, 2] < 0
        faces[turned] = faces[turned][:, ::-1]
        given = Mesh(V, faces)
        boundary = np.sort(given.edges[given.faces_per_edge == 1], axis=1)
        lengths = lengths_of(V, faces)
        result = delaunay(IntrinsicTriangulation(faces, lengths, half_edge_twins(faces)))
        ends = np.sort(
            np.stack([result.faces[:, [1, 2, 0]], result.faces[:, [2, 0, 1]]], axis=2).reshape(-1, 2), axis=1
        )
        assert np.array_equal(np.unique(ends[result.twins < 0], axis=0), boundary)
        assert result.lengths.shape == lengths.shape
        assert intrinsic_delaunay(given).stiffness.shape == (14, 14)


def test_compiled_or_not_is_the_same(assert_same, limbs):
    faces = limbs.faces
    twins = half_edge_twins(faces)
    lengths = (1 + np.random.default_rng(3).random(faces.shape) * 0.9).ravel()
    lengths = np.maximum(lengths, lengths[twins])  # equal on both sides
    assert_same(lambda kernel: flipped(kernel, faces, lengths.reshape(-1, 3), 10 * len(twins)))
