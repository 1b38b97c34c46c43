"""Point clouds: what they hold, and what is refused."""

import numpy as np
import pytest

from lbskel import MeshError, PointCloud


def test_points_are_kept_and_cannot_be_changed():
    given = [[0, 0, 0], [1, 2, 3]]
    cloud = PointCloud(given)
    assert np.array_equal(cloud.points, given)
    assert cloud.points.dtype == np.float64
    assert repr(cloud) == "PointCloud(2 points)"
    with pytest.raises(ValueError, match="read-only"):
        cloud.points[0] = 1


@pytest.mark.parametrize("points", [[], [[0, 0]], [[0, 0, np.nan]], [[0, 0, np.inf]]])
def test_what_is_no_cloud_is_refused(points):
    with pytest.raises(MeshError):
        PointCloud(points)
