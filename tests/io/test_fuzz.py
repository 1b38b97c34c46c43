"""Reading a file of any bytes returns a value or raises an error of lbskel, never another error."""

import contextlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lbskel import Mesh, Skeleton
from lbskel.errors import LbskelError, MissingDependency
from lbskel.io import (
    FORMATS,
    MESH_READERS,
    MESH_WRITERS,
    POINT_READERS,
    as_mesh,
    read_mesh,
    read_points,
    read_skeleton,
    write_mesh,
    write_skeleton,
)
from lbskel.preprocess import preprocess_mesh

PYRAMID = Mesh(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]],
    [[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
)
LOOP = Skeleton([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 2, 0]], [[0, 1], [1, 2], [0, 2], [2, 3]], [1, 2, 3, 4], [0, 3, 1])

# Words that break readers: other numbers, other types, ends of lines and of tags
WORDS = [b"-1", b"0", b"4294967295", b"99999999999999999999", b"nan", b"inf", b"1e999", b"\n", b" ", b"#", b",", b"x"]
WORDS += [b"\x00\x00\x00\x00", b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"{}", b"[]", b"null", b'"a"', b"<a>", b"\\\n"]

edits = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 12), st.one_of(st.sampled_from(WORDS), st.binary(max_size=4))),
    min_size=1,
    max_size=4,
)


def edited(data, changes):
    """The data with some ranges replaced; positions are fractions of its length."""
    for position, length, word in changes:
        start = int(position * len(data))
        data = data[:start] + word + data[start + length :]
    return data


def check_only_lbskel_errors(read, path, data):
    path.write_bytes(data)
    message = str(path)
    try:
        read(path)
    except MissingDependency:
        return  # the changes made a LAZ file of a LAS file, and laspy is not installed
    except LbskelError as error:
        message = str(error)
    assert message.startswith(str(path))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("files")


def cloud_files(folder):
    """The bytes of a valid file for each extension that only point clouds have."""
    points = np.array(PYRAMID.vertices)
    files = dict.fromkeys(("xyz", "txt", "csv"), b"0 0 0\n1 0 0\n1 1 0\n")
    files["pcd"] = b"FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nPOINTS 5\nDATA binary\n" + points.tobytes()
    np.save(folder / "points.npy", points)
    np.savez(folder / "points.npz", points)
    las = bytearray(227)
    las[:4], las[96], las[105], las[107] = b"LASF", 227, 12, 5
    files["las"] = bytes(las) + points.astype("<i4").tobytes()
    return files | {name: (folder / f"points.{name}").read_bytes() for name in ("npy", "npz")}


@pytest.fixture(scope="module")
def valid(folder):
    """The bytes of a valid file for each reader and extension."""
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("lxml")
    exported = trimesh.Trimesh(PYRAMID.vertices, PYRAMID.faces, process=False)
    files = {
        (read_mesh, "glb"): exported.export(file_type="glb"),
        (read_mesh, "gltf"): exported.export(file_type="gltf", embed_buffers=True)["model.gltf"],
        (read_mesh, "3mf"): trimesh.Scene(exported).export(file_type="3mf"),
        (
            read_mesh,
            "vtp",
        ): b'<VTKFile type="PolyData"><PolyData><Piece><Points><DataArray type="Float32" format="ascii">'
        b'0 0 0 1 0 0 0 1 0</DataArray></Points><Polys><DataArray type="Int32" Name="connectivity" format="binary">'
        b"DAAAAAAAAAABAAAAAgAAAA==</DataArray>"
        b'<DataArray type="Int32" Name="offsets" format="ascii">3</DataArray></Polys>'
        b"</Piece></PolyData></VTKFile>",
        (
            read_mesh,
            "vtk",
        ): b"# vtk DataFile Version 5.1\n\nBINARY\nDATASET POLYDATA\nPOINTS 3 char\n\0\0\0\1\0\0\0\1\0\n"
        b"POLYGONS 2 3\nOFFSETS char\n\0\3\nCONNECTIVITY char\n\0\1\2\n",
    }
    for name in MESH_WRITERS:
        write_mesh(folder / f"valid.{name}", PYRAMID)
        files[read_mesh, name] = (folder / f"valid.{name}").read_bytes()
    for name in ("ply", "off", "obj"):
        files[read_points, name] = files[read_mesh, name]
    files |= {(read_points, name): content for name, content in cloud_files(folder).items()}
    for name in FORMATS:
        write_skeleton(folder / f"valid-skeleton.{name}", LOOP)
        files[read_skeleton, name] = (folder / f"valid-skeleton.{name}").read_bytes()
    for (read, name), data in files.items():
        (folder / f"{read.__name__}.{name}").write_bytes(data)
        (folder / "read_skeleton_edges.csv").write_text("source,target\n0,1\n")
        assert read(folder / f"{read.__name__}.{name}") is not None
    return files


