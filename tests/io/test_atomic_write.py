"""Atomic writing: nothing is overwritten unless asked, nothing partly written is left."""

import os
import stat

import pytest

from lbskel.errors import FormatError
from lbskel.io.atomic_write import writable_target, write_all_safely, write_safely


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_bytes_text_and_callables_are_written(tmp_path):
    write_safely(tmp_path / "bytes.bin", b"\x00\xff")
    write_safely(str(tmp_path / "text.txt"), "é\n")
    write_safely(tmp_path / "called.txt", lambda path: path.write_text(path.suffix))
    assert (tmp_path / "bytes.bin").read_bytes() == b"\x00\xff"
    assert (tmp_path / "text.txt").read_bytes() == "é\n".encode()
    assert (tmp_path / "called.txt").read_text() == ".txt"
    assert names(tmp_path) == ["bytes.bin", "called.txt", "text.txt"]


def test_an_existing_file_is_replaced_only_with_force(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(FormatError, match=r"a\.txt: exists already.*force=True.*--force"):
        write_safely(path, "new")
    assert path.read_text() == "old"
    write_safely(path, "new", force=True)
    assert path.read_text() == "new"


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError, OSError(28, "No space left on device")])
@pytest.mark.parametrize("exists", [False, True])
def test_nothing_partly_written_is_left(tmp_path, error, exists):
    path = tmp_path / "a.txt"
    if exists:
        path.write_text("old")

    def fail(temporary):
        temporary.write_text("half")
        raise error

    with pytest.raises(FormatError if isinstance(error, OSError) else error):
        write_safely(path, fail, force=True)
    assert names(tmp_path) == (["a.txt"] if exists else [])
    assert not exists or path.read_text() == "old"


def test_a_folder_that_cannot_be_written_is_found_before_anything_is_made(tmp_path, monkeypatch):
    """By what the system tells of the folder: it lets the superuser, who may run the tests, write everywhere."""
    monkeypatch.setattr(os, "access", lambda folder, mode: (folder, mode) != (tmp_path, os.W_OK | os.X_OK))
    with pytest.raises(FormatError, match=r"a\.txt: the folder .* cannot be written; name a file in another"):
        writable_target(tmp_path / "a.txt", force=True)


def test_a_full_disk_is_reported(tmp_path):
    def fail(_):
        raise OSError(28, "No space left on device")

    with pytest.raises(FormatError, match=r"a\.txt: cannot be written: No space left"):
        write_safely(tmp_path / "a.txt", fail)


def test_several_files_are_all_written_or_none(tmp_path):
    (tmp_path / "b.txt").write_text("old")
    contents = {tmp_path / "a.txt": "a", tmp_path / "b.txt": "b"}
    with pytest.raises(FormatError, match=r"b\.txt: exists already"):
        write_all_safely(contents)
    assert names(tmp_path) == ["b.txt"]

    def fail(_):
        raise RuntimeError

    with pytest.raises(RuntimeError):
        write_all_safely({tmp_path / "a.txt": "a", tmp_path / "b.txt": fail}, force=True)
    assert names(tmp_path) == ["b.txt"]
    assert (tmp_path / "b.txt").read_text() == "old"
    write_all_safely(contents, force=True)
    assert [(tmp_path / name).read_text() for name in names(tmp_path)] == ["a", "b"]


def test_folders_missing_folders_and_impossible_names_are_rejected(tmp_path):
    with pytest.raises(FormatError, match="is a folder"):
        write_safely(tmp_path, "x", force=True)
    with pytest.raises(FormatError, match="missing does not exist; create it first"):
        write_safely(tmp_path / "missing" / "a.txt", "x")
    for name in ("a\0b", "x" * 300):
        with pytest.raises(FormatError, match="cannot be written"):
            write_safely(tmp_path / name, "x")
    assert names(tmp_path) == []


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes on this system")
def test_a_pipe_is_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FormatError, match="not a regular file"):
        write_safely(tmp_path / "pipe", "x", force=True)
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


@pytest.mark.skipif(os.name == "nt", reason="links and permissions of POSIX")
def test_links_are_followed_and_permissions_kept(tmp_path):
    (tmp_path / "target.txt").write_text("old")
    (tmp_path / "target.txt").chmod(0o640)
    (tmp_path / "link.txt").symlink_to("target.txt")
    write_safely(tmp_path / "link.txt", "new", force=True)
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "target.txt").read_text() == "new"
    assert stat.S_IMODE((tmp_path / "target.txt").stat().st_mode) == 0o640


def test_a_byte_of_a_name_that_is_not_utf8_is_escaped_in_text(tmp_path):
    write_safely(tmp_path / "a.txt", "日 \udcff\n")
    assert (tmp_path / "a.txt").read_text(encoding="utf-8") == "日 \\udcff\n"
