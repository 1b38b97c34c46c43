"""Handles of components, with holes and with surfaces that touch at a vertex."""

import numpy as np
import pytest
from helpers import joined, moved

from lbskel import Mesh
from lbskel.evaluation.handles import count_handles
from lbskel.shapes import chain_of_tori, cylinder, perforated_plate, sphere, torus


def touching(*meshes):
    """Meshes in a row, the last vertex along x of each at the first of the next."""
    end, placed = np.zeros(3), []
    for mesh in meshes:
        low, high = mesh.vertices[mesh.vertices[:, 0].argmin()], mesh.vertices[mesh.vertices[:, 0].argmax()]
        placed.append(mesh.with_vertices(mesh.vertices - low + end))
        end = end + high - low
    whole = joined(*placed)
    V, number = np.unique(np.round(whole.vertices, 9), axis=0, return_inverse=True)
    return Mesh(V, number.ravel()[whole.faces])


@pytest.mark.parametrize(
    ("mesh", "genus"),
    [(sphere(1), 0), (torus(), 1), (chain_of_tori(3), 3), (perforated_plate(2), 4), (cylinder(), 0)],
)
def test_a_surface_has_its_genus_whatever_its_holes(mesh, genus):
    assert count_handles(mesh).tolist() == [genus]
    assert count_handles(Mesh(mesh.vertices, mesh.faces[3:])).tolist() == [genus]
    turned = np.where(np.arange(len(mesh.faces))[:, None] % 3 == 0, mesh.faces[:, ::-1], mesh.faces)
    assert count_handles(Mesh(mesh.vertices, turned)).tolist() == [genus]


def test_each_component_is_counted(ring, rod):
    assert count_handles(joined(rod, moved(ring, 4.0), moved(chain_of_tori(2), 9.0))).tolist() == [0, 1, 2]


def test_surfaces_that_touch_at_a_vertex_are_counted_apart(ring):
    balls = touching(*[sphere(2)] * 5)
    assert balls.n_components == 1
    assert count_handles(balls).tolist() == [0]
    assert count_handles(touching(sphere(2), ring, sphere(2), ring, sphere(2))).tolist() == [2]


def test_holes_that_touch_at_a_vertex_are_two():
    ball = sphere(2)
    at_vertex = np.flatnonzero((ball.faces == 0).any(axis=1))
    for removed in (at_vertex[[0, 2]], at_vertex):
        assert count_handles(Mesh(ball.vertices, np.delete(ball.faces, removed, axis=0))).tolist() == [0]
