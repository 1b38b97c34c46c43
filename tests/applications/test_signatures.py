"""Heat and wave kernel signatures: closed forms on the sphere, sums, invariances."""

import numpy as np
import pytest
from helpers import joined, moved

from lbskel import MeshError, heat_kernel_signature, spectral_basis, wave_kernel_signature
from lbskel.shapes import sphere, torus


@pytest.fixture(scope="module")
def ring_basis():
    return spectral_basis(torus(1.0, 0.3, 24, 12), 40)


def test_heat_on_the_sphere_is_the_sum_over_degrees():
    """By the addition theorem the sum of x^2 over the degree l is (2 l + 1) / 4 pi at every vertex."""
    basis = spectral_basis(sphere(4), 36)
    times = np.array([0.5, 1.0, 3.0])
    degrees = np.arange(6)
    exact = ((2 * degrees + 1) @ np.exp(-np.outer(degrees * (degrees + 1), times))) / (4 * np.pi)
    found = heat_kernel_signature(basis, times)
    assert (
        np.abs(found - exact).max() < 0.01 * exact.max()
    )  # h^2 = 0.005, some times for areas of faces below those of the sphere


def test_signatures_integrate_to_the_trace_and_to_one(ring_basis):
    masses = ring_basis.mass.diagonal()
    times = np.array([0.0, 0.1, 2.0])
    trace = np.exp(-np.outer(ring_basis.values, times)).sum(axis=0)
    assert np.abs(masses @ heat_kernel_signature(ring_basis, times) - trace).max() < 1e-9
    assert np.abs(masses @ wave_kernel_signature(ring_basis) - 1.0).max() < 1e-10


def test_a_wave_kernel_of_small_width_is_the_square_of_one_function():
    basis = spectral_basis(sphere(3).with_vertices(sphere(3).vertices * [1.0, 1.3, 1.7]), 8)
    levels = np.log(basis.values[1:])
    found = wave_kernel_signature(basis, levels, width=1e-3)
    assert np.abs(found - basis.functions[:, 1:] ** 2).max() < 1e-10  # levels differ by far more than the width
    far = wave_kernel_signature(basis, [levels[-1] + 1e3], width=1e-3)[:, 0]
    assert np.abs(far - basis.functions[:, -1] ** 2).max() < 1e-10


def test_default_scales_follow_the_spectrum(ring_basis):
    heat = heat_kernel_signature(ring_basis)
    assert heat.shape == (288, 100)
    first, last = 4 * np.log(10) / ring_basis.values[[-1, 1]]
    assert np.array_equal(heat, heat_kernel_signature(ring_basis, np.geomspace(first, last, 100)))
    assert wave_kernel_signature(ring_basis).shape == (288, 100)


def test_scaling_and_order_of_vertices():
    mesh = torus(1.0, 0.3, 24, 12)
    order = np.random.default_rng(3).permutation(288)
    place = np.argsort(order)
    changed = type(mesh)(5.0 * mesh.vertices[order], place[mesh.faces])
    # as many functions as end between two eigenvalues: sums over a whole eigenspace do not depend on its basis
    k = next(k for k in range(20, 30) if np.diff(spectral_basis(mesh, k + 1).values)[-1] > 0.1)
    one, other = spectral_basis(mesh, k), spectral_basis(changed, k)
    for signature in (heat_kernel_signature, wave_kernel_signature):
        assert np.abs(25 * signature(other) - signature(one)[order]).max() < 1e-8 * signature(one).max()


def test_several_components_have_several_zeros(ring_basis):
    ring = torus(1.0, 0.3, 24, 12)
    two = spectral_basis(joined(ring, moved(ring, 5.0)), 20)
    assert np.isfinite(heat_kernel_signature(two)).all()
    assert np.isfinite(wave_kernel_signature(two)).all()
    late = heat_kernel_signature(two, [1e6])[:, 0]
    assert np.abs(late * ring.area - 1.0).max() < 1e-3  # the heat of each spreads over it alone; its area is mollified


def test_what_cannot_be_is_refused(ring_basis):
    with pytest.raises(MeshError, match="negative"):
        heat_kernel_signature(ring_basis, [-1.0])
    with pytest.raises(MeshError, match="finite"):
        heat_kernel_signature(ring_basis, [np.nan])
    with pytest.raises(MeshError, match="list of"):
        wave_kernel_signature(ring_basis, 3.0)
    with pytest.raises(MeshError, match="width"):
        wave_kernel_signature(ring_basis, [1.0])
    with pytest.raises(MeshError, match="more than there are components"):
        heat_kernel_signature(spectral_basis(sphere(2), 1))
    for wrong in (["a"], [1j]):
        with pytest.raises(MeshError, match="list of finite numbers"):
            heat_kernel_signature(ring_basis, wrong)
    with pytest.raises(MeshError, match="width"):
        wave_kernel_signature(ring_basis, width="wide")


@pytest.mark.parametrize(("operator", "power"), [("robust", 2), ("inverse_distance", 1), ("random_walk", 0)])
def test_signatures_are_in_units_of_one_over_a_mass(operator, power):
    mesh = torus(1.0, 0.3, 24, 12)
    one, other = (spectral_basis(each, 9, operator=operator) for each in (mesh, mesh.with_vertices(4 * mesh.vertices)))
    for signature in (heat_kernel_signature, wave_kernel_signature):
        assert np.abs(4.0**power * signature(other) - signature(one)).max() < 1e-9 * signature(one).max()
