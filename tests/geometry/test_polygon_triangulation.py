"""Triangulation of nonconvex polygons and boundary loops: triangles do not overlap, polygons keep their triangles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lbskel import as_mesh, read_mesh
from lbskel.geometry.polygon_triangulation import min_area_triangulation

# The letter L, counter-clockwise from its inner corner
LETTER = np.array([[1, 1, 0], [1, 2, 0], [0, 2, 0], [0, 0, 0], [2, 0, 0], [2, 1, 0]], dtype=float)
ARROW = np.array([[0, 0, 0], [2, 1, 0], [0, 2, 0], [0.5, 1, 0]])


def prism(outline):
    """Bottom, top and sides of a prism of height 1."""
    k = len(outline)
    i = np.arange(k)
    sides = np.stack([i, (i + 1) % k, k + (i + 1) % k, k + i], axis=1)
    return np.concatenate([outline, outline + [0, 0, 1]]), [list(i[::-1]), list(i + k), *sides.tolist()]


def star(k):
    """A star-shaped outline of k corners."""
    turn = 2 * np.pi * np.arange(k) / k
    reach = np.where(np.arange(k) % 2, 0.3, 1.0)
    return np.stack([reach * np.cos(turn), reach * np.sin(turn), 0 * turn], axis=1)


def outline_area(outline):
    """By the trapezoid formula, in the plane z = 0."""
    x, y, _ = outline.T
    return abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2


@pytest.mark.parametrize("turn", range(6))
@pytest.mark.parametrize("scale", [1.0, 1e-100, 1e70])
def test_triangles_do_not_overlap_whatever_corner_comes_first(turn, scale):
    mesh = as_mesh((scale * LETTER, [np.roll(np.arange(6), turn).tolist()]))
    assert mesh.area == pytest.approx(3 * scale**2)
    A, B, C = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    assert (np.cross(B - A, C - A)[:, 2] >= 0).all()  # zero for three collinear corners


@pytest.mark.parametrize("outline", [LETTER, ARROW, star(40), star(7)])
def test_a_prism_has_the_area_of_its_faces(outline):
    mesh = as_mesh(prism(outline))
    sides = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum()
    assert mesh.genus == 0
    assert mesh.area == pytest.approx(2 * outline_area(outline) + sides)
    assert abs(mesh.volume) == pytest.approx(outline_area(outline))


def test_the_polygon_of_every_triangle_is_kept(tmp_path):
    vertices, polygons = prism(LETTER)
    lines = [*(f"v {x} {y} {z}" for x, y, z in vertices), *("f " + " ".join(str(i + 1) for i in p) for p in polygons)]
    (tmp_path / "letter.obj").write_text("\n".join(lines))
    mesh = read_mesh(tmp_path / "letter.obj")
    assert np.array_equal(mesh.vertices, vertices)
    assert mesh.polygon_of_face.tolist() == [0] * 4 + [1] * 4 + np.repeat(range(2, 8), 2).tolist()
    for number, polygon in enumerate(polygons):
        assert set(mesh.faces[mesh.polygon_of_face == number].ravel()) == set(polygon)
    assert as_mesh((vertices, [[0, 1, 2], [3, 4, 5]])).polygon_of_face is None


def test_convex_polygons_stay_fans():
    turn = 2 * np.pi * np.arange(9) / 9
    mesh = as_mesh((np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1), [list(range(9))]))
    assert mesh.faces.tolist() == [[0, k, k + 1] for k in range(1, 8)]


@pytest.mark.parametrize("normal", [[0, 0, 1], [0, 0, -1], [1, 0, 0], [-3, 1, 2]])
def test_polygons_of_many_corners_are_triangulated_in_their_plane(normal):
    """A star of 2,000 corners, for which the tables of areas have four million entries, between two polygons."""
    turn, _ = Rotation.align_vectors([normal], [[0, 0, 1]])
    outline = turn.apply(star(2000))
    mesh = as_mesh((1e3 + np.concatenate([outline, outline[:3]]), [[0, 1, 2], list(range(2000)), [2000, 2001, 2002]]))
    assert mesh.notes == ("1 polygon was cut into triangles",)
    assert mesh.face_areas[1:-1].sum() == pytest.approx(outline_area(star(2000)))
    assert (mesh.face_normals[1:-1] @ normal > 0).all()
    assert np.array_equal(mesh.polygon_of_face, np.repeat([0, 1, 2], [1, 1998, 1]))
    assert set(mesh.faces[1:-1].ravel()) == set(range(2000))


def test_a_long_outline_that_crosses_itself_is_told():
    x = np.linspace(0, 4 * np.pi, 200)
    wave = np.stack([x, np.sin(x), 0 * x], axis=1)
    outline = np.concatenate([wave, wave[::-1] * [1, -1, 1]])
    mesh = as_mesh((outline, [list(range(400))]))
    assert len(mesh.faces) == 398
    [_, note] = mesh.notes
    assert note == (
        "1 polygon was cut into triangles that overlap, the first of them polygon 0: its outline of 400 corners "
        "crosses itself"
    )


def test_a_polygon_whose_chords_are_all_forbidden_has_no_triangulation():
    taken = np.ones((1, 5, 5), dtype=bool)
    assert np.isinf(min_area_triangulation(star(5)[None], taken)[1]).all()


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60)
def test_any_polygons_keep_their_corners_and_counts(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 10))
    vertices = np.round(rng.normal(size=(n, 3)), int(rng.integers(0, 3)))
    polygons = [rng.integers(0, n, size=rng.integers(3, 9)).tolist() for _ in range(3)]
    mesh = as_mesh((vertices, polygons))
    numbers = np.repeat(np.arange(3), [len(polygon) - 2 for polygon in polygons])
    assert len(mesh.faces) == len(numbers)
    for number, polygon in enumerate(polygons):
        assert set(mesh.faces[numbers == number].ravel()) == set(polygon)
