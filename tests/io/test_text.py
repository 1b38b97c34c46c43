"""Numbers from text: columns, lists and integers, with errors that name the line."""

import numpy as np
import pytest

from lbskel.errors import FormatError, MeshError, MissingDependency, UnknownChoice
from lbskel.io.text import (
    MAX_EXACT_INTEGER,
    as_floats,
    as_integers,
    content_lines,
    convert_errors,
    decode_text,
    format_rows,
    known_extension,
    parse_columns,
    parse_index_lists,
    parse_numbers,
    prefix_errors,
    read_bytes,
    read_text,
)

TEXT = "# head\n1 2 3\n\n 4 5 6 # tail\n7 8 9\n"


def test_lines_have_the_numbers_that_an_editor_shows():
    lines = content_lines(TEXT)
    assert lines.texts == ["1 2 3", "4 5 6", "7 8 9"]
    np.testing.assert_array_equal(lines.numbers, [2, 4, 5])
    assert lines[1:].texts == ["4 5 6", "7 8 9"]
    assert lines[np.array([2, 0])].texts == ["7 8 9", "1 2 3"]
    np.testing.assert_array_equal(lines[np.array([2, 0])].numbers, [5, 2])


def test_columns_are_counted_from_zero():
    np.testing.assert_array_equal(parse_columns(content_lines(TEXT), range(1, 3), "pairs"), [[2, 3], [5, 6], [8, 9]])
    assert parse_columns(content_lines(""), range(3), "triples").shape == (0, 3)


@pytest.mark.parametrize("faulty", range(7))
def test_the_first_faulty_line_is_named(faulty):
    rows = ["1 2 3"] * 7
    rows[faulty:] = ["1 2 x"] * (7 - faulty)
    with pytest.raises(FormatError, match=f"^line {faulty + 1}: three numbers expected, found '1 2 x'$"):
        parse_columns(content_lines("\n".join(rows)), range(3), "three numbers")


def test_numbers_are_separated_by_any_white_space():
    np.testing.assert_array_equal(parse_numbers("1\t-2.5\r\n 3e2\n"), [1, -2.5, 300])
    np.testing.assert_array_equal(parse_numbers(memoryview(b"1 2")), [1, 2])
    with pytest.raises(ValueError, match="x"):
        parse_numbers("1 x")


def test_lists_of_different_lengths_are_concatenated_in_the_order_of_the_lines():
    lines = content_lines("3 10 11 12\n1 20\n3 30 31 32\n0\n")
    values = parse_index_lists(lines, np.array([3, 1, 3, 0]), 1, "indices")
    np.testing.assert_array_equal(values, [10, 11, 12, 20, 30, 31, 32])
    assert values.dtype == np.int64
    with pytest.raises(FormatError, match="line 2: 2 indices expected, found '1 20'"):
        parse_index_lists(lines, np.array([3, 2, 3, 0]), 1, "indices")


def test_integers_beyond_the_exact_range_of_float64_are_rejected():
    largest = MAX_EXACT_INTEGER - 1
    np.testing.assert_array_equal(as_integers(np.array([largest, -largest]), "ids"), [2**53 - 1, 1 - 2**53])
    for value in (MAX_EXACT_INTEGER, -MAX_EXACT_INTEGER, 0.5, np.nan, np.inf):
        with pytest.raises(FormatError, match="row 1: ids must be whole numbers"):
            as_integers(np.array([[0, 0], [0, value]]), "ids")
        with pytest.raises(FormatError, match="line 9: ids must be whole numbers"):
            as_integers(np.array([0, value]), "ids", np.array([4, 9]))


def test_nested_lists_become_arrays_of_the_given_shape():
    np.testing.assert_array_equal(as_floats([1, None], "radii"), [1, np.nan])
    assert as_floats([], "nodes", 3).shape == (0, 3)
    with pytest.raises(FormatError, match=r"nodes: the shape must be \(n, 3\), not \(1, 2\)"):
        as_floats([[1, 2]], "nodes", 3)
    with pytest.raises(FormatError, match=r"radii: the shape must be \(n,\), not \(1, 2\)"):
        as_floats([[1, 2]], "radii")


def test_formatted_numbers_are_read_back_bit_for_bit():
    rows = np.array([[0.1, 1e-300, 1 / 3], [-0.0, 5e-324, 1.7976931348623157e308]])
    text = format_rows("v ", rows)
    assert text.splitlines()[0] == "v 0.1 1e-300 0.3333333333333333"
    np.testing.assert_array_equal(parse_numbers(text.replace("v", "")).reshape(2, 3), rows)
    assert format_rows("", np.array([[1, 2]])) == "1 2\n"


def test_the_extension_in_lower_case(tmp_path):
    assert known_extension("a.tar.OBJ", ("obj",), "meshes") == "obj"
    for path, fault in (("a.stl", "unknown extension 'stl'"), ("a", "no extension"), (tmp_path, "is a folder")):
        with pytest.raises(FormatError, match=f"{fault}; known for meshes: obj, off$"):
            known_extension(path, ("obj", "off"), "meshes")


def test_errors_of_lbskel_keep_their_kind_and_get_the_path():
    for error, kind in ((MeshError("bad"), MeshError), (FormatError("bad"), FormatError)):
        with pytest.raises(kind, match=r"^a\.obj: bad$"), prefix_errors("a.obj"):
            raise error
    with pytest.raises(FormatError, match=r"^a\.obj: bad$"), prefix_errors("a.obj"):
        raise UnknownChoice("bad")
    with pytest.raises(MissingDependency, match=r"^reading needs x"), prefix_errors("a.obj"):
        raise MissingDependency("x", "extra", "reading")


def test_errors_of_other_packages_become_format_errors():
    with pytest.raises(FormatError, match=r"^a\.obj: cannot be read as \.obj: KeyError: 'x'$"), convert_errors("a.obj"):
        raise KeyError("x")
    with pytest.raises(MeshError, match=r"^a\.obj: bad$"), convert_errors("a.obj"):
        raise MeshError("bad")
    with pytest.raises(KeyboardInterrupt), convert_errors("a.obj"):
        raise KeyboardInterrupt


def test_files_that_cannot_be_read(tmp_path):
    (tmp_path / "empty").touch()
    for name, message in (("", "is a folder"), ("empty", "the file is empty"), ("missing", "no such file")):
        with pytest.raises(FormatError, match=message):
            read_bytes(tmp_path / name)


def test_text_is_utf8_with_or_without_a_byte_order_mark(tmp_path):
    (tmp_path / "a").write_bytes(b"\xef\xbb\xbf\xc3\xa9")
    assert read_text(tmp_path / "a") == "é"
    assert decode_text(b"caf\xe9") == "caf\ufffd"
