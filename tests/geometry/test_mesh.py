"""Meshes and point clouds: validation, conversion from other types, connectivity and measures."""

import copy
import pickle
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from helpers import joined, moved
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lbskel import LbskelError, Mesh, MeshError, PointCloud
from lbskel.errors import were
from lbskel.geometry.arrays import read_only
from lbskel.geometry.mesh import as_mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.shapes import capsule, chain_of_tori, cylinder, flat_grid, sphere, torus

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
HALVES = [[0, 1, 2], [0, 2, 3]]


def mobius_strip(n=6):
    """A strip of n squares with half a twist: vertex 2 i is on one edge, 2 i + 1 on the other."""
    turn = np.repeat(np.arange(n) * 2 * np.pi / n, 2)
    side = np.tile([-0.3, 0.3], n)
    wide = 1 + side * np.cos(turn / 2)
    V = np.stack([wide * np.cos(turn), wide * np.sin(turn), side * np.sin(turn / 2)], axis=1)
    faces = []
    for i in range(n):
        a, b = 2 * i, 2 * i + 1
        c, d = (2 * i + 2, 2 * i + 3) if i < n - 1 else (1, 0)
        faces += [[a, c, b], [b, c, d]]
    return Mesh(V, faces)


def klein_bottle(n=8, m=8):
    """A closed non-orientable surface: a grid glued straight in one direction and mirrored in the other."""

    def at(i, j):
        return (i % n) * m + (j % m if i < n else -j % m)

    faces = []
    for i in range(n):
        for j in range(m):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            faces += [[a, b, c], [a, c, d]]
    return Mesh(np.random.default_rng(0).normal(size=(n * m, 3)), faces)


# --- Validation


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        ([[0, 0], [1, 0], [0, 1]], r"shape \(n, 3\), not \(3, 2\); for a planar shape add a column of zeros"),
        ([0, 1, 2], r"shape \(n, 3\), not \(3,\)"),
        (np.zeros((3, 4)), r"shape \(n, 3\), not \(3, 4\)"),
        ([], "empty: there are no vertices"),
        (np.empty((0, 3)), "empty: there are no vertices"),
        ([["a", "b", "c"]] * 3, "array of numbers"),
        ([[0, 0, 0], [1, 0], [0, 1, 0]], "array of numbers"),
        (None, "vertices"),
    ],
)
def test_vertices_of_a_wrong_shape_are_rejected(vertices, message):
    with pytest.raises(MeshError, match=message):
        Mesh(vertices, [[0, 1, 2]])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_coordinates_that_are_not_finite_are_rejected(value):
    V = np.zeros((20, 3))
    V[[3, 7], [0, 2]] = value
    with pytest.raises(MeshError, match=r"vertices 3, 7 have NaN or infinite"):
        Mesh(V, [[0, 1, 2]])
    V[10:] = value
    with pytest.raises(MeshError, match=r"vertices 3, 7, 10, 11, 12 and 7 more have NaN or infinite"):
        Mesh(V, [[0, 1, 2]])


@pytest.mark.parametrize("index", [-1, 4, 2**40, -(2**40)])
@pytest.mark.parametrize("corner", [0, 1, 2])
def test_an_index_out_of_range_is_rejected(index, corner):
    F = np.array([[0, 1, 2]] * 9)
    F[6, corner] = index
    with pytest.raises(MeshError, match=r"faces 6 use a vertex index outside 0\.\.3; .*1-based"):
        Mesh(SQUARE, F)


def test_all_faces_out_of_range_are_counted():
    with pytest.raises(MeshError, match=r"faces 0, 1, 2, 3, 4 and 4 more use a vertex index outside 0\.\.3"):
        Mesh(SQUARE, [[1, 2, 4]] * 9)


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([], "it has no faces; a set of points is a PointCloud"),
        (np.empty((0, 3), dtype=int), "it has no faces"),
        ([0, 1, 2], r"shape \(m, 3\), not \(3,\)"),
        ([[0, 1, 2, 3]], r"shape \(m, 3\), not \(1, 4\); as_mesh\(\) triangulates quads"),
        ([[0, 1, 2.5]], "whole numbers, not float64"),
        ([[0, 1, np.nan]], "whole numbers, not float64"),
        ([[True, False, True]], "whole numbers, not bool"),
        ([["0", "1", "2"]], "whole numbers, not <U1"),
    ],
)
def test_faces_of_a_wrong_shape_or_type_are_rejected(faces, message):
    with pytest.raises(MeshError, match=message):
        Mesh(SQUARE, faces)


