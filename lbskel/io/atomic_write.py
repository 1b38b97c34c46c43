"""Atomic writing of files: no file is overwritten unless asked, and no partly written file is left behind.

The content is written to a temporary file in the same folder, which then replaces the target in one step. The temporary
file is also removed if a signal ends the process.
"""

from __future__ import annotations

__all__ = ["Content", "writable_target", "write_all_safely", "write_safely"]

import os
import secrets
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

from lbskel.errors import FormatError, LbskelError
from lbskel.geometry.signals import ended_after_tidying_up

Content: TypeAlias = bytes | str | Callable[[Path], object]


def write_safely(path: str | os.PathLike[str], data: Content, force: bool = False) -> None:
    """Write one file completely or not at all.

    Parameters
    ----------
    path : path-like
        The target, in a folder that exists.
    data : bytes, str or callable
        Text is encoded as UTF-8; what has no code there, as a byte in the name of a file, is escaped. A callable is
        called with a temporary path of the same extension, and writes there.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    FormatError
        If the file exists and ``force`` is not set, or the operating system refuses to write it.
    """
    write_all_safely({Path(path): data}, force)


def write_all_safely(contents: Mapping[Path, Content], force: bool = False) -> None:
    """Write several files that belong together; no target is replaced before all contents are on the disk.

    Parameters
    ----------
    contents : mapping of Path to bytes, str or callable
        The content of each file, as :func:`write_safely` takes it.
    force : bool
        Whether existing files may be replaced.

    Raises
    ------
    FormatError
        If a file exists and ``force`` is not set, or the operating system refuses to write it.
    """
    targets = {writable_target(path, force): data for path, data in contents.items()}
    temporaries = {target: target.with_name(f".{secrets.token_hex(8)}{target.suffix}") for target in targets}
    with ended_after_tidying_up():
        try:
            for target, data in targets.items():
                _write(temporaries[target], data)
                if target.exists():
                    shutil.copymode(target, temporaries[target])
            for target, temporary in temporaries.items():
                os.replace(temporary, target)
        except OSError as error:
            names = ", ".join(map(str, targets))
            raise FormatError(f"{names}: cannot be written: {error.strerror or error}") from error
        finally:
            for temporary in temporaries.values():
                temporary.unlink(missing_ok=True)


def writable_target(path: Path, force: bool) -> Path:
    """Follow the links of a path to the file it names; raise FormatError if that file cannot or must not be written."""
    try:
        target = Path(os.path.realpath(path))
        if target.is_dir():
            raise FormatError(f"{path}: is a folder; give the name of a file in it")
        if not target.parent.is_dir():
            raise FormatError(f"{path}: the folder {target.parent} does not exist; create it first")
        if target.exists() and not target.is_file():
            raise FormatError(f"{path}: is not a regular file")
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise FormatError(f"{path}: the folder {target.parent} cannot be written; name a file in another")
        if target.exists() and not force:
            raise FormatError(f"{path}: exists already; to replace it use force=True (--force on the command line)")
    except LbskelError:
        raise
    except (OSError, ValueError) as error:  # the name is too long, has a null character or is not permitted
        raise FormatError(f"{path}: cannot be written: {error}") from None
    return target


def _write(temporary: Path, data: Content) -> None:
    """Create a file with the given content."""
    if callable(data):
        data(temporary)
    else:
        temporary.write_bytes(data.encode(errors="backslashreplace") if isinstance(data, str) else data)
