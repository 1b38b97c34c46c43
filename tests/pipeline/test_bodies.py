"""The skeleton of one body: the stages in their order, and the full surface where the proxy loses a handle."""

from dataclasses import replace

import numpy as np
import pytest

import lbskel.pipeline.bodies as bodies
from lbskel import PRESETS, Contraction, Mesh, MeshError, Status, collapse, contract, prepare, refine, to_skeleton
from lbskel.geometry.vertex_map import VertexMap
from lbskel.pipeline.bodies import skeletonize_body
from lbskel.pipeline.profiling import StageTimer
from lbskel.preprocess.simplification import simplify
from lbskel.shapes import capsule, torus

SETTINGS = PRESETS["curvature_flow"]


@pytest.fixture(scope="module")
def body():
    """A torus of 3,200 faces with a proxy of 800."""
    [whole] = prepare(torus(1.0, 0.3, 64, 25)).bodies
    return replace(whole, proxy=simplify(whole.mesh, target_faces=800))


def test_a_collapsed_graph_becomes_a_skeleton_without_radii(ring):
    graph = collapse(contract(ring))
    skeleton = to_skeleton(graph)
    assert np.array_equal(skeleton.nodes, graph.nodes)
    assert np.array_equal(skeleton.node_of_vertex, graph.node_of_vertex)
    assert (skeleton.radii == 0).all()


def test_a_body_whose_handles_are_kept_is_contracted_once(body):
    assert len(body.proxy.mesh.faces) < len(body.mesh.faces)
    timer = StageTimer()
    skeleton, report = skeletonize_body(body, SETTINGS, refine, timer)
    direct = refine(to_skeleton(collapse(contract(body.proxy.mesh, SETTINGS))), body)
    assert np.array_equal(skeleton.nodes, direct.nodes)
    assert skeleton.cycle_rank == body.mesh.genus == 1
    assert not [note for note in report["notes"] if "contracted in full" in note]


def losing_the_handle_of(n_faces):
    """A refinement that opens the ring that comes from a surface of so many faces, and keeps others."""

    def refine_badly(skeleton, body):
        refined = refine(skeleton, body)
        return replace(refined, edges=refined.edges[1:]) if len(body.proxy.mesh.faces) == n_faces else refined

    return refine_badly


def test_a_lost_handle_is_found_on_the_full_surface(body):
    n_faces = len(body.proxy.mesh.faces)
    skeleton, report = skeletonize_body(body, SETTINGS, losing_the_handle_of(n_faces), StageTimer())
    assert skeleton.cycle_rank == 1
    assert len(skeleton.node_of_vertex) == len(body.mesh.vertices)
    assert report["notes"][-1] == "contracted in full, since the proxy kept 0 cycles of 1"
    assert report["proxy_faces"] == report["faces"] if "proxy_faces" in report else True


def test_where_there_is_no_proxy_or_no_time_the_first_skeleton_stays(body, monkeypatch):
    [full] = prepare(body.mesh, simplify="none").bodies
    skeleton, report = skeletonize_body(full, SETTINGS, losing_the_handle_of(len(full.mesh.faces)), StageTimer())
    assert skeleton.cycle_rank == 0
    assert not [note for note in report["notes"] if "contracted in full" in note]
    timer = StageTimer()
    monkeypatch.setattr(timer.__class__, "has_time_for", lambda self, stage: stage == "contract")
    calls = []
    monkeypatch.setattr(bodies, "contract", lambda *args, **options: calls.append(1) or contract(*args, **options))
    skeleton, _ = skeletonize_body(body, SETTINGS, losing_the_handle_of(len(body.proxy.mesh.faces)), timer)
    assert (skeleton.cycle_rank, len(calls)) == (0, 1)


@pytest.mark.parametrize(("status", "is_collapsed"), [(Status.AREA_GREW, True), (Status.TIME_LIMIT, False)])
def test_a_large_body_that_was_not_contracted_is_collapsed_unless_the_time_is_over(
    status, is_collapsed, body, monkeypatch
):
    monkeypatch.setattr(bodies, "MAX_FACES", 100)

    def fail(mesh, settings, time_limit):
        return Contraction(mesh, mesh, VertexMap.identity(len(mesh.vertices)), (), status)

    monkeypatch.setattr(bodies, "contract", fail)
    timer = StageTimer()
    skeleton, report = skeletonize_body(body, SETTINGS, refine, timer)
    assert ((skeleton.cycle_rank == 1), "collapse" in timer.skipped) == (is_collapsed, not is_collapsed)
    assert report["status"] == status.value


def test_contraction_may_take_half_of_the_time_left(body, monkeypatch):
    limits = []
    monkeypatch.setattr(
        bodies,
        "contract",
        lambda *args, time_limit: limits.append(time_limit) or contract(*args, time_limit=time_limit),
    )
    for time_limit in (None, 1e9):
        skeletonize_body(body, SETTINGS, losing_the_handle_of(0), StageTimer(time_limit=time_limit))
    assert limits[0] is None
    assert 4e8 < limits[-1] <= 5e8


def test_vertices_in_no_face_are_named():
    rod = capsule(3.0, 0.4, 8)
    stray = Mesh(np.concatenate([rod.vertices, [[5, 5, 5]]]), rod.faces)
    with pytest.raises(MeshError, match=r"has 1 vertex in no face, .* a body from lbskel.prepare"):
        to_skeleton(collapse(contract(stray)))