def test_the_error_is_a_value_error_of_lbskel():
    with pytest.raises(LbskelError) as caught:
        Mesh([], [])
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize(
    ("points", "message"), [([], "no points"), ([[0, 0]], "points must have shape"), ([[0, np.nan, 0]], "points 0")]
)
def test_points_are_validated(points, message):
    with pytest.raises(MeshError, match=message):
        PointCloud(points)


# --- Stored arrays


def test_arrays_are_copied_to_contiguous_doubles_and_integers():
    V = np.asfortranarray(np.array(SQUARE, dtype=np.float32))
    F = np.asfortranarray(np.array(HALVES, dtype=np.uint16))
    mesh = Mesh(V, F)
    assert (mesh.vertices.dtype, mesh.faces.dtype) == (np.float64, np.int64)
    assert mesh.vertices.flags.c_contiguous
    assert mesh.faces.flags.c_contiguous
    V[:], F[:] = 9, 0
    assert mesh.vertices.tolist() == SQUARE
    assert mesh.faces.tolist() == HALVES


def test_floats_with_integer_values_are_indices():
    assert Mesh(SQUARE, np.array(HALVES, dtype=float)).faces.tolist() == HALVES


def test_the_smallest_mesh_and_a_point_cloud():
    assert Mesh(SQUARE[:3], [[0, 1, 2]]).area == 0.5
    assert len(PointCloud(SQUARE).points) == 4


@pytest.mark.parametrize(
    "name",
    [
        "vertices",
        "faces",
        "edges",
        "edge_of_half_edge",
        "half_edges",
        "faces_per_edge",
        "face_areas",
        "component_of_vertex",
    ],
)
def test_arrays_are_read_only(name, tetrahedron):
    array = getattr(tetrahedron, name)
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 0
    with pytest.raises(AttributeError):
        setattr(tetrahedron, name, array)


def test_points_are_read_only():
    with pytest.raises(ValueError, match="read-only"):
        PointCloud(SQUARE).points[0] = 0
    assert not read_only(np.zeros(3)).flags.writeable


def test_repr(tetrahedron):
    assert repr(tetrahedron) == "Mesh(4 vertices, 4 faces)"
    assert repr(Mesh(np.eye(3), [[0, 1, 2]])) == "Mesh(3 vertices, 1 face)"
    assert repr(Mesh(np.zeros((1234, 3)), [[0, 1, 2]])) == "Mesh(1,234 vertices, 1 face)"
    assert repr(PointCloud(np.zeros((1, 3)))) == "PointCloud(1 point)"
    assert repr(PointCloud(SQUARE)) == "PointCloud(4 points)"


# --- Conversion: stand-ins have the attributes of the classes of other packages


def same(data, faces=HALVES, notes=()):
    mesh = as_mesh(data)
    assert mesh.vertices.tolist() == SQUARE
    assert mesh.faces.tolist() == faces
    assert mesh.notes == notes
    return mesh


@pytest.mark.parametrize("kind", [tuple, list])
def test_pairs_are_converted(kind):
    same(kind([SQUARE, HALVES]))
    same(kind([np.array(SQUARE), np.array(HALVES)]))
    same(kind([np.array(SQUARE), np.array(HALVES, dtype=np.uint32)]))


def test_a_mesh_is_returned_unchanged(tetrahedron):
    assert as_mesh(tetrahedron) is tetrahedron


def test_a_trimesh_is_converted():
    same(trimesh.Trimesh(SQUARE, HALVES, process=False))
    same(SimpleNamespace(vertices=SQUARE, faces=HALVES))


def test_a_pyvista_mesh_is_converted():
    flat = np.array([3, 0, 1, 2, 3, 0, 2, 3])
    same(SimpleNamespace(points=np.array(SQUARE), faces=flat))
    same(
        SimpleNamespace(points=np.array(SQUARE), faces=np.array([4, 0, 1, 2, 3])),
        notes=("1 polygon was cut into triangles",),
    )
    same(SimpleNamespace(points=np.array(SQUARE), faces=np.array(HALVES)))


