"""STL: corners merged at equal positions, text and binary, and errors that name the line."""

import struct

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.errors import FormatError, MeshError
from lbskel.io import read_mesh, write_mesh
from lbskel.io.stl import TRIANGLE, encode_stl

FACET = "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid"


def soup(mesh):
    return mesh.vertices[mesh.faces].astype(np.float32)


def test_corners_at_exactly_equal_positions_are_merged(read, tetrahedron):
    corners = soup(tetrahedron)
    corners[corners == 0] = np.where(np.arange((corners == 0).sum()) % 2, 0.0, -0.0)  # both zeros are one position
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in corners)
    binary = read("a.stl", b"solid but binary".ljust(80) + struct.pack("<I", 4) + rows)
    facets = "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {x} {y} {z}\n" for x, y, z in triangle)
        + " endloop\nendfacet\n"
        for triangle in corners.tolist()
    )
    text = read("b.stl", f"solid facet vertex\n{facets}endsolid\nSOLID\r\n{facets.upper()}ENDSOLID\n")
    order = [0, 2, 1, 3]  # of first appearance
    for mesh, times in ((binary, 1), (text, 2)):
        np.testing.assert_array_equal(mesh.vertices, tetrahedron.vertices[order])
        np.testing.assert_array_equal(mesh.faces, np.tile(np.argsort(order)[tetrahedron.faces], (times, 1)))
        assert mesh.notes == (f"{12 * times} corners were merged into 4 vertices at exactly equal positions",)
        assert mesh.is_closed_manifold == (times == 1)


def test_positions_that_differ_in_the_last_bit_are_not_merged(read):
    next_to_1 = np.nextafter(np.float32(1), np.float32(2))
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 1, 0], [next_to_1, 0, 0]], dtype="<f4")
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in corners.reshape(2, 9))
    mesh = read("a.stl", bytes(80) + struct.pack("<I", 2) + rows)
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])
    assert mesh.vertices[3, 0] == next_to_1


def test_round_trip_keeps_single_precision(tmp_path, precise_fan):
    write_mesh(tmp_path / "a.stl", precise_fan)
    np.testing.assert_array_equal(soup(read_mesh(tmp_path / "a.stl")), soup(precise_fan))


def test_written_normals_are_unit_vectors_outwards(tetrahedron):
    rows = np.frombuffer(encode_stl(tetrahedron), TRIANGLE, offset=84)
    expected = np.array([[0, 0, -1], [0, -1, 0], [-1, 0, 0], np.full(3, 3**-0.5)])
    np.testing.assert_allclose(rows["normal"], expected, rtol=1e-6)  # single precision


def test_coordinates_beyond_single_precision_are_rejected(tmp_path):
    with pytest.raises(FormatError, match=r"a\.stl: coordinates overflow the single precision of STL"):
        write_mesh(tmp_path / "a.stl", Mesh([[0, 0, 0], [1e39, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    assert not (tmp_path / "a.stl").exists()


def test_a_mesh_so_far_away_that_vertices_would_merge_is_rejected(tmp_path, tetrahedron):
    far = tetrahedron.with_vertices(tetrahedron.vertices + 1e8)  # where the step of single precision is 8
    with pytest.raises(FormatError, match=r"3 vertices would merge .* move the mesh to the origin, or write obj"):
        write_mesh(tmp_path / "a.stl", far)
    write_mesh(tmp_path / "b.stl", tetrahedron.with_vertices(tetrahedron.vertices + 1e4))
    # vertices as near to each other as this merge at the origin, too
    near = Mesh([*tetrahedron.vertices + 1e4, [1e4 + 1, 1e4 + 1e-9, 1e4]], [*tetrahedron.faces, [0, 1, 4]])
    write_mesh(tmp_path / "c.stl", near)


def test_degenerate_faces_are_written_with_a_zero_normal(tmp_path):
    write_mesh(tmp_path / "a.stl", Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 1]]))
    rows = np.frombuffer((tmp_path / "a.stl").read_bytes(), TRIANGLE, offset=84)
    np.testing.assert_array_equal(rows["normal"], np.zeros((1, 3)))
    assert read_mesh(tmp_path / "a.stl").faces.tolist() == [[0, 1, 1]]


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        ("Dear reader,\n", FormatError, "neither STL text, which begins with solid and has no zero bytes, nor binary"),
        ("solid\nendsolid\n", MeshError, "empty"),
        (FACET.removesuffix("endsolid"), FormatError, "ends at line 8 without endsolid"),
        (
            "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
            FormatError,
            "line 6: vertex expected",
        ),
        ("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", FormatError, "ends at line 4 without endsolid"),
        (
            FACET.replace("0 1 0", "0 1"),
            FormatError,
            "line 6: vertex and three coordinates expected, found 'vertex 0 1'",
        ),
        (FACET.replace("1 0 0", "1 0 nan"), MeshError, "vertices 1 have NaN"),
    ],
)
def test_errors_name_the_place(rejects, content, error, message):
    rejects("a.stl", content, error, message)


@pytest.mark.parametrize(
    ("change", "hint"),
    [(lambda data: data[:-20], r"was it cut off\?"), (lambda data: data + bytes(20) + b"x", "save it again")],
)
def test_a_binary_file_that_says_solid_and_has_another_length_is_no_text(rejects, tetrahedron, change, hint):
    data = b"solid".ljust(80) + encode_stl(tetrahedron)[80:]
    rejects("a.stl", change(data), FormatError, r"4 triangles in 284 bytes, but the file has \d+; " + hint)


def test_a_text_with_a_byte_order_mark_is_read_and_one_triangle_has_no_note(read):
    mesh = read("a.stl", b"\xef\xbb\xbf" + FACET.encode())
    assert (mesh.faces.tolist(), mesh.notes) == ([[0, 1, 2]], ())


def test_declared_gigabytes_are_not_allocated(rejects_without_allocating):
    rejects_without_allocating("a.stl", bytes(80) + struct.pack("<I", 60_000_000) + bytes(1000))


def test_a_binary_file_of_no_triangles_is_an_empty_mesh(rejects):
    rejects("a.stl", bytes(84), MeshError, "the mesh is empty")


def test_a_mesh_too_small_for_single_precision_is_refused(tetrahedron):
    for unit in (1e-44, 1e-50):
        with pytest.raises(FormatError, match="underflow the single precision of STL"):
            encode_stl(Mesh(unit * tetrahedron.vertices, tetrahedron.faces))
    assert encode_stl(Mesh(1e-29 * tetrahedron.vertices, tetrahedron.faces))
