"""The default preprocessing: what it repairs and what it returns unchanged."""

import numpy as np
import pytest
from helpers import joined, without_faces

from lbskel import Mesh, MeshError, Pipeline, Skeleton, UnknownChoice, skeletonize
from lbskel.geometry.components import components
from lbskel.geometry.deadline import Deadline
from lbskel.preprocess import preprocess_mesh
from lbskel.preprocess.automatic import OUT_OF_TIME
from lbskel.shapes import capsule, chain_of_tori, flat_grid, make, sphere, torus, tube, tube_mesh

TORUS = torus(1.0, 0.4, 40, 24)


def test_a_valid_mesh_is_returned_unchanged():
    for mesh in (TORUS, chain_of_tori(2, step=0.1)):
        result = preprocess_mesh(mesh)
        assert result.mesh is mesh
        assert result.report == {"pipeline": "auto", "steps": [], "open_ends": []}


@pytest.mark.parametrize("how", [None, "none"])
def test_none_returns_the_mesh_unchanged(how):
    given = without_faces(TORUS, range(7))
    assert preprocess_mesh(given, how).mesh is given


def test_a_mesh_is_coarse_where_most_of_its_area_is_though_few_of_its_faces_are():
    """A bar of long faces, and a ball of a tenth of its area with ten times its faces."""
    z = np.linspace(0, 10, 5)
    bar = tube(np.stack([0 * z, 0 * z, z], axis=1), 0.5, sides=6)
    ball = sphere(4)
    mesh = joined(bar, ball.with_vertices(0.5 * ball.vertices + [5, 0, 0]))
    assert len(bar.faces) < 0.1 * len(ball.faces)
    prepared = preprocess_mesh(mesh)
    assert len(prepared.mesh.faces) >= len(ball.faces) + 3 * len(bar.faces)


def test_holes_are_closed_and_a_coarse_mesh_refined():
    closed = preprocess_mesh(without_faces(TORUS, range(7)))
    assert closed.mesh.genus == 1
    assert [step["step"] for step in closed.report["steps"]] == ["close_holes"]
    fine = preprocess_mesh(torus(1.0, 0.1, 20, 5))
    assert [step["step"] for step in fine.report["steps"]] == ["refine"]


def test_crumbs_are_removed_unless_there_is_nothing_else():
    crumb = Mesh(0.01 * np.eye(3) + [3.0, 0, 0], [[0, 1, 2]])
    result = preprocess_mesh(joined(TORUS, crumb))
    assert np.array_equal(result.mesh.faces, TORUS.faces)
    assert result.vertex_map.indices[-3:].tolist() == [-1] * 3
    only = joined(crumb, crumb.with_vertices(crumb.vertices + [1, 0, 0]))
    assert len(preprocess_mesh(only).mesh.faces) == 2


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


@pytest.mark.parametrize("share", [1, 100, 500])
def test_faces_that_are_refined_without_their_neighbors_leave_no_hole(share):
    rng = np.random.default_rng(0)
    chosen = rng.permutation(len(TORUS.faces))[: len(TORUS.faces) * share // 1000]
    a, b, c = TORUS.faces[chosen].T
    ends = np.concatenate([[a, b], [b, c], [c, a]], axis=1).T
    edges, of_side = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    ab, bc, ca = len(TORUS.vertices) + of_side.reshape(3, -1)
    smaller = np.concatenate([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]], axis=1).T
    vertices = np.concatenate([TORUS.vertices, TORUS.vertices[edges].mean(axis=1)])
    closed = preprocess_mesh(Mesh(vertices, np.concatenate([np.delete(TORUS.faces, chosen, axis=0), smaller])))
    assert (closed.mesh.is_closed_manifold, closed.mesh.n_components, closed.mesh.genus) == (True, 1, 1)
    assert closed.mesh.volume == pytest.approx(TORUS.volume, rel=0.001)


