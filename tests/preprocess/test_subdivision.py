"""Refinement: long edges are split, the surface is unchanged."""

import numpy as np
import pytest
from helpers import joined, moved

from lbskel import Mesh
from lbskel.preprocess import subdivision
from lbskel.preprocess.subdivision import coarse_faces, refine
from lbskel.shapes import torus, tube


def test_long_edges_are_split_without_changing_the_surface():
    mesh = torus(1.0, 0.1, 20, 5)
    assert coarse_faces(mesh, 0.8).all()
    result = refine(mesh, max_edge_length=0.5)
    assert coarse_faces(result.mesh, 0.6).mean() < 0.02
    assert result.mesh.genus == 1
    assert np.array_equal(result.mesh.vertices[: len(mesh.vertices)], mesh.vertices)
    assert result.vertex_map.indices.tolist() == list(range(len(mesh.vertices)))
    assert result.mesh.area == pytest.approx(mesh.area)
    assert result.mesh.volume == pytest.approx(mesh.volume)


def test_where_two_edges_are_split_the_shorter_diagonal_may_be_taken():
    """Wedges along an axis: of the trapezium between both midpoints and the base, only one diagonal is short."""
    V = np.array([[0.0, 0, 0], [4, 0, 0], [5, 1, 0]])
    for turn in range(3):
        mesh = Mesh(np.roll(V, turn, axis=0), [[0, 1, 2]])
        is_split = mesh.edge_lengths > 2
        fine = Mesh(*subdivision._split_edges(mesh, is_split, shorter=True)[:2])
        assert sorted(fine.edge_lengths) == pytest.approx(
            sorted([2, 2, np.sqrt(26) / 2, np.sqrt(26) / 2, np.sqrt(2), np.sqrt(2) / 2, np.sqrt(2.5)])
        )
        assert fine.volume == 0
        assert np.allclose(fine.face_normals, mesh.face_normals)
        mirrored = Mesh(mesh.vertices, [[1, 0, 2]])
        assert sorted(
            Mesh(*subdivision._split_edges(mirrored, is_split, shorter=True)[:2]).edge_lengths
        ) == pytest.approx(sorted(fine.edge_lengths))


def test_within_a_number_of_faces_the_shorter_diagonals_make_fewer(monkeypatch):
    """A rough ring: 1,984 faces in place of 2,124."""
    ring = torus(1.0, 0.05, 40, 6)
    mesh = ring.with_vertices(ring.vertices + 0.01 * np.random.default_rng(0).normal(size=ring.vertices.shape))
    monkeypatch.setattr(subdivision, "MAX_FACES", 4_000)
    fewer = refine(mesh, max_edge_length=0.2).mesh
    split = subdivision._split_edges
    monkeypatch.setattr(subdivision, "_split_edges", lambda *given, shorter: split(*given, shorter=not shorter))
    assert len(fewer.faces) < len(refine(mesh, max_edge_length=0.2).mesh.faces)


def test_a_flat_part_has_the_radius_of_its_triangles(rod):
    """Its edges are nine times as long as they may be: they are divided in 16, and needles, as all here, in 3^4."""
    flat = rod.with_vertices(rod.vertices * [1, 1, 1e-3])
    assert len(flat.faces) < len(refine(flat).mesh.faces) <= 3**4 * len(flat.faces)


def relative_lengths(mesh, radius_at):
    """Longest edge of each face over the local radius at its center."""
    P = mesh.vertices[mesh.faces]
    return np.linalg.norm(P - np.roll(P, 1, axis=1), axis=2).max(axis=1) / radius_at(P.mean(axis=1))


def test_beyond_the_number_of_faces_all_parts_are_coarser_by_one_factor(monkeypatch):
    """Two rings, one of a quarter of the other's radius."""
    mesh = joined(torus(1.0, 0.2, 12, 6), moved(torus(1.0, 0.05, 48, 6), 3.0))
    monkeypatch.setattr(subdivision, "MAX_FACES", 100_000)
    fine = refine(mesh, max_edge_length=0.2).mesh
    monkeypatch.setattr(subdivision, "MAX_FACES", 12_000)
    limited = refine(mesh, max_edge_length=0.2).mesh
    assert len(mesh.faces) < len(limited.faces) < len(fine.faces)
    # the prediction takes edges as halved until they are short, and each face by itself
    assert 4_000 < len(limited.faces) < 18_000
    lengths = relative_lengths(limited, lambda centers: np.where(centers[:, 0] < 1.5, 0.2, 0.05))
    is_thick = limited.vertices[limited.faces][:, 0, 0] < 1.5
    # halving leaves edges between half the limit and the limit
    assert 0.5 < lengths[is_thick].max() / lengths[~is_thick].max() < 2


def test_the_faces_of_needles_are_predicted():
    """Of 100 sides; 50 long and 1 thick: in five rounds each of the 200 needles is divided into three."""
    pipe = tube([[0, 0, 0], [0, 0, 50]], 1.0, sides=100)
    assert subdivision._predicted_faces(subdivision._length_ratios(pipe, 0.8)) == 200 + 200 * 3**5
    fine = refine(pipe, max_edge_length=0.8).mesh
    assert len(fine.faces) == 200 + 200 * 3**4  # one round fewer, for no more than the bound
    assert fine.edge_lengths.max() == pytest.approx(50 / 2**4, rel=0.01)
    thick = tube([[0, 0, 0], [0, 0, 50]], 1.0, sides=16)
    assert refine(thick, max_edge_length=0.8).mesh.edge_lengths.max() < 1.6


def test_no_round_follows_once_there_are_enough_faces(monkeypatch):
    mesh = torus(1.0, 0.1, 20, 5)
    monkeypatch.setattr(subdivision, "MAX_FACES", 1000)
    monkeypatch.setattr(subdivision, "_predicted_faces", lambda ratios: 0.0)
    assert 1000 <= len(refine(mesh, max_edge_length=0.01).mesh.faces) <= 4000


def test_a_mesh_of_more_faces_gets_twice_as_many(monkeypatch):
    z = np.cumsum(np.linspace(0.1, 1.0, 20))
    mesh = tube(np.stack([0 * z, 0 * z, z], axis=1), 0.2, sides=8)
    monkeypatch.setattr(subdivision, "MAX_FACES", len(mesh.faces) // 2)
    assert len(mesh.faces) < len(refine(mesh).mesh.faces) <= 2 * len(mesh.faces)  # without a bound, 4,176


def test_faces_with_a_long_edge_are_coarse():
    """A tube with three quarters of its faces in its finer half."""
    z = np.concatenate([np.arange(0, 2, 0.5), np.linspace(2, 4, 13)])
    mesh = tube(np.stack([0 * z, 0 * z, z], axis=1), 0.2, sides=8)
    is_long = np.ptp(mesh.vertices[mesh.faces][:, :, 2], axis=1) > 0.4
    assert 0.2 < is_long.mean() < 0.3
    # edges of 0.5 and 0.17 along it on a tube 0.4 thick; diagonals 0.52 and 0.23
    assert np.array_equal(coarse_faces(mesh, 0.8), is_long)
