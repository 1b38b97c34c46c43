"""The stand-ins for Cython's names: every name that a kernel uses is there; the kernels' own tests run with them."""

import re
from pathlib import Path

import pytest

from lbskel._kernels import c_types

FOLDER = Path(c_types.__file__).parent
KERNELS = [path for path in sorted(FOLDER.glob("*.py")) if "\n    import cython\n" in path.read_text(encoding="utf-8")]


def test_the_kernels_are_found():
    assert {"bvh", "dijkstra", "triangles"} <= {path.stem for path in KERNELS}


@pytest.mark.parametrize("path", KERNELS, ids=lambda path: path.stem)
def test_there_is_a_stand_in_for_every_name_of_cython(path):
    used = set(re.findall(r"\bcython\.(?!cimports)(\w+)", path.read_text(encoding="utf-8")))
    assert used <= set(c_types.__all__)


def test_types_can_be_indexed_and_decorators_change_nothing():
    def function():
        pass

    assert c_types.const[c_types.double][:, ::1] is c_types.double
    assert c_types.locals(x=c_types.double)(c_types.exceptval(check=False)(c_types.cfunc(function))) is function
    assert c_types.declare(c_types.double, 0.5) == 0.5
    assert c_types.cast(c_types.longlong, -2.75) == -2  # as in C, toward zero
    assert c_types.compiled is False