def test_a_sheet_stays_open_and_open_debris_is_removed(rod):
    assert preprocess_mesh(flat_grid()).mesh.is_closed is False
    given = joined(without_faces(TORUS, range(7)), Mesh([[5, 0, 0], [5.1, 0, 0], [5, 0.1, 0]], [[0, 1, 2]]))
    result = preprocess_mesh(given)
    assert (result.mesh.n_components, result.mesh.genus) == (1, 1)
    assert (result.vertex_map.indices[-3:] == -1).all()


@pytest.mark.parametrize("distance", [1e5, 1e9, 1e70])
def test_a_stray_face_is_removed_however_far_away_it_is(distance):
    stray = Mesh([[distance, 0, 0], [distance, 0.1, 0], [distance, 0, 0.1]], [[0, 1, 2]])
    result = preprocess_mesh(joined(TORUS, stray))
    assert np.array_equal(result.mesh.vertices, TORUS.vertices)
    assert np.array_equal(result.mesh.faces, TORUS.faces)


def test_a_mesh_that_merging_would_destroy_is_not_merged():
    """Long needles between two clusters, each far smaller than the tolerance."""
    rng = np.random.default_rng(0)
    ends = 1e-9 * rng.normal(size=(2, 400, 3)) + [[[0, 0, 0]], [[1, 0, 0]]]
    k = np.arange(400)
    result = preprocess_mesh(Mesh(ends.reshape(-1, 3), np.stack([k, 400 + k, 400 + (k + 1) % 400], axis=1)))
    assert "vertices that are close were not merged, since that would merge most of the mesh" in result.notes


def test_debris_around_a_hole_is_removed_also_if_it_has_many_faces_and_small_closed_bodies_are_kept():
    """A patch of 0.0025 of the area, below 0.01, in 242 faces, which are no crumb: they are more than 0.2 % of all."""
    given = without_faces(TORUS, range(7))
    side = np.sqrt(0.0025 * given.area)
    patch = flat_grid(12, 12)
    patch = patch.with_vertices(side * patch.vertices + [3, 0, 0])
    result = preprocess_mesh(joined(given, patch))
    assert (result.mesh.n_components, result.mesh.genus) == (1, 1)
    assert (result.vertex_map.indices[-144:] == -1).all()
    note = "1 open component was removed as smaller than 0.01 of the largest one's area and no piece of a limb"
    assert note in result.notes
    larger = patch.with_vertices(2.5 * patch.vertices)  # 0.0156 of the area: no debris
    assert preprocess_mesh(joined(given, larger)).mesh.n_components == 2
    ball = sphere(2).with_vertices(0.05 * sphere(2).vertices + [3, 0, 0])
    assert ball.area < 0.0025 * given.area
    assert preprocess_mesh(joined(given, ball)).mesh.n_components == 2


def test_dangling_faces_are_removed_from_a_closed_surface_only():
    outside = np.array([[2.0, 0, 0.3], [0, 2.0, 0.3]])
    fins = [[*TORUS.faces[k, :2], len(TORUS.vertices) + i] for i, k in enumerate((0, 700))]
    finned = Mesh(np.concatenate([TORUS.vertices, outside]), np.concatenate([TORUS.faces, fins]))
    result = preprocess_mesh(finned)
    assert np.array_equal(result.mesh.faces, TORUS.faces)
    assert "2 dangling faces were removed from a closed surface" in result.notes
    skeleton = skeletonize(finned)
    assert (skeleton.cycle_rank, len(skeleton.tips), skeleton.report["passed"]) == (1, 0, True)
    open_surface = without_faces(finned, range(400, 410))
    assert not [note for note in preprocess_mesh(open_surface).notes if "dangling" in note]


