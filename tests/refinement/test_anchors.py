"""Anchors and the root: vertices and points that the caller names, and nodes at them."""

import numpy as np
import pytest
from helpers import path_in

from lbskel import Mesh, MeshError, Skeleton, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.anchors import attach_anchors, nearest_node, resolve_anchor
from lbskel.refinement.radii import inscribed_radii
from lbskel.shapes import capsule, flat_grid


@pytest.fixture(scope="module")
def mesh():
    """A rod of radius 0.5 from -2.5 to 2.5 along z."""
    return capsule(4.0, 0.5, 32)


@pytest.fixture(scope="module")
def skeleton(mesh):
    """Five nodes on the axis, one unit apart."""
    return inscribed_radii(path_in(mesh, [[0, 0, z] for z in (-2, -1, 0, 1, 2)]), Surface(mesh))


def with_anchor(skeleton, mesh, point):
    vertex, point = resolve_anchor(point, mesh)
    return attach_anchors(skeleton, Surface(mesh), np.array([vertex]), point[None], np.array([7]))


def test_a_vertex_is_itself_and_a_point_has_the_nearest_vertex_in_use():
    loose = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.4, 0.4, 0]], [[0, 1, 2]])
    assert resolve_anchor(1, loose)[0] == 1
    with pytest.raises(MeshError, match="vertex 3, given as anchor, belongs to no face"):
        resolve_anchor(3, loose)
    vertex, point = resolve_anchor([0.4, 0.7, 0], loose)
    assert (vertex, point.tolist()) == (2, [0.4, 0.7, 0])  # the last vertex is nearer, but in no face


@pytest.mark.parametrize(
    ("anchor", "message"),
    [
        (-1, "there is no vertex -1"),
        (3, r"there is no vertex 3, given as anchor: the mesh has vertices 0\.\.2"),
        (0.5, "must be the index of a vertex or a point"),
        ([0, 0], "must be the index of a vertex or a point"),
        ([0, 0, np.inf], "must be the index of a vertex or a point"),
        ([0, 0, 1j], "must be the index of a vertex or a point"),
        ([1, [2]], "must be the index of a vertex or a point"),
        ("a", "must be the index of a vertex or a point"),
    ],
)
def test_what_is_neither_a_vertex_nor_a_point_is_refused(anchor, message):
    with pytest.raises(MeshError, match=message):
        resolve_anchor(anchor, Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))


@pytest.mark.filterwarnings("error")
def test_an_anchor_beyond_all_squares_is_refused_without_a_warning(ring):
    with pytest.raises(MeshError, match="anchor 0 lies outside"):
        skeletonize(ring, anchors=[[1e300, 0, 0]])


def test_a_node_near_an_anchor_moves_to_it(skeleton, mesh):
    anchored = with_anchor(skeleton, mesh, [0.1, 0, 2.1])
    assert anchored.nodes[4].tolist() == [0.1, 0, 2.1]
    assert anchored.anchors.tolist() == [4]
    assert anchored.radii[4] == pytest.approx(0.5 - np.hypot(0.1, 0.1), rel=0.02)
    assert np.array_equal(anchored.edges, skeleton.edges)


def test_an_edge_near_an_anchor_is_bent_through_it(skeleton, mesh):
    anchored = with_anchor(skeleton, mesh, [0.2, 0, 0.5])
    assert anchored.nodes[5].tolist() == [0.2, 0, 0.5]
    assert anchored.edges.tolist() == [[0, 1], [1, 2], [2, 5], [3, 4], [3, 5]]
    assert anchored.anchors.tolist() == [5]
    assert anchored.radii[5] == pytest.approx(0.3, rel=0.02)


def test_an_anchor_far_from_the_skeleton_gets_a_branch_from_the_node_of_its_vertex(skeleton, mesh):
    """Farther than half the local radius of 0.5."""
    anchored = with_anchor(skeleton, mesh, [0.3, 0, 0.1])
    assert np.array_equal(anchored.nodes[anchored.anchors], [[0.3, 0, 0.1]])
    assert (len(anchored.tips), anchored.cycle_rank, anchored.n_components) == (3, 0, 1)
    assert anchored.degrees[2] == 3
    assert Surface(mesh).contains(anchored.nodes).all()


