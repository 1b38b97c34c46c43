"""Stand-ins for the names of Cython's pure Python mode, with which the kernels run where they are not compiled.

Decorators return what they decorate, types can be indexed (``double[:, ::1]``) and do nothing, ``declare`` and ``cast``
return their value. Only what the kernels use is here: https://cython.readthedocs.io/en/latest/src/tutorial/pure.html.
"""

from __future__ import annotations

__all__ = [
    "Py_ssize_t",
    "bint",
    "cast",
    "cclass",
    "cfunc",
    "compiled",
    "const",
    "declare",
    "double",
    "exceptval",
    "final",
    "gil",
    "inline",
    "int",
    "locals",
    "longlong",
    "nogil",
    "schar",
    "uchar",
    "ulonglong",
    "void",
]

import builtins
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

compiled = False


class _Type:
    """A C type, or a memory view or constant of one."""

    def __getitem__(self, _: Any) -> _Type:
        return self


Py_ssize_t = bint = const = double = int = longlong = schar = uchar = ulonglong = void = _Type()


class _NoGil(nullcontext[None]):
    """A block or function that lets other threads run where it is compiled, or a block in it that does not."""

    def __call__(self, decorated: Any) -> Any:
        return decorated


gil = nogil = _NoGil()


def declare(_: Any, value: Any) -> Any:
    """Return the value of a typed constant."""
    return value


def cast(type_: Any, value: Any) -> Any:
    """Return a value as an integer; the kernels cast to nothing else."""
    return builtins.int(value) if type_ is longlong else value


def cfunc(decorated: Any) -> Any:
    """Return what is decorated."""
    return decorated


cclass = final = inline = cfunc


def locals(**_: Any) -> Callable[[Any], Any]:
    """Make a decorator that returns what it decorates."""
    return cfunc


def exceptval(**_: Any) -> Callable[[Any], Any]:
    """Make a decorator that returns what it decorates."""
    return cfunc
