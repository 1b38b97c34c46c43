"""Compression: the decoder needs the fields alone, errors fall with the rate, all functions lose only the rounding."""

import numpy as np
import pytest
from helpers import joined, moved

from lbskel import BASES, CompressedMesh, Mesh, MeshError, UnknownChoice, compress
from lbskel.applications import compression
from lbskel.shapes import sphere, torus
from lbskel.solvers.eigenproblem import smallest_eigenpairs


@pytest.fixture(scope="module")
def blob():
    """A sphere with six bumps."""
    ball = sphere(3)
    return ball.with_vertices(ball.vertices * (1 + 0.4 * (ball.vertices**4).sum(axis=1, keepdims=True)))


@pytest.mark.parametrize("basis", BASES)
def test_errors_fall_with_functions_and_bits(blob, basis):
    errors = [compress(blob, k, basis=basis, bits=20).rms_error(blob) for k in (6, 18, 54)]
    assert errors[0] > errors[1] > 2 * errors[2]
    few, many = (compress(blob, 54, basis=basis, bits=bits) for bits in (3, 16))
    assert few.rms_error(blob) > 1.5 * many.rms_error(blob)
    assert few.bits_per_vertex < many.bits_per_vertex


@pytest.mark.parametrize("basis", BASES)
def test_the_decoder_needs_only_the_fields(blob, basis):
    packed = compress(blob, 50, basis=basis)
    fields = ("basis", "faces", "n_vertices", "coefficients", "step", "origin", "anchors")
    copy = CompressedMesh(**{name: getattr(packed, name) for name in fields})
    assert np.array_equal(copy.mesh.vertices, packed.mesh.vertices)
    assert packed.coefficients.dtype == np.int64
    assert np.abs(packed.coefficients).max() <= 2**11


def other_eigenpairs(S, M, k):
    """The eigenvectors of other rounding errors: other bases of equal eigenvalues, and other signs."""
    random = np.random.default_rng(1)
    values, X = smallest_eigenpairs(S, M, k)
    for group in np.split(np.arange(k), np.flatnonzero(np.diff(values) > 1e-9) + 1):
        X[:, group] = X[:, group] @ np.linalg.qr(random.standard_normal((len(group), len(group))))[0]
    return values + 1e-15 * random.standard_normal(k), X + 1e-14 * random.standard_normal(X.shape)


@pytest.mark.parametrize(
    "mesh",
    [sphere(2), torus(1.0, 0.3, 24, 12), joined(sphere(2), moved(sphere(2), 3.0), moved(sphere(1), 6.0))],
    ids=["sphere", "torus", "three components"],
)
@pytest.mark.parametrize("k", [3, 30, 45])
def test_other_eigenvectors_of_equal_eigenvalues_decode_the_same_mesh(mesh, k, monkeypatch):
    packed = compress(mesh, k)
    assert k / 3 <= len(packed.coefficients) <= k
    given = packed.mesh.vertices
    monkeypatch.setattr(compression, "smallest_eigenpairs", other_eigenpairs)
    del packed.__dict__["mesh"]
    assert np.abs(packed.mesh.vertices - given).max() < 1e-9  # the errors of 1e-14 over the smallest gaps, near 1e-3


def test_equal_eigenvalues_are_taken_all_or_none():
    """The graph of the icosahedron has the eigenvalues 0, 5 - sqrt(5) three times, 6 five times, 5 + sqrt(5)."""
    sizes = [len(compress(sphere(0), k).coefficients) for k in range(1, 13)]
    assert sizes == [1, 1, 1, 4, 4, 4, 4, 4, 9, 9, 9, 12]


def test_all_functions_lose_only_the_rounding():
    mesh = sphere(2)
    n = len(mesh.vertices)
    packed = compress(mesh, n, bits=16)
    assert packed.rms_error(mesh) < packed.step  # each of 3 n coefficients is rounded by at most half a step


def test_the_rate_is_that_of_the_coefficients():
    packed = CompressedMesh(
        "spectral",
        sphere(1).faces,
        42,
        np.repeat([[0, 1, 2], [0, 1, 3]], [2, 2], axis=0),
        1.0,
        np.zeros(3),
        np.empty(0),
    )
    assert packed.bits_per_vertex == pytest.approx((4 * 64 + 4 * (1 + 2)) / 42)  # a sign for 1; for 2 and 3 a digit too


def test_similar_meshes_have_similar_copies(blob):
    copy = blob.with_vertices(100.0 * blob.vertices + 5.0)
    one, hundred = compress(blob, 30), compress(copy, 30)
    assert hundred.rms_error(copy) == pytest.approx(100 * one.rms_error(blob), rel=1e-3)


def test_anchors_are_kept_in_place_and_each_component_has_one(blob):
    two = joined(blob, moved(blob, 5.0))
    packed = compress(two, 300, basis="geometry_aware", bits=24)
    assert len(np.unique(packed.anchors)) == 300
    assert set(two.component_of_vertex[packed.anchors]) == {0, 1}
    error = np.linalg.norm(packed.mesh.vertices - two.vertices, axis=1)
    assert error[packed.anchors].mean() < 0.9 * error.mean()  # anchors are soft


def test_a_mesh_at_one_point():
    assert compress(Mesh(np.ones((3, 3)), [[0, 1, 2]]), 2).mesh.vertices.tolist() == [[1.0] * 3] * 3


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("first", [0, 1])
def test_an_unused_vertex_far_away_is_not_coded(blob, basis, first):
    far = np.array([[1e16, 0, 0]])
    vertices = np.concatenate([far, blob.vertices] if first else [blob.vertices, far])
    mesh = Mesh(vertices, blob.faces + first)
    packed, expected = compress(mesh, 60, basis=basis), compress(blob, 60, basis=basis)
    n = len(blob.vertices)
    assert np.array_equal(packed.mesh.vertices[first : first + n], expected.mesh.vertices)
    assert np.array_equal(packed.mesh.vertices[0 if first else n], packed.origin)
    assert np.array_equal(packed.anchors, expected.anchors + first)
    assert packed.rms_error(mesh) == expected.rms_error(blob)
    assert packed.bits_per_vertex == expected.bits_per_vertex
    with pytest.raises(UnknownChoice, match="functions"):
        compress(mesh, n + 1, basis=basis)


def test_a_vertex_that_only_a_degenerate_face_uses_is_coded(blob):
    n = len(blob.vertices)
    mesh = Mesh(np.concatenate([blob.vertices, [[9.0, 9.0, 9.0]]]), np.concatenate([blob.faces, [[n, n, n]]]))
    packed = compress(mesh, 60, basis="geometry_aware")
    assert np.abs(packed.mesh.vertices[-1] - 9.0).max() <= packed.step


def test_what_cannot_be_is_refused(blob):
    with pytest.raises(UnknownChoice, match="functions"):
        compress(blob, 10**6)
    with pytest.raises(UnknownChoice, match="bits"):
        compress(blob, 10, bits=0)
    with pytest.raises(UnknownChoice, match="wavelet"):
        compress(blob, 10, basis="wavelet")
    for basis in BASES:
        with pytest.raises(MeshError, match="2 connected components"):
            compress(joined(blob, moved(blob, 5.0)), 1, basis=basis)
    with pytest.raises(MeshError, match=f"a mesh of {len(blob.vertices)} vertices was compressed, not one of 12"):
        compress(blob, 10).rms_error(sphere(0))