@pytest.mark.parametrize("flat", [[3, 0, 1, 2, -1, 0, 2], [0, 3, 0, 1, 2], [2, 0, 1], [3, 0, 1]])
def test_an_invalid_pyvista_list_is_rejected(flat):
    with pytest.raises(MeshError, match=r"number of corners|fewer than three corners"):
        as_mesh(SimpleNamespace(points=np.array(SQUARE), faces=np.array(flat)))


def test_a_meshio_mesh_is_converted():
    triangle, quad = np.array([[0, 1, 2]]), np.array([[0, 1, 2, 3]])
    points = np.array(SQUARE)
    same(SimpleNamespace(points=points, cells_dict={"line": triangle[:, :2], "triangle": np.array(HALVES)}))
    note = ("1 polygon was cut into triangles",)
    same(SimpleNamespace(points=points, cells_dict={"quad": quad}), notes=note)
    both = SimpleNamespace(points=points, cells_dict={"quad": quad, "triangle": triangle})
    same(both, faces=[*HALVES, [0, 1, 2]], notes=note)
    with pytest.raises(MeshError, match="it has no faces"):
        as_mesh(SimpleNamespace(points=points, cells_dict={"tetra": quad}))


@pytest.mark.parametrize("data", [5, None, b"square", object(), (SQUARE,), (SQUARE, HALVES, HALVES)])
def test_other_objects_are_rejected(data):
    with pytest.raises(MeshError, match=r"cannot take a mesh from \w+; give \(vertices, faces\), a path"):
        as_mesh(data)


def test_quads_become_two_triangles_each():
    mesh = same((SQUARE, [[0, 1, 2, 3]]), notes=("1 polygon was cut into triangles",))
    assert mesh.area == 1.0


def test_mixed_polygons_become_fans_in_their_order():
    angle = 2 * np.pi * np.arange(6) / 6
    V = np.stack([np.cos(angle), np.sin(angle), np.zeros(6)], axis=1)
    mesh = as_mesh((V, [[0, 1, 2], [0, 2, 3, 4, 5]]))
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
    assert mesh.area == pytest.approx(1.5 * np.sqrt(3))
    assert mesh.notes == ("1 polygon was cut into triangles",)


def test_padding_is_not_a_corner():
    mesh = as_mesh((SQUARE, np.array([[0, 1, 2, -1], [0, 2, 3, -1]])))
    assert mesh.faces.tolist() == HALVES
    assert mesh.notes == ()
    mesh = as_mesh((SQUARE, [[0, 1, 2, 3, -1], [0, 2, 3, -1, -1]]))
    assert mesh.faces.tolist() == [*HALVES, [0, 2, 3]]


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([[0, 1, 2, -1], [0, 1, -1, -1]], "faces 1 have fewer than three corners; leave them out"),
        ([[0, 1, 2, -1], [0, -1, -1, -1], [-1, -1, -1, -1]], "faces 1, 2 have fewer than three corners"),
        ([[0, 1], [1, 2]], "faces 0, 1 have fewer than three corners"),
        ([[0, 1, 2], [0, 1], [0, 1, 2, 3]], "faces 1 have fewer than three corners"),
        ([[0, 1, 2], []], "faces 1 have fewer than three corners"),
        ([[0, -1, 2, 3]], "vertex index outside"),
        ([[0, 1, -1]], "vertex index outside"),
        ([[0, 1, 2, 7]], "vertex index outside"),
        ([0, 1, 2], "each face must be a sequence"),
        ([0, [1, 2, 3]], "each face must be a sequence"),
        (5, "sequence of index sequences, not int"),
        (None, "sequence of index sequences, not NoneType"),
        ([["a", "b", "c"]], "whole numbers"),
        ([[0, 1, 2.5, 3]], "whole numbers"),
        ([], "it has no faces"),
        (np.empty((0, 4), dtype=int), "it has no faces"),
    ],
)
def test_invalid_polygons_are_rejected(faces, message):
    with pytest.raises(MeshError, match=message):
        as_mesh((SQUARE, faces))


