"""Every kind of damage through spectrum and geodesics: a finite result or a typed error, and nothing silent."""

from contextlib import suppress

import numpy as np
import pytest

import lbskel
from benchmarks.damage import DAMAGE, damaged
from lbskel import LbskelError
from lbskel.shapes import torus


def signatures(mesh):
    basis = lbskel.spectral_basis(mesh, 8)
    assert np.abs(basis.gram() - np.eye(len(basis.values))).max() < 1e-6  # soup loses digits, see MASS_FLOOR
    yield basis.values
    yield lbskel.heat_kernel_signature(basis)
    yield lbskel.wave_kernel_signature(basis)


def compressions(mesh):
    for basis in lbskel.BASES:
        yield lbskel.compress(mesh, min(25, len(mesh.vertices)), basis=basis).mesh.vertices


def distances(mesh):
    method = lbskel.HeatMethod(mesh)
    source = int(mesh.faces[0, 0])
    distance = method.distance(source)
    near = np.isfinite(distance)
    assert distance[source] == 0
    assert set(mesh.component_of_vertex[near]) == {mesh.component_of_vertex[source]}
    yield distance[near]
    yield method.extend([source], [1.0])[near]


def mesh_of(kind, folder):
    broken = damaged(kind, torus(1.0, 0.3, 16, 8))
    if broken.extension:
        path = folder / f"mesh.{broken.extension}"
        path.write_bytes(broken.data)
        return lbskel.as_mesh(path)
    return lbskel.as_mesh((broken.vertices, broken.faces))


@pytest.mark.parametrize("kind", DAMAGE)
@pytest.mark.parametrize("application", [signatures, compressions, distances], ids=lambda each: each.__name__)
def test_damage_gives_a_finite_result_or_a_typed_error(kind, application, tmp_path):
    with suppress(LbskelError):
        for result in application(mesh_of(kind, tmp_path)):
            assert np.isfinite(result).all()
