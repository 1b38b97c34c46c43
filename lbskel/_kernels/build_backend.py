"""The build backend: that of setuptools, and a C compiler from the package index where the machine has none.

``ziglang`` carries clang and is installed for the time of the build only, as other backends do it with CMake and Ninja.
numba would compile the kernels in the first run of every installation. It does not take the place of this: with LLVM it
is larger than scipy, takes seconds for each kernel, and has no classes like those of sections and shortest paths.
"""

from __future__ import annotations

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "find_compiler",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]

import importlib.util
import os
import shlex
import shutil
import sys
import sysconfig
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import (
    build_editable,
    build_sdist,
    build_wheel,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

COMPILER = "ziglang"  # the package


def get_requires_for_build_wheel(config_settings: Any = None) -> list[str]:
    """List what a build needs besides setuptools and Cython."""
    return [*build_meta.get_requires_for_build_wheel(config_settings), *_compiler()]


def get_requires_for_build_editable(config_settings: Any = None) -> list[str]:
    """List what a development install needs besides setuptools and Cython."""
    return [*build_meta.get_requires_for_build_editable(config_settings), *_compiler()]


def find_compiler() -> dict[str, str]:
    """Environment variables with which setuptools finds the package's compiler; none where the machine has one."""
    if not _compiler() or importlib.util.find_spec(COMPILER) is None:
        return {}
    command = f"{shlex.quote(sys.executable)} -m {COMPILER} cc"
    return {"CC": command, "LDSHARED": f"{command} -shared"}


def _compiler() -> list[str]:
    """Name the package with the compiler, if it is needed; elsewhere than on Linux setuptools finds the system's."""
    command = os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc"
    return [COMPILER] if sys.platform == "linux" and shutil.which(shlex.split(command)[0]) is None else []
