"""Means of neighbors and boundaries from sorted edges, beside the operator and the table of edges."""

import numpy as np
import pytest

from lbskel import Mesh, laplacian
from lbskel.applications.neighbor_means import NeighborMeans, boundary_vertices, edge_keys
from lbskel.shapes import flat_grid, torus

MESHES = {
    "closed": torus(1.0, 0.3, 12, 8),
    "open": flat_grid(5, 4),
    "of many vertices": flat_grid(256, 257),  # more than 2^16, where keys are longer
    "with an edge of three faces and an isolated vertex": Mesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [9, 9, 9]], [[0, 1, 2], [0, 3, 1], [0, 1, 4]]
    ),
    "with a corner twice": Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [1, 1, 2]]),
    "faces against each other": Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 2, 3]]),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_means_are_those_of_the_random_walk(mesh):
    n, X = len(mesh.vertices), mesh.vertices
    means = NeighborMeans(n, edge_keys(mesh))
    operator = laplacian(mesh, operator="random_walk")
    degrees = operator.mass.diagonal()
    assert np.array_equal(means.degrees, degrees)
    has_edge = degrees > 0
    assert means @ X == pytest.approx(has_edge[:, None] * X - operator.strong() @ X, abs=1e-12)


@pytest.mark.parametrize("name", ["closed", "open", "of many vertices", "faces against each other"])
def test_the_boundary_is_that_of_the_mesh(name):
    mesh = MESHES[name]
    expected = mesh.edges[mesh.faces_per_edge == 1]
    assert set(boundary_vertices(len(mesh.vertices), edge_keys(mesh)).tolist()) == set(expected.ravel().tolist())


def test_an_edge_of_three_faces_is_no_boundary():
    mesh = MESHES["with an edge of three faces and an isolated vertex"]
    keys = edge_keys(mesh)
    assert np.count_nonzero(keys == 1) == 3  # the edge (0, 1)
    found = boundary_vertices(6, keys)
    assert sorted(zip(*found.reshape(2, -1).tolist(), strict=True)) == [(0, 2), (0, 3), (0, 4), (1, 2), (1, 3), (1, 4)]
