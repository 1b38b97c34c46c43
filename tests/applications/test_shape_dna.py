"""Shape-DNA: isometric shapes of any size are alike, others are told apart."""

import numpy as np
import pytest

from lbskel import MeshError, shape_dna_distance, spectral_basis
from lbskel.shapes import sphere, torus


@pytest.mark.parametrize("operator", ["robust", "inverse_distance", "mean_value_symmetric"])
def test_size_and_place_do_not_count_and_shape_does(operator):
    ring = torus(1.0, 0.3, 24, 12)
    one = spectral_basis(ring, 20, operator=operator)
    turned = ring.with_vertices(7.0 * ring.vertices[:, [1, 2, 0]] + 3.0)
    same = spectral_basis(turned, 20, operator=operator)
    other = spectral_basis(torus(1.0, 0.4, 24, 12), 20, operator=operator)
    assert shape_dna_distance(one, same) < 1e-8
    assert shape_dna_distance(one, other) > 1.0
    assert shape_dna_distance(one, other) == shape_dna_distance(other, one)


def test_the_distance_is_that_of_areas_times_values_over_their_numbers():
    a, b = spectral_basis(sphere(3), 9), spectral_basis(torus(1.0, 0.3), 12)
    expected = sum(((a.values[i] * a.area - b.values[i] * b.area) / (i + 1)) ** 2 for i in range(9)) ** 0.5
    assert shape_dna_distance(a, b) == pytest.approx(expected, rel=1e-12)


def test_a_spectrum_of_zeros_is_refused():
    with pytest.raises(MeshError, match="positive eigenvalues"):
        shape_dna_distance(spectral_basis(sphere(2), 1), spectral_basis(sphere(2), 5))
    assert np.isfinite(spectral_basis(sphere(2), 1).values).all()
