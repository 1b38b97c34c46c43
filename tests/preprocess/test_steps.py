"""The steps of preprocessing: what each mends, what it must leave alone, and where every vertex goes."""

import numpy as np
import pytest
from helpers import joined, moved
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lbskel import Mesh, UnknownChoice
from lbskel.geometry.shape_diameter import local_thickness
from lbskel.preprocess import STEPS
from lbskel.preprocess.cleaning import keep_components, merge_close, remove_duplicates
from lbskel.preprocess.degenerate_faces import corner_angles, remove_degenerate
from lbskel.preprocess.holes import boundary_loops, close_holes
from lbskel.preprocess.orientation import fix_orientation, relative_vector_area, split_nonmanifold
from lbskel.preprocess.remeshing import smooth_noise
from lbskel.preprocess.result import distance_between
from lbskel.preprocess.subdivision import coarse_share, refine
from lbskel.preprocess.vertex_umbrellas import fans_of
from lbskel.shapes import capsule, cylinder, flat_grid, sphere, torus

CUBE = Mesh(
    [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ],
)


def welded(mesh):
    """The mesh with vertices at the same place made one, whatever comes of it."""
    V, place = np.unique(mesh.vertices, axis=0, return_inverse=True)
    return Mesh(V, place.reshape(-1)[mesh.faces])


def without(mesh, faces):
    return Mesh(mesh.vertices, np.delete(mesh.faces, faces, axis=0))


def turned(mesh, faces):
    F = np.array(mesh.faces)
    F[faces] = F[faces][:, ::-1]
    return Mesh(mesh.vertices, F)


@pytest.mark.parametrize("name", sorted(set(STEPS) - {"smooth_noise", "simplify", "remesh_isotropic"}))
def test_what_is_sound_is_given_back(name, ring, rod):
    fine = torus(1.0, 0.4, 40, 24)
    result = STEPS[name](fine)
    assert result.mesh is fine
    assert result.vertex_map.tolist() == list(range(len(fine.vertices)))
    assert result.notes == ()
    [record] = result.report["steps"]
    assert record["step"] == name
    assert record["before"] == record["after"]


# --- merging


def test_close_vertices_become_one(ring):
    soup = ring.vertices[ring.faces].reshape(-1, 3)
    soup = soup + 1e-9 * np.random.default_rng(0).standard_normal(soup.shape)
    given = Mesh(soup, np.arange(len(soup)).reshape(-1, 3))
    result = merge_close(given)
    assert result.mesh.genus == 1
    assert np.array_equal(result.vertex_map.indices[given.faces], result.mesh.faces)
    # a vertex moves no further than the noise on both, which has a deviation of 1e-9
    assert np.abs(result.mesh.vertices[result.vertex_map.indices] - given.vertices).max() < 2e-8
    assert merge_close(given, tolerance=0.0).mesh is given


def test_a_tolerance_that_swallows_the_mesh_is_refused(ring):
    with pytest.raises(UnknownChoice, match="smaller"):
        merge_close(without(sphere(4), [0]), tolerance=0.5)
    with pytest.raises(UnknownChoice, match="negative"):
        merge_close(ring, tolerance=-1.0)


def test_ten_thousand_vertices_at_one_place_are_merged_at_once():
    """Pairs of them would be fifty million."""
    corner = np.zeros((10_000, 3))
    V = np.concatenate([corner, [[1, 0, 0], [0, 1, 0], [0, 0, 1]]])
    result = merge_close(Mesh(V, [[0, 10_000, 10_001], [5, 10_001, 10_002], [9, 10_002, 10_000]]))
    assert len(result.mesh.vertices) == 4


def test_crumbs_are_left_out(ring, tetrahedron):
    small = Mesh(0.05 * tetrahedron.vertices + [3, 0, 0], tetrahedron.faces)
    result = keep_components(joined(ring, small, moved(ring, 5)))
    assert (result.mesh.n_components, result.mesh.genus) == (2, 2)
    assert (result.vertex_map.indices[len(ring.vertices) : len(ring.vertices) + 4] == -1).all()
    assert keep_components(joined(ring, small), smallest=0.0).mesh.n_components == 2


