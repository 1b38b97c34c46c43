"""Inner loops that cannot be vectorized with numpy: modules that Cython compiles at installation.

Each is plain Python with C types as annotations (Cython's pure Python mode). Where there was no C compiler it runs
uncompiled, with the same results, only many times slower (``is_slow``). Arguments are arrays that the callers have
checked.
"""

from __future__ import annotations

__all__ = ["is_slow"]

from lbskel._kernels.compiled_files import changed_sources, installed_twin, is_compiled, uncompiled_kernels

_folder = __path__[0]
if is_compiled(_folder):
    if _changed := changed_sources(_folder):
        raise ImportError(
            f"the compiled kernels in {_folder} are not those of the sources ({', '.join(_changed)} changed): "
            "run pip install -e . in the clone"
        )
elif _twin := installed_twin(_folder):
    __path__.insert(0, _twin)


def is_slow() -> bool:
    """Whether kernels run uncompiled."""
    return bool(uncompiled_kernels(_folder))
