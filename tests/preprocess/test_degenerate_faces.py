"""Degenerate faces: needles and caps are removed, topology and shape are kept."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lbskel import Mesh
from lbskel.preprocess.degenerate_faces import corner_angles, remove_degenerate
from lbskel.preprocess.holes import boundary_loops
from lbskel.preprocess.result import hausdorff_distance
from lbskel.shapes import cylinder, flat_grid, sphere, torus


def with_needles(mesh, count, rng):
    V = np.array(mesh.vertices)
    for i, j in mesh.edges[rng.choice(len(mesh.edges), count, replace=False)]:
        V[i] = V[j] + 1e-8 * (V[i] - V[j])
    return Mesh(V, mesh.faces)


def with_caps(mesh, count, rng):
    V, F = mesh.vertices.tolist(), mesh.faces.tolist()
    for face in rng.choice(len(F), count, replace=False):
        a, b, c = F[face]
        V.append(((mesh.vertices[a] + mesh.vertices[b]) / 2).tolist())
        F[face] = [len(V) - 1, b, c]
        F += [[a, len(V) - 1, c], [a, b, len(V) - 1]]
    return Mesh(V, F)


@pytest.mark.parametrize("spoil", [with_needles, with_caps])
def test_degenerate_faces_are_removed_without_changing_the_surface(spoil):
    mesh = torus(1.0, 0.4, 40, 24)
    given = spoil(mesh, 30, np.random.default_rng(2))
    assert np.degrees(corner_angles(given.vertices[given.faces])).max() > 179.5 or spoil is with_needles
    result = remove_degenerate(given)
    angles = np.degrees(corner_angles(result.mesh.vertices[result.mesh.faces]))
    assert angles.min() > 0.5
    assert angles.max() < 179.5
    assert result.mesh.genus == 1
    assert hausdorff_distance(given, result.mesh) < 1e-7  # needles are 1e-8 of an edge wide
    assert (result.vertex_map.indices >= 0).all()
    assert np.abs(result.mesh.vertices[result.vertex_map.indices] - given.vertices).max() < 1e-7


def test_collapsing_needles_at_a_boundary_opens_nothing():
    pipe = cylinder(0.3, 2.0, 12, 8)
    given = with_needles(pipe, 12, np.random.default_rng(3))
    result = remove_degenerate(given)
    assert sorted(map(len, boundary_loops(result.mesh)))[0] >= 3
    assert len(boundary_loops(result.mesh)) == 2
    assert result.mesh.euler_characteristic == pipe.euler_characteristic


def test_a_collapse_that_would_pinch_the_surface_is_rejected():
    """The waist of a three-sided hourglass is 1e-9 wide; collapsing it would leave two bodies."""
    turn = 2 * np.pi * np.arange(3) / 3
    waist = 1e-9 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    wide = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    V = np.concatenate([wide - [0, 0, 1], waist, wide + [0, 0, 1]])
    sides = [[k + i, k + (i + 1) % 3, k + 3 + i] for k in (0, 3) for i in range(3)]
    sides += [[k + (i + 1) % 3, k + 3 + (i + 1) % 3, k + 3 + i] for k in (0, 3) for i in range(3)]
    mesh = Mesh(V, [*sides, [0, 2, 1], [6, 7, 8]])
    assert mesh.genus == 0
    result = remove_degenerate(mesh)
    assert (result.mesh.genus, result.mesh.n_components) == (0, 1)
    assert hausdorff_distance(mesh, result.mesh) < 1e-8


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_a_surface_rounded_to_a_coarse_grid_keeps_its_topology(seed):
    rng = np.random.default_rng(seed)
    mesh = sphere(1)
    given = Mesh(np.round(mesh.vertices * rng.uniform(0.5, 3, 3)), mesh.faces)
    result = remove_degenerate(given, angle=5.0)
    assert result.mesh.genus == 0
    assert (result.vertex_map.indices >= 0).all()


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_faces_that_name_a_vertex_twice_do_no_harm(seed):
    rng = np.random.default_rng(seed)
    F = np.array(sphere(0).faces)
    F[rng.integers(0, len(F), 4), 0] = F[rng.integers(0, len(F), 4), 1]
    V = np.round(sphere(0).vertices * rng.uniform(0.5, 2, 3))
    result = remove_degenerate(Mesh(V, [*F, *F[:3, [0, 1, 1]]]), angle=10.0)
    assert np.isfinite(result.mesh.vertices).all()
    assert len(result.vertex_map.indices) == len(V)


def test_of_faces_that_name_a_vertex_twice_none_is_told_to_be_kept(tetrahedron):
    given = Mesh(tetrahedron.vertices, [*tetrahedron.faces, [0, 1, 1]])
    assert remove_degenerate(given).mesh is given
    assert remove_degenerate(given).notes == ()


def test_a_needle_at_a_boundary_is_collapsed_to_its_boundary_vertex():
    grid = flat_grid(6, 6)
    is_boundary = np.isin(np.arange(len(grid.vertices)), grid.edges[grid.faces_per_edge == 1])
    n_collapsed = 0
    for i, j in np.concatenate([grid.edges, grid.edges[:, ::-1]]).tolist():
        if is_boundary[i] and not is_boundary[j]:
            V = np.array(grid.vertices)
            V[j] = V[i] + 1e-9 * (V[j] - V[i])
            result = remove_degenerate(grid.with_vertices(V))
            n_collapsed += len(result.mesh.vertices) < len(V)
            targets = result.vertex_map.indices[is_boundary]
            assert np.array_equal(result.mesh.vertices[targets], V[is_boundary])
    assert n_collapsed > 10