def test_labels_and_fields_come_back(ring):
    soup = Mesh(ring.vertices[ring.faces].reshape(-1, 3), np.arange(3 * len(ring.faces)).reshape(-1, 3))
    more = Mesh([*soup.vertices, [9, 9, 9]], soup.faces)
    result = merge_close(more).compose(remove_duplicates)
    back = result.pull_back(np.array(result.mesh.vertices))
    assert np.array_equal(back[:-1], soup.vertices)
    assert np.isnan(back[-1]).all()
    labels = result.pull_back(np.arange(len(result.mesh.vertices)))
    assert np.array_equal(labels, result.vertex_map.indices)


# --- orientation


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0])
def test_faces_are_turned_outwards(ring, share):
    chosen = np.flatnonzero(np.random.default_rng(1).random(len(ring.faces)) < share)
    result = fix_orientation(turned(ring, chosen))
    assert result.mesh.is_closed_manifold
    assert result.mesh.volume == pytest.approx(ring.volume)


def test_the_wall_of_a_hollow_faces_inwards_and_a_neighbor_outwards():
    ball = sphere(2)
    hollow = joined(ball, Mesh(0.5 * ball.vertices, ball.faces[:, ::-1]))
    assert fix_orientation(hollow).mesh is hollow
    beside = joined(ball, Mesh(ball.vertices + [3, 0, 0], ball.faces[:, ::-1]))
    assert fix_orientation(beside).mesh.volume == pytest.approx(2 * ball.volume)


def test_a_sheet_keeps_the_side_of_most_of_its_faces():
    grid = flat_grid()
    result = fix_orientation(turned(grid, [0, 5]))
    assert np.array_equal(np.sort(result.mesh.faces, axis=1), np.sort(grid.faces, axis=1))
    normal = np.cross(
        *(result.mesh.vertices[result.mesh.faces[:, k]] - result.mesh.vertices[result.mesh.faces[:, 0]] for k in (1, 2))
    )
    assert (normal[:, 2] > 0).all()


def test_openness():
    assert relative_vector_area(sphere(2)) == pytest.approx(0.0, abs=1e-12)
    assert relative_vector_area(flat_grid()) == pytest.approx(1.0)
    assert relative_vector_area(cylinder(0.3, 2.0, 16, 8)) == pytest.approx(0.0, abs=1e-12)
    ball = sphere(4)
    half = without(ball, np.flatnonzero(ball.vertices[ball.faces].mean(axis=1)[:, 2] < 0))
    assert relative_vector_area(half) == pytest.approx(0.5, abs=0.02)  # the rim is a row of triangles, about 0.1 wide


# --- taking apart


@pytest.mark.parametrize("step", [[1, 1, 0], [1, 1, 1]], ids=["edge", "vertex"])
def test_bodies_that_touch_come_apart(step):
    touching = welded(joined(CUBE, Mesh(CUBE.vertices + step, CUBE.faces)))
    assert touching.n_components == 1
    assert not touching.is_closed_manifold
    result = split_nonmanifold(touching)
    assert (result.mesh.is_closed_manifold, result.mesh.n_components) == (True, 2)
    assert result.mesh.volume == pytest.approx(2.0)
    assert np.array_equal(result.mesh.vertices[result.vertex_map.indices], touching.vertices)


def test_a_fin_stays_a_sheet_of_its_own():
    mesh = Mesh([*CUBE.vertices, [2, 2, 0.5]], [*CUBE.faces, [6, 7, 8]])
    assert (mesh.faces_per_edge > 2).sum() == 1
    result = split_nonmanifold(mesh)
    assert result.mesh.is_edge_manifold
    assert result.mesh.area == pytest.approx(mesh.area)


