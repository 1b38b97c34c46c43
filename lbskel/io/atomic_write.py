"""Writing files: nothing is overwritten unasked, and nothing half-written is ever left under the name asked for.

The content goes to a temporary name in the same folder, which then takes the place of the target in one step.
"""

from __future__ import annotations

__all__ = ["Content", "rows_text", "write_all_safely", "write_safely"]

import os
import secrets
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

from numpy.typing import NDArray

from lbskel.errors import FormatError, LbskelError

Content: TypeAlias = bytes | str | Callable[[Path], object]


def write_safely(path: str | os.PathLike[str], data: Content, force: bool = False) -> None:
    """Write one file whole or not at all.

    Parameters
    ----------
    path : path-like
        In a folder that exists.
    data : bytes, str or callable
        Text is encoded as UTF-8; a callable is given a temporary path with the same extension and writes there.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    FormatError
        If the file exists and ``force`` is not set, or the system refuses to write it.
    """
    write_all_safely({Path(path): data}, force)


def write_all_safely(contents: Mapping[Path, Content], force: bool = False) -> None:
    """Write several files that belong together: none takes its place before the content of all is on the disk."""
    targets = {_target(path, force): data for path, data in contents.items()}
    temporaries = {target: target.with_name(f".{secrets.token_hex(8)}{target.suffix}") for target in targets}
    try:
        for target, data in targets.items():
            _write(temporaries[target], data)
            if target.exists():
                shutil.copymode(target, temporaries[target])
        for target, temporary in temporaries.items():
            os.replace(temporary, target)
    except OSError as error:
        raise FormatError(f"{', '.join(map(str, targets))}: cannot be written: {error.strerror or error}") from error
    finally:
        for temporary in temporaries.values():
            temporary.unlink(missing_ok=True)


def _target(path: Path, force: bool) -> Path:
    """The file behind the path (links followed), or a FormatError that says why it must not be written."""
    try:
        target = Path(os.path.realpath(path))
        if target.is_dir():
            raise FormatError(f"{path}: is a folder; name a file in it")
        if not target.parent.is_dir():
            raise FormatError(f"{path}: the folder {target.parent} does not exist; create it first")
        if target.exists() and not target.is_file():
            raise FormatError(f"{path}: is not a regular file")
        if target.exists() and not force:
            raise FormatError(f"{path}: exists already; to replace it use force=True (--force on the command line)")
    except LbskelError:
        raise
    except (OSError, ValueError) as error:  # a name that is too long, has a null character or is not permitted
        raise FormatError(f"{path}: cannot be written: {error}") from None
    return target


def _write(temporary: Path, data: Content) -> None:
    """Create a new file with that content."""
    if callable(data):
        data(temporary)
    else:
        temporary.write_bytes(data.encode() if isinstance(data, str) else data)


def rows_text(prefix: str, rows: NDArray) -> str:
    """One line per row: the prefix and the numbers, written so that reading gives the same float64 again."""
    return "".join(prefix + " ".join(map(repr, row)) + "\n" for row in rows.tolist())