def test_an_anchor_on_a_sheet_adds_no_more_nodes_than_its_path_has_vertices():
    sheet = flat_grid(20, 20)
    sheet = sheet.with_vertices(sheet.vertices + 0.1 * np.sin(6 * sheet.vertices[:, :1]) * [0, 0, 1])
    plain, anchored = skeletonize(sheet), skeletonize(sheet, anchors=[0])
    assert np.allclose(anchored.nodes[anchored.anchors], sheet.vertices[:1])
    assert len(anchored.nodes) - len(plain.nodes) <= 2 * 20


def test_a_second_anchor_does_not_move_the_first(skeleton, mesh):
    first = with_anchor(skeleton, mesh, [0.1, 0, 2.1])
    both = with_anchor(first, mesh, [0.12, 0, 2.15])
    assert len(both.anchors) == 2
    assert np.array_equal(both.nodes[both.anchors], [[0.1, 0, 2.1], [0.12, 0, 2.15]])


def test_an_anchor_on_the_surface_is_taken_and_one_outside_is_refused(skeleton, mesh):
    assert len(with_anchor(skeleton, mesh, 0).anchors) == 1
    with pytest.raises(MeshError, match="anchor 7 lies outside of the surface"):
        with_anchor(skeleton, mesh, [0.51, 0, 0])


def test_an_anchor_of_an_open_mesh_must_lie_in_its_bounding_sphere(skeleton, mesh):
    is_kept = (mesh.vertices[mesh.faces][:, :, 2] < 2.2).all(axis=1)
    cup = Mesh(mesh.vertices, mesh.faces[is_kept])
    assert len(with_anchor(skeleton, cup, [0, 0, 2.2]).anchors) == 1
    with pytest.raises(MeshError, match="anchor 7 lies outside of the bounding sphere of the mesh"):
        with_anchor(skeleton, cup, [0, 0, 4.0])


def test_no_anchors_leave_the_skeleton_alone(skeleton, mesh):
    none = np.empty(0, dtype=np.int64)
    assert attach_anchors(skeleton, Surface(mesh), none, np.empty((0, 3)), none) is skeleton


def test_a_lone_node_moves_to_an_anchor_near_it(mesh):
    lone = Skeleton(np.zeros((1, 3)), [], [0.5], np.zeros(len(mesh.vertices)))
    assert with_anchor(lone, mesh, [0.1, 0, 0]).nodes.tolist() == [[0.1, 0, 0]]
    assert len(with_anchor(lone, mesh, [0, 0, 1.0]).edges) >= 1


def test_the_root_is_the_node_of_a_vertex_or_the_one_nearest_to_a_point(skeleton, mesh):
    top = int(mesh.vertices[:, 2].argmax())
    assert nearest_node(skeleton, top, mesh) == 4
    assert nearest_node(skeleton, [0, 0, 0.6], mesh) == 3
    elsewhere = Skeleton(skeleton.nodes, skeleton.edges, skeleton.radii, np.zeros(len(mesh.vertices)))
    assert nearest_node(elsewhere, top, mesh) == 0


def test_a_root_outside_the_bounding_sphere_is_refused(skeleton, mesh):
    assert nearest_node(skeleton, mesh.vertices[mesh.vertices[:, 2].argmax()], mesh) == 4  # on the sphere itself
    assert nearest_node(skeleton, [2.4, 0, 0], mesh) == 2  # outside the surface, but near
    with pytest.raises(MeshError, match=r"the root .* lies outside of the bounding sphere .* in the units of the mesh"):
        nearest_node(skeleton, [0, 0, 2.6], mesh)
    with pytest.raises(MeshError, match="there is no vertex 9999, given as root"):
        nearest_node(skeleton, 9999, mesh)