@given(st.integers(0, 2**32 - 1))
@example(364590)  # a fan that passes an edge twice
@settings(max_examples=40, deadline=None)
def test_any_triangles_can_be_taken_apart(seed):
    rng = np.random.default_rng(seed)
    given = remove_duplicates(Mesh(rng.normal(size=(9, 3)), rng.integers(0, 9, size=(14, 3)))).mesh
    result = split_nonmanifold(given)
    F = result.mesh.faces
    if (np.sort(F, axis=1)[:, :2] != np.sort(F, axis=1)[:, 1:]).all():
        assert result.mesh.is_edge_manifold
    assert np.array_equal(result.mesh.vertices[F], given.vertices[given.faces])
    assert (fans_of(result.mesh).of_corner == F).all()


# --- holes


def test_the_ends_of_a_pipe_are_closed():
    pipe = cylinder(0.3, 2.0, 24, 8)
    assert sorted(map(len, boundary_loops(pipe))) == [24, 24]
    result = close_holes(pipe, largest=1.0)
    assert result.mesh.genus == 0
    # a prism of 24 sides
    assert result.mesh.volume == pytest.approx(2.0 * 0.3**2 * 12 * np.sin(2 * np.pi / 24))
    assert np.array_equal(result.mesh.vertices[: len(pipe.vertices)], pipe.vertices)
    assert close_holes(pipe, largest=0.5).mesh is pipe


@pytest.mark.parametrize("seed", range(4))
def test_however_many_faces_are_missing_the_surface_is_closed(seed):
    ball = sphere(3)
    rng = np.random.default_rng(seed)
    given = without(ball, np.flatnonzero(rng.random(len(ball.faces)) < 0.12))
    result = close_holes(given, largest=2.0)
    assert result.mesh.is_closed
    assert result.mesh.is_edge_manifold
    assert distance_between(ball, result.mesh) < 0.1  # holes are two or three edges of 0.15 wide, of a diagonal of 3.5


def test_a_rim_too_long_to_triangulate_gets_a_vertex_in_its_middle():
    pipe = cylinder(0.3, 2.0, 320, 3)
    result = close_holes(pipe, largest=1.0)
    assert (result.mesh.genus, len(result.mesh.vertices)) == (0, len(pipe.vertices) + 2)


