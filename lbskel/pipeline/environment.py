"""What results and speed depend on besides the input: versions of packages, compiled kernels, processors."""

from __future__ import annotations

__all__ = ["SLOW", "are_kernels_compiled", "system", "versions"]

import os
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from lbskel import _kernels

PACKAGES = ("lbskel", "numpy", "scipy", "libigl", "cvxopt")
OPTIONAL_PACKAGES = ("fast-simplification", "trimesh", "matplotlib", "plotly", "networkx", "pymeshlab", "dask", "pyamg")
SLOW = (
    "the inner loops are not compiled, so this takes many times as long; install a wheel "
    "(pip install --only-binary :all: lbskel), or a C compiler and then pip install --force-reinstall --no-deps lbskel"
)


@cache
def versions() -> dict[str, str]:
    """Versions of Python and of the packages that results depend on."""
    return {"python": platform.python_version()} | {package: _version(package) for package in PACKAGES}


@cache
def are_kernels_compiled() -> bool:
    """Whether the inner loops are compiled; uncompiled they have the same results, many times slower."""
    return not _kernels.is_slow()


def system() -> dict[str, Any]:
    """Describe the installation, for reports of errors: versions, kernels, processors and threads."""
    return {
        **versions(),
        **{package: _version(package) for package in OPTIONAL_PACKAGES},
        "platform": platform.platform(),
        "processors": os.cpu_count(),
        "threads": f"OMP_NUM_THREADS is {os.environ.get('OMP_NUM_THREADS', 'not set')}",
        "kernels_compiled": are_kernels_compiled(),
        "advice": "none" if are_kernels_compiled() else SLOW,
    }


def _version(package: str) -> str:
    """Version of an installed package."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
