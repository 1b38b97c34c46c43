"""Refinement: long edges are split, the surface is unchanged."""

import numpy as np
import pytest

from lbskel.preprocess.subdivision import coarse_fraction, refine
from lbskel.shapes import torus


def test_long_edges_are_split_without_changing_the_surface():
    mesh = torus(1.0, 0.1, 20, 5)
    assert coarse_fraction(mesh, 0.8) == 1.0
    result = refine(mesh, max_edge_length=0.5)
    assert coarse_fraction(result.mesh, 0.6) < 0.02
    assert result.mesh.genus == 1
    assert np.array_equal(result.mesh.vertices[: len(mesh.vertices)], mesh.vertices)
    assert result.vertex_map.indices.tolist() == list(range(len(mesh.vertices)))
    assert result.mesh.area == pytest.approx(mesh.area)
    assert result.mesh.volume == pytest.approx(mesh.volume)


def test_flat_parts_are_hardly_refined(rod):
    flat = rod.with_vertices(rod.vertices * [1, 1, 1e-3])
    # only its boundary, whose normals lie in the plane, is refined; else it would get a hundred times the faces
    assert len(refine(flat).mesh.faces) < 4 * len(flat.faces)
