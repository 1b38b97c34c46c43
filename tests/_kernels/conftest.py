"""Each kernel is tested twice, compiled and as plain Python, and both must agree to the last bit."""

import functools
import importlib
import importlib.util
import sys
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

from lbskel import _kernels
from lbskel.shapes import make

FOLDER = Path(_kernels.__file__).parent


def compiled(name):
    """A kernel as it was installed; the test is skipped if that is not compiled."""
    module = importlib.import_module(f"lbskel._kernels.{name}")
    if module.__file__.endswith(".py"):
        pytest.skip("kernels were not compiled at installation")
    return module


@functools.cache
def uncompiled(name):
    """A kernel run as plain Python, without Cython."""
    spec = importlib.util.spec_from_file_location(f"uncompiled_{name}", FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    with mock.patch.dict(sys.modules, {"cython": None}):
        spec.loader.exec_module(module)
    return module


def name_of(request):
    """The kernel that a test file is named for."""
    return request.path.stem.removeprefix("test_")


@pytest.fixture(params=[compiled, uncompiled], ids=lambda load: load.__name__)
def kernel(request):
    """The kernel of the test file, once compiled and once as plain Python."""
    return request.param(name_of(request))


@pytest.fixture
def assert_same(request):
    """Compare what a function of a kernel returns for the compiled one and for plain Python, bit for bit."""

    def check(function):
        first = function(compiled(name_of(request)))
        with np.errstate(all="raise"):
            second = function(uncompiled(name_of(request)))
        assert len(first) == len(second) > 0
        for one, other in zip(first, second, strict=True):
            one, other = np.asarray(one), np.asarray(other)
            assert one.dtype == other.dtype
            assert np.array_equal(one, other, equal_nan=one.dtype.kind == "f")

    return check


@pytest.fixture(scope="session")
def limbs():
    """A closed shape with four limbs: about 600 vertices."""
    return make("limbs", n_vertices=600).mesh


@pytest.fixture(scope="session")
def square():
    """(V, F) of the unit square in the plane z = 0, in 32 triangles that face upwards."""
    x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5), indexing="ij")
    i = (5 * np.arange(4)[:, None] + np.arange(4)).ravel()
    faces = np.concatenate([np.stack([i, i + 5, i + 6], axis=1), np.stack([i, i + 6, i + 1], axis=1)])
    return np.stack([x.ravel(), y.ravel(), np.zeros(25)], axis=1), faces.astype(np.int64)


@pytest.fixture(scope="session")
def box():
    """(V, F) of the unit cube, oriented outwards; every diagonal ends at the corner (0, 0, 0) or (1, 1, 1)."""
    V = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    F = [[0, 3, 2], [0, 1, 3], [0, 5, 1], [0, 4, 5], [0, 6, 4], [0, 2, 6]]
    F += [[7, 4, 6], [7, 5, 4], [7, 2, 3], [7, 6, 2], [7, 1, 5], [7, 3, 1]]
    return V, np.array(F, dtype=np.int64)
