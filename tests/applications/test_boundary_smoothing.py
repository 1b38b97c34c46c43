"""Boundaries of labels: smooth on a sphere, kept in creases, without teeth, and on meshes with faults."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from lbskel import Mesh
from lbskel.applications.boundary_smoothing import _columns, _without_teeth, concavity, smooth_labels
from lbskel.applications.face_graph import FaceGraph, face_graph
from lbskel.shapes import sphere


def boundary_length(labels, graph):
    return graph.lengths[labels[graph.pairs[:, 0]] != labels[graph.pairs[:, 1]]].sum()


def smoothed(mesh, labels, radius, choices=None):
    choices = np.ones((len(labels), labels.max() + 1)) if choices is None else choices
    radii = np.full(len(mesh.faces), radius)
    return smooth_labels(labels, face_graph(mesh), mesh.face_areas, radii, csr_array(choices))


@pytest.fixture(scope="module")
def halves():
    """A sphere of radius 1, the height of each face, and halves with a boundary that waves by 0.15 eleven times."""
    mesh = sphere(4)
    x, y, z = mesh.vertices[mesh.faces].mean(axis=1).T
    return mesh, z, (z > 0.15 * np.sin(11 * np.arctan2(y, x))).astype(np.int64)


def test_a_waving_boundary_becomes_the_equator(halves):
    mesh, z, waving = halves
    found = smoothed(mesh, waving, 1.0)
    edge = mesh.edge_lengths.mean()
    assert (np.abs(z[waving != (z > 0)]) > 1.5 * edge).any()
    assert np.abs(z[found != (z > 0)]).max(initial=0.0) < edge  # a face is one height or the other of its middle
    # 2 / sqrt(3): the shortest path along edges of equilateral triangles in the worst direction, over the straight line
    assert boundary_length(found, face_graph(mesh)) < 2 / np.sqrt(3) * 2 * np.pi


def test_labels_of_distant_faces_share_a_column_and_keep_their_boundaries(halves, monkeypatch):
    mesh, z, _ = halves
    x, y, _ = mesh.vertices[mesh.faces].mean(axis=1).T
    cap = (z > 0.7 + 0.1 * np.sin(11 * np.arctan2(y, x))).astype(np.int64) + 2 * (z < -0.7)
    expected = smoothed(mesh, cap, 0.1)
    choices = np.stack([np.ones(len(z)), z > 0.1, z < -0.1], axis=1)
    assert _columns(csr_array(choices)).tolist() == [0, 1, 1]
    assert smoothed(mesh, cap, 0.1, choices).tolist() == expected.tolist() != cap.tolist()
    monkeypatch.setattr("lbskel.applications.boundary_smoothing.COLUMNS", 1)
    assert smoothed(mesh, cap, 0.1, choices).tolist() == expected.tolist()


def test_columns_differ_where_a_face_can_have_both_labels():
    choices = csr_array(np.array([[1.0, 1, 0, 0], [0, 1, 1, 0], [0, 0, 1, 1], [0, 0, 1, 1]]))
    choices.data[0] = 0.0  # an entry, of any value
    assert _columns(choices).tolist() == [0, 1, 0, 1]


def test_surfaces_are_smoothed_each_with_its_own_labels(halves):
    mesh, _, waving = halves
    n = len(mesh.vertices)
    two = Mesh(np.concatenate([mesh.vertices, mesh.vertices + 5]), np.concatenate([mesh.faces, mesh.faces + n]))
    expected = smoothed(mesh, waving, 1.0)
    found = smoothed(two, np.concatenate([np.where(waving == 1, 7, 2), waving]), 1.0)
    assert found[: len(waving)].tolist() == np.where(expected == 1, 7, 2).tolist()
    assert found[len(waving) :].tolist() == expected.tolist()


def test_scale_does_not_matter_but_waves_longer_than_the_radius_stay(halves):
    mesh, _, waving = halves
    tiny = mesh.with_vertices(1e-4 * mesh.vertices)
    assert smoothed(tiny, waving, 1e-4).tolist() == smoothed(mesh, waving, 1.0).tolist()
    assert (smoothed(mesh, waving, 0.05) != waving).mean() < 0.02  # of the 7 % that the equator changes


def plateau(height):
    """A square in a plane, raised by a height, and the label of its faces, 1 on it and on its walls."""
    n, step = 24, 1 / 12
    i, j = np.divmod(np.arange((n + 1) ** 2), n + 1)
    is_raised = (np.abs(i - n / 2) < 5) & (np.abs(j - n / 2) < 5)
    V = np.stack([i * step, j * step, height * is_raised], axis=1)
    a = np.flatnonzero((i < n) & (j < n))
    b, c, d = a + n + 1, a + n + 2, a + 1
    F = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(V, F), is_raised[F].any(axis=1).astype(np.int64)


def test_boundaries_are_rounded_in_a_plane_and_stay_in_creases():
    """Of the corners 42 faces change where creases conduct like flat edges."""
    flat, labels = plateau(0.0)
    raised = plateau(0.08)[0]
    assert 0 < (smoothed(flat, labels, 0.2) != labels).sum() < 100  # at the corners
    assert (smoothed(raised, labels, 0.2) == labels).all()


def test_teeth_are_cut_and_a_face_between_two_others_stays():
    """Faces in a fan: the boundary of one with two edges at another label gets shorter."""
    pairs = np.array([[0, 1], [1, 2], [0, 2], [2, 3]])
    graph = FaceGraph(pairs, np.array([1.0, 1.0, 1.0, 5.0]), np.zeros(4), np.ones(4))
    assert _without_teeth(np.array([0, 1, 0, 0]), graph).tolist() == [0, 0, 0, 0]
    assert _without_teeth(np.array([1, 1, 0, 0]), graph).tolist() == [1, 1, 0, 0]
    pair = FaceGraph(np.array([[0, 1]]), np.ones(1), np.zeros(1), np.ones(1))
    assert len(set(_without_teeth(np.array([0, 1]), pair).tolist())) == 1  # one of two follows the other, not both


def test_a_concave_edge_conducts_less_and_a_convex_one_does_not():
    graph = FaceGraph(np.array([[0, 1], [1, 2]]), np.ones(2), np.array([0.5, -0.5]), np.full(2, 0.25))
    assert concavity(graph, np.full(3, 2.0)) == pytest.approx([0.5 * 2 / 0.25, 0])


def test_one_label_and_faces_without_area(halves):
    mesh, z, _ = halves
    labels = np.zeros(len(mesh.faces), dtype=np.int64)
    assert smoothed(mesh, labels, 1.0) is labels
    F = np.concatenate([mesh.faces, [[0, 0, mesh.faces[0, 1]], [5, 5, 5]]])
    halves_and_two = np.append((z > 0).astype(np.int64), [0, 1])
    found = smoothed(Mesh(mesh.vertices, F), halves_and_two, 1.0)
    assert np.isin(found, [0, 1]).all()
    assert (found[:-2] == smoothed(mesh, halves_and_two[:-2], 1.0)).all()
