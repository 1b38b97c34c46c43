"""Anchors: from the caller's vertices and points to those of each body."""

import numpy as np
import pytest
from helpers import box_mesh, joined, moved

from lbskel import Mesh, MeshError, skeletonize
from lbskel.pipeline.anchoring import listed_anchors, resolve_anchors
from lbskel.pipeline.preparation import prepare
from lbskel.shapes import capsule, torus


def test_anchors_are_brought_to_unit_coordinates_and_to_their_body(rod, ring):
    mesh = joined(rod, moved(ring, 4.0))
    mesh = mesh.with_vertices(10 * mesh.vertices + [1.0, 2.0, 3.0])
    prepared = prepare(mesh, preprocess=None)
    on_ring = len(rod.vertices) + 5
    point = mesh.vertices[3] * 0.5 + mesh.vertices[7] * 0.5
    anchors = resolve_anchors([on_ring, point, 3], prepared)
    assert (
        np.abs(
            anchors.points - prepared.frame.to_unit(np.stack([mesh.vertices[on_ring], point, mesh.vertices[3]]))
        ).max()
        == 0
    )
    rod_body, ring_body = sorted(prepared.bodies, key=lambda body: body.mesh.genus)
    of_rod, of_ring = anchors.within(rod_body), anchors.within(ring_body)
    assert len(of_rod.points) == 2
    assert np.array_equal(ring_body.mesh.vertices[of_ring.vertices], of_ring.points)


@pytest.mark.parametrize("anchors", [0, 1.5, "012", None])
def test_what_is_no_list_is_refused(anchors, rod):
    with pytest.raises(MeshError, match=r"anchors must be a list of vertices or points, such as \[0\]"):
        resolve_anchors(anchors, prepare(rod))


def test_no_anchors_are_none(rod):
    anchors = resolve_anchors((), prepare(rod))
    assert (anchors.vertices.shape, anchors.points.shape) == ((0,), (0, 3))


def test_an_anchor_given_twice_is_one_and_has_the_number_of_the_first(rod):
    point = rod.vertices[3].tolist()
    anchors = resolve_anchors([5, 3, point, 5, 3], prepare(rod))
    assert (len(anchors.vertices), len(anchors.points), anchors.numbers.tolist()) == (2, 2, [0, 1])


def test_an_error_names_the_anchor_by_its_place_in_the_list(rod, ring):
    both = joined(rod, ring)
    outside = ring.vertices.max(axis=0) + 0.01
    with pytest.raises(MeshError, match="anchor 1 lies outside"):
        skeletonize(both, anchors=[0, outside])


def test_a_vertex_that_smoothing_moves_is_an_anchor_at_its_new_place():
    ring = torus(1.0, 0.25)
    noise = np.random.default_rng(0).normal(0, 0.3 * ring.edge_lengths.mean(), ring.vertices.shape)
    noisy = Mesh(ring.vertices + noise, ring.faces)
    prepared = prepare(noisy)
    outside = int(prepared.surface.distance(prepared.frame.to_unit(noisy.vertices)).argmax())
    by_index, by_place = (resolve_anchors([anchor], prepared) for anchor in (outside, noisy.vertices[outside]))
    place = prepared.mesh.vertices[prepared.vertex_map.indices[outside]]
    assert np.array_equal(by_index.points, [place])
    assert np.array_equal(by_place.points, [place])
    assert len(skeletonize(noisy, anchors=[int(v) for v in range(0, 1000, 150)]).anchors) == 7


def test_vertices_that_preprocessing_joins_are_one_anchor(rod):
    """The corners of triangles without common vertices, as in STL, that lie at almost one place."""
    corners = rod.vertices[rod.faces].reshape(-1, 3)
    corners = corners + 1e-9 * np.random.default_rng(0).normal(size=corners.shape)
    soup = Mesh(corners, np.arange(len(corners)).reshape(-1, 3))
    at_one_place = np.flatnonzero(rod.faces.ravel() == rod.faces[0, 0])
    assert len(resolve_anchors(at_one_place.tolist(), prepare(soup)).points) == 1


@pytest.mark.parametrize("anchors", [np.array(0), np.array(0.5)])
def test_a_single_number_is_no_list_of_anchors(anchors):
    with pytest.raises(MeshError, match="anchors must be a list"):
        listed_anchors(anchors)


def test_an_anchor_inside_a_body_is_of_that_body_though_a_vertex_of_another_is_nearer():
    box, rod = box_mesh((2, 2, 6)), moved(capsule(5.0, 0.1, 12), 1.2)
    skeleton = skeletonize(joined(box, rod), anchors=[(0, 0, 0)])
    (node,) = skeleton.anchors
    assert skeleton.nodes[node] == pytest.approx(0, abs=1e-9)
    assert skeleton.component_of_node[node] == skeleton.component_of_node[skeleton.node_of_vertex[0]]


@pytest.mark.parametrize("preprocess", ["auto", None])
def test_an_anchor_beside_or_at_a_crumb_is_of_the_body_around_it(preprocess, tetrahedron):
    rod, crumb = capsule(3.0, 0.4, 40), tetrahedron.with_vertices(1e-3 * tetrahedron.vertices)
    mesh = joined(rod, crumb)
    for anchor in ((0.0, 0.0, 0.01), len(rod.vertices)):
        skeleton = skeletonize(mesh, anchors=[anchor], preprocess=preprocess)
        assert np.linalg.norm(skeleton.nodes[skeleton.anchors], axis=1).max() <= 0.01 + 1e-9
        assert len(skeleton.anchors) == 1
