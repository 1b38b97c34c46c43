"""How the kernels are compiled; for setuptools, which loads this file by itself, without the package."""

from __future__ import annotations

__all__ = ["BesideSources"]

from setuptools.command.build_ext import build_ext


class BesideSources(build_ext):
    """Optimizes, and puts what is compiled beside its source too, since Python run in the clone finds it there."""

    def build_extensions(self) -> None:
        """Compile with the same roundings everywhere: a product and a sum are not made one."""
        for extension in self.extensions:
            if self.compiler.compiler_type != "msvc":  # which optimizes, and keeps to the standard, by itself
                extension.extra_compile_args = ["-O3", "-ffp-contract=off"]
        super().build_extensions()

    def run(self) -> None:
        """Build into the wheel, then copy."""
        super().run()
        self.copy_extensions_to_source()
