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


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([], "the cloud is empty: there are no points"),
        ([[0, 0]], "must have shape"),
        ([[0, 0, np.nan]], "points 0 have NaN or infinite coordinates, counted from 0; remove them$"),
        ([[0, 0, np.inf]], "remove them$"),
    ],
)
def test_what_is_no_cloud_is_refused(points, message):
    with pytest.raises(MeshError, match=message):
        PointCloud(points)
