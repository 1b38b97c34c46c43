"""Preparation: unit size, bodies, maps and notes, and the way back to the caller's coordinates."""

import numpy as np
import pytest
from helpers import joined, moved

import lbskel
from lbskel import Mesh, MeshError, Skeleton, UnknownChoice
from lbskel.geometry import shape_diameter
from lbskel.geometry.shape_diameter import thickness_along_normal
from lbskel.pipeline.preparation import prepare
from lbskel.shapes import capsule, cylinder, flat_grid, sphere, torus


def test_the_mesh_is_at_unit_size_about_the_origin(tripod):
    mesh = tripod.with_vertices(1000 * tripod.vertices + [5.0, -7.0, 11.0])
    prepared = prepare(mesh)
    assert prepared.mesh.diameter_bound == pytest.approx(1.0, rel=1e-12)
    assert np.abs(prepared.mesh.centroid).max() < 1e-12
    assert prepared.frame.scale == pytest.approx(mesh.diameter_bound, rel=1e-15)
    assert prepared.source is mesh
    back = prepared.frame.from_unit(prepared.mesh.vertices)[prepared.vertex_map.indices]
    assert np.abs(back - mesh.vertices).max() < 1e-12 * mesh.diameter_bound
    assert np.abs(prepared.frame.to_unit(back) - prepared.mesh.vertices[prepared.vertex_map.indices]).max() < 1e-14


def test_each_part_with_an_inside_is_a_body(rod, ring):
    crumb = lbskel.Mesh(np.eye(3) + 9, [[0, 1, 2]])
    prepared = prepare(joined(rod, moved(ring, 4.0), crumb), preprocess=None)
    assert [len(body.mesh.faces) for body in prepared.bodies] == [300, 256]
    assert prepared.notes == ("too small for a skeleton: 1 component",)
    for body in prepared.bodies:
        assert np.array_equal(body.mesh.vertices, prepared.mesh.vertices[body.vertices])


def test_the_cuts_of_a_tube_are_its_own_where_another_goes_through_them():
    wide, narrow = cylinder(1.0, 10.0, 32, 60), cylinder(0.3, 10.0, 24, 100)
    rod = capsule(14.0, 0.3, 24)
    for inner, n_cuts in ((narrow, 2), (rod, 0)):
        outer, other = sorted(prepare(joined(wide, inner)).bodies, key=lambda body: -np.ptp(body.mesh.vertices[:, 0]))
        assert (len(outer.open_ends), outer.is_piece) == (2, True)
        assert (len(other.open_ends), other.is_inner, other.is_piece) == (n_cuts, n_cuts > 0, False)


def test_the_inner_wall_of_a_pipe_is_told_and_not_joined_to_the_outer():
    mesh = joined(cylinder(1.0, 10.0, 32, 60), cylinder(0.8, 10.0, 32, 60))
    skeleton = lbskel.skeletonize(mesh)
    assert (skeleton.n_components, len(skeleton.tips), skeleton.report["pieces_joined"]) == (2, 4, 0)
    (note,) = (note for note in skeleton.report["notes"] if "inside others" in note)
    assert "leave one surface of a wall out: component 1, at (" in note
    assert not prepare(joined(mesh, moved(mesh, 4.0))).bodies[0].is_inner


def test_sheets_are_told_and_a_flat_one_is_no_piece(rod):
    ground, hills = flat_grid(), flat_grid(20, 20)
    hills = hills.with_vertices(hills.vertices + [3, 0, 0] + 0.1 * np.sin(6 * hills.vertices[:, :1]) * [0, 0, 1])
    prepared = prepare(joined(rod, moved(ground, 1.0), hills))
    assert [body.is_piece for body in prepared.bodies] == [False, False, True]
    (note,) = prepared.notes
    assert note.startswith("sheets enclose no volume")
    assert note.endswith("leave them out: component 1, at (1.93333, 1, 0), component 2, at (3.94737, 1, -0.0563796)")
    assert prepare(cylinder(1.0, 10.0, 32, 60)).notes == ("2 holes were closed with 64 faces",)


def test_a_large_body_has_a_proxy_unless_it_is_not_wanted():
    fine = torus(1.0, 0.35, 200, 60)
    assert len(prepare(fine).bodies[0].proxy.mesh.faces) < len(fine.faces)
    full = prepare(fine, simplify="none")
    assert full.bodies[0].proxy.mesh is full.bodies[0].mesh
    # the surface of the score is the same in both
    assert len(full.surface.proxy.mesh.faces) == len(prepare(fine).surface.proxy.mesh.faces) < len(fine.faces)


