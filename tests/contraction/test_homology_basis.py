"""Loops of a surface: dual bases, conserved flows, sums over loops as scalar products, and the intersection form."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.contraction.homology_basis import homology_basis
from lbskel.shapes import chain_of_tori, torus

MESHES = [torus(1.0, 0.3, 12, 6), chain_of_tori(3, step=0.35)]


@pytest.fixture(params=MESHES, ids=["torus", "chain"])
def basis(request):
    return homology_basis(request.param)


def numbers(n, seed=0):
    return np.random.default_rng(seed).integers(0, 2**64, n, dtype=np.uint64)


def dot(a, b):
    return (a * b).sum(dtype=np.uint64)


def matrix(function, n):
    return np.stack([function(column) for column in np.eye(n, dtype=np.uint64)], axis=1).astype(np.int64)


def test_there_are_two_generators_for_each_handle(basis):
    assert len(basis.generators) == 2 * basis.mesh.genus


def test_a_flow_along_edges_leaves_nothing_at_a_vertex(basis):
    flow = basis.flow_along(numbers(len(basis.generators)))
    out = np.zeros(len(basis.mesh.vertices), dtype=np.uint64)
    np.add.at(out, basis.mesh.edges[:, 0], flow)
    np.subtract.at(out, basis.mesh.edges[:, 1], flow)
    assert flow.any()
    assert not out.any()


def test_a_flow_across_edges_leaves_nothing_in_a_face(basis):
    flow = basis.flow_across(numbers(len(basis.generators)))
    assert flow.any()
    assert not (basis.sign * flow[basis.mesh.edge_of_half_edge]).reshape(3, -1).sum(axis=0, dtype=np.uint64).any()


def test_each_loop_across_edges_meets_its_loop_along_edges_once_and_no_other(basis):
    n = len(basis.generators)
    assert np.array_equal(matrix(lambda x: basis.sums_along(basis.flow_across(x)), n), np.eye(n))


def test_sums_over_loops_are_the_scalar_products_with_their_flows(basis):
    x, values = numbers(len(basis.generators)), numbers(len(basis.mesh.edges), 1)
    assert dot(x, basis.sums_along(values)) == dot(basis.flow_along(x), values)
    assert dot(x, basis.sums_across(values)) == dot(basis.flow_across(x), values)


def test_the_intersection_form_is_antisymmetric_and_unimodular(basis):
    J = matrix(basis.intersections, len(basis.generators))
    assert np.array_equal(J, -J.T)
    assert round(np.linalg.det(J)) == 1


def test_the_two_loops_of_a_torus_meet_once_whatever_the_order_of_vertices():
    mesh = MESHES[0]
    for seed in range(5):
        order = np.random.default_rng(seed).permutation(len(mesh.vertices))
        shuffled = Mesh(mesh.vertices[np.argsort(order)], order[mesh.faces])
        J = matrix(homology_basis(shuffled).intersections, 2)
        assert np.abs(J).tolist() == [[0, 1], [1, 0]]
