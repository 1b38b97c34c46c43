"""Linking numbers by crossings: against Gauss' integral, from every direction, and refused where surfaces intersect."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lbskel.contraction.homology_basis import homology_basis
from lbskel.contraction.linking_form import linking_form
from lbskel.shapes import chain_of_tori, lattice, torus


def matrix(function, n):
    return np.stack([function(column) for column in np.eye(n, dtype=np.uint64)], axis=1).astype(np.int64)


def view(seed):
    return Rotation.random(random_state=seed).as_matrix()


def gauss_integral(first, second):
    """Linking number of two sets of segments that form loops: the solid angles swept by their differences, over 4 pi.

    Van Oosterom, Strackee 1983, https://doi.org/10.1109/TBME.1983.325207.
    """

    def angle(a, b, c):
        triple = np.einsum("...k,...k->...", a, np.cross(b, c))
        dots = [np.einsum("...k,...k->...", p, q) for p, q in ((a, b), (b, c), (c, a))]
        return 2 * np.arctan2(triple, 1 + sum(dots))

    R = second[None, :, :, None] - first[:, None, None, :]  # (first, second, end of the second, end of the first, 3)
    R = R / np.linalg.norm(R, axis=-1, keepdims=True)
    a, b, c, d = R[:, :, 0, 0], R[:, :, 1, 0], R[:, :, 1, 1], R[:, :, 0, 1]
    return (angle(a, b, c) + angle(a, c, d)).sum() / (4 * np.pi)


@pytest.mark.parametrize("mesh", [torus(1.0, 0.3, 12, 6), chain_of_tori(2, step=0.35)], ids=["torus", "chain"])
def test_linking_numbers_are_gauss_integrals(mesh):
    basis = homology_basis(mesh)
    n, m = len(basis.generators), len(mesh.faces)
    M = matrix(linking_form(basis, mesh, view(0)).apply, n)
    centers = mesh.vertices[mesh.faces].mean(axis=1)
    middles = mesh.vertices[mesh.edges].mean(axis=1)
    for i, column in enumerate(np.eye(n, dtype=np.uint64)):
        along = basis.flow_along(column).astype(np.int64)
        [edges] = np.nonzero(along)
        assert set(np.abs(along[edges])) == {1}
        inner = np.where((along[edges] > 0)[:, None], mesh.edges[edges], mesh.edges[edges][:, ::-1])
        for j, other in enumerate(np.eye(n, dtype=np.uint64)):
            if i == j:
                continue  # these two loops meet on the surface
            across = basis.flow_across(other).astype(np.int64)
            [edges] = np.nonzero(across)
            sides = np.where((across[edges] > 0)[:, None], basis.sides[edges], basis.sides[edges][:, ::-1]) % m
            left, middle, right = centers[sides[:, 0]], middles[edges], centers[sides[:, 1]]
            outer = np.concatenate([np.stack([left, middle], axis=1), np.stack([middle, right], axis=1)])
            integral = gauss_integral(mesh.vertices[inner], outer)
            # the closed form is exact; what is left is rounding over some thousand pairs of segments
            assert abs(abs(integral) - abs(M[i, j])) < 1e-9


@pytest.mark.parametrize("mesh", [chain_of_tori(3, step=0.35), lattice(3)], ids=["chain", "lattice"])
def test_the_matrix_is_a_projection_and_the_same_in_every_view(mesh):
    basis = homology_basis(mesh)
    n = 2 * mesh.genus
    J = matrix(basis.intersections, n)
    forms = [linking_form(basis, mesh, view(seed)) for seed in range(4)]
    first = matrix(forms[0].apply, n)
    assert np.array_equal(first @ first, first)
    assert np.array_equal(first @ J + J @ first.T, J)
    assert np.trace(first) == mesh.genus == np.linalg.matrix_rank(first)
    for form in forms:
        assert form.is_consistent()
        assert form.has_kernel_of(forms[0])
        assert np.array_equal(matrix(form.apply, n), first)
        assert np.array_equal(matrix(form.apply_transposed, n), first.T)


def test_a_surface_inside_out_has_another_kernel():
    mesh = torus(1.0, 0.3, 16, 8)
    R, r = np.hypot(*mesh.vertices[:, :2].T), mesh.vertices[:, 2]
    basis = homology_basis(mesh)
    form = linking_form(basis, mesh, view(0))
    toward = mesh.vertices[:, :2] / R[:, None]
    inversion = (R - 1) ** 2 + r**2  # turned around its own axis, the tube is inside out
    flipped = np.column_stack([toward * (1 - 0.1 * (R - 1) / inversion)[:, None], r * 0.1 / inversion])
    assert basis.mesh.with_vertices(flipped).volume < 0
    other = linking_form(basis, mesh.with_vertices(flipped), view(0))
    assert other.is_consistent()
    assert not other.has_kernel_of(form)


def test_surfaces_that_intersect_themselves_are_refused():
    mesh = chain_of_tori(2, step=0.2)
    basis = homology_basis(mesh)
    refused = [
        not linking_form(
            basis, mesh.with_vertices(np.random.default_rng(seed).normal(size=mesh.vertices.shape)), view(0)
        ).is_consistent()
        for seed in range(10)
    ]
    assert all(refused)


def test_a_projection_of_another_rank_than_the_genus_is_refused():
    """Tori of twelve scattered vertices, of whose loops none are linked with outer ones, or all."""
    mesh = torus(1.0, 0.3, 4, 3)
    basis, traces = homology_basis(mesh), set()
    for seed in range(20):
        scattered = mesh.with_vertices(np.random.default_rng(seed).normal(size=mesh.vertices.shape))
        form = linking_form(basis, scattered, view(0))
        M = matrix(form.apply, 2)
        if np.array_equal(M @ M, M):
            traces.add(int(np.trace(M)))
            assert form.is_consistent() == (np.trace(M) == 1)
    assert traces == {0, 1, 2}