def test_a_twig_that_is_cut_off_is_a_piece_however_small():
    """A twig on a trunk, with a slit across it: what is beyond has 0.008 of the area, and is joined to the rest."""
    nodes = [[-12, 0, 0], [0, 0, 0], [12, 0, 0], [0, 0, 1], [0, 0, 3]]
    whole = tube_mesh(Skeleton(nodes, [[0, 1], [1, 2], [1, 3], [3, 4]], [1, 1, 1, 0.2, 0.2]), edge_length=0.4).mesh
    height = whole.vertices[whole.faces].mean(axis=1)[:, 2]
    cut = without_faces(whole, np.flatnonzero(np.abs(height - 2.2) < 0.1))
    assert sorted(part.mesh.area / whole.area < 0.01 for part in components(cut)) == [False, True]
    skeleton = skeletonize(cut)
    assert (skeleton.n_components, skeleton.report["pieces_joined"]) == (1, 1)
    assert skeleton.nodes[:, 2].max() > 2.9
    assert not [note for note in skeleton.report["notes"] if "too small" in note or "smaller" in note]


def test_bodies_that_touch_are_split_beside_a_small_one():
    ball = sphere(3)
    top = ball.vertices[:, 2].argmax()
    other = np.where(
        np.arange(len(ball.vertices)) == ball.vertices[:, 2].argmin(),
        top,
        len(ball.vertices) + np.arange(len(ball.vertices)),
    )
    V = np.concatenate([ball.vertices, ball.vertices + [0, 0, 2 * ball.vertices[top, 2]]])
    touching = Mesh(V, np.concatenate([ball.faces, other[ball.faces]]))
    small = sphere(2).with_vertices(0.05 * sphere(2).vertices + [3, 0, 0])
    for given, n in ((touching, 2), (joined(touching, small), 3)):
        result = preprocess_mesh(given)
        assert result.mesh.is_closed_manifold
        assert result.mesh.n_components == n


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
    with pytest.raises(UnknownChoice, match="unknown pipeline or step ''; choose one of: auto, none"):
        skeletonize(mesh, preprocess="")


def test_vertices_and_faces_are_taken():
    result = preprocess_mesh((TORUS.vertices, TORUS.faces[4:]))
    assert (result.mesh.genus, result.report["pipeline"]) == (1, "auto")
    alone = preprocess_mesh((TORUS.vertices, TORUS.faces[4:]), "close_holes")
    assert alone.report["pipeline"] == "close_holes"
    assert np.array_equal(alone.mesh.faces, result.mesh.faces)


def test_a_surface_inside_out_is_reoriented():
    reversed_torus = Mesh(TORUS.vertices, TORUS.faces[:, ::-1])
    result = preprocess_mesh(reversed_torus)
    assert result.mesh.volume == pytest.approx(TORUS.volume)
    assert result.notes == ("1,920 faces were reversed",)
    assert result.vertex_map.is_identity


BALL = sphere(2)


def test_one_of_several_surfaces_that_is_inside_out_is_reoriented(rod):
    """The volume of both together is positive."""
    small = Mesh(0.4 * rod.vertices + [3.0, 0, 0], rod.faces[:, ::-1])
    given = joined(rod, small)
    result = preprocess_mesh(given)
    assert given.volume > 0
    assert result.mesh.volume == pytest.approx(rod.volume * (1 + 0.4**3))
    assert result.notes == (f"{len(rod.faces)} faces were reversed",)


@pytest.mark.parametrize("name", ["rod", "limbs"])
def test_a_cavity_belongs_to_the_solid_around_it(name):
    """A round void on the axis: one body, a note, and its vertices have nodes."""
    if name == "rod":
        solid, center, radius = capsule(6.0, 0.5, 20), np.zeros(3), 0.3
    else:
        shape = make("limbs", n_vertices=1500)
        thickest = shape.truth.radii.argmax()
        solid, center, radius = shape.mesh, shape.truth.nodes[thickest], 0.5 * shape.truth.radii[thickest]
    void = Mesh(center + radius * BALL.vertices, BALL.faces[:, ::-1])
    given = joined(solid, void)
    result = preprocess_mesh(given)
    assert (result.mesh.n_components, result.mesh.volume) == (1, pytest.approx(solid.volume))
    assert (result.vertex_map.indices[len(solid.vertices) :] == -1).all()
    skeleton = skeletonize(given)
    alone = skeletonize(solid)
    assert np.array_equal(skeleton.nodes, alone.nodes)
    assert skeleton.report["score"]["verdict"] != "fail"
    assert [note for note in skeleton.report["notes"] if "1 cavity was filled" in note]
    assert np.array_equal(skeleton.node_of_vertex[: len(solid.vertices)], alone.node_of_vertex)
    to_void = np.linalg.norm(skeleton.nodes[skeleton.node_of_vertex[len(solid.vertices) :]] - center, axis=1)
    assert to_void.max() < 4 * radius


