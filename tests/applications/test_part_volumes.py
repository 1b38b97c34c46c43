"""Volumes of parts of a box: cut across, where three parts meet, open, turned inwards, and as a soup of triangles."""

import numpy as np
import pytest
from helpers import triangle_soup, without_faces

from lbskel import Mesh
from lbskel.applications.part_volumes import part_volumes


@pytest.fixture
def box():
    """A box from x = 5 to 8 with a section of 1 by 2, in three cells: 24 faces of its sides and 4 of its ends."""
    ring = np.array([[0, 0], [1, 0], [1, 2], [0, 2]])
    vertices = np.array([[5 + x, *yz] for x in range(4) for yz in ring], dtype=float)
    quads = [
        [4 * x + k, 4 * x + (k + 1) % 4, 4 * x + 4 + (k + 1) % 4, 4 * x + 4 + k] for x in range(3) for k in range(4)
    ]
    quads += [[3, 2, 1, 0], [12, 13, 14, 15]]
    mesh = Mesh(vertices, [face for a, b, c, d in quads for face in ((a, c, b), (a, d, c))])
    return mesh if mesh.volume > 0 else Mesh(mesh.vertices, mesh.faces[:, ::-1])


def cells(mesh):
    return np.clip(mesh.vertices[mesh.faces].mean(axis=1)[:, 0] - 5, 0, 2.9).astype(int)


def test_a_box_cut_across_has_the_volumes_of_its_cells(box):
    assert box.volume == pytest.approx(6)
    assert part_volumes(box, cells(box), 3) == pytest.approx(2)
    assert part_volumes(triangle_soup(box), cells(box), 3) == pytest.approx(2)
    is_end = np.arange(28) >= 24
    assert part_volumes(without_faces(box, np.flatnonzero(is_end)), cells(box)[~is_end], 3) == pytest.approx(2)


def test_where_three_parts_meet_their_volumes_sum_to_that_of_the_mesh(box):
    is_upper = box.vertices[box.faces].mean(axis=1)[:, 2] > 1
    parts = np.where(cells(box) == 0, 0, 1 + is_upper)
    volumes = part_volumes(box, parts, 3)
    assert volumes.sum() == pytest.approx(6)
    assert volumes.min() > 1


def test_a_flat_part_has_no_volume(box):
    is_end = np.arange(28) >= 26
    assert part_volumes(box, is_end.astype(int), 2) == pytest.approx([6, 0])
