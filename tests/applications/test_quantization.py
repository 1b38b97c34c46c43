"""High-pass quantization: rounding, rates, error bounds, and normals better than those of rounded positions."""

import numpy as np
import pytest

from lbskel import UnknownChoice, laplacian, quantize_deltas
from lbskel.applications.quantization import coded_bits, round_to_bits


def test_rounding_is_off_by_half_a_step_at_most():
    values = np.random.default_rng(0).standard_normal((500, 3)) * [1, 5, 2]
    codes, rounded = round_to_bits(values, 7)
    step = np.ptp(values, axis=0).max() / 127
    assert np.abs(rounded - values).max() <= step / 2 * (1 + 1e-12)
    assert (codes.min(), codes.max()) == (0, 127)
    constant = np.full((4, 2), 3.5)
    assert (round_to_bits(constant, 4)[1] == constant).all()


def test_the_rate_is_that_of_digits_and_signs_and_of_their_number():
    assert coded_bits(np.array([[0, -1], [0, 1], [4, 1], [-7, 1]])) == (1 + (0 + 0 + 3 + 3) / 4) + (0 + 1)
    assert coded_bits(np.zeros((5, 2), dtype=np.int64)) == 0.0


@pytest.mark.parametrize("bits", [4, 10, 24, 31])
def test_the_rate_is_near_the_entropy_of_the_distribution_though_all_codes_are_different(bits):
    random = np.random.default_rng(0)
    uniform = random.integers(-(2**bits), 2**bits, (400, 1))
    normal = np.rint(2**bits * random.standard_normal((400, 1))).astype(np.int64)
    assert coded_bits(uniform) == pytest.approx(bits + 1, abs=0.3)
    assert coded_bits(normal) == pytest.approx(bits + np.log2(2 * np.pi * np.e) / 2, abs=0.3)


def test_the_error_keeps_its_bound_and_falls_with_bits_and_anchors(ring):
    S = laplacian(ring, operator="graph").stiffness.toarray()
    previous = np.inf
    for bits, n in ((6, 1), (6, 10), (8, 10), (8, 60), (12, 60)):
        result = quantize_deltas(ring, bits=bits, n_anchors=n)
        rounding = round_to_bits(S @ ring.vertices, bits)[1] - S @ ring.vertices
        sigma = np.linalg.svd(np.concatenate([S, np.eye(len(S))[result.anchors]]), compute_uv=False)[-1]
        error = np.linalg.norm(result.mesh.vertices - ring.vertices)
        assert error <= np.linalg.norm(rounding) / sigma * (1 + 1e-6)
        assert error < previous
        previous = error


def test_normals_are_better_than_those_of_positions_at_the_same_bits(tripod):
    rounded = tripod.with_vertices(round_to_bits(tripod.vertices, 7)[1])
    encoded = quantize_deltas(tripod, bits=7, n_anchors=10)
    assert encoded.bits_per_vertex < 21 + 10 * 107 / len(tripod.vertices)
    errors = [
        np.degrees(np.arccos(np.einsum("mx,mx->m", mesh.face_normals, tripod.face_normals).clip(-1, 1))).mean()
        for mesh in (encoded.mesh, rounded)
    ]
    assert errors[0] < 0.5 * errors[1]


@pytest.mark.parametrize("options", [{"bits": 0}, {"bits": 40}, {"n_anchors": 0}, {"anchor_weight": -1.0}])
def test_wrong_options_are_named(tripod, options):
    with pytest.raises(UnknownChoice):
        quantize_deltas(tripod, **options)


@pytest.mark.parametrize("operator", ["graph", "inverse_distance", "mean_value", "mean_value_symmetric"])
def test_the_surface_does_not_depend_on_the_unit(tripod, operator):
    found = []
    for scale in (1.0, 1e-6):
        mesh = tripod.with_vertices(scale * tripod.vertices)
        found.append(quantize_deltas(mesh, bits=10, n_anchors=12, operator=operator).mesh.vertices / scale)
    assert found[1] == pytest.approx(found[0], abs=1e-7)  # the system's condition number is about 1e9
