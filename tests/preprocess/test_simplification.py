"""Simplification: fewer faces, the same topology and surface, and an exact vertex map."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import patches_are_connected
from scipy.spatial.transform import Rotation

from lbskel import Mesh, UnknownChoice, skeletonize
from lbskel.geometry.surface_queries import Proxy, Surface
from lbskel.preprocess import simplification, simplify
from lbskel.preprocess.result import hausdorff_distance
from lbskel.preprocess.simplification import _vertex_map_of_collapses, fewest_faces
from lbskel.shapes import capsule, chain_of_tori, cylinder, lattice, make, sphere, torus
from lbskel.shapes.primitives import join_rings

SHAPES = {
    "torus": torus(1.0, 0.3, 96, 40),
    "tori": chain_of_tori(3),
    "capsule": capsule(3.0, 0.4, 60),
    "cylinder": cylinder(0.4, 3.0, 60, 61),
}


@pytest.mark.parametrize("name", SHAPES)
def test_fewer_faces_of_the_same_topology(name):
    mesh = SHAPES[name]
    simple = simplify(mesh, target_faces=len(mesh.faces) // 4)
    assert len(simple.mesh.faces) <= 1.1 * len(mesh.faces) // 4
    assert simple.mesh.euler_characteristic == mesh.euler_characteristic
    assert simple.mesh.n_components == 1
    assert simple.mesh.genus == mesh.genus
    assert simple.mesh.is_closed == mesh.is_closed
    assert "simplified" in simple.notes[0]


@pytest.mark.parametrize("name", SHAPES)
def test_the_map_is_local_and_complete(name):
    mesh = SHAPES[name]
    simple = simplify(mesh, target_faces=len(mesh.faces) // 4)
    assert simple.vertex_map.indices.shape == (len(mesh.vertices),)
    assert set(simple.vertex_map.indices) == set(range(len(simple.mesh.vertices)))
    start, end = simple.mesh.vertices[simple.mesh.edges].transpose(1, 0, 2)
    longest = np.linalg.norm(end - start, axis=1).max()
    # a vertex is merged into a corner of the triangle that now covers it
    assert np.linalg.norm(simple.mesh.vertices[simple.vertex_map.indices] - mesh.vertices, axis=1).max() < 1.5 * longest
    i, j = simple.vertex_map.indices[mesh.edges].T
    pairs = {tuple(edge) for edge in simple.mesh.edges.tolist()}
    assert all(a == b or (min(a, b), max(a, b)) in pairs for a, b in zip(i.tolist(), j.tolist(), strict=True))


def test_the_simplified_surface_stays_close():
    mesh = sphere(5)
    simple = simplify(mesh, target_faces=2000)
    # of 2000 uneven faces the longest edges are 0.2 long: chords and overshoot of h^2 / 8 each
    assert Surface(mesh).distance(simple.mesh.vertices).max() < 2 * 0.2**2 / 8


@pytest.mark.parametrize(("scale", "offset"), [(1.0, 1e5), (1e-9, 0.0), (1e30, 0.0), (1e-120, 0.0)])
def test_the_same_edges_collapse_anywhere_and_in_any_unit(scale, offset):
    """Far from the origin single precision tells no vertices apart, and thresholds of the library have no unit."""
    mesh = SHAPES["torus"]
    here = simplify(mesh, target_faces=1000)
    there = simplify(mesh.with_vertices(scale * mesh.vertices + offset), target_faces=1000)
    assert np.array_equal(there.mesh.faces, here.mesh.faces)
    assert np.array_equal(there.vertex_map.indices, here.vertex_map.indices)
    # two roundings in single precision, those of offsets in double
    assert np.abs((there.mesh.vertices - offset) / scale - here.mesh.vertices).max() < 1e-6


def test_the_same_edges_collapse_however_a_mesh_is_turned():
    """The unit was taken from the bounding box, which a rotation changes: other proxies, and other skeletons."""
    mesh = make("limbs", n_vertices=3000).mesh  # without ties, which a regular mesh has
    turned = mesh.with_vertices(mesh.vertices @ Rotation.from_euler("xyz", [20, 30, 40], degrees=True).as_matrix().T)
    here, there = (simplify(each, target_faces=2000) for each in (mesh, turned))
    assert np.array_equal(there.mesh.faces, here.mesh.faces)


def test_a_far_vertex_without_a_face_changes_nothing():
    mesh = SHAPES["torus"]
    here = simplify(mesh, target_faces=1000)
    there = simplify(Mesh([*mesh.vertices, [1e12, 0.0, 0.0]], mesh.faces), target_faces=1000)
    assert np.array_equal(there.mesh.faces, here.mesh.faces)
    assert np.array_equal(there.vertex_map.indices[:-1], here.vertex_map.indices)


def test_a_mesh_below_the_target_is_returned_unchanged():
    mesh = sphere(2)
    same = simplify(mesh, target_faces=10_000)
    assert same.mesh is mesh
    assert np.array_equal(same.vertex_map.indices, np.arange(len(mesh.vertices)))


def test_a_mesh_whose_topology_forbids_the_target_is_returned_unchanged():
    mesh = chain_of_tori(3)
    same = simplify(mesh, target_faces=30)  # three handles of this shape need more faces than that
    assert same.mesh is mesh
    assert "without changing the topology" in same.notes[0]


def test_a_target_must_be_positive():
    with pytest.raises(UnknownChoice, match=r"positive whole number, not 100\.5"):
        simplify(SHAPES["torus"], target_faces=100.5)
    with pytest.raises(UnknownChoice, match="positive"):
        simplify(sphere(2), target_faces=0)


def test_the_choice_of_a_target_is_told_by_step_and_syntax():
    for options in ({}, {"target_faces": 100, "error": 0.1}):
        with pytest.raises(UnknownChoice, match=r"simplify:target_faces=2000 or simplify:error=0\.01"):
            simplify(sphere(2), **options)


def test_an_error_bound_that_spares_no_face_is_noted():
    result = simplify(sphere(2), error=1e-9)
    assert result.notes == ("320 faces were not simplified: none could be spared with error=1e-09",)


def test_the_skeleton_of_a_proxy_is_that_of_the_full_mesh(monkeypatch):
    mesh = torus(1.0, 0.3, 96, 40)
    full = skeletonize(mesh, simplify="none")
    monkeypatch.setattr("lbskel.preprocess.proxy.MAX_FACES", 1500)
    proxy = skeletonize(mesh)
    assert "simplified" in proxy.report["components"][0]["notes"][0]
    assert full.report["components"][0]["notes"] == []
    assert (proxy.cycle_rank, len(proxy.tips)) == (full.cycle_rank, len(full.tips)) == (1, 0)
    assert len(proxy.node_of_vertex) == len(mesh.vertices)
    # both are refined against the same surface, so they differ only in where nodes lie along the circle
    for skeleton in (full, proxy):
        assert np.abs(np.hypot(*skeleton.nodes[:, :2].T) - 1).max() < 0.02
    near = np.linalg.norm(proxy.nodes[proxy.node_of_vertex] - mesh.vertices, axis=1)
    assert near.max() < 1.1 * 0.3 * 1.05  # the nearest node is half a spacing away along the circle


def test_unused_vertices_are_mapped_to_nodes():
    mesh = sphere(4)
    more = Mesh(np.concatenate([mesh.vertices, [[9.0, 9, 9]]]), mesh.faces)
    assert len(skeletonize(more).node_of_vertex) == len(more.vertices)
    skeleton = skeletonize(more, preprocess="simplify:target_faces=1000")
    distances = np.linalg.norm(skeleton.nodes - 9.0, axis=1)  # of two nodes at one place in a ball, either is nearest
    assert distances[skeleton.node_of_vertex[-1]] == distances.min()


def test_unused_vertices_are_not_mapped_to_other_vertices():
    mesh = sphere(4)
    more = Mesh(np.concatenate([[[9.0, 9, 9]], mesh.vertices]), mesh.faces + 1)
    simple = simplify(more, target_faces=1000)
    assert len(simple.mesh.faces) <= 1100
    assert simple.vertex_map.indices[0] == -1
    assert (simple.vertex_map.indices[1:] >= 0).all()


def test_a_vertex_without_remaining_faces_is_not_mapped():
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    assert _vertex_map_of_collapses(np.array([[3, 4]]), faces, 6).tolist() == [0, 1, 2, -1, -1, -1]
    assert _vertex_map_of_collapses(np.array([[1, 0], [2, 1]]), faces, 6).tolist() == [-1, -1, -1, 0, 1, 2]


@pytest.mark.parametrize("name", SHAPES)
def test_inside_tests_with_a_proxy_agree_with_the_mesh(name):
    mesh = SHAPES[name]
    simple = simplify(mesh, target_faces=len(mesh.faces) // 4)
    deviation = 2 * simple.report["steps"][0]["deviation"]
    kept = np.zeros(len(simple.mesh.vertices), dtype=np.int64)  # not used by these queries
    rng = np.random.default_rng(0)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    near = mesh.vertices + rng.normal(scale=deviation, size=mesh.vertices.shape)
    points = np.concatenate([rng.uniform(low, high, size=(2000, 3)), near])
    rough = Surface(mesh, Proxy(simple.mesh, simple.vertex_map, kept, deviation))
    assert (rough.contains(points) == Surface(mesh).contains(points)).mean() > 0.999  # but for points on the surface
    clear, far = rough.clearance(points), Surface(mesh).distance(points)
    assert (clear <= far * (1 + 1e-9)).all()
    assert (clear >= far - 2 * deviation).all()


def test_simplifying_by_error_respects_the_bound():
    mesh = sphere(4)
    result = simplify(mesh, error=0.01)
    assert len(result.mesh.faces) < 0.3 * len(mesh.faces)
    assert hausdorff_distance(mesh, result.mesh) <= 0.01


def test_within_an_error_bound_vertices_are_mapped_by_their_place():
    """The sides of a square rod are flat: along them collapses cost nothing."""
    t = np.arange(16) / 16
    outline = np.concatenate([np.stack([0 * t, t], 1), np.stack([t, 1 + 0 * t], 1)])
    outline = np.concatenate([outline, 1 - outline])
    z = np.linspace(0, 8, 65)
    rings = np.concatenate(
        [np.broadcast_to(outline, (65, 64, 2)), np.broadcast_to(z[:, None, None], (65, 64, 1))], axis=2
    )
    rod = join_rings(rings)
    simple = simplify(rod, error=0.02)
    assert len(simple.mesh.faces) < len(rod.faces) / 20
    back = simple.pull_back(np.array(simple.mesh.vertices))
    assert np.linalg.norm(back - rod.vertices, axis=1).max() < 0.02 * rod.diameter_bound
    assert patches_are_connected(rod, simple.vertex_map.indices)


def test_libigl_simplifies_where_fast_simplification_fails(monkeypatch):
    mesh = torus(1.0, 0.4, 40, 24)
    monkeypatch.setattr("lbskel.preprocess.simplification.AGGRESSIVENESS", ())
    result = simplify(mesh, target_faces=600)
    assert "by libigl" in result.notes[0]
    assert result.mesh.genus == 1
    assert len(result.mesh.faces) <= 660
    assert patches_are_connected(mesh, result.vertex_map.indices)


def test_a_candidate_of_another_topology_is_rejected(monkeypatch):
    """The first candidate has the faces and the shape asked for, but a hole; the second is closed."""
    mesh = sphere(4)
    closed = simplify(mesh, target_faces=1200)
    holed = replace(closed, mesh=Mesh(closed.mesh.vertices, closed.mesh.faces[1:]))
    monkeypatch.setattr(simplification, "_candidates", lambda mesh, target: iter([holed, closed]))
    assert simplify(mesh, target_faces=1200).mesh is closed.mesh
    monkeypatch.setattr(simplification, "_candidates", lambda mesh, target: iter([holed]))
    assert simplify(mesh, target_faces=1200).mesh is mesh


def test_a_candidate_far_from_the_surface_is_rejected(monkeypatch):
    mesh = sphere(4)
    closed = simplify(mesh, target_faces=1200)
    far = replace(closed, mesh=closed.mesh.with_vertices(1.2 * closed.mesh.vertices))
    monkeypatch.setattr(simplification, "_candidates", lambda mesh, target: iter([far]))
    assert simplify(mesh, target_faces=1200).mesh is mesh


def test_the_deviation_is_in_units_of_the_mesh():
    mesh = sphere(4)
    one, eight = (
        simplify(mesh.with_vertices(size * mesh.vertices), target_faces=1000).report["steps"][0]["deviation"]
        for size in (1.0, 8.0)
    )
    assert eight == pytest.approx(8 * one)
    # 1000 equilateral triangles on a unit sphere have edges h of 0.17, and lie up to h^2 / 6 below it
    assert 0.17**2 / 24 < one < 0.17**2


def test_fewest_faces_are_those_of_the_tetrahedron_and_of_the_torus_of_seven_vertices():
    assert [fewest_faces(genus) for genus in (0, 1, 3)] == [4, 14, 28]


def test_a_target_below_what_the_genus_needs_is_given_up_at_once(monkeypatch):
    monkeypatch.setattr("lbskel.preprocess.simplification._candidates", None)  # would fail if it was tried
    mesh = lattice(3)
    result = simplify(mesh, target_faces=fewest_faces(28) - 1)
    assert result.mesh is mesh
    assert "genus 28 needs" in " ".join(result.notes)