@given(st.lists(st.integers(3, 9), min_size=1, max_size=20))
def test_fans_keep_area_and_corners(sizes):
    """Regular polygons side by side: every corner is used, and the area follows from the formula."""
    polygons, points, area, first = [], [], 0.0, 0
    for place, n in enumerate(sizes):
        angle = 2 * np.pi * np.arange(n) / n
        points.append(np.stack([np.cos(angle) + 3 * place, np.sin(angle), 0 * angle], axis=1))
        polygons.append(list(range(first, first + n)))
        area += n / 2 * np.sin(2 * np.pi / n)
        first += n
    mesh = as_mesh((np.concatenate(points), polygons))
    assert len(mesh.faces) == sum(n - 2 for n in sizes)
    assert np.unique(mesh.faces).tolist() == list(range(first))
    assert mesh.area == pytest.approx(area)
    cut = sum(n > 3 for n in sizes)
    assert mesh.notes == ((f"{were(cut, 'polygon')} cut into triangles",) if cut else ())


# --- Connectivity


def test_half_edges_lie_opposite_their_corner(ring):
    m = len(ring.faces)
    for k in (0, 5, m, m + 7, 2 * m + 3):
        start, end = ring.half_edges[k]
        corner, face = k // m, ring.faces[k % m]
        assert [face[corner], start, end] == np.roll(face, -corner).tolist()


@pytest.mark.parametrize("make", [lambda: flat_grid(5, 4), mobius_strip, klein_bottle, lambda: sphere(2)])
def test_edges_are_the_pairs_in_the_faces(make):
    mesh = make()
    pairs = {tuple(sorted(pair)) for face in mesh.faces.tolist() for pair in (face[:2], face[1:], face[::2])}
    assert [tuple(edge) for edge in mesh.edges.tolist()] == sorted(pairs)
    assert (np.sort(mesh.half_edges, axis=1) == mesh.edges[mesh.edge_of_half_edge]).all()
    counts = [sum(set(edge) <= set(face) for face in mesh.faces.tolist()) for edge in mesh.edges.tolist()]
    assert mesh.faces_per_edge.tolist() == counts


def test_edge_lengths_are_those_of_a_corner(tetrahedron):
    assert tetrahedron.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
    assert tetrahedron.edge_lengths.tolist() == [1, 1, 1, *[np.sqrt(2)] * 3]
    assert (tetrahedron.with_vertices(2 * tetrahedron.vertices).edge_lengths == 2 * tetrahedron.edge_lengths).all()


def test_components_are_numbered_with_those_without_a_face_last(tetrahedron, ring):
    lone = np.array([[9.0, 9, 9]])
    mesh = joined(tetrahedron, moved(ring, 5))
    mesh = Mesh(np.concatenate([lone, mesh.vertices, lone + 1]), mesh.faces + 1)
    assert mesh.n_components == 2
    label = mesh.component_of_vertex
    assert np.unique(label[1:5]).tolist() == [0]
    assert np.unique(label[5:-1]).tolist() == [1]
    assert sorted(label[[0, -1]]) == [2, 3]
    assert mesh.euler_characteristic == 2
    assert mesh.genus == 1


@pytest.mark.parametrize("genus", [0, 1, 2, 4])
def test_genus(genus):
    mesh = chain_of_tori(genus, step=0.15)
    assert mesh.is_closed_manifold
    assert mesh.genus == genus
    assert mesh.euler_characteristic == 2 - 2 * genus


def test_genus_is_summed_over_components(ring, tetrahedron):
    mesh = joined(ring, moved(ring, 3), moved(tetrahedron, 6))
    assert (mesh.n_components, mesh.genus) == (3, 2)


@pytest.mark.parametrize(
    ("make", "edge_manifold", "closed", "closed_manifold"),
    [
        (lambda: sphere(1), True, True, True),
        (lambda: torus(1.0, 0.3, 12, 6), True, True, True),
        (lambda: cylinder(0.5, 2.0, 8, 4), True, False, False),
        (lambda: flat_grid(3, 3), True, False, False),
        (mobius_strip, True, False, False),
        (klein_bottle, True, True, False),
    ],
)
def test_manifold_properties_of_surfaces(make, edge_manifold, closed, closed_manifold):
    mesh = make()
    assert (mesh.is_edge_manifold, mesh.is_closed, mesh.is_closed_manifold) == (
        edge_manifold,
        closed,
        closed_manifold,
    )
    assert (mesh.genus is None) == (not closed_manifold)


def test_euler_characteristics():
    assert mobius_strip().euler_characteristic == 0
    assert klein_bottle().euler_characteristic == 0
    assert cylinder(0.5, 2.0, 8, 4).euler_characteristic == 0
    assert flat_grid(4, 3).euler_characteristic == 1


