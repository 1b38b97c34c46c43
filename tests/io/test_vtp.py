"""VTP, with vtk as the other program."""

import base64
import tracemalloc
import zlib
from dataclasses import replace

import numpy as np
import pytest

from lbskel.errors import FormatError
from lbskel.io import FORMATS, read_skeleton, write_skeleton


def vtk_reader(path):
    xml = pytest.importorskip("vtkmodules.vtkIOXML")
    reader = xml.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader


def vtp(points="0 0 0 1 1 1", connectivity="0 1", offsets="2", **attributes):
    """A file of one piece."""
    head = "".join(f' {name}="{value}"' for name, value in attributes.items())
    return (
        f'<VTKFile type="PolyData"{head}><PolyData><Piece><Points><DataArray type="Float64" format="ascii">{points}'
        f'</DataArray></Points><Lines><DataArray type="Int64" Name="connectivity" format="ascii">{connectivity}'
        f'</DataArray><DataArray type="Int64" Name="offsets" format="ascii">{offsets}</DataArray></Lines></Piece>'
        "</PolyData></VTKFile>"
    )


@pytest.mark.parametrize("kind", ["inscribed", "mean"])
def test_only_inscribed_radii_are_called_so(kind, tmp_path, skeleton):
    write_skeleton(tmp_path / "a.vtp", replace(skeleton, radius_kind=kind))
    array = vtk_reader(tmp_path / "a.vtp").GetOutput().GetPointData().GetArray("MaximumInscribedSphereRadius")
    assert (array is not None) == (kind == "inscribed")


def test_vtk_reads_a_written_skeleton(tmp_path, skeleton):
    write_skeleton(tmp_path / "a.vtp", skeleton)
    data = vtk_reader(tmp_path / "a.vtp").GetOutput()
    from vtkmodules.util.numpy_support import vtk_to_numpy

    np.testing.assert_array_equal(vtk_to_numpy(data.GetPoints().GetData()), skeleton.nodes)
    np.testing.assert_array_equal(vtk_to_numpy(data.GetPointData().GetArray("radius")), skeleton.radii)
    field = data.GetFieldData()
    np.testing.assert_array_equal(vtk_to_numpy(field.GetArray("node_of_vertex")), skeleton.node_of_vertex)
    assert field.GetAbstractArray("radius_kind").GetValue(0) == "mean"
    assert data.GetNumberOfVerts() == 1
    offsets, points = (
        vtk_to_numpy(part()) for part in (data.GetLines().GetOffsetsArray, data.GetLines().GetConnectivityArray)
    )
    for polyline, branch in zip(np.split(points, offsets[1:-1]), skeleton.branches, strict=True):
        np.testing.assert_array_equal(polyline, branch)


@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZMA"])
@pytest.mark.parametrize("header", ["UInt32", "UInt64"])
@pytest.mark.parametrize("order", ["LittleEndian", "BigEndian"])
def test_files_of_vtk_in_every_encoding(tmp_path, skeleton, check_round_trip, mode, compressor, header, order):
    write_skeleton(tmp_path / "a.vtp", skeleton)
    reader = vtk_reader(tmp_path / "a.vtp")
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    for encoded in (False, True):
        writer = vtkXMLPolyDataWriter()
        writer.SetInputConnection(reader.GetOutputPort())
        getattr(writer, f"SetDataModeTo{mode}")()
        getattr(writer, f"SetCompressorTypeTo{compressor}")()
        getattr(writer, f"SetHeaderTypeTo{header}")()
        getattr(writer, f"SetByteOrderTo{order}")()
        writer.SetEncodeAppendedData(encoded)
        writer.SetBlockSize(64)  # bytes: several blocks, the last of which is not full
        writer.SetFileName(str(tmp_path / "b.vtp"))
        assert writer.Write() == 1
        back = read_skeleton(tmp_path / "b.vtp")
        if mode == "Ascii":  # in which vtk writes 11 digits
            np.testing.assert_allclose(back.nodes, skeleton.nodes, rtol=1e-10)
            np.testing.assert_array_equal(back.edges, skeleton.edges)
        else:
            check_round_trip(back, skeleton, FORMATS["vtp"].loses)


def test_several_pieces_in_single_precision(read):
    piece = (
        '<Piece NumberOfPoints="2"><Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">'
        "0 0 0 1 1 1</DataArray></Points>{radii}<Lines>"
        '<DataArray type="Int32" Name="connectivity" format="ascii">1 0</DataArray>'
        '<DataArray type="Int32" Name="offsets" format="ascii">2</DataArray></Lines></Piece>'
    )
    named = '<DataArray type="Float32" Name="MaximumInscribedSphereRadius" format="ascii">0.5 0.25</DataArray>'
    pieces = piece.format(radii="") + piece.format(radii=f"<PointData>{named}</PointData>")
    skeleton = read("a.vtp", f'<VTKFile type="PolyData"><PolyData>{pieces}</PolyData></VTKFile>', read_skeleton)
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [2, 3]])
    np.testing.assert_array_equal(skeleton.radii, [np.nan, np.nan, 0.5, 0.25])


def test_consecutive_polylines_are_not_joined(read):
    points = " ".join(map(str, range(15)))
    skeleton = read("a.vtp", vtp(points=points, connectivity="0 1 2 4 3", offsets="3 5"), read_skeleton)
    np.testing.assert_array_equal(skeleton.edges, [[0, 1], [1, 2], [3, 4]])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("Dear reader,\n", "not XML"),
        ("<VTKFile/>", "not a VTP file"),
        (vtp(points="0 0 0 1"), "do not have three coordinates"),
        (vtp(points="0 0 zero"), "cannot be read as .vtp"),
        (vtp(connectivity="0 2"), r"a line uses a point outside 0\.\.1"),
        (vtp(connectivity="0 -1"), r"a line uses a point outside 0\.\.1"),
        (vtp(offsets="1"), "the offsets of the lines do not match"),
        (vtp(offsets="3 2"), "the offsets of the lines do not match"),
        (vtp().replace('"Float64"', '"Float128"'), "unknown type of array 'Float128'"),
        (vtp().replace('"ascii"', '"morse"', 1), "unknown format 'morse'"),
        (
            vtp(compressor="vtkLZ4DataCompressor").replace('"ascii">0 0 0', '"binary">'),
            "is compressed by vtkLZ4DataCompressor, which is not",
        ),
        (
            vtp(header_type="UInt64").replace('"ascii">0 0 0 1 1 1', '"binary">////fwAAAAA='),
            "an array declares 2,147,483,655 bytes",
        ),
    ],
)
def test_errors_say_what_is_wrong(rejects, content, message):
    rejects("a.vtp", content, FormatError, message, read_skeleton)


def test_a_block_that_inflates_to_more_than_declared_is_cut(read):
    block = zlib.compress(np.array([[0, 0, 0], [1, 1, 1]], dtype="<f8").tobytes() + bytes(30_000_000))
    head = np.array([1, 48, 48, len(block)], dtype="<u4").tobytes()
    text = vtp(compressor="vtkZLibDataCompressor").replace(
        '"ascii">0 0 0 1 1 1', f'"binary">{base64.b64encode(head).decode()}{base64.b64encode(block).decode()}'
    )
    tracemalloc.start()
    try:
        skeleton = read("a.vtp", text, read_skeleton)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(skeleton.nodes, [[0, 0, 0], [1, 1, 1]])
    assert peak < 2_000_000  # bytes; the file has about 40,000 and would inflate to 30 million
