"""Bodies of voxels: which voxels they consist of, and where their surface lies."""

import json

import numpy as np
import pytest

from benchmarks import voxels
from benchmarks.voxels import voxel_body
from lbskel import Mesh, Skeleton, prepare
from lbskel.preprocess.proxy import MAX_FACES, face_budget
from lbskel.shapes import tube_mesh
from lbskel.skeleton.edge_distances import nearest_on_edges


def test_the_surface_of_voxels_lies_between_those_inside_and_outside_a_tube():
    shape = tube_mesh(Skeleton([[0, 0, 0], [0, 0, 9], [5, 0, 15]], [[0, 1], [1, 2]], [2.0, 2.0, 2.0]))
    body, step = voxel_body(shape, 0.4), 0.4 * 2.0
    assert (body.mesh.is_closed_manifold, body.mesh.n_components, body.mesh.genus) == (True, 1, 0)
    halves = 2 * (body.mesh.vertices - body.mesh.vertices[0]) / step
    assert halves == pytest.approx(np.rint(halves), abs=1e-6)  # centers of voxels, and middles between them
    to_axis, _, radii = nearest_on_edges(
        Skeleton(shape.truth.nodes, shape.truth.edges, shape.truth.radii), body.mesh.vertices
    )
    assert np.abs(to_axis - radii).max() <= 0.5 * step * (1 + 1e-9)
    assert np.abs(to_axis - radii).mean() > 0.1 * step  # steps
    assert body.truth is shape.truth


@pytest.mark.parametrize(("scale", "offset"), [(1.7, 0.0), (1 / 3.3, 0.0), (1.0, 100.1)])
def test_a_mesh_of_voxels_has_the_same_proxy_in_any_unit_and_place(scale, offset):
    """Its edges are alike: rounding errors would decide which collapse, and which faces rays along edges hit."""
    nodes = [[0, 0, 0], [0, 0, 9], [5, 2, 15], [-5, 0, 15], [9, 4, 20], [5, -4, 20]]
    tubes = tube_mesh(Skeleton(nodes, [[0, 1], [1, 2], [1, 3], [2, 4], [2, 5]], [1.0, 1.0, 0.7, 0.7, 0.5, 0.5]))
    mesh = voxel_body(tubes, 0.22).mesh
    assert len(mesh.faces) > MAX_FACES
    bodies = [prepare(Mesh(s * mesh.vertices + o, mesh.faces)).bodies[0] for s, o in ((1.0, 0.0), (scale, offset))]
    assert face_budget(bodies[0].mesh) == face_budget(bodies[1].mesh)
    one, other = (body.proxy.mesh for body in bodies)
    assert len(one.faces) < len(mesh.faces)
    assert np.array_equal(one.faces, other.faces)
    assert other.vertices == pytest.approx(one.vertices, abs=1e-12)


def test_the_benchmark_counts_proxies_and_graphs_in_all_places(tmp_path, monkeypatch):
    for name, value in (("EXPONENTS", (-30,)), ("SMALL", (2, 0.3)), ("LARGE", (4, 0.25))):
        monkeypatch.setattr(voxels, name, value)
    voxels.run(True, tmp_path)
    tables = json.loads((tmp_path / "voxels.json").read_text())
    for row in (*tables["rounding"], *tables["short edges"]):
        assert (row["ROUNDING"], row["bodies"], row["proxies"], row["graphs"]) == ("2^-30", 1, 1, 1)
        assert 0 < row["accuracy"] < 0.2
    assert "## Rounding of coordinates, in four places" in (tmp_path / "voxels.md").read_text()
