"""Meshes in polygonal data of VTK: files that vtk writes, in every encoding, and broken ones."""

import numpy as np
import pytest
from helpers import soup_faces, vtk_faces, vtk_polydata

from lbskel import MeshError, read_mesh, write_skeleton
from lbskel.errors import FormatError
from lbskel.io.vtk_polydata import read_vtp_mesh, triangles_of_strips

vtk = pytest.importorskip("vtk")


@pytest.mark.parametrize("kind", ["polygons", "strips", "both"])
@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
@pytest.mark.parametrize("compressor", [None, "ZLib", "LZMA"])
def test_what_vtk_writes_is_read(tmp_path, kind, mode, compressor):
    given = vtk_polydata(kind)
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetInputData(given)
    writer.SetFileName(str(tmp_path / "a.vtp"))
    getattr(writer, f"SetDataModeTo{mode}")()
    writer.SetCompressor(getattr(vtk, f"vtk{compressor}DataCompressor")() if compressor else None)
    writer.SetEncodeAppendedData(kind == "both")
    writer.SetHeaderTypeToUInt64() if kind == "strips" else writer.SetHeaderTypeToUInt32()
    assert writer.Write() == 1
    points, faces = vtk_faces(given)
    soup, mesh = read_vtp_mesh(tmp_path / "a.vtp"), read_mesh(tmp_path / "a.vtp")
    np.testing.assert_array_equal(mesh.vertices.astype(np.float32), points)
    assert soup_faces(soup) == faces
    assert len(mesh.faces) == sum(len(face) - 2 for face in faces)
    assert any("strips were cut into triangles" in note for note in mesh.notes) == (kind != "polygons")


def test_pieces_are_joined(read):
    piece = (
        '<Piece><Points><DataArray type="Float64" format="ascii">{} 0 0 1 0 0 0 1 0'
        '</DataArray></Points><Polys><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>'
        '<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray></Polys></Piece>'
    )
    mesh = read("a.vtp", f'<VTKFile type="PolyData"><PolyData>{piece.format(0)}{piece.format(-1)}</PolyData></VTKFile>')
    assert mesh.vertices[:, 0].tolist() == [0, 1, 0, -1, 1, 0]
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_every_second_triangle_of_a_strip_is_turned():
    corners, sizes = triangles_of_strips((np.array([7, 8, 9, 5, 0, 1, 2]), np.array([4, 3])))
    assert (corners.tolist(), sizes.tolist()) == ([7, 8, 9, 9, 8, 5, 0, 1, 2], [3, 3, 3])


def test_a_skeleton_is_no_mesh(tmp_path, tree):
    write_skeleton(tmp_path / "a.vtp", tree)
    with pytest.raises(FormatError, match=r"a\.vtp: there are no polygons and no triangle strips: lines"):
        read_mesh(tmp_path / "a.vtp")


def arrays(points="0 0 0 1 0 0 0 1 0", connectivity="0 1 2", offsets="3", section="Polys"):
    return (
        '<VTKFile type="PolyData"><PolyData><Piece>'
        f'<Points><DataArray type="Float64" format="ascii">{points}</DataArray></Points>'
        f'<{section}><DataArray type="Int64" Name="connectivity" format="ascii">{connectivity}</DataArray>'
        f'<DataArray type="Int64" Name="offsets" format="ascii">{offsets}</DataArray></{section}>'
        "</Piece></PolyData></VTKFile>"
    )


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        (
            '<VTKFile type="UnstructuredGrid"></VTKFile>',
            FormatError,
            "a VTK data set of UnstructuredGrid, not of PolyData",
        ),
        ("<svg/>", FormatError, "a VTK data set of an unknown type"),
        ("solid", FormatError, "not XML"),
        ('<VTKFile type="PolyData"/>', FormatError, "there are no polygons"),
        (arrays(points="0 0"), FormatError, "the points do not have three coordinates each"),
        (arrays(points="x 0 0"), FormatError, "x"),
        (arrays(offsets="2"), FormatError, "the offsets of the cells do not match"),
        (arrays(offsets="5 3"), FormatError, "the offsets of the cells do not match"),
        (arrays(connectivity="0 1 3"), MeshError, "faces 0 .* use vertices that do not exist"),
        (arrays(connectivity="0 1", offsets="2"), MeshError, "faces 0 .* fewer than three corners"),
        (
            arrays(connectivity="0 1", offsets="2", section="Strips"),
            FormatError,
            "triangle strip 0 .* fewer than three",
        ),
        (
            arrays().replace("<VTKFile", '<VTKFile compressor="vtkLZ4DataCompressor"').replace("ascii", "binary"),
            FormatError,
            "is compressed by vtkLZ4DataCompressor, which is not supported; save",
        ),
    ],
)
def test_errors(rejects, content, error, message):
    rejects("a.vtp", content, error, message)