READERS = [(read_mesh, name) for name in MESH_READERS]
READERS += [(read_points, name) for name in POINT_READERS if name != "laz"]  # the bytes of LAZ are laspy's to check
READERS += [(read_skeleton, name) for name in FORMATS]


@pytest.mark.parametrize(("read", "name"), READERS)
@settings(max_examples=50)
@given(changes=edits)
def test_damaged_files(folder, valid, read, name, changes):
    check_only_lbskel_errors(read, folder / f"{read.__name__}.{name}", edited(valid[read, name], changes))


HEADS = {
    "obj": [b"v 0 0 0\n", b"f 1"],
    "off": [b"OFF\n"],
    "ply": [b"ply\nformat ascii 1.0\n", b"ply\nformat binary_little_endian 1.0\nelement vertex 1\n"],
    "stl": [b"solid\nfacet"],
    "glb": [b"glTF\x02\x00\x00\x00"],
    "gltf": [b'{"asset": {}, "meshes": '],
    "3mf": [b"PK\x03\x04"],
    "xyz": [b"0 0"],
    "txt": [b"0 0"],
    "npy": [b"\x93NUMPY\x01\x00"],
    "pcd": [b"FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nPOINTS 5\nDATA binary\n"],
    "las": [b"LASF"],
    "swc": [b"1 0 0 0 0 1 -1\n"],
    "json": [b'{"edges": [], "nodes": '],
    "npz": [b"PK\x03\x04"],
    "vtp": [b"<VTKFile><PolyData>"],
    "vtk": [b"# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\n"],
    "graphml": [b'<graphml xmlns="http://graphml.graphdrawing.org/xmlns">'],
    "csv": [b"id,x,y,z,radius\n"],
}


@pytest.mark.parametrize(("read", "name"), READERS)
@settings(max_examples=25)
@given(data=st.data())
def test_any_bytes(folder, read, name, data):
    head = data.draw(st.sampled_from([b"", *HEADS[name]]))
    tail = data.draw(st.one_of(st.binary(max_size=200), st.text('0123456789.- \n{}[]<>,:"ve', max_size=60)))
    content = head + (tail if isinstance(tail, bytes) else tail.encode())
    check_only_lbskel_errors(read, folder / f"{read.__name__}.{name}", content)


def test_every_reader_is_fuzzed(valid):
    assert set(valid) == set(READERS)


numbers = st.one_of(
    st.integers(-2, 9), st.floats(width=32), st.sampled_from([2**63, -(2**64), 1e308, None, "1", b"x", True])
)
rows = st.lists(st.one_of(st.lists(numbers, max_size=5), numbers), max_size=5)
points = st.one_of(rows, st.lists(st.lists(st.integers(-3, 3), min_size=3, max_size=3), min_size=3, max_size=6))
corners = st.one_of(rows, st.lists(st.lists(st.integers(-1, 6), min_size=3, max_size=4), min_size=1, max_size=6))


@settings(max_examples=100)
@given(vertices=points, faces=corners)
def test_as_mesh_of_anything(vertices, faces):
    """Any lists give a mesh that can be preprocessed, or an error of lbskel."""
    with contextlib.suppress(LbskelError):
        mesh = as_mesh((vertices, faces))
        assert np.isfinite(preprocess_mesh(mesh).mesh.vertices).all()