def test_a_skeleton_is_brought_to_the_vertices_of_the_prepared_mesh(rod):
    corners = rod.faces.ravel()
    soup = lbskel.Mesh(rod.vertices[corners], np.arange(len(corners)).reshape(-1, 3))
    prepared = prepare(soup)
    nodes = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    node_of_vertex = (soup.vertices[:, 2] > 0).astype(int)
    skeleton = Skeleton(nodes, [[0, 1]], [0.4, 0.4], node_of_vertex, mean_radii=[0.5, 0.5])
    local = prepared.skeleton_to_unit(skeleton)
    assert np.abs(local.nodes - prepared.frame.to_unit(nodes)).max() == 0
    assert local.radii * prepared.frame.scale == pytest.approx([0.4, 0.4])
    assert local.mean_radii * prepared.frame.scale == pytest.approx([0.5, 0.5])
    height = prepared.frame.from_unit(prepared.mesh.vertices)[:, 2]
    assert np.array_equal(local.node_of_vertex, (height > 0).astype(int))


def test_what_cannot_be_prepared_says_why(rod):
    with pytest.raises(UnknownChoice, match="'some'"):
        prepare(rod, simplify="some")
    with pytest.raises(MeshError, match="all vertices of the mesh lie at one point"):
        prepare(rod.with_vertices(0 * rod.vertices))


def test_vertices_that_preprocessing_adds_are_mapped_to_nodes_near_them():
    """A square tower of 8 vertices is split to hundreds; the finished skeleton knows the nodes of the 8 alone."""
    corners = np.array([[x, y, z] for z in (0.0, 8.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)
    quads = [[3, 2, 1, 0], [4, 5, 6, 7], *([k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4] for k in range(4))]
    tower = lbskel.as_mesh((corners, quads))
    skeleton = lbskel.skeletonize(tower)
    prepared = prepare(tower)
    assert len(prepared.mesh.vertices) > 100
    local = prepared.skeleton_to_unit(skeleton)
    ways, bound = prepared.mesh.vertices - local.nodes[local.node_of_vertex], 2 / prepared.frame.scale
    assert np.abs(ways[:, 2]).max() < bound
    assert np.linalg.norm(ways, axis=1).max() < bound
    assert skeleton.report["score"]["measures"]["coverage"] > 0.5


def test_the_order_of_vertices_and_faces_does_not_change_the_skeleton(tripod):
    mesh = tripod
    random = np.random.default_rng(5)
    order = random.permutation(len(mesh.vertices))
    other = lbskel.Mesh(mesh.vertices[order], np.argsort(order)[mesh.faces][random.permutation(len(mesh.faces))])
    first, second = lbskel.skeletonize(mesh), lbskel.skeletonize(other)
    assert first.edges.tolist() == second.edges.tolist()
    # the centroid is summed in another order, which ten linear systems amplify
    assert np.abs(first.nodes - second.nodes).max() < 1e-6 * mesh.diagonal
    assert first.node_of_vertex[order].tolist() == second.node_of_vertex.tolist()


@pytest.mark.parametrize("n_faces", [None, 150])
def test_a_mirror_image_has_the_mirror_image_of_the_skeleton(tripod, n_faces):
    """The coarse one is refined, which divides faces in the sense of their orientation."""
    mesh = tripod if n_faces is None else lbskel.preprocess.simplify(tripod, target_faces=n_faces).mesh
    mirror = np.array([1.0, -1, 1])
    first, second = (
        lbskel.skeletonize(given) for given in (mesh, Mesh(mesh.vertices * mirror, mesh.faces[:, [1, 0, 2]]))
    )
    assert first.edges.tolist() == second.edges.tolist()
    assert np.abs(first.nodes - second.nodes * mirror).max() < 1e-6 * mesh.diagonal  # of the rounding of ten systems
    assert first.node_of_vertex.tolist() == second.node_of_vertex.tolist()


def test_the_radii_that_show_that_a_mesh_is_fine_are_those_of_its_body(tripod, monkeypatch):
    calls = []
    monkeypatch.setattr(
        shape_diameter,
        "thickness_along_normal",
        lambda mesh, faces, **options: calls.append(mesh) or thickness_along_normal(mesh, faces, **options),
    )
    prepared = prepare(Mesh(tripod.vertices, tripod.faces))
    (body,) = prepared.bodies
    radii = shape_diameter.local_radii(body.mesh)
    assert len(calls) == 1
    assert radii == pytest.approx(shape_diameter.local_radii(Mesh(body.mesh.vertices, body.mesh.faces)), rel=1e-9)


def test_the_radii_that_show_that_a_mesh_is_coarse_decide_how_it_is_refined(monkeypatch):
    calls = []
    monkeypatch.setattr(
        shape_diameter,
        "thickness_along_normal",
        lambda mesh, faces, **options: calls.append(mesh) or thickness_along_normal(mesh, faces, **options),
    )
    coarse = torus(1.0, 0.2, 12, 4)
    assert len(prepare(coarse).mesh.faces) > len(coarse.faces)
    assert len(calls) == 1


def test_rays_of_one_body_do_not_end_at_another():
    ball = sphere(3)
    shell = Mesh(
        np.concatenate([ball.vertices, 0.5 * ball.vertices]),
        np.concatenate([ball.faces, ball.faces + len(ball.vertices)]),
    )
    bodies = prepare(shell).bodies
    assert [shape_diameter.local_radii(body.mesh).max() / body.mesh.diameter_bound for body in bodies] == pytest.approx(
        [0.5] * len(bodies), rel=0.1
    )
