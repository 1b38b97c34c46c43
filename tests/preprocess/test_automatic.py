"""The default preprocessing: what it repairs and what it returns unchanged."""

import numpy as np
import pytest
from helpers import joined, without_faces

from lbskel import Mesh, MeshError, Pipeline, UnknownChoice, skeletonize
from lbskel.preprocess import preprocess_mesh
from lbskel.shapes import capsule, chain_of_tori, flat_grid, torus

TORUS = torus(1.0, 0.4, 40, 24)


def test_a_valid_mesh_is_returned_unchanged():
    for mesh in (TORUS, chain_of_tori(2, step=0.1)):
        result = preprocess_mesh(mesh)
        assert result.mesh is mesh
        assert result.report == {"pipeline": "auto", "steps": []}


@pytest.mark.parametrize("how", [None, "none"])
def test_none_returns_the_mesh_unchanged(how):
    given = without_faces(TORUS, range(7))
    assert preprocess_mesh(given, how).mesh is given


def test_holes_are_closed_and_a_coarse_mesh_refined():
    closed = preprocess_mesh(without_faces(TORUS, range(7)))
    assert closed.mesh.genus == 1
    assert [step["step"] for step in closed.report["steps"]] == ["close_holes"]
    fine = preprocess_mesh(torus(1.0, 0.1, 20, 5))
    assert [step["step"] for step in fine.report["steps"]] == ["refine"]


def test_t_junctions_are_closed():
    V, F = TORUS.vertices.tolist(), TORUS.faces.tolist()
    for face in range(0, 200, 20):
        a, b, c = F[face]
        V.append(((TORUS.vertices[a] + TORUS.vertices[b]) / 2).tolist())
        F[face] = [len(V) - 1, b, c]
        F.append([a, len(V) - 1, c])
    result = preprocess_mesh(Mesh(V, F))
    assert result.mesh.genus == 1
    assert result.mesh.area == pytest.approx(TORUS.area)
    assert result.mesh.face_areas.min() > 0.1 * TORUS.face_areas.min()


def test_a_sheet_stays_open_and_open_debris_is_removed(rod):
    assert preprocess_mesh(flat_grid()).mesh.is_closed is False
    given = joined(without_faces(TORUS, range(7)), Mesh([[5, 0, 0], [5.1, 0, 0], [5, 0.1, 0]], [[0, 1, 2]]))
    result = preprocess_mesh(given)
    assert (result.mesh.n_components, result.mesh.genus) == (1, 1)
    assert (result.vertex_map.indices[-3:] == -1).all()


def test_coordinates_that_would_overflow_are_rejected():
    for scale in (1e76, 1e300):
        with pytest.raises(MeshError, match=r"vertex \d+ are as large as .* scale the mesh down"):
            skeletonize(TORUS.with_vertices(scale * TORUS.vertices))
    assert skeletonize(Mesh(1e70 * torus(1.0, 0.4, 16, 10).vertices, torus(1.0, 0.4, 16, 10).faces)).cycle_rank == 1


def test_a_skeleton_through_a_pipeline_is_mapped_from_the_given_mesh(tmp_path):
    mesh = capsule(3.0, 0.4, 20)
    skeleton = skeletonize(mesh, preprocess="simplify:target_faces=600")
    assert len(skeleton.node_of_vertex) == len(mesh.vertices)
    near = np.linalg.norm(skeleton.nodes[skeleton.node_of_vertex] - mesh.vertices, axis=1)
    assert near.max() < 1.5 * 0.4
    assert skeleton.report["preprocess"]["pipeline"] == "simplify:target_faces=600"
    again = skeletonize(mesh, preprocess=Pipeline.parse(skeleton.report["preprocess"]["pipeline"]))
    assert np.array_equal(again.nodes, skeleton.nodes)
    with pytest.raises(UnknownChoice, match="a Pipeline, a name or None"):
        skeletonize(mesh, preprocess=3)


def test_vertices_and_faces_are_taken():
    result = preprocess_mesh((TORUS.vertices, TORUS.faces[7:]))
    assert (result.mesh.genus, result.report["pipeline"]) == (1, "auto")
    alone = preprocess_mesh((TORUS.vertices, TORUS.faces[7:]), "close_holes")
    assert alone.report["pipeline"] == "close_holes"
    assert np.array_equal(alone.mesh.faces, result.mesh.faces)


def test_a_surface_inside_out_is_reoriented():
    reversed_torus = Mesh(TORUS.vertices, TORUS.faces[:, ::-1])
    result = preprocess_mesh(reversed_torus)
    assert result.mesh.volume == pytest.approx(TORUS.volume)
    assert result.notes == ("1920 faces were reversed",)
    assert result.vertex_map.is_identity
