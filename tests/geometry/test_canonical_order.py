"""The canonical order: the same surface, and the same numbers however the input was numbered, turned or mirrored."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lbskel import Mesh
from lbskel.geometry.canonical_order import in_canonical_order
from lbskel.shapes import cylinder, make, sphere, torus


def renumbered(mesh, seed):
    """The mesh with its vertices, faces and the corners of each face in another order."""
    random = np.random.default_rng(seed)
    order = random.permutation(len(mesh.vertices))
    new_index = np.argsort(order)
    faces = new_index[mesh.faces][random.permutation(len(mesh.faces))]
    turns = random.integers(0, 3, len(faces))[:, None] + np.arange(3)
    return Mesh(mesh.vertices[order], np.take_along_axis(faces, turns % 3, axis=1))


def mirrored(mesh):
    """The mirror image in a plane askew, oriented outwards, and the matrix of the reflection."""
    normal = np.array([2.0, -1, 2]) / 3
    H = np.eye(3) - 2 * np.outer(normal, normal)
    return Mesh(mesh.vertices @ H, mesh.faces[:, ::-1]), H


def two_parts():
    """A sphere and an open cylinder, and a vertex without a face."""
    ball, side = sphere(1), cylinder(0.5, 1.0, 8, 4)
    V = np.concatenate([ball.vertices, side.vertices + [3, 0.1, 0], [[9, 9, 9]]])
    return Mesh(V, np.concatenate([ball.faces, side.faces + len(ball.vertices)]))


SURFACES = {"torus": torus(1.0, 0.3, 12, 7), "cylinder": cylinder(1.0, 2.0, 9, 5), "two parts": two_parts()}


@pytest.mark.parametrize("name", SURFACES)
def test_the_surface_and_its_orientation_stay(name):
    mesh = SURFACES[name]
    ordered, vertex_map, mirror = in_canonical_order(mesh)
    assert np.array_equal(ordered.vertices[vertex_map.indices] * mirror, mesh.vertices)
    outward = mesh.faces[:, :: int(mirror.prod())]
    corners = {tuple(np.roll(face, -face.argmin())) for face in vertex_map.indices[outward]}
    assert {tuple(np.roll(face, -face.argmin())) for face in ordered.faces} == corners


def test_components_stay_in_their_order():
    parts = SURFACES["two parts"]
    mesh = Mesh(np.concatenate([[[9.0, 9, 9]], parts.vertices]), parts.faces + 1)  # the first vertex has no face
    ordered, vertex_map, _ = in_canonical_order(mesh)
    found_anew = Mesh(ordered.vertices, ordered.faces).component_of_vertex
    assert np.array_equal(found_anew[vertex_map.indices], mesh.component_of_vertex)
    assert np.array_equal(ordered.component_of_vertex, found_anew)


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("image", [False, True])
def test_the_edges_are_those_of_the_renumbered_mesh(name, image):
    given = mirrored(SURFACES[name])[0] if image else SURFACES[name]
    ordered, *_ = in_canonical_order(renumbered(given, 5))
    found_anew = Mesh(ordered.vertices, ordered.faces)
    assert np.array_equal(ordered.edges, found_anew.edges)
    assert np.array_equal(ordered.edge_of_half_edge, found_anew.edge_of_half_edge)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", ["torus", "cylinder"])
def test_the_order_of_the_input_does_not_decide(name, seed):
    first, second = (in_canonical_order(mesh)[0] for mesh in (SURFACES[name], renumbered(SURFACES[name], seed)))
    assert np.array_equal(first.vertices, second.vertices)
    assert np.array_equal(first.faces, second.faces)


def test_a_turned_shape_without_symmetry_is_numbered_alike():
    mesh = make("tripod", n_vertices=400).mesh
    R = Rotation.random(random_state=3).as_matrix()
    turned, turned_map, turned_mirror = in_canonical_order(renumbered(mesh.with_vertices(mesh.vertices @ R.T), 4))
    ordered, _, mirror = in_canonical_order(mesh)
    assert len(turned_map) == len(mesh.vertices)
    assert np.array_equal(turned.faces, ordered.faces)
    back = turned.vertices * turned_mirror @ R * mirror
    assert back == pytest.approx(ordered.vertices, abs=1e-12)  # rounding of the rotation


@pytest.mark.parametrize("name", ["tripod", "dinosaur"])
def test_a_shape_without_symmetry_and_its_mirror_image_are_numbered_alike(name):
    mesh = make(name, n_vertices=800).mesh
    image, H = mirrored(mesh)
    (ordered, _, mirror), (other, _, other_mirror) = in_canonical_order(mesh), in_canonical_order(renumbered(image, 4))
    assert mirror.prod() == -other_mirror.prod()
    assert np.array_equal(ordered.faces, other.faces)
    assert other.vertices * other_mirror @ H * mirror == pytest.approx(ordered.vertices, abs=1e-12)


def test_what_is_known_of_a_mesh_is_kept_in_its_mirror_image():
    for mesh in (two_parts(), mirrored(two_parts())[0]):
        assert not mesh.is_closed_manifold
        ordered, *_ = in_canonical_order(mesh)
        assert ordered.__dict__["is_closed_manifold"] is False


def test_an_edge_of_three_faces_is_not_crossed():
    fan = Mesh([[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1.5, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    ordered, vertex_map, mirror = in_canonical_order(fan)
    assert len(ordered.faces) == 3
    assert np.array_equal(ordered.vertices[vertex_map.indices] * mirror, fan.vertices)
