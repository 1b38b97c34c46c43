"""Which compiled kernels belong to which sources: checksums, written when kernels are compiled beside their sources.

Only a development install (``pip install -e .``) has compiled files beside sources that change. It also has a record of
checksums of the sources that were compiled, one for each platform, with which the sources are compared at import.
"""

from __future__ import annotations

__all__ = [
    "LIMITED_API",
    "SUFFIX",
    "changed_sources",
    "checksums",
    "installed_twin",
    "is_compiled",
    "uncompiled_kernels",
    "write_record",
]

import os
import sys
import sysconfig
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import find_spec
from zlib import crc32

# whether kernels are compiled for the limited API, which all later Pythons have too: the one of 3.10 has no buffers
LIMITED_API = (
    sys.implementation.name == "cpython"
    and sys.version_info >= (3, 11)
    and not sysconfig.get_config_var("Py_GIL_DISABLED")
)
# of compiled files: .abi3.so, or .pyd on Windows; otherwise with the version of Python and the platform
SUFFIX = next((each for each in EXTENSION_SUFFIXES if "abi3" in each), ".pyd") if LIMITED_API else EXTENSION_SUFFIXES[0]
RECORD = f"sources{SUFFIX}.crc"
NOT_COMPILED = ("__init__.py", "build_backend.py", "c_types.py", "compiled_files.py")


def checksums(folder: str | os.PathLike[str]) -> dict[str, str]:
    """CRC-32 of each Python file in a folder that compiled kernels depend on."""
    found = {}
    for name in sorted(os.listdir(folder)):
        if name.endswith(".py") and name not in NOT_COMPILED:
            with open(os.path.join(folder, name), "rb") as file:
                found[name] = f"{crc32(file.read()):08x}"
    return found


def write_record(folder: str | os.PathLike[str]) -> None:
    """Write the checksums of a folder, in which kernels have just been compiled, beside them.

    Files compiled for this version of Python alone, which would be imported in their place, are removed.
    """
    if EXTENSION_SUFFIXES[0] != SUFFIX:
        for name in os.listdir(folder):
            if name.endswith(EXTENSION_SUFFIXES[0]):
                os.remove(os.path.join(folder, name))
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


def uncompiled_kernels(folder: str | os.PathLike[str]) -> list[str]:
    """Names of the kernels of a folder that run as plain Python when they are imported."""
    names = [name.removesuffix(".py") for name in checksums(folder) if name != "build_ext.py"]
    found = {name: find_spec(f"lbskel._kernels.{name}") for name in names}
    return [name for name, spec in found.items() if spec is None or (spec.origin or "").endswith(".py")]
