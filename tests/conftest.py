"""What several test files use: small shapes, made once, and a fresh interpreter.

Hypothesis takes the same examples in every run, however long each takes, so that what passed here passes elsewhere, on
a busy machine too; others are tried with ``pytest --hypothesis-profile=default``.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from lbskel import Mesh
from lbskel.shapes import capsule, chain_of_tori, make, torus

# the clone comes last, so that an installed lbskel is the one tested
sys.path.append(str(Path(__file__).parent.parent))

settings.register_profile("repeatable", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def tetrahedron():
    """The corner of the unit cube: closed, outwards, volume 1/6."""
    return Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


@pytest.fixture(scope="session")
def ring():
    """A coarse torus, of genus 1: 128 vertices."""
    return torus(1.0, 0.25, 16, 8)


@pytest.fixture(scope="session")
def rod():
    """A coarse capsule along z, of genus 0 with two tips: 152 vertices."""
    return capsule(3.0, 0.4, 10)


@pytest.fixture(scope="session")
def two_rings():
    """Two rings in a row, of genus 2: 576 vertices."""
    return chain_of_tori(2, step=0.2)


@pytest.fixture(scope="session")
def tripod():
    """Three limbs of different lengths from one place, with no symmetry: 756 vertices."""
    return make("tripod", n_vertices=800).mesh


@pytest.fixture(scope="session")
def python():
    """Run a fresh interpreter, ``python("-m", "lbskel", cwd=...)``, on one thread unless told otherwise."""

    def run(*arguments, cwd=None, **environment):
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            cwd=cwd,
            env={**os.environ, "OMP_NUM_THREADS": "1", **environment},
            capture_output=True,
            text=True,
        )

    return run
