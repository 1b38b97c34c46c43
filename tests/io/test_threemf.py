"""3MF: objects joined with their transforms, and clear errors for damaged archives and missing packages."""

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


def test_all_objects_are_joined_with_their_transforms(tmp_path):
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
        (archive_of("other.txt", b"3"), "has no model"),
        (archive_of("3D/3dmodel.model", b" " * 50_000_000), "more than the limit"),
        (archive_of("3D/3dmodel.model", b"<model><"), "cannot be read as .3mf"),
        (archive_of("3D/3dmodel.model", b"<model></model>"), "3mf"),
    ],
)
def test_damaged_archives_are_rejected(tmp_path, content, message):
    with pytest.raises(FormatError, match=message):
        reads(tmp_path, content)


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("lbskel.io.threemf.find_spec", lambda name: None if name == "lxml" else True)
    with pytest.raises(MissingDependency, match=r"lxml.*lbskel\[3mf\]"):
        reads(tmp_path, exported(RING))