def test_the_rim_of_a_sheet_is_no_hole():
    grid = flat_grid()
    assert close_holes(grid, largest=9.0).mesh is grid
    hollow = without(grid, [len(grid.faces) // 2])
    assert len(close_holes(hollow, largest=9.0).mesh.faces) == len(grid.faces)


def test_a_seam_of_orientation_is_no_hole(ring):
    given = turned(ring, range(40))
    assert boundary_loops(given) == []


# --- degenerate faces


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
def test_degenerate_faces_go_and_the_surface_stays(spoil):
    mesh = torus(1.0, 0.4, 40, 24)
    given = spoil(mesh, 30, np.random.default_rng(2))
    assert np.degrees(corner_angles(given.vertices[given.faces])).max() > 179.5 or spoil is with_needles
    result = remove_degenerate(given)
    angles = np.degrees(corner_angles(result.mesh.vertices[result.mesh.faces]))
    assert angles.min() > 0.5
    assert angles.max() < 179.5
    assert result.mesh.genus == 1
    assert distance_between(given, result.mesh) < 1e-7  # needles are 1e-8 of an edge wide
    assert (result.vertex_map.indices >= 0).all()
    assert np.abs(result.mesh.vertices[result.vertex_map.indices] - given.vertices).max() < 1e-7


def test_nothing_opens_where_a_needle_lies_at_a_rim():
    pipe = cylinder(0.3, 2.0, 12, 8)
    given = with_needles(pipe, 12, np.random.default_rng(3))
    result = remove_degenerate(given)
    assert sorted(map(len, boundary_loops(result.mesh)))[0] >= 3
    assert len(boundary_loops(result.mesh)) == 2
    assert result.mesh.euler_characteristic == pipe.euler_characteristic


def test_a_collapse_that_would_pinch_is_not_done():
    """The waist of an hourglass of three sides, 1e-9 wide: without it there are two bodies."""
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
    assert distance_between(mesh, result.mesh) < 1e-8


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_vertices_on_a_coarse_grid_keep_their_topology(seed):
    rng = np.random.default_rng(seed)
    mesh = sphere(1)
    given = Mesh(np.round(mesh.vertices * rng.uniform(0.5, 3, 3)), mesh.faces)
    result = remove_degenerate(given, angle=5.0)
    assert result.mesh.genus == 0
    assert (result.vertex_map.indices >= 0).all()


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_faces_that_name_a_vertex_twice_are_in_nobodys_way(seed):
    rng = np.random.default_rng(seed)
    F = np.array(sphere(0).faces)
    F[rng.integers(0, len(F), 4), 0] = F[rng.integers(0, len(F), 4), 1]
    V = np.round(sphere(0).vertices * rng.uniform(0.5, 2, 3))
    result = remove_degenerate(Mesh(V, [*F, *F[:3, [0, 1, 1]]]), angle=10.0)
    assert np.isfinite(result.mesh.vertices).all()
    assert len(result.vertex_map.indices) == len(V)


# --- refinement and smoothing


def test_thickness_is_that_of_a_ball_and_of_a_slab():
    ball = sphere(3)
    every = np.arange(len(ball.faces))
    # straight through is 2; a slanted ray ends on the sphere a quarter nearer
    assert local_thickness(ball, every) == pytest.approx(np.full(len(every), 1.5), rel=0.02)
    assert np.isinf(local_thickness(flat_grid(), np.array([0]))).all()


def test_long_edges_are_split_and_the_surface_stays():
    mesh = torus(1.0, 0.1, 20, 5)
    assert coarse_share(mesh, 0.8) == 1.0
    result = refine(mesh, edge=0.5)
    assert coarse_share(result.mesh, 0.6) < 0.02
    assert result.mesh.genus == 1
    assert np.array_equal(result.mesh.vertices[: len(mesh.vertices)], mesh.vertices)
    assert result.vertex_map.tolist() == list(range(len(mesh.vertices)))
    assert result.mesh.area == pytest.approx(mesh.area)
    assert result.mesh.volume == pytest.approx(mesh.volume)


def test_what_is_flat_is_hardly_refined(rod):
    flat = rod.with_vertices(rod.vertices * [1, 1, 1e-3])
    # but for its rim, which looks along the plane; by its height there would be a hundred times the faces
    assert len(refine(flat).mesh.faces) < 4 * len(flat.faces)


def test_noise_is_smoothed_and_the_shape_kept():
    mesh = capsule(3.0, 0.4, 24)
    rng = np.random.default_rng(0)
    noisy = mesh.with_vertices(mesh.vertices + 0.008 * rng.standard_normal(mesh.vertices.shape))
    smooth = smooth_noise(noisy).mesh
    before, after = (np.linalg.norm(other.vertices - mesh.vertices, axis=1) for other in (noisy, smooth))
    assert np.sqrt(np.mean(after**2)) < 0.75 * np.sqrt(np.mean(before**2))  # 0.66; what runs along the surface stays
    assert smooth.volume == pytest.approx(mesh.volume, rel=0.02)
    pipe = cylinder(0.3, 2.0, 12, 8)
    is_rim = np.isin(np.arange(len(pipe.vertices)), pipe.edges[pipe.faces_per_edge == 1])
    assert np.array_equal(smooth_noise(pipe).mesh.vertices[is_rim], pipe.vertices[is_rim])


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("close_holes", {"largest": 0.0}),
        ("keep_components", {"smallest": 2.0}),
        ("remove_degenerate", {"angle": 90.0}),
        ("refine", {"edge": -1.0}),
        ("smooth_noise", {"iterations": -1}),
        ("smooth_noise", {"iterations": 10**12}),
        ("simplify", {}),
        ("simplify", {"target_faces": 9, "error": 0.1}),
        ("simplify", {"error": 0.0}),
        ("remesh_isotropic", {"edge": 0.0}),
        ("remesh_isotropic", {"edge": 1e-6}),
        ("remesh_isotropic", {"of": "height"}),
    ],
)
def test_numbers_out_of_range_are_refused(name, options, ring):
    with pytest.raises(UnknownChoice):
        STEPS[name](ring, **options)
