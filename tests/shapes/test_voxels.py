"""Surfaces of voxels: closed, outwards, and of the genus that was built."""

import numpy as np
import pytest

from lbskel import MeshError, UnknownChoice
from lbskel.shapes import brush, lattice, perforated_plate, porous_block, voxel_surface, voxel_tree


def test_a_voxel_is_an_octahedron():
    mesh = voxel_surface([[[True]]])
    assert mesh.is_closed_manifold
    assert len(mesh.faces) == 8
    # the vertices are half way to the neighbors of the voxel at the origin
    assert np.sort(np.abs(mesh.vertices).sum(axis=1)).tolist() == [0.5] * 6
    assert mesh.volume == pytest.approx(1 / 6)


def test_voxels_are_where_they_are_filled():
    filled = np.zeros((2, 3, 4))
    filled[1, 2, 3] = True
    assert voxel_surface(filled).vertices.mean(axis=0).tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("mesh", "genus"),
    [(lattice(2), 5), (lattice(4, spacing=4), 81), (perforated_plate(6), 36), (brush(4), 0)],
    ids=["cube", "lattice", "plate", "brush"],
)
def test_the_genus_is_the_number_of_mouths(mesh, genus):
    assert mesh.n_components == 1
    assert mesh.volume > 0
    assert mesh.genus == genus


def test_a_brush_has_its_bristles():
    mesh = brush(5, length=9)
    assert (mesh.vertices[:, 2] == mesh.vertices[:, 2].max()).sum() == 25


def test_a_voxel_tree_has_its_twigs_on_both_sides():
    mesh = voxel_tree(4, length=9)
    assert (mesh.genus, mesh.n_components) == (0, 1)
    z = mesh.vertices[:, 2]
    assert [(z == z.min()).sum(), (z == z.max()).sum()] == [8, 8]


@pytest.mark.parametrize("grain", [0.0, 1.5])
def test_a_porous_block_is_one_closed_surface_of_high_genus(grain):
    mesh = porous_block(14, grain=grain)
    assert mesh.n_components == 1
    assert mesh.genus >= 5
    again = porous_block(14, grain=grain)
    assert np.array_equal(mesh.vertices, again.vertices)


def test_what_leaves_no_voxels_or_no_holes_is_refused():
    for filled in (np.ones((3, 3)), np.zeros((2, 2, 2))):
        with pytest.raises(MeshError, match=r"filled must have shape \(x, y, z\) and a voxel"):
            voxel_surface(filled)
    with pytest.raises(UnknownChoice, match="spacing must be at least 2, not 1"):
        lattice(3, spacing=1)
    with pytest.raises(UnknownChoice, match="filled must be above 0 and at most 1, not 0"):
        porous_block(4, filled=0)


def test_labels_are_filled_and_gray_values_refused():
    block = np.zeros((4, 4, 4), dtype=np.int64)
    block[1:3, 1:3, 1:3] = 7
    assert voxel_surface(block).volume == voxel_surface(block > 0).volume
    with pytest.raises(MeshError, match="not gray values of float64: compare them with a threshold"):
        voxel_surface(block * 0.9)
