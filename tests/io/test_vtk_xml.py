"""Arrays in XML files of VTK: every encoding, and blocks that are shorter or longer than declared."""

import base64
import lzma
import struct
import zlib

import numpy as np
import pytest

from lbskel.errors import FormatError, UnknownChoice
from lbskel.io.vtk_xml import encode_array, parse_vtk

VALUES = np.array([0.1, -2.5, 1e300, 7.0])


def first_array(text, **attributes):
    """The values of the first array of a file."""
    head = "".join(f' {name}="{value}"' for name, value in attributes.items())
    data = text if isinstance(text, bytes) else text.encode()
    file = parse_vtk(f"<VTKFile{head}>".encode() + data + b"</VTKFile>")
    return file.array(next(element for element in file.root.iter() if element.tag in ("DataArray", "Array")))


@pytest.mark.parametrize(
    ("values", "kind"),
    [(VALUES, "Float64"), (np.array([0, -(2**62)]), "Int64"), (np.frombuffer(b"mean\0", dtype=np.uint8), "String")],
)
def test_an_encoded_array_is_read_back(values, kind):
    text = encode_array("a", values)
    assert f'type="{kind}"' in text
    np.testing.assert_array_equal(first_array(text, header_type="UInt64"), values)


def test_tuples_of_several_components_are_counted():
    assert 'NumberOfComponents="3" NumberOfTuples="2"' in encode_array("a", np.zeros((2, 3)), 3)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize(("header", "kind"), [("I", "UInt32"), ("Q", "UInt64")])
@pytest.mark.parametrize("is_base64", [True, False])
@pytest.mark.parametrize("compress", [None, zlib.compress, lzma.compress])
def test_appended_data_in_every_encoding(order, header, kind, is_base64, compress):
    data = VALUES.astype(order + "f8").tobytes()
    if compress:
        blocks = [compress(data[:20]), compress(data[20:])]
        head = struct.pack(f"{order}5{header}", 2, 20, 12, *map(len, blocks))
    else:
        blocks = [data]
        head = struct.pack(f"{order}{header}", len(data))
    body = b"".join(blocks)
    if is_base64:
        body = base64.b64encode(head) + base64.b64encode(body) if compress else base64.b64encode(head + body)
    else:
        body = head + body
    offset = 5
    encoding = "base64" if is_base64 else "raw"
    text = f'<DataArray type="Float64" format="appended" offset="{offset}"/><AppendedData encoding="{encoding}">_'
    attributes = {"byte_order": "LittleEndian" if order == "<" else "BigEndian", "header_type": kind}
    if compress:
        attributes["compressor"] = "vtkZLibDataCompressor" if compress is zlib.compress else "vtkLZMADataCompressor"
    content = text.encode() + b"x" * offset + body + b"</AppendedData>"
    np.testing.assert_array_equal(first_array(content, **attributes), VALUES)


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ('<DataArray type="Float128" format="ascii">1</DataArray>', UnknownChoice, "unknown type of array 'Float128'"),
        (
            '<DataArray type="Int8" Name="a" format="morse">1</DataArray>',
            FormatError,
            "array a: unknown format 'morse'",
        ),
        ('<DataArray type="Int8" format="binary">////fwAAAAA=</DataArray>', FormatError, "declares 2,147,483,651"),
        ("<DataArray", FormatError, "not XML"),
    ],
)
def test_errors_say_what_is_wrong(text, error, message):
    with pytest.raises(error, match=message):
        first_array(text)


def test_a_file_of_lz4_is_rejected():
    with pytest.raises(FormatError, match="compressed by vtkLZ4DataCompressor, which is not"):
        first_array('<DataArray type="Int8" format="binary">AAAA</DataArray>', compressor="vtkLZ4DataCompressor")
