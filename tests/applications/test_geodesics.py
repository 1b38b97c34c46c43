"""Geodesic distance and extended values in one call: the same as the heat method's, for any kind of mesh."""

import numpy as np
import pytest

from lbskel import HeatMethod, MeshError, UnknownChoice, extend_values, geodesic_distance


def test_one_call_is_a_query_of_the_heat_method(ring):
    for operator in ("robust", "cotangent"):
        method = HeatMethod(ring, operator)
        assert np.array_equal(geodesic_distance(ring, [3, 50], operator=operator), method.distance([3, 50]))
        assert np.array_equal(extend_values(ring, [3, 50], [1, 2], operator=operator), method.extend([3, 50], [1, 2]))
    pair = (ring.vertices.tolist(), ring.faces.tolist())
    assert np.array_equal(geodesic_distance(pair, 3), geodesic_distance(ring, 3))
    assert np.array_equal(extend_values(pair, [3], [1.0]), extend_values(ring, [3], [1.0]))


def test_errors_are_those_of_the_heat_method(ring):
    with pytest.raises(MeshError, match="no vertices of the mesh"):
        geodesic_distance(ring, 10**6)
    with pytest.raises(UnknownChoice, match="operator 'smooth'"):
        extend_values(ring, [0], [1.0], operator="smooth")
