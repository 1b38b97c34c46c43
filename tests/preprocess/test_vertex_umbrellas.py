"""Umbrellas: one at each vertex of a manifold, more where surfaces touch."""

import numpy as np
from helpers import joined, with_reversed_faces

from lbskel import Mesh
from lbskel.preprocess.vertex_umbrellas import find_umbrellas

CUBE = Mesh(
    [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ],
)


def welded(mesh):
    V, position = np.unique(mesh.vertices, axis=0, return_inverse=True)
    return Mesh(V, position.reshape(-1)[mesh.faces])


def test_a_closed_manifold_has_one_umbrella_at_each_vertex_and_a_twin_of_each_half_edge(ring):
    umbrellas = find_umbrellas(ring)
    assert np.array_equal(umbrellas.of_corner, ring.faces)
    half_edges = ring.half_edges
    assert np.array_equal(half_edges[umbrellas.twin], half_edges[:, ::-1])


def test_half_edges_at_a_boundary_and_at_a_seam_have_no_twin(ring):
    assert (find_umbrellas(Mesh(ring.vertices, ring.faces[1:])).twin < 0).sum() == 3
    assert (find_umbrellas(with_reversed_faces(ring, [0])).twin < 0).sum() == 6


def test_cubes_that_share_an_edge_have_two_umbrellas_at_its_ends():
    """The edge has four faces; those of one cube are connected, as the inside lies between them."""
    mesh = welded(joined(CUBE, Mesh(CUBE.vertices + [1, 1, 0], CUBE.faces)))
    assert mesh.faces_per_edge.max() == 4
    umbrellas = find_umbrellas(mesh)
    assert umbrellas.of_corner.max() + 1 == len(mesh.vertices) + 2
    assert (umbrellas.twin >= 0).all()
    faces = np.arange(3 * len(mesh.faces)) % len(mesh.faces)
    assert np.array_equal(faces < 12, faces[umbrellas.twin] < 12)


def test_pyramids_that_share_their_apex_have_two_umbrellas_there(tetrahedron):
    V = np.concatenate([tetrahedron.vertices, -tetrahedron.vertices[1:]])
    F = np.concatenate([tetrahedron.faces, np.array([0, 4, 5, 6])[tetrahedron.faces[:, ::-1]]])
    assert np.unique(find_umbrellas(Mesh(V, F)).of_corner).tolist() == list(range(8))


def test_faces_that_name_a_vertex_twice_are_connected_to_no_others(tetrahedron):
    m = len(tetrahedron.faces) + 1
    twin = find_umbrellas(Mesh(tetrahedron.vertices, [*tetrahedron.faces, [0, 1, 1]])).twin.reshape(3, m)
    own, others = twin[:, -1], twin[:, :-1]
    assert (own[own >= 0] % m == m - 1).all()
    assert (others[others >= 0] % m < m - 1).all()
