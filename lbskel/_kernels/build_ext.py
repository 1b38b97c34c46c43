"""Build commands for setuptools, which loads this file on its own, without the package.

A build leaves nothing in the source folder: C files, objects and metadata go to a temporary folder. Only a development
install (``pip install -e .``) puts compiled kernels beside their sources, with a record of these (``compiled_files``).

From Python 3.11 on the kernels are compiled for the limited API, so that one wheel serves all later versions.
"""

from __future__ import annotations

__all__ = ["Build", "BuildKernels", "BuildWheel", "EggInfo", "SourceDistribution"]

import atexit
import os
import re
import runpy
import shutil
import sys
import tempfile

from setuptools import Extension
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build import build
from setuptools.command.build_ext import build_ext
from setuptools.command.egg_info import egg_info
from setuptools.command.sdist import sdist

# how the kernels are compiled: no checks of indices, and C's division
INDEX_CHECKS = ("boundscheck", "wraparound", "initializedcheck")
DIRECTIVES = {"language_level": 3, "cdivision": True, **dict.fromkeys(INDEX_CHECKS, False)}
REPOSITORY = "LBSKEL_REPOSITORY"  # environment variable: its address, for the metadata of a release
CHECKS = "LBSKEL_KERNEL_CHECKS"  # environment variable: index checks to switch on, separated by spaces

SHARED = "lbskel._kernels.memory_views"  # Cython's own code, which would else be compiled in each kernel
FOLDER = os.path.dirname(os.path.abspath(__file__))
compiled_files = runpy.run_path(os.path.join(FOLDER, "compiled_files.py"))
LIMITED_API = compiled_files["LIMITED_API"]

# what the tests and the commands of the README need besides the package
SOURCE_FOLDERS = ("benchmarks", "meshes", "tests", ".github")

TEMPORARY = tempfile.mkdtemp(prefix="lbskel-build-")
atexit.register(shutil.rmtree, TEMPORARY, ignore_errors=True)


class Build(build):
    """Builds in a temporary folder."""

    def initialize_options(self) -> None:
        """Set the folder."""
        super().initialize_options()
        self.build_base = os.path.join(TEMPORARY, "build")


class EggInfo(egg_info):
    """Writes metadata to a temporary folder, with links that work on a package page where the repository is known."""

    def initialize_options(self) -> None:
        """Set the folder."""
        super().initialize_options()
        self.egg_base = TEMPORARY

    def finalize_options(self) -> None:
        """Complete the relative links of the README."""
        super().finalize_options()
        if address := os.environ.get(REPOSITORY):
            metadata = self.distribution.metadata
            blob, raw = (f"{address}/{kind}/v{metadata.version}/" for kind in ("blob", "raw"))
            text = re.sub(r"(!\[[^]]*\]\()(?![\w+.-]+:|#)", rf"\1{raw}", metadata.long_description or "")
            metadata.long_description = re.sub(r"((?<!!)\[[^]]*\]\()(?![\w+.-]+:|#)", rf"\1{blob}", text)
            metadata.project_urls = {
                "Source": address,
                "Issues": f"{address}/issues",
                "Documentation": f"{address}#readme",
                "Changelog": f"{address}#changes",
            }


class SourceDistribution(sdist):
    """Packs what the tests need too."""

    def make_distribution(self) -> None:
        """Add the folders, without what running their files leaves there."""
        for folder in SOURCE_FOLDERS:
            self.filelist.graft(folder)
        for pattern in ("*.py[cod]", "*.so", "*.crc", ".*cache"):
            self.filelist.global_exclude(pattern)
        self.filelist.sort()
        self.filelist.remove_duplicates()
        super().make_distribution()


class BuildWheel(bdist_wheel):
    """Makes one wheel for all Pythons with the limited API."""

    def finalize_options(self) -> None:
        """Set the tag."""
        if LIMITED_API:
            self.py_limited_api = "cp311"
        super().finalize_options()


class BuildKernels(build_ext):
    """Compiles the kernels with Cython."""

    def finalize_options(self) -> None:
        """Set the directives, and the extensions of the limited API."""
        if SHARED not in [extension.name for extension in self.distribution.ext_modules or []]:
            file = os.path.join(*SHARED.split(".")) + ".c"
            self.distribution.ext_modules = [*(self.distribution.ext_modules or []), Extension(SHARED, [file])]
        for extension in self.distribution.ext_modules:
            extension.optional = True
            extension.py_limited_api = LIMITED_API
        super().finalize_options()
        checks = dict.fromkeys(os.environ.get(CHECKS, "").split(), True)
        if unknown := checks.keys() - set(INDEX_CHECKS):
            raise ValueError(f"{CHECKS}: unknown {', '.join(sorted(unknown))}; known: {', '.join(INDEX_CHECKS)}")
        self.cython_directives = DIRECTIVES | checks
        self.parallel: int = os.cpu_count() or 1

    def build_extensions(self) -> None:
        """Compile with the same rounding on all platforms: no fused multiply-add."""
        from Cython.Build import cythonize

        is_checked = any(self.cython_directives[name] for name in INDEX_CHECKS)
        for extension in self.extensions:
            if LIMITED_API:
                extension.define_macros = [("Py_LIMITED_API", "0x030b0000")]
            if self.compiler.compiler_type != "msvc":  # which optimizes and rounds like this by default
                extension.extra_compile_args = [
                    "-O1" if is_checked else "-O3",
                    "-g0",
                    "-ffp-contract=off",
                    "-fno-trapping-math",
                    "-fno-math-errno",
                ]
        generated = cythonize(
            self.extensions,
            nthreads=self.parallel if sys.platform == "linux" else 0,  # elsewhere processes are spawned, from setup
            build_dir=self.build_temp,
            compiler_directives=self.cython_directives,
            shared_utility_qualified_name=SHARED,
        )
        sources = {extension.name: extension.sources for extension in generated}
        for extension in self.extensions:
            extension.sources = sources[extension.name]
        super().build_extensions()

    def run(self) -> None:
        """Build; beside the sources, write the record of these too."""
        os.environ.update(runpy.run_path(os.path.join(FOLDER, "build_backend.py"))["find_compiler"]())
        super().run()
        if self.inplace:
            compiled_files["write_record"](FOLDER)
