"""The view in which limbs hide one another least."""

import numpy as np
import pytest
from helpers import box_mesh, joined, planar_fork

from lbskel import PointCloud
from lbskel.shapes import make, torus
from lbskel.visualization.camera import principal_view
from lbskel.visualization.viewpoint import turned, unobstructed_view


def legs():
    """A broad plate on four legs, two behind the others."""
    legs = [box_mesh([0.3, 1.6, 0.1], [x, -0.9, z]) for x in (-1.5, 1.5) for z in (-0.5, 0.5)]
    return joined(box_mesh([4, 0.3, 1.2]), *legs)


def test_legs_that_hide_one_another_are_seen_from_the_side():
    """Seen along z, the legs of each pair cover each other; the direction chosen keeps them a leg apart or more."""
    mesh = legs()
    side, view = principal_view(mesh), unobstructed_view(mesh)
    np.testing.assert_allclose(side.axes[2], [0, 0, 1], atol=1e-9)
    near, far = np.array([[1.5, -0.9, 0.5], [1.5, -0.9, -0.5]])
    assert np.linalg.norm((side.project(near[None]) - side.project(far[None]))[0, :2]) < 1e-9
    assert np.linalg.norm((view.project(near[None]) - view.project(far[None]))[0, :2]) > 0.3
    assert view.axes[2] @ side.axes[2] > np.cos(np.radians(46))
    np.testing.assert_allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(view.axes) == pytest.approx(1)
    assert view.axes[2][1] >= 0  # from above, if at all
    assert view.axes[1][1] > 0.9


@pytest.mark.parametrize("shape", [torus(1.0, 0.3), PointCloud(torus(1.0, 0.3).vertices), planar_fork()])
def test_what_lies_in_a_plane_is_seen_across_it(shape):
    assert np.array_equal(unobstructed_view(shape).axes, principal_view(shape).axes)


def test_size_and_place_do_not_matter():
    mesh = make("tree", n_vertices=1500).mesh
    moved = mesh.with_vertices(mesh.vertices * 1e-3 + [5, 6, 7])
    np.testing.assert_allclose(unobstructed_view(moved).axes, unobstructed_view(mesh).axes, atol=1e-6)


def test_a_view_turned_by_90_degrees_is_that_of_the_side():
    """What pointed to the right points at the viewer or away; the vertical axis stays."""
    view = principal_view(legs())
    side = turned(view, 90)
    np.testing.assert_allclose(side.axes[1], view.axes[1], atol=1e-12)
    np.testing.assert_allclose(np.abs(side.axes @ view.axes.T)[[0, 2]], [[0, 0, 1], [1, 0, 0]], atol=1e-12)
