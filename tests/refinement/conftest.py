"""Shapes that several tests of the refinement use, made once."""

import numpy as np
import pytest
from helpers import STAR_ENDS, STAR_RADIUS, mesh_of_branches

from lbskel.geometry.surface_queries import Surface
from lbskel.shapes import capsule


@pytest.fixture(scope="session")
def star():
    """Four arms and a foot that all meet at the origin."""
    return mesh_of_branches([([np.zeros(3), end], STAR_RADIUS) for end in STAR_ENDS.values()])


@pytest.fixture(scope="session")
def rod_along_z():
    """Queries on a rod of radius 0.5 from -4.5 to 4.5 along z."""
    return Surface(capsule(8.0, 0.5, 32))
