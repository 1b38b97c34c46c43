"""Cells of a surface: how many there are, what they cover, and distances between them."""

import numpy as np
import pytest

from lbskel.geometry.deadline import NEVER
from lbskel.refinement import surface_cells as module
from lbskel.refinement.surface_cells import surface_cells
from lbskel.shapes import sphere, tube


def test_long_thin_shapes_have_as_many_cells_as_their_length_in_radii(monkeypatch):
    """A tube has 2 pi l / r squared radii of area; there is a cell for each CELL_AREA of them, but at least N_CELLS."""
    mesh = tube(np.stack([np.arange(0, 401), 0 * np.arange(0, 401), 0 * np.arange(0, 401)], axis=1), 1.0, sides=32)
    monkeypatch.setattr(module, "N_CELLS", 10)
    # polygons of 32 corners are half a per cent thinner, and the ends have 0.5 % of the area
    n_cells = len(surface_cells(mesh, NEVER).seeds)
    assert n_cells == pytest.approx(2 * np.pi * 400 / module.CELL_AREA, rel=0.02)
    monkeypatch.setattr(module, "N_CELLS", 50)
    assert len(surface_cells(sphere(3), NEVER).seeds) == 50


def test_cells_cover_the_surface_and_distances_are_those_on_a_sphere(monkeypatch):
    monkeypatch.setattr(module, "N_CELLS", 60)
    ball = sphere(4)
    cells = surface_cells(ball, NEVER)
    assert np.array_equal(cells.cell_of_vertex[cells.seeds], np.arange(60))
    assert cells.areas.sum() == pytest.approx(ball.area, rel=1e-12)
    assert (cells.adjacency != cells.adjacency.T).nnz == 0
    found = cells.shortest_paths.distances(np.array([0]))[0]
    exact = np.arccos(np.clip(ball.vertices[cells.seeds] @ ball.vertices[cells.seeds[0]], -1, 1))
    others = exact > 0
    # paths go through seeds, so that they are longer, by a third where they are one or two cells long
    assert (found[others] > 0.99 * exact[others]).all()
    assert (found[others] < 1.35 * exact[others]).all()