def test_a_pinched_vertex_is_not_manifold(tetrahedron):
    V = np.concatenate([tetrahedron.vertices, -tetrahedron.vertices[1:]])
    F = np.concatenate([tetrahedron.faces, np.array([0, 4, 5, 6])[tetrahedron.faces[:, ::-1]]])
    mesh = Mesh(V, F)
    assert (mesh.is_edge_manifold, mesh.is_closed) == (True, True)
    assert not mesh.is_closed_manifold
    assert mesh.genus is None


def test_a_reversed_face_is_not_consistently_oriented(ring):
    F = np.array(ring.faces)
    F[17] = F[17, ::-1]
    mesh = Mesh(ring.vertices, F)
    assert (mesh.is_edge_manifold, mesh.is_closed, mesh.is_closed_manifold) == (True, True, False)


def test_a_surface_inside_out_is_a_manifold(ring):
    mesh = Mesh(ring.vertices, ring.faces[:, ::-1])
    assert mesh.genus == 1
    assert mesh.volume == pytest.approx(-ring.volume)


def test_three_faces_at_an_edge_are_not_manifold():
    mesh = Mesh(np.random.default_rng(0).normal(size=(5, 3)), [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    assert mesh.faces_per_edge.max() == 3
    assert not mesh.is_edge_manifold


@pytest.mark.parametrize("face", [[0, 1, 1], [2, 2, 2], [3, 0, 3]])
def test_a_face_that_names_a_vertex_twice_is_not_manifold(face, tetrahedron):
    assert not Mesh(tetrahedron.vertices, [*tetrahedron.faces.tolist(), face]).is_edge_manifold


def test_a_duplicate_face_is_not_manifold(tetrahedron):
    mesh = Mesh(tetrahedron.vertices, [*tetrahedron.faces.tolist(), tetrahedron.faces[0].tolist()])
    assert not mesh.is_edge_manifold


def test_many_faces_do_not_overflow():
    """46,341 squared exceeds 32 bits, and pairs of vertices are numbered by products."""
    mesh = torus(1.0, 0.4, 260, 180)
    n = 260 * 180
    assert n > 46341
    assert (len(mesh.vertices), len(mesh.faces), len(mesh.edges)) == (n, 2 * n, 3 * n)
    assert (np.diff(mesh.edges[:, 0]) >= 0).all()
    assert (mesh.edges >= 0).all()
    assert (mesh.faces_per_edge == 2).all()
    assert (mesh.n_components, mesh.is_closed_manifold, mesh.genus) == (1, True, 1)


@given(st.permutations(range(16)), st.integers(0, 2**32 - 1))
def test_numbering_does_not_matter(order, seed):
    mesh = flat_grid(4, 4)
    order = np.array(order)
    rng = np.random.default_rng(seed)
    F = np.argsort(order)[rng.permutation(mesh.faces)]
    other = Mesh(mesh.vertices[order], np.array([np.roll(face, rng.integers(3)) for face in F]))
    assert other.area == pytest.approx(mesh.area)
    assert other.euler_characteristic == mesh.euler_characteristic
    assert np.bincount(other.faces_per_edge).tolist() == np.bincount(mesh.faces_per_edge).tolist()
    assert (other.is_closed, other.is_edge_manifold) == (False, True)


# --- Measures


def test_measures_of_the_corner_of_a_cube(tetrahedron):
    assert tetrahedron.face_areas == pytest.approx([0.5, 0.5, 0.5, np.sqrt(3) / 2])
    assert tetrahedron.volume == pytest.approx(1 / 6)
    assert tetrahedron.diagonal == pytest.approx(np.sqrt(3))


@pytest.mark.parametrize("shift", [0.0, 1e6])
def test_measures_of_a_sphere(shift):
    mesh = sphere(4)
    mesh = mesh.with_vertices(mesh.vertices + shift)
    # of 2,562 vertices; the error of an inscribed polyhedron is of second order in its edges of 0.07
    assert mesh.area == pytest.approx(4 * np.pi, rel=0.07**2)
    assert mesh.volume == pytest.approx(4 * np.pi / 3, rel=0.07**2)
    assert mesh.n_components == 1


def test_diagonal_is_that_of_the_bounding_box():
    mesh = capsule(3.0, 0.4, 8)
    x, y, z = np.ptp(mesh.vertices, axis=0)
    assert mesh.diagonal == pytest.approx(np.sqrt(x * x + y * y + z * z))


@pytest.mark.parametrize("size", [1e16, 3.4e38, 1e308])
def test_measures_ignore_unused_vertices_far_away(size):
    mesh = capsule(3.0, 0.4, 6)
    unused = Mesh([*mesh.vertices, [size, 0, -size]], mesh.faces)
    assert unused.face_areas == pytest.approx(mesh.face_areas, rel=1e-12)
    assert unused.volume == pytest.approx(mesh.volume, rel=1e-12)
    assert unused.centroid == pytest.approx(mesh.centroid, abs=1e-12)
    assert unused.diameter_bound == pytest.approx(mesh.diameter_bound, rel=1e-12)


def test_diagonal_ignores_unused_vertices(tetrahedron):
    mesh = Mesh([*tetrahedron.vertices.tolist(), [100, 100, 100]], tetrahedron.faces)
    assert mesh.diagonal == pytest.approx(np.sqrt(3))


@pytest.mark.parametrize("scale", [1e-200, 1e-6, 1.0, 1e6, 1e200])
def test_diagonal_neither_overflows_nor_vanishes(tetrahedron, scale):
    assert tetrahedron.with_vertices(scale * tetrahedron.vertices).diagonal == pytest.approx(np.sqrt(3) * scale)


def test_areas_of_vertices_are_a_third_of_their_faces():
    """Two triangles that share an edge, and a vertex without a face."""
    mesh = Mesh([[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, 1, 1 / 2**0.5], [9, 9, 9]], [[0, 1, 2], [2, 1, 3]])
    small = mesh.face_areas[1]
    assert mesh.vertex_areas == pytest.approx([2 / 3, (2 + small) / 3, (2 + small) / 3, small / 3, 0])


def test_the_longest_edge_at_each_vertex():
    mesh = Mesh([[0, 0, 0], [3, 0, 0], [0, 4, 0], [0, 0, 1], [9, 9, 9]], [[0, 1, 2], [0, 2, 3]])
    assert mesh.longest_edges == pytest.approx([4, 5, 5, 17**0.5, 0])


def test_areas_of_degenerate_faces_are_zero():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2], [0, 1, 1], [2, 2, 2]])
    assert mesh.face_areas.tolist() == [0, 0, 0]


