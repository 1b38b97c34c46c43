"""Shapes that several tests of the refinement use, made once."""

import numpy as np
import pytest
from helpers import STAR_ENDS, STAR_RADIUS, mesh_of_branches


@pytest.fixture(scope="session")
def star():
    """Four arms and a foot that all meet at the origin."""
    return mesh_of_branches([([np.zeros(3), end], STAR_RADIUS) for end in STAR_ENDS.values()])
