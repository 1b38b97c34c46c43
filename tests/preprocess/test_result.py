"""The result of a step: composition of maps, fields brought back to the input, the report, the distance of surfaces."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from lbskel import Mesh
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.cleaning import merge_close, remove_duplicates
from lbskel.preprocess.result import (
    PreprocessResult,
    hausdorff_distance,
    identity_result,
    mesh_statistics,
    preprocess_step,
)
from lbskel.shapes import sphere, torus


def test_fields_and_labels_are_pulled_back_to_the_input(ring):
    soup = Mesh(ring.vertices[ring.faces].reshape(-1, 3), np.arange(3 * len(ring.faces)).reshape(-1, 3))
    more = Mesh([*soup.vertices, [9, 9, 9]], soup.faces)
    result = merge_close(more).compose(remove_duplicates)
    back = result.pull_back(np.array(result.mesh.vertices))
    assert np.array_equal(back[:-1], soup.vertices)
    assert np.isnan(back[-1]).all()
    labels = result.pull_back(np.arange(len(result.mesh.vertices)))
    assert np.array_equal(labels, result.vertex_map.indices)


def test_maps_weights_notes_and_reports_are_composed(tetrahedron):
    weights = csr_array(np.array([[0.5, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]))
    first = PreprocessResult(tetrahedron, VertexMap([1, 1, 2, 3]), ("first",), weights, {"steps": [1]})

    def reverse(mesh):
        return PreprocessResult(mesh, VertexMap([3, 2, 1, 0]), ("second",), None, {"steps": [2]})

    result = first.compose(reverse)
    assert result.vertex_map.indices.tolist() == [2, 2, 1, 0]
    assert result.weights.toarray().tolist() == [[0, 0, 0.5, 0.5], [0, 0, 1, 0], [0, 1, 0, 0], [1, 0, 0, 0]]
    assert result.notes == ("first", "second")
    assert result.report == {"steps": [1, 2]}
    assert first.report == {"steps": [1]}


def test_real_numbers_are_interpolated_and_labels_are_not(tetrahedron):
    weights = csr_array(np.array([[0.25, 0.75, 0, 0], [0, 0, 0, 0]]))
    result = PreprocessResult(tetrahedron, VertexMap([1, -1]), (), weights)
    assert result.pull_back(np.array([4.0, 8, 0, 0])).tolist()[0] == 7.0
    assert result.pull_back(np.array([4.0, 8, 0, 0]), missing=-5.0).tolist() == [7.0, -5.0]
    assert result.pull_back(np.array([4, 8, 0, 0])).tolist() == [8, -1]
    assert result.pull_back(np.array([False, True, False, False])).tolist() == [True, False]
    assert result.pull_back(np.ones((4, 2, 3))).shape == (2, 2, 3)


def test_the_identity_maps_every_vertex_to_itself(tetrahedron):
    result = identity_result(tetrahedron, "nothing to do")
    assert result.mesh is tetrahedron
    assert result.vertex_map.is_identity
    assert result.notes == ("nothing to do",)


def test_a_step_takes_what_as_mesh_takes_and_reports_what_it_did(tetrahedron):
    @preprocess_step
    def without_first_face(mesh, *, level=2, name=None):
        smaller = Mesh(mesh.vertices, mesh.faces[1:])
        return PreprocessResult(smaller, VertexMap.identity(4), ("done",), report={"deviation": 0.5})

    [record] = without_first_face((tetrahedron.vertices, tetrahedron.faces)).report["steps"]
    assert (record["step"], record["options"]) == ("without_first_face", {"level": 2})
    assert record["before"] == mesh_statistics(tetrahedron)
    assert (record["after"]["faces"], record["after"]["boundary_edges"]) == (3, 3)
    assert (record["notes"], record["deviation"]) == (["done"], 0.5)


def test_the_distance_of_concentric_spheres_is_the_difference_of_their_radii():
    ball = sphere(4)
    larger = ball.with_vertices(1.25 * ball.vertices)
    # relative to the bound of the first; chords of 0.07 lie up to 0.001 below a sphere
    assert hausdorff_distance(ball, larger) == pytest.approx(0.25 / ball.diameter_bound, abs=0.002)
    assert hausdorff_distance(larger, ball) == pytest.approx(0.25 / larger.diameter_bound, abs=0.002)
    assert hausdorff_distance(ball, ball) == 0.0


def test_the_distance_is_taken_in_both_directions():
    """All points of half a ring are on the whole ring, but not the other way round."""
    ring = torus(1.0, 0.3, 40, 20)
    half = Mesh(ring.vertices, ring.faces[ring.vertices[ring.faces].mean(axis=1)[:, 0] > 0])
    there, back = (
        hausdorff_distance(ring, half) * ring.diameter_bound,
        hausdorff_distance(half, ring) * half.diameter_bound,
    )
    assert there == pytest.approx(back)
    assert there > 1.0