# --- Other positions


def test_cached_connectivity_is_kept(two_rings):
    source = Mesh(two_rings.vertices, two_rings.faces, ("a note",))
    assert source.genus == 2
    moved = source.with_vertices(2 * source.vertices)
    assert moved.edges is source.edges
    assert moved.component_of_vertex is source.component_of_vertex
    assert moved.notes == ("a note",)


def test_measures_are_computed_anew(tetrahedron):
    assert tetrahedron.face_areas.sum() == tetrahedron.area  # known from here on
    moved = tetrahedron.with_vertices(2 * tetrahedron.vertices)
    assert moved.area == pytest.approx(4 * tetrahedron.area)
    assert moved.volume == pytest.approx(8 * tetrahedron.volume)
    assert moved.diagonal == pytest.approx(2 * tetrahedron.diagonal)


def test_another_number_of_vertices_discards_the_cache(tetrahedron):
    assert len(tetrahedron.component_of_vertex) == 4
    moved = tetrahedron.with_vertices([*tetrahedron.vertices.tolist(), [5, 5, 5]])
    assert len(moved.component_of_vertex) == 5
    with pytest.raises(MeshError, match="vertex index outside"):
        tetrahedron.with_vertices(tetrahedron.vertices[:3])


def test_positions_are_checked(tetrahedron):
    with pytest.raises(MeshError, match="vertices 2 have NaN"):
        tetrahedron.with_vertices(np.where(np.arange(4)[:, None] == 2, np.nan, tetrahedron.vertices))


def test_face_normals_of_the_corner_of_a_cube(tetrahedron):
    expected = np.array([[0, 0, -1], [0, -1, 0], [-1, 0, 0], np.ones(3) / np.sqrt(3)])
    assert tetrahedron.face_normals == pytest.approx(expected)
    with pytest.raises(ValueError, match="read-only"):
        tetrahedron.face_normals[0] = 0
    scaled = tetrahedron.with_vertices(-2 * tetrahedron.vertices)
    assert scaled.face_normals == pytest.approx(expected)  # a point reflection keeps (B - A) x (C - A)
    degenerate = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    assert degenerate.face_normals.tolist() == [[0, 0, 0]]


