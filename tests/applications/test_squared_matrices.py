"""Squared matrices: the product, and the refusal of rows that would become large dense blocks."""

import numpy as np
import pytest

from lbskel import (
    EDITING_METHODS,
    Mesh,
    MeshError,
    edit,
    laplacian,
    least_squares_mesh,
    quantize_deltas,
    reconstruct,
    smooth,
)
from lbskel.applications.compression import compress
from lbskel.applications.similarity_invariance import invariant_matrix
from lbskel.applications.squared_matrices import matrix_product
from lbskel.operators.assembly import stiffness_of_pairs

N = 8000  # triangles around the center of a fan


@pytest.fixture(scope="module")
def cone():
    angles = np.linspace(0, 2 * np.pi, N, endpoint=False)
    rim, order = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1), np.arange(N)
    return Mesh([*rim, [0, 0, 1]], np.stack([np.full(N, N), order, (order + 1) % N], axis=1))


def test_the_product_is_that_of_the_matrices(ring):
    L = laplacian(ring)
    K = invariant_matrix(L.stiffness, ring.vertices)
    for A, B, dimensions in ((L.stiffness, L.strong(), 1), (K.T, K, 3)):
        assert (matrix_product(A, B, dimensions).toarray() == (A @ B).toarray()).all()


@pytest.mark.parametrize(
    "use",
    [
        lambda mesh: smooth(mesh, fix_boundary=False),
        lambda mesh: quantize_deltas(mesh),
        lambda mesh: least_squares_mesh(mesh, 4),
        lambda mesh: reconstruct(mesh, np.zeros((N + 1, 3)), [3], anchor_weight=1.0),
        lambda mesh: compress(mesh, 4, basis="geometry_aware"),
        *[
            lambda mesh, method=method: edit(mesh, [[3], [9]], [np.eye(4)] * 2, method=method)
            for method in EDITING_METHODS
            if method != "harmonic"
        ],
    ],
)
def test_a_vertex_of_too_many_neighbors_is_named_with_the_way_out(cone, use):
    with pytest.raises(MeshError, match=r"vertex 8000 has 8,000 neighbors.*remesh_isotropic.*'implicit'.*'harmonic'"):
        use(cone)


def test_methods_that_square_no_matrix_take_any_number_of_neighbors(cone):
    smoothed = smooth(cone, method="implicit")
    assert smoothed.vertices[N, 2] < 1
    lifted = edit(cone, [np.arange(N)], [np.eye(4)], method="harmonic")
    assert lifted.vertices == pytest.approx(cone.vertices, abs=1e-9)


@pytest.mark.parametrize(("limit", "is_refused"), [(148, True), (149, False)])
def test_the_vertex_with_the_most_neighbors_decides(monkeypatch, limit, is_refused):
    monkeypatch.setattr("lbskel.applications.squared_matrices.MAX_NEIGHBORS", limit)
    n = 150
    S = stiffness_of_pairs(n, *np.triu_indices(n, 1), np.ones(n * (n - 1) // 2))
    if is_refused:
        with pytest.raises(MeshError, match="vertex 0 has 149 neighbors, more than 148"):
            matrix_product(S.T, S)
    else:
        assert matrix_product(S.T, S).nnz == n * n
