"""The tufted cover: closed on any triangle soup, glued in the order of the angle, and the Laplacian it leads to."""

import numpy as np
import pytest
import robust_laplacian

from lbskel import Mesh
from lbskel.operators.robust import robust
from lbskel.operators.tufted_cover import tufted_cover
from lbskel.shapes import cylinder, flat_grid, schwarz_lantern, sphere, torus


def fan(*angles):
    """Faces at one edge on the z-axis, at some angles in degrees around it, and the edges' third corners 2, 3, ..."""
    turns = np.radians(angles)
    V = [[0, 0, 0], [0, 0, 1], *np.stack([np.cos(turns), np.sin(turns), 0.5 + 0 * turns], axis=1).tolist()]
    return Mesh(V, [[0, 1, 2 + k] if k % 2 else [1, 0, 2 + k] for k in range(len(angles))])


def book(n_pages):
    """Bent grids at a common polyline of edges."""
    grid = flat_grid(7, 9)
    x, z, _ = grid.vertices.T
    is_spine = x == 0
    V, F = [np.stack([0 * z, 0 * z, z], axis=1)[is_spine]], []
    for k in range(n_pages):
        angle = 2 * np.pi * k / n_pages + 0.3 * np.sin(3 * x + k)
        index = np.cumsum(~is_spine) - 1 + sum(len(part) for part in V)
        index[is_spine] = np.arange(is_spine.sum())
        V.append(np.stack([x * np.cos(angle), x * np.sin(angle), z], axis=1)[~is_spine])
        F.append(index[grid.faces[:, ::-1] if k % 2 else grid.faces])
    return Mesh(np.concatenate(V), np.concatenate(F))


def soup(n=60):
    """Random triangles on few vertices: edges of up to many faces, none twice."""
    rng = np.random.default_rng(0)
    F = np.unique(np.sort(np.array([rng.choice(12, 3, replace=False) for _ in range(n)]), axis=1), axis=0)
    return Mesh(rng.normal(size=(12, 3)), F)


MESHES = {
    "closed": torus(1.0, 0.3, 20, 10),
    "open": cylinder(0.3, 2.0, 9, 12),
    "caps": schwarz_lantern(12, 40),
    "one face": Mesh([[0, 0, 0], [3, 0, 0], [0, 2, 1]], [[0, 1, 2]]),
    "three pages": book(3),
    "four pages": book(4),
    "soup": soup(),
    "oriented at random": Mesh(sphere(1).vertices, [f if k % 3 else f[::-1] for k, f in enumerate(sphere(1).faces)]),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_the_cover_has_two_copies_of_each_face_and_every_edge_has_two_faces(mesh):
    m = len(mesh.faces)
    faces, twins = tufted_cover(mesh.vertices, mesh.faces)
    assert np.array_equal(faces[:m], mesh.faces)
    assert np.array_equal(np.sort(faces[m:], axis=1), np.sort(mesh.faces, axis=1))
    half_edges = np.arange(6 * m)
    assert np.array_equal(twins[twins], half_edges)
    assert (twins != half_edges).all()
    # glued half-edges run along the same edge in opposite directions, so the cover is oriented
    face, corner = np.divmod(half_edges, 3)
    start, end = faces[face, (corner + 1) % 3], faces[face, (corner + 2) % 3]
    assert np.array_equal(start, end[twins])


@pytest.mark.parametrize("angles", [(0, 120, 240), (10, 200, 80), (0, 90, 180, 270), (300, 20, 250, 100, 170)])
def test_around_an_edge_each_face_is_glued_to_the_next_on_either_side(angles):
    mesh = fan(*angles)
    m = len(mesh.faces)
    faces, twins = tufted_cover(mesh.vertices, mesh.faces)
    at_edge = np.flatnonzero(faces.ravel() >= 2)  # half-edges opposite the third corners
    neighbors = [set() for _ in range(m)]
    for half_edge in at_edge.tolist():
        neighbors[half_edge // 3 % m].add(int(twins[half_edge] // 3 % m))
    order = np.argsort(angles).tolist()
    for place, face in enumerate(order):
        assert neighbors[face] == {order[place - 1], order[(place + 1) % m]}


def test_a_boundary_edge_joins_the_two_sides_of_its_face():
    faces, twins = tufted_cover(np.eye(3), np.array([[0, 1, 2]]))
    assert faces.tolist() == [[0, 1, 2], [0, 2, 1]]
    assert twins.tolist() == [3, 5, 4, 0, 2, 1]


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_the_laplacian_of_the_cover_is_that_of_the_package_robust_laplacian(mesh):
    stiffness, mass = robust_laplacian.mesh_laplacian(mesh.vertices, mesh.faces)
    L = robust(mesh)
    # up to rounding of lengths, which flips add up: the Laplacian is unique even where the triangulation is not
    assert np.abs((L.stiffness - stiffness).toarray()).max() < 1e-9 * np.abs(stiffness.data).max()
    assert np.abs((L.mass - mass).toarray()).max() < 1e-9 * mass.data.max()