def test_a_ball_inside_a_solid_is_a_body_and_one_that_is_inward_outside_of_it_is_no_cavity():
    rod = capsule(6.0, 0.5, 20)
    inside = joined(rod, Mesh(0.3 * BALL.vertices, BALL.faces))
    assert preprocess_mesh(inside).mesh is inside
    assert skeletonize(inside).n_components == 2
    outside = joined(rod, Mesh(0.3 * BALL.vertices + [3.0, 0, 0], BALL.faces[:, ::-1]))
    assert preprocess_mesh(outside).mesh.n_components == 2


def test_crumbs_are_removed_and_their_vertices_have_nodes(tetrahedron):
    fine = torus(1.0, 0.4, 60, 24)  # of 2880 faces, of which 4 are less than 0.2 %
    crumb = Mesh(0.05 * tetrahedron.vertices + [1.6, 0, 0], tetrahedron.faces)
    given = joined(fine, crumb, Mesh(crumb.vertices + [0, 0, 1.0], crumb.faces))
    result = preprocess_mesh(given)
    assert result.mesh.n_components == 1
    assert "2 components were removed as too small for a skeleton" in result.notes
    skeleton = skeletonize(given)
    assert (skeleton.n_components, skeleton.cycle_rank, skeleton.report["passed"]) == (1, 1, True)
    assert len(skeleton.node_of_vertex) == len(given.vertices)
    # a component as small in faces alone is a body
    large = joined(fine, Mesh(tetrahedron.vertices + [3.0, 0, 0], tetrahedron.faces))
    assert preprocess_mesh(large).mesh.n_components == 2


def test_after_a_deadline_defects_are_repaired_and_nothing_else_is_looked_for():
    given = without_faces(TORUS, range(1))
    cavity = sphere(1)
    given = joined(given, Mesh(0.05 * cavity.vertices + [1.0, 0, 0], cavity.faces[:, ::-1]))
    in_time, late = preprocess_mesh(given), preprocess_mesh(given, deadline=Deadline(0.0))
    assert (in_time.mesh.n_components, late.mesh.n_components) == (1, 2)
    assert late.mesh.is_closed_manifold
    assert late.notes[-1] == OUT_OF_TIME
    assert OUT_OF_TIME not in in_time.notes


def test_crumbs_are_removed_before_the_repair_unless_it_may_close_them(tetrahedron):
    """Crumbs beside an open surface: one inside of it that faces inwards, and one of three faces around a hole."""
    fine = without_faces(torus(1.0, 0.4, 60, 24), range(1))
    crumb = Mesh(0.05 * tetrahedron.vertices, tetrahedron.faces)
    inward = Mesh(crumb.vertices + [1.0, 0, 0], crumb.faces[:, ::-1])
    result = preprocess_mesh(joined(fine, inward, Mesh(crumb.vertices + 2.0, crumb.faces)))
    assert result.mesh.is_closed_manifold
    assert result.mesh.n_components == 1
    assert [note for note in result.notes if "components" in note or "cavities" in note] == [
        "2 components were removed as too small for a skeleton"
    ]
    open_body = Mesh(tetrahedron.vertices + [3.0, 0, 0], tetrahedron.faces[1:])
    assert preprocess_mesh(joined(fine, open_body)).mesh.n_components == 2
