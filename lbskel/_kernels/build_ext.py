"""Build commands for setuptools, which loads this file on its own, without the package.

A build leaves nothing in the source folder: C files, objects and metadata go to a temporary folder. Only a development
install (``pip install -e .``) puts compiled kernels beside their sources, with a record of these (``compiled_files``).
"""

from __future__ import annotations

__all__ = ["Build", "BuildKernels", "EggInfo"]

import atexit
import os
import runpy
import shutil
import tempfile

from setuptools.command.build import build
from setuptools.command.build_ext import build_ext
from setuptools.command.egg_info import egg_info

# how the kernels are compiled: no checks of indices, and C's division
INDEX_CHECKS = ("boundscheck", "wraparound", "initializedcheck")
DIRECTIVES = {"language_level": 3, "cdivision": True, **dict.fromkeys(INDEX_CHECKS, False)}
CHECKS = "LBSKEL_KERNEL_CHECKS"  # environment variable: index checks to switch on, separated by spaces

TEMPORARY = tempfile.mkdtemp(prefix="lbskel-build-")
atexit.register(shutil.rmtree, TEMPORARY, ignore_errors=True)


class Build(build):
    """Builds in a temporary folder."""

    def initialize_options(self) -> None:
        """Set the folder."""
        super().initialize_options()
        self.build_base = os.path.join(TEMPORARY, "build")


class EggInfo(egg_info):
    """Writes metadata to a temporary folder."""

    def initialize_options(self) -> None:
        """Set the folder."""
        super().initialize_options()
        self.egg_base = TEMPORARY


class BuildKernels(build_ext):
    """Compiles the kernels with Cython."""

    def finalize_options(self) -> None:
        """Set the directives, and the folder of C files."""
        super().finalize_options()
        checks = dict.fromkeys(os.environ.get(CHECKS, "").split(), True)
        if unknown := checks.keys() - set(INDEX_CHECKS):
            raise ValueError(f"{CHECKS}: unknown {', '.join(sorted(unknown))}; known: {', '.join(INDEX_CHECKS)}")
        self.cython_directives = DIRECTIVES | checks
        self.cython_c_in_temp = True

    def build_extensions(self) -> None:
        """Compile with the same rounding on all platforms: no fused multiply-add."""
        for extension in self.extensions:
            if self.compiler.compiler_type != "msvc":  # which optimizes and rounds like this by default
                is_checked = any(self.cython_directives[name] for name in INDEX_CHECKS)
                extension.extra_compile_args = ["-O1" if is_checked else "-O3", "-ffp-contract=off"]
        super().build_extensions()

    def run(self) -> None:
        """Build; beside the sources, write the record of these too."""
        super().run()
        if self.inplace:
            folder = os.path.dirname(os.path.abspath(__file__))
            runpy.run_path(os.path.join(folder, "compiled_files.py"))["write_record"](folder)
