"""Stop rules: that of rings, and its names."""

import numpy as np
import pytest

from lbskel import PointCloud, Status
from lbskel.contraction.settings import STOP_RULES
from lbskel.contraction.stop_rules import RULES
from lbskel.operators.star_rings import stars_in_order
from lbskel.shapes import sphere

STARS = stars_in_order(PointCloud(sphere(2).vertices))


def test_settings_name_every_rule():
    assert set(RULES) == set(STOP_RULES)


@pytest.mark.parametrize(
    ("before", "after", "fault"),
    [
        (1.0, 0.5, None),
        (0.5, 0.489, None),
        (0.5, 0.491, Status.RINGS),
        (0.5, 0.6, Status.RINGS),
        (1.0, 1.25, Status.BOX_GREW),
    ],
)
def test_rings_must_lose_a_hundredth_of_their_first_length(before, after, fault):
    meshes = (STARS, *(STARS.with_vertices(STARS.vertices * factor) for factor in (before, after)))
    assert RULES["rings"].fault(None, None, *meshes) is fault


def test_one_longer_side_of_the_box_is_enough():
    grown = STARS.vertices * [0.1, 0.1, 1.25]
    assert RULES["rings"].fault(None, None, STARS, STARS, STARS.with_vertices(grown)) is Status.BOX_GREW
    assert RULES["rings"].completion(None, None, None) is None


def test_a_point_without_a_star_does_not_count():
    far = PointCloud(np.concatenate([STARS.vertices, [[9.0, 0, 0]]]))
    stars = stars_in_order(far)
    assert RULES["rings"].fault(None, None, stars, stars, stars.with_vertices(stars.vertices * 0.5)) is None
