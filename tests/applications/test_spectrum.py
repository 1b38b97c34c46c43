"""Eigenpairs of Laplacians: values, orthonormal functions, multiple eigenvalues, several components."""

import numpy as np
import pytest
from helpers import joined, moved
from scipy.linalg import eigh
from scipy.sparse import csc_array

from lbskel import Mesh, MeshError, SolveError, UnknownChoice, laplacian
from lbskel.applications import eigenpairs
from lbskel.operators import Laplacian
from lbskel.shapes import flat_grid, sphere, torus


def dense_eigenvalues(L, k):
    return eigh(L.stiffness.toarray(), L.mass.toarray(), eigvals_only=True)[:k]


def gram(L, X):
    return X.T @ (L.mass @ X)


@pytest.mark.parametrize("mass", ["voronoi", "barycentric", "full"])
@pytest.mark.parametrize("k", [1, 9, 40])
def test_values_equal_those_of_the_dense_problem_and_functions_are_orthonormal(mass, k):
    L = laplacian(torus(1.0, 0.4, 36, 18), mass=mass)  # the symmetry of the torus makes most eigenvalues double
    values, X = eigenpairs(L, k)
    expected = dense_eigenvalues(L, k)
    assert values.shape == (k,)
    assert X.shape == (648, k)
    assert np.abs(values - expected).max() < 1e-10 * dense_eigenvalues(L, 648)[-1]
    assert np.abs(gram(L, X) - np.eye(k)).max() < 1e-10
    assert np.abs(L.stiffness @ X - (L.mass @ X) * values).max() < 1e-10 * abs(L.stiffness).max()


@pytest.mark.parametrize("k", [9, 16, 21])
def test_every_eigenfunction_of_a_multiple_eigenvalue_is_found(k):
    """The sphere's eigenvalue l (l + 1) has multiplicity 2 l + 1; Lanczos' method alone finds 4 of the 5 of l = 2."""
    values, _ = eigenpairs(laplacian(sphere(4)), k)
    degrees = np.repeat(np.arange(5), 2 * np.arange(5) + 1)[:k]
    assert np.abs(values - degrees * (degrees + 1)).max() < 0.15  # h = 0.07: h^2 l^4 / 12 for l = 4


@pytest.mark.parametrize("k", [20, 28])
def test_eigenfunctions_of_eigenvalues_that_are_nearly_multiple_are_found(k):
    """One vertex in the middle of a face of the sphere splits some of its multiple eigenvalues by little."""
    ball = sphere(3)
    (a, b, c), new = ball.faces[0], len(ball.vertices)
    V = np.concatenate([ball.vertices, [ball.vertices[[a, b, c]].mean(axis=0)]])
    L = laplacian(Mesh(V, np.concatenate([ball.faces[1:], [[a, b, new], [b, c, new], [c, a, new]]])))
    values, _ = eigenpairs(L, k)
    assert np.abs(values - dense_eigenvalues(L, k)).max() < 1e-10 * abs(L.stiffness).max() / L.mass.diagonal().min()


def test_each_component_has_a_zero_eigenvalue(ring):
    parts = joined(ring, moved(ring, 5.0), sphere(3), moved(sphere(2), 9.0))
    L = laplacian(Mesh(np.concatenate([parts.vertices, [[99.0, 0, 0]]]), parts.faces))
    values, X = eigenpairs(L, 12)
    assert np.abs(values[:4]).max() < 1e-10
    assert values[4] > 0.1
    assert np.abs(gram(L, X) - np.eye(12)).max() < 1e-10
    indicators = np.zeros((len(parts.vertices) + 1, 4))
    for part in range(4):
        indicators[:-1, part] = parts.component_of_vertex == part
    # the four functions span the indicator functions of the components
    assert np.abs(indicators - X[:, :4] @ (X[:, :4].T @ (L.mass @ indicators))).max() < 1e-10
    assert (X[-1] == 0).all()


def test_runs_give_the_same_bytes():
    L = laplacian(sphere(3), operator="robust")
    first, second = eigenpairs(L, 20), eigenpairs(L, 20)
    assert all(a.tobytes() == b.tobytes() for a, b in zip(first, second, strict=True))
    X = first[1]
    assert (X[np.abs(X).argmax(axis=0), np.arange(20)] > 0).all()


def test_neumann_eigenvalues_of_a_square():
    values, _ = eigenpairs(laplacian(flat_grid(30, 30)), 6)
    assert np.abs(values / np.pi**2 - [0, 1, 1, 2, 4, 4]).max() < 0.02  # (pi k / 29)^2 / 12 of k^2


def test_solvers_agree():
    L = laplacian(sphere(3))
    with pytest.raises(UnknownChoice, match="solver 'pardiso'"):
        eigenpairs(L, 10, solver="pardiso")
    assert np.abs(eigenpairs(L, 10)[0] - eigenpairs(L, 10, solver="superlu")[0]).max() < 1e-10


def test_asking_for_more_eigenpairs_than_vertices_gives_all(tetrahedron):
    values, X = eigenpairs(laplacian(tetrahedron), 10)
    assert values.shape == (4,)
    assert X.shape == (4, 4)


def test_operators_without_a_real_nonnegative_spectrum_are_refused(ring):
    with pytest.raises(MeshError, match="'mean_value_symmetric'"):
        eigenpairs(laplacian(ring, operator="mean_value"), 3)
    L = laplacian(ring)
    with pytest.raises(SolveError):
        eigenpairs(Laplacian(-L.stiffness, L.mass), 3)
    with pytest.raises(MeshError, match="no area"):
        eigenpairs(Laplacian(L.stiffness, csc_array(L.mass.shape)), 3)
