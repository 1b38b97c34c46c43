"""3MF: read where its packages are, and refused in a sentence where the file or the packages are not what is needed."""

import io
import zipfile

import numpy as np
import pytest

from lbskel.errors import FormatError, MissingDependency
from lbskel.io import read_mesh
from lbskel.shapes import torus

trimesh = pytest.importorskip("trimesh")
pytest.importorskip("lxml")

RING = torus(1.0, 0.3, 12, 8)


def exported(*meshes):
    return trimesh.Scene([trimesh.Trimesh(m.vertices, m.faces, process=False) for m in meshes]).export(file_type="3mf")


def reads(tmp_path, data):
    path = tmp_path / "mesh.3mf"
    path.write_bytes(data)
    return read_mesh(path)


def archive_of(name, content):
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    return data.getvalue()


def test_all_objects_become_one_mesh_where_they_are_placed(tmp_path):
    mesh = reads(tmp_path, exported(RING, RING.with_vertices(RING.vertices + [5, 0, 0])))
    assert (mesh.n_components, mesh.genus) == (2, 2)
    assert mesh.notes == ("2 meshes of the scene were joined into one",)
    both = np.concatenate([RING.vertices, RING.vertices + [5, 0, 0]])
    assert np.abs(mesh.vertices - both).max() < 1e-6  # written with eight digits


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (exported(RING)[:400], "truncated"),
        (b"no archive", "not a 3MF archive"),
        (archive_of("other.txt", b"3"), "holds no model"),
        (archive_of("3D/3dmodel.model", b" " * 50_000_000), "which no model does"),
        (archive_of("3D/3dmodel.model", b"<model><"), "not readable as .3mf"),
        (archive_of("3D/3dmodel.model", b"<model></model>"), "3mf"),
    ],
)
def test_what_is_no_3mf_is_told(tmp_path, content, message):
    with pytest.raises(FormatError, match=message):
        reads(tmp_path, content)


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("lbskel.io.threemf.find_spec", lambda name: None if name == "lxml" else True)
    with pytest.raises(MissingDependency, match=r"lxml.*lbskel\[3mf\]"):
        reads(tmp_path, exported(RING))
