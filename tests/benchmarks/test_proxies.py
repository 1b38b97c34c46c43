"""The benchmark of proxies: other proxies are used while they are measured, and the means of a row."""

import pytest

from benchmarks import proxies
from lbskel.preprocess import proxy, simplify_to_proxy
from lbskel.shapes import torus, vessel_tree


@pytest.mark.parametrize("value", [proxies.QUADRICS, 0.2, 0.4])
def test_other_proxies_are_made(value):
    mesh, usual = torus(1.0, 0.015, 3000, 48), proxy.SHORT_EDGE
    n_faces = len(simplify_to_proxy(mesh).mesh.faces)
    with proxies._proxies(value):
        other = simplify_to_proxy(mesh)
    assert len(other.mesh.faces) != n_faces
    assert ("as the local radii allow" in other.report["steps"][0]["notes"][0]) == (value != proxies.QUADRICS)
    assert usual == proxy.SHORT_EDGE


def test_a_row_has_the_sums_and_means_of_its_shapes():
    row = proxies._row([vessel_tree(3, seed=seed) for seed in (0, 1)], 0.375)
    assert row["tips"] == "10/10"
    assert row["sections"] == "14/14"
    assert (row["sections off"], row["tips found"], row["failed"]) == (0, 1, 0)
    assert 0 < row["accuracy"] < 0.05