def test_volume_is_positive_where_faces_are_oriented_outwards(ring):
    assert ring.volume > 0
    assert Mesh(ring.vertices, ring.faces[:, ::-1]).volume < 0


def test_centroid_is_weighted_by_area():
    """Two squares of one area, at heights 0 and 2, one of them of 81 vertices: the centroid lies halfway."""
    grid = flat_grid(9, 9)
    fine = grid.with_vertices(grid.vertices - grid.centroid)
    x, y, _ = np.abs(fine.vertices).max(axis=0)
    coarse = Mesh([[-x, -y, 2], [x, -y, 2], [x, y, 2], [-x, y, 2]], HALVES)
    assert fine.area == pytest.approx(coarse.area)
    both = joined(fine, coarse)
    assert both.centroid == pytest.approx([0, 0, 1])
    assert both.vertices[:, 2].mean() < 0.2


@pytest.mark.parametrize("exponent", [-320, 280, 480])  # units of 5e-97, 2e84 and 3e144: squares of areas overflow
def test_measures_are_exact_in_every_unit_that_holds_them(exponent):
    mesh = torus(1.0, 0.3, 12, 8)
    mesh = mesh.with_vertices(mesh.vertices + 0.5)
    there = mesh.with_vertices(np.ldexp(mesh.vertices, exponent))
    assert np.array_equal(there.face_areas, np.ldexp(mesh.face_areas, 2 * exponent))
    assert there.area == np.ldexp(mesh.area, 2 * exponent)
    assert np.array_equal(there.centroid, np.ldexp(mesh.centroid, exponent))
    assert there.diameter_bound == np.ldexp(mesh.diameter_bound, exponent)
    with np.errstate(over="ignore"):
        assert there.volume == np.ldexp(mesh.volume, 3 * exponent)  # infinite from 1e103 on


def test_diameter_bound_is_twice_the_largest_distance_from_the_centroid():
    mesh = sphere(3)
    assert mesh.diameter_bound == pytest.approx(2.0)
    assert mesh.with_vertices(3 * mesh.vertices + 5).diameter_bound == pytest.approx(6.0)
    unused = Mesh([*mesh.vertices, [9, 9, 9]], mesh.faces)
    assert unused.diameter_bound == pytest.approx(2.0)
    rod = capsule(3.0, 0.4, 24)
    assert rod.diameter_bound == pytest.approx(np.ptp(rod.vertices[:, 2]))


@given(st.integers(0, 2**32 - 1))
def test_the_diameter_bound_does_not_change_under_rotation(seed):
    mesh = capsule(3.0, 0.4, 8)
    rotated = mesh.with_vertices(Rotation.random(random_state=seed).apply(np.array(mesh.vertices)))
    assert rotated.diameter_bound == pytest.approx(mesh.diameter_bound)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda shape: pickle.loads(pickle.dumps(shape))])
def test_copies_are_constant_and_measure_anew(copied):
    """What a mesh caches, such as search trees, stays with it; those of libigl cannot be pickled."""
    whole = torus(1.0, 0.3)
    open_mesh = Mesh(whole.vertices, whole.faces[1:], notes=("cut",))
    Surface(open_mesh).contains(np.zeros((1, 3)))
    again = copied(open_mesh)
    assert (again.notes, again.area) == (("cut",), open_mesh.area)
    assert np.array_equal(again.vertices, open_mesh.vertices)
    assert not again.vertices.flags.writeable
    assert "_searches" not in vars(copied(open_mesh))
    cloud = copied(PointCloud(whole.vertices))
    assert not cloud.points.flags.writeable


def test_masked_coordinates_and_faces_are_refused():
    masked = np.ma.masked_equal([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-9999, 0, 0]], -9999)
    with pytest.raises(MeshError, match="vertices have masked entries"):
        Mesh(masked, [[0, 1, 2]])
    with pytest.raises(MeshError, match="faces have masked entries"):
        Mesh(np.eye(3), np.ma.masked_equal([[0, 1, 2], [0, 1, -1]], -1))
    assert len(PointCloud(masked[:3]).points) == 3  # nothing masked


def test_numbers_too_large_for_a_float_are_refused():
    with pytest.raises(MeshError, match="vertices must be an array of numbers"):
        Mesh([[10**400, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
