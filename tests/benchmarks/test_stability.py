"""The benchmark of stability: skeletons under an orthogonal matrix are brought back."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from benchmarks.stability import MIRRORED, TURNED, _n_variants_of_tips, _row, _skeleton
from lbskel.shapes import make


@pytest.mark.parametrize("matrix", [TURNED, MIRRORED])
def test_a_skeleton_under_a_matrix_is_brought_back(matrix):
    mesh = make("tripod", n_vertices=800).mesh
    plain, moved = _skeleton(mesh, 2.0, np.eye(3)), _skeleton(mesh, 2.0, matrix)
    distances = cKDTree(moved.nodes[moved.tips]).query(plain.nodes[plain.tips])[0]
    assert distances.max() < 0.1 * plain.mean_radii.min()


def test_tips_lost_and_added_are_counted_against_the_skeletons_as_they_are():
    tripod, dinosaur = make("tripod", n_vertices=800), make("dinosaur", n_vertices=1500)
    first = [_skeleton(shape.mesh, 2.0, np.eye(3)) for shape in (dinosaur, tripod)]
    row = _row("turned", [tripod], [tripod.mesh, tripod.mesh], first)
    assert (row["tips"], row["meshes with other tips"], row["graphs right"]) == (6, 1, "1/1")
    assert row["tips added"] - row["tips lost"] == 3 - len(first[0].tips)


def test_a_tip_is_of_the_variants_that_have_one_near_it():
    tips = [np.array([[0.0, 0, 0], [5, 0, 0]]), np.array([[0.1, 0, 0]]), np.array([[0.05, 0, 0], [0, 0.05, 0]])]
    assert _n_variants_of_tips(tips, 0.2) == [3, 1, 1]
