"""Tips extended to the surface."""

import numpy as np
import pytest
from helpers import path_in

from lbskel import Skeleton
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.surface_tips import tips_at_surface
from lbskel.shapes import capsule


def test_tips_at_the_surface_go_straight_ahead_or_to_the_nearest_point():
    mesh = capsule(4.0, 0.5, 64)
    path = path_in(mesh, [[0, 0, -2], [0, 0, 0], [0, 0, 1.8]])
    # the lower end is 0.5 from the pole; from the upper one the pole is 0.7 away, less than two radii of 0.5
    ends = tips_at_surface(path, Surface(mesh))
    assert ends.nodes[ends.tips][:, 2] == pytest.approx([-2.5, 2.5], abs=0.01)
    assert np.array_equal(ends.nodes[:3], path.nodes)
    early = tips_at_surface(path_in(mesh, [[0, 0, -2], [0, 0, 0], [0.3, 0, 1.0]]), Surface(mesh))
    # ahead it is 1.5 to the surface, more than two radii of 0.2, so the nearest point is taken
    assert np.linalg.norm(early.nodes[early.tips] - [0.5, 0, 1.0], axis=1).min() < 0.01
    point = Skeleton(np.zeros((1, 3)), [], [0.5], np.zeros(len(mesh.vertices)))
    assert tips_at_surface(point, Surface(mesh)) is point
