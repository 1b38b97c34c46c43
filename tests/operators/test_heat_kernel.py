"""The heat kernel: its scale, and the correction for its cut-off."""

import numpy as np
import pytest
from operator_shapes import hexagons
from scipy.spatial.transform import Rotation

from lbskel import Mesh, MeshError, PointCloud
from lbskel.operators import laplacian
from lbskel.operators.heat_kernel import heat_kernel, heat_kernel_stiffness


def test_the_cut_off_of_the_kernel_is_corrected():
    mesh, _ = hexagons(41, 0.02)
    x, y, _ = mesh.vertices.T
    middle = 20 * 41 + 20
    wide, narrow = (heat_kernel(mesh, time=4.0, cut_off=c).delta(x**2 + y**2)[middle] for c in (5.0, 2.0))
    assert abs(wide / -4 - 1) < 2e-3
    assert abs(narrow / -4 - 1) < 0.05  # a disc of radius 5.7 edges: its rim is counted to one in twenty
    kept = 1 - 3 * np.exp(-2)  # of |x|^2 within two standard deviations
    assert abs(narrow * kept / -4 - 1) > 0.3


def test_quadratics_on_regular_rings():
    mesh, inner = hexagons(41, 0.05)
    x, y, _ = mesh.vertices.T
    values, middle = 3 * x**2 + x * y - y**2, 20 * 41 + 20
    assert inner[middle]
    # the sum over a lattice is the integral up to exp(-(2 pi / h)^2 t), and what lies beyond the cut-off is known
    for time, cut_off in ((2.0, 4.0), (4.0, 3.0)):
        found = heat_kernel(mesh, time=time, cut_off=cut_off).delta(values)[middle]
        assert abs(found / -4 - 1) < 0.02  # the rim of a disc of 10 edges is counted to about one in fifty


def test_the_weight_of_two_points_is_the_kernel_times_their_areas():
    t, c, d = 0.3, 2.5, 0.8
    found = heat_kernel_stiffness(np.array([[0, 0, 0], [d, 0, 0]]), np.array([0.2, 0.7]), t, c).toarray()
    captured = 1 - (1 + c**2 / 2) * np.exp(-(c**2) / 2)
    weight = 0.2 * 0.7 * np.exp(-(d**2) / (4 * t)) / (4 * np.pi * t**2) / captured
    assert found == pytest.approx(weight * np.array([[1, -1], [-1, 1]]), rel=1e-14)
    # a pair farther apart than c sqrt(2 t) = 1.94 has no weight
    assert heat_kernel_stiffness(np.array([[0, 0, 0], [1.95, 0, 0]]), np.ones(2), t, c).nnz == 0
    assert heat_kernel_stiffness(np.array([[0, 0, 0], [1.93, 0, 0]]), np.ones(2), t, c).nnz == 4


def test_the_time_is_in_squared_median_edge_lengths_and_the_mass_barycentric():
    mesh = Mesh([[0, 0, 0], [4, 0, 0], [0, 3, 0], [0, 0, 0]], [[0, 1, 2], [0, 3, 0]])  # and edges without length
    L = heat_kernel(mesh, time=2.0, cut_off=4.0)
    assert L.treated_vertices.tolist() == [3]
    L = heat_kernel(Mesh(mesh.vertices[:3], mesh.faces[:1]), time=2.0, cut_off=4.0)
    assert L.mass.diagonal() == pytest.approx([2, 2, 2], rel=1e-14)
    t = 2.0 * 4.0**2  # the median of 3, 4 and 5
    captured = 1 - (1 + 4.0**2 / 2) * np.exp(-(4.0**2) / 2)
    weights = [-(2 * 2) * np.exp(-(d**2) / (4 * t)) / (4 * np.pi * t**2 * captured) for d in (4, 3, 5)]
    assert L.stiffness.toarray()[[0, 0, 1], [1, 2, 2]] == pytest.approx(weights, rel=1e-13)


def test_one_point_far_away_changes_nothing_and_is_listed_as_treated():
    mesh, _ = hexagons(21, 0.05)
    far = Mesh(np.concatenate([mesh.vertices, [[1e5, 0, 0]]]), np.concatenate([mesh.faces, [[0, 1, 441]]]))
    near, with_far = heat_kernel(mesh), heat_kernel(far)
    changed = np.flatnonzero(abs(with_far.stiffness[:-1, :-1] - near.stiffness).sum(axis=1) > 1e-12)
    around_the_face = (np.linalg.norm(mesh.vertices - mesh.vertices[:2].mean(axis=0), axis=1) < 0.3).nonzero()[0]
    assert set(changed.tolist()) <= set(around_the_face.tolist())  # the areas of its corners are larger
    assert with_far.treated_vertices.tolist() == [441]
    assert heat_kernel(Mesh([*mesh.vertices, [9, 9, 9]], mesh.faces)).treated_vertices.tolist() == []  # in no face
    cloud = laplacian(PointCloud(far.vertices), operator="heat_kernel")
    assert cloud.treated_vertices.tolist() == [441]
    assert cloud.stiffness.nnz < 1.1 * near.stiffness.nnz


def test_no_point_of_a_lattice_is_at_the_cut_off():
    """The rounding of a rotation must not decide about a pair."""
    g = np.stack(np.meshgrid(np.arange(20.0), np.arange(20.0), [0.0]), -1).reshape(-1, 3)
    for points in (g, hexagons(12, 1.0)[0].vertices):
        turned = Rotation.random(random_state=0).apply(points.copy())
        one, other = (laplacian(PointCloud(P), operator="heat_kernel").stiffness for P in (points, turned))
        assert one.nnz == other.nnz
        assert abs(one - other).max() < 1e-12 * abs(one).max()


def test_a_kernel_that_would_couple_too_many_pairs_is_refused(monkeypatch):
    points = np.random.default_rng(0).random((200, 3))
    monkeypatch.setattr("lbskel.operators.heat_kernel.MAX_PAIRS", 19_899)
    with pytest.raises(MeshError, match=r"19,900 pairs of 200 points.*smaller time.*'robust'"):
        heat_kernel_stiffness(points, np.ones(200), 10.0, 3.0)
    assert heat_kernel_stiffness(points, np.ones(200), 1e-4, 3.0).nnz < 2000
