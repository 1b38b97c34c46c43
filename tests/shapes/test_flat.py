"""Flat shapes: their volumes against closed forms, and axes that lie in the middle of them."""

import numpy as np
import pytest

from lbskel.geometry.cross_sections import cross_sections
from lbskel.shapes.flat import elliptic_tube, leaf, ribbon, twisted_ellipse


def test_a_straight_elliptic_tube_has_the_volume_of_a_cylinder_and_an_ellipsoid():
    axis = np.linspace([0.0, 0, 0], [0, 0, 3.0], 31)
    shape = elliptic_tube(axis, np.tile([0.4, 0.2], (31, 1)), 0.0, "tube", 3000)
    radius = np.sqrt(0.4 * 0.2)
    assert shape.truth.radii == pytest.approx(radius)
    # inscribed polyhedra: a 48-gon has 0.3 % less area than its ellipse, and edges of 0.04 cut 2 % off the curved ends
    assert shape.mesh.volume == pytest.approx(np.pi * radius**2 * 3 + 4 / 3 * np.pi * radius**3, rel=0.02)
    assert np.ptp(shape.mesh.vertices, axis=0) == pytest.approx([0.8, 0.4, 3 + 2 * radius], rel=0.02)


@pytest.mark.parametrize("make", [twisted_ellipse, ribbon, leaf])
def test_the_axis_runs_through_the_middle_of_the_sections(make):
    shape = make(n_vertices=2000)
    assert shape.mesh.is_closed_manifold
    assert (shape.mesh.genus, shape.mesh.n_components, shape.truth.n_tips) == (0, 1, 2)
    inner = np.arange(10, len(shape.truth.nodes) - 10, 10)
    tangents = shape.truth.nodes[inner + 1] - shape.truth.nodes[inner - 1]
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    section = cross_sections(shape.mesh, shape.truth.nodes[inner], tangents)
    assert section.surrounds.all()
    offsets = np.linalg.norm(section.centroids - shape.truth.nodes[inner], axis=1) / shape.truth.radii[inner]
    assert offsets.max() < 0.1  # edges of a third of a radius, and sections of a bent tube are not ellipses
    # a plane across a bent ribbon cuts it at the same thickness: area is that of the ellipse
    areas = np.pi * shape.truth.radii[inner] ** 2
    assert section.areas == pytest.approx(areas, rel=0.1)
