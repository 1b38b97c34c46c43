"""PLY as a format: headers, elements with lists in every encoding, and files that are shorter than declared."""

import struct

import numpy as np
import pytest

from lbskel.errors import FormatError
from lbskel.io.ply import encode_ply_header, parse_ply

POINT = ["float x", "float y", "float z"]
LIST = ["list uchar int vertex_indices"]


def ply(encoding, body, **elements):
    """A file of some elements, each given as its count and its properties."""
    return encode_ply_header(encoding, [], elements).encode() + body


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("sizes", [(3, 3), (3, 1), (0, 2)])
def test_lists_of_equal_and_different_lengths(encoding, sizes):
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(encoding)
    rows = [(index + 1, list(range(10 * index, 10 * index + size)), -1.5 * index) for index, size in enumerate(sizes)]
    if order:
        body = b"".join(struct.pack(f"{order}hB{len(v)}id", a, len(v), *v, b) for a, v, b in rows)
    else:
        body = "".join(f"{a} {len(v)} {' '.join(map(str, v))} {b}\n" for a, v, b in rows).encode()
    element = parse_ply(ply(encoding, body, thing=(2, ["short a", "list uchar int v", "double b"]))).elements["thing"]
    np.testing.assert_array_equal(element["a"], [1, 2])
    np.testing.assert_array_equal(element["b"], [0, -1.5])
    np.testing.assert_array_equal(element["v"].sizes, sizes)
    np.testing.assert_array_equal(element["v"].values, [value for _, values, _ in rows for value in values])


def test_elements_comments_and_counts_of_a_header():
    header = encode_ply_header("ascii", ["made by hand", "radius_kind mean"], {"a": (1, ["int b"]), "c": (0, LIST)})
    assert header.splitlines() == [
        "ply",
        "format ascii 1.0",
        "comment made by hand",
        "comment radius_kind mean",
        "element a 1",
        "property int b",
        "element c 0",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    file = parse_ply(header.encode() + b"7\n")
    assert file.comments == ["made by hand", "radius_kind mean"]
    np.testing.assert_array_equal(file.elements["a"]["b"], [7])
    assert len(file.elements["c"]["vertex_indices"].sizes) == 0


@pytest.mark.parametrize("newline", [b"\n", b"\r\n", b"\r"])
def test_a_byte_order_mark_and_comments_with_other_line_separators(newline):
    comment = "a\x0bb\u2028c\x85d"
    text = encode_ply_header("ascii", [comment], {"a": (1, ["int b"])}).encode() + b"7\n"
    file = parse_ply(b"\xef\xbb\xbf" + text.replace(b"\n", newline))
    assert (file.comments, file.elements["a"]["b"]) == ([comment], [7])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"OFF\n", "it must begin with ply"),
        (b"ply\nformat ascii 1.0\n", "no end_header"),
        (b"ply\nformat ebcdic 1.0\nend_header\n", "line 2: not a line of a PLY header"),
        (b"ply\nelement vertex 1\nend_header\n", "names no format"),
        (b"ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "line 3: not a line"),
        (b"ply\nformat ascii 1.0\nproperty float x\nend_header\n", "line 3: not a line"),
        (ply("ascii", b"", vertex=(1, ["quad x"])), "line 4: not a line"),
        (ply("ascii", b"0 0 0\n1 nought 0\n", vertex=(5, POINT)), "line 9: 'nought' is not a number"),
        (ply("ascii", b"1 2 3 4", vertex=(5, POINT)), "element vertex of 5: the header declares more data"),
        (ply("ascii", b" \n", a=(1, ["int b"])), "element a of 1: the header declares more data"),
        (
            ply("binary_little_endian", bytes(36), a=(2, POINT), b=(2, POINT)),
            "element b of 2: the header declares more data",
        ),
        (ply("ascii", b"-3 0 1 2", face=(1, LIST)), "element face of 1: a list cannot have -3"),
        (ply("ascii", b"1.5 0 1 2", face=(1, LIST)), "a list cannot have 1.5"),
    ],
)
def test_errors_name_the_line_or_the_element(content, message):
    with pytest.raises(FormatError, match=message):
        parse_ply(content)


HUGE = {
    "rows": ply("binary_little_endian", bytes(1000), vertex=(300_000_000, POINT)),
    "a list": ply("binary_little_endian", b"\xff" + bytes(100), face=(1, LIST)),
    "a long list": ply("binary_little_endian", b"\xff\xff\xff\xff" + bytes(100), face=(1, ["list uint int i"])),
    "lists": ply("binary_little_endian", bytes(1000), face=(4_000_000_000, LIST)),
    "rows of text": ply("ascii", b"1 2 3\n", vertex=(300_000_000, POINT)),
}


@pytest.mark.parametrize("name", HUGE)
def test_declared_gigabytes_are_not_allocated(rejects_without_allocating, name):
    rejects_without_allocating("a.ply", HUGE[name])
