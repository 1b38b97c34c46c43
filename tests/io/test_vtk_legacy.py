"""Legacy files of VTK: those that vtk writes, old and new, as text and binary, and broken ones."""

import numpy as np
import pytest
from helpers import soup_faces, vtk_faces, vtk_polydata

from lbskel import MeshError, read_mesh
from lbskel.errors import FormatError
from lbskel.io.vtk_legacy import read_vtk

vtk = pytest.importorskip("vtk")

HEAD = "# vtk DataFile Version 3.0\na title\nASCII\nDATASET POLYDATA\n"
POINTS = "POINTS 3 float\n0 0 0 1 0 0\n0 1 0\n"
NEW = HEAD.replace("3.0", "5.1") + POINTS


@pytest.mark.parametrize("kind", ["polygons", "strips", "both"])
@pytest.mark.parametrize("version", [42, 51])
@pytest.mark.parametrize("is_binary", [False, True])
def test_what_vtk_writes_is_read(tmp_path, kind, version, is_binary):
    given = vtk_polydata(kind)
    writer = vtk.vtkPolyDataWriter()
    writer.SetInputData(given)
    writer.SetFileName(str(tmp_path / "a.vtk"))
    writer.SetFileVersion(version)
    writer.SetFileTypeToBinary() if is_binary else writer.SetFileTypeToASCII()
    assert writer.Write() == 1
    points, faces = vtk_faces(given)
    mesh = read_mesh(tmp_path / "a.vtk")
    # text has six digits
    np.testing.assert_allclose(mesh.vertices, points, rtol=0 if is_binary else 1e-5, atol=0 if is_binary else 1e-15)
    assert soup_faces(read_vtk(tmp_path / "a.vtk")) == faces
    assert len(mesh.faces) == sum(len(face) - 2 for face in faces)


def test_lines_between_sections_case_and_data_do_not_matter(read):
    mesh = read(
        "a.vtk",
        HEAD.lower().replace("datafile version", "DataFile Version")
        + "\nfield FieldData 2\nTime 1 1 double\n0.5\nMETADATA\nINFORMATION 0\n\nids 1 2 int\n7 8\n\n"
        + POINTS
        + "METADATA\nCOMPONENT_NAMES\nx\n\nLINES 1 3\n2 0 1\n\nPOLYGONS 1 4\n3 0 1 2\nPOINT_DATA 3\nx\n",
    )
    assert (mesh.vertices.tolist(), mesh.faces.tolist()) == ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        ("", FormatError, "the file is empty|not a legacy VTK file"),
        ("# vtk DataFile\n", FormatError, "not a legacy VTK file"),
        (
            HEAD.replace("POLYDATA", "STRUCTURED_GRID"),
            FormatError,
            "a VTK data set of STRUCTURED_GRID, not of PolyData",
        ),
        (HEAD.replace("DATASET", "FIELD"), FormatError, "a VTK data set of POLYDATA|unknown type"),
        (HEAD, FormatError, "there are no polygons"),
        (HEAD + POINTS + "LINES 1 3\n2 0 1\n", FormatError, "there are no polygons"),
        (HEAD + POINTS + "FACES 1 4\n3 0 1 2\n", FormatError, "unknown section 'FACES'"),
        (HEAD + "POINTS x float\n", FormatError, "a section begins with 'x float', where its size is expected"),
        (HEAD + "POINTS 3 float\n0 0 0\n", FormatError, "declares 9 numbers, and fewer follow"),
        (HEAD + "POINTS 999999999999 float\n0 0 0\n", FormatError, "is the file truncated"),
        (HEAD + "POINTS 1 float\n0 0 zero\n", FormatError, "not a number: .*zero"),
        (HEAD + "POINTS 1 quad\n0 0 0\n", FormatError, "unknown type of numbers 'quad'"),
        (HEAD + POINTS + "POLYGONS 2 4\n3 0 1 2\n", FormatError, "declares 2 cells of 4 numbers"),
        (HEAD + POINTS + "POLYGONS 1 4\n9 0 1 2\n", FormatError, "declares 1 cell of 4 numbers"),
        (HEAD + POINTS + "POLYGONS 2 4\n-3 0 1 2\n", FormatError, "declares 2 cells of 4 numbers"),
        (HEAD + POINTS + "POLYGONS 1 4\n3 0 1 7\n", MeshError, "faces 0 .* use vertices that do not exist"),
        (HEAD + "FIELD f 1\na 1 3 string\none\n", FormatError, "declares 3 texts, and fewer follow"),
        (
            HEAD.replace("ASCII", "BINARY") + "FIELD f 1\na 1 9 string\none\n",
            FormatError,
            "declares 9 texts, and fewer follow",
        ),
        (HEAD + "FIELD f 1\nname 1 1\n0\n", FormatError, "an array of a field begins with 'name 1 1'"),
        (NEW + "POLYGONS 2 3\n3 0 1 2\n", FormatError, "OFFSETS and a type expected, found '3 0 1 2'"),
        (
            NEW + "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 2\nCONNECTIVITY vtktypeint64\n0 1 2\n",
            FormatError,
            "the offsets of the cells do not match",
        ),
        (
            NEW + "POLYGONS 3 3\nOFFSETS vtktypeint64\n0 5 3\nCONNECTIVITY vtktypeint64\n0 1 2\n",
            FormatError,
            "the offsets of the cells do not match",
        ),
        (HEAD.replace("ASCII", "BINARY") + "POINTS 3 float\n1234", FormatError, "is the file truncated"),
    ],
)
def test_errors(rejects, content, error, message):
    rejects("a.vtk", content, error, message)


@pytest.mark.parametrize("is_binary", [False, True])
def test_texts_of_a_field_are_skipped(tmp_path, is_binary):
    given, texts = vtk_polydata("polygons"), vtk.vtkStringArray()
    texts.SetName("origin")
    for text in ("scanner A", "", "a" * 70, "b" * 20_000, "two\nlines"):
        texts.InsertNextValue(text)
    given.GetFieldData().AddArray(texts)
    writer = vtk.vtkPolyDataWriter()
    writer.SetInputData(given)
    writer.SetFileName(str(tmp_path / "a.vtk"))
    writer.SetFileTypeToBinary() if is_binary else writer.SetFileTypeToASCII()
    assert writer.Write() == 1
    assert soup_faces(read_vtk(tmp_path / "a.vtk")) == vtk_faces(given)[1]
