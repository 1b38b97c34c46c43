"""Reading and writing meshes: paths, extensions, other programs, and what as_mesh takes."""

import os
import subprocess
import sys

import numpy as np
import pytest

import lbskel.geometry.mesh
from lbskel import Mesh
from lbskel.errors import FormatError, MeshError
from lbskel.io import MESH_READERS, MESH_WRITERS, as_mesh, read_mesh, write_mesh

trimesh = pytest.importorskip("trimesh")


def soup(mesh):
    return mesh.vertices[mesh.faces].astype(np.float32)


@pytest.fixture
def exported(tetrahedron):
    """The tetrahedron as trimesh writes it in a format."""
    return trimesh.Trimesh(tetrahedron.vertices, tetrahedron.faces, process=False).export


# Meshes


@pytest.mark.parametrize("name", [name for name in MESH_WRITERS if name != "stl"])
def test_round_trip_to_the_last_bit(tmp_path, precise_fan, name):
    write_mesh(tmp_path / f"a.{name}", precise_fan)
    back = read_mesh(tmp_path / f"a.{name}")
    np.testing.assert_array_equal(back.vertices, precise_fan.vertices)
    np.testing.assert_array_equal(back.faces, precise_fan.faces)
    assert back.notes == ()


@pytest.mark.parametrize("name", MESH_WRITERS)
def test_trimesh_reads_a_written_mesh(tmp_path, tetrahedron, name):
    write_mesh(tmp_path / f"a.{name}", tetrahedron)
    other = trimesh.load(tmp_path / f"a.{name}", process=False)
    np.testing.assert_array_equal(soup(other), soup(tetrahedron))
    # unit normals in single precision
    np.testing.assert_allclose(np.linalg.norm(other.face_normals, axis=1), 1, rtol=1e-6)


@pytest.mark.parametrize("name", ["obj", "off", "ply", "stl"])
def test_a_mesh_written_by_trimesh_is_read(read, exported, tetrahedron, name):
    np.testing.assert_array_equal(soup(read(f"a.{name}", exported(file_type=name))), soup(tetrahedron))


def test_a_file_that_exists_is_replaced_only_with_force(tmp_path, tetrahedron, precise_fan):
    write_mesh(tmp_path / "a.off", tetrahedron)
    with pytest.raises(FormatError, match="exists already"):
        write_mesh(tmp_path / "a.off", precise_fan)
    assert len(read_mesh(tmp_path / "a.off").vertices) == 4
    write_mesh(tmp_path / "a.off", precise_fan, force=True)
    assert len(read_mesh(tmp_path / "a.off").vertices) == 9


def test_a_format_that_is_only_read_is_not_written(tmp_path, tetrahedron):
    with pytest.raises(FormatError, match="unknown extension 'glb'; known for meshes: obj, off, ply, stl"):
        write_mesh(tmp_path / "a.glb", tetrahedron)


@pytest.mark.parametrize("name", ["ply", "stl", "glb"])
def test_a_binary_file_truncated_anywhere_is_rejected(read, exported, name):
    whole = exported(file_type=name)
    for length in range(len(whole)):
        with pytest.raises(FormatError):
            read(f"a.{name}", whole[:length])


def test_paths_that_are_not_files_of_meshes(tmp_path):
    with pytest.raises(
        FormatError, match=r"a\.xml: unknown extension 'xml'; known for meshes: obj, off, ply, stl, glb, gltf"
    ):
        read_mesh(tmp_path / "a.xml")
    with pytest.raises(FormatError, match="no extension; known for meshes"):
        read_mesh("mesh")
    with pytest.raises(FormatError, match="is a folder"):
        read_mesh(tmp_path)
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(FormatError, match="is a folder, not a file"):
        read_mesh(tmp_path / "folder.obj")
    for name in ("missing.obj", "MISSING.OBJ", "folder.obj/a.stl"):
        with pytest.raises(FormatError, match=r"no such file|cannot be read"):
            read_mesh(tmp_path / name)
    with pytest.raises(FormatError, match=r"cannot be read"):
        read_mesh("a\0.obj")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes on this system")
def test_a_pipe_does_not_block(tmp_path):
    os.mkfifo(tmp_path / "a.obj")
    with pytest.raises(FormatError, match="not a regular file"):
        read_mesh(tmp_path / "a.obj")


def test_extensions_in_capitals(tmp_path, tetrahedron):
    write_mesh(tmp_path / "A.OBJ", tetrahedron)
    assert len(read_mesh(tmp_path / "A.OBJ").vertices) == 4


def test_every_written_format_is_read():
    assert set(MESH_WRITERS) <= set(MESH_READERS)


# as_mesh


def test_as_mesh_takes_paths_arrays_and_meshes(tmp_path, tetrahedron):
    path = tmp_path / "a.off"
    write_mesh(path, tetrahedron)
    for data in (str(path), path, tetrahedron, (tetrahedron.vertices, tetrahedron.faces)):
        mesh = as_mesh(data)
        assert isinstance(mesh, Mesh)
        np.testing.assert_array_equal(mesh.faces, tetrahedron.faces)
    assert as_mesh(tetrahedron) is tetrahedron
    with pytest.raises(FormatError, match="no such file"):
        as_mesh(tmp_path / "b.off")
    with pytest.raises(FormatError, match="square: no extension; known for meshes"):
        as_mesh("square")
    with pytest.raises(MeshError):
        as_mesh(17)


def test_paths_are_registered_with_the_function_of_geometry(tmp_path, tetrahedron):
    assert lbskel.geometry.mesh.as_mesh is as_mesh

    class PathLike:
        def __fspath__(self):
            return str(tmp_path / "a.off")

    write_mesh(PathLike(), tetrahedron)
    np.testing.assert_array_equal(lbskel.geometry.mesh.as_mesh(PathLike()).faces, tetrahedron.faces)


def test_write_mesh_takes_whatever_as_mesh_takes(tmp_path, tetrahedron):
    pair, copy = tmp_path / "pair.off", tmp_path / "copy.obj"
    write_mesh(pair, (tetrahedron.vertices, tetrahedron.faces.tolist()))
    write_mesh(copy, pair)
    np.testing.assert_array_equal(read_mesh(copy).faces, tetrahedron.faces)
    with pytest.raises(MeshError):
        write_mesh(tmp_path / "none.off", 17)


def test_importing_loads_no_optional_package():
    code = "import sys, lbskel.io; print([n for n in ('trimesh', 'networkx', 'vtkmodules') if n in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
