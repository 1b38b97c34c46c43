"""Which compiled kernels belong to which sources: checksums, written when kernels are compiled beside their sources.

Only a development install (``pip install -e .``) has compiled files beside sources that change. It also has a record of
checksums of the sources that were compiled, one for each platform, with which the sources are compared at import.
"""

from __future__ import annotations

__all__ = ["SUFFIX", "changed_sources", "checksums", "installed_twin", "is_compiled", "write_record"]

import os
import sys
from importlib.machinery import EXTENSION_SUFFIXES
from zlib import crc32

SUFFIX = EXTENSION_SUFFIXES[0]  # of compiled files, with the version of Python and the platform
RECORD = f"sources{SUFFIX}.crc"


def checksums(folder: str | os.PathLike[str]) -> dict[str, str]:
    """CRC-32 of each Python file in a folder."""
    found = {}
    for name in sorted(os.listdir(folder)):
        if name.endswith(".py"):
            with open(os.path.join(folder, name), "rb") as file:
                found[name] = f"{crc32(file.read()):08x}"
    return found


def write_record(folder: str | os.PathLike[str]) -> None:
    """Write the checksums of a folder, in which kernels have just been compiled, beside them."""
    with open(os.path.join(folder, RECORD), "w", encoding="ascii") as file:
        file.writelines(f"{name} {checksum}\n" for name, checksum in checksums(folder).items())


def is_compiled(folder: str | os.PathLike[str]) -> bool:
    """Whether a folder has compiled kernels for this Python."""
    return os.path.isdir(folder) and any(name.endswith(SUFFIX) for name in os.listdir(folder))


def changed_sources(folder: str | os.PathLike[str]) -> list[str]:
    """Python files added, removed or changed since the kernels in a folder were compiled; none without a record."""
    try:
        with open(os.path.join(folder, RECORD), encoding="ascii") as file:
            recorded = dict(line.split() for line in file)
    except FileNotFoundError:
        return []
    present = checksums(folder)
    return sorted(name for name in recorded.keys() | present.keys() if recorded.get(name) != present.get(name))


def installed_twin(folder: str | os.PathLike[str]) -> str | None:
    """Folder of compiled kernels on ``sys.path`` that were made from the same sources as those in a folder, or None.

    Python started in a clone imports the package of the clone. After ``pip install .`` nothing is compiled there.
    """
    for entry in sys.path:
        other = os.path.join(entry, "lbskel", "_kernels")
        if is_compiled(other) and not os.path.samefile(other, folder) and checksums(other) == checksums(folder):
            return None if changed_sources(other) else other
    return None
