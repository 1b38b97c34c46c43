"""The proxy: as many faces as the thickness of a shape needs, and maps in both directions."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.geometry.deadline import Deadline, OutOfTime
from lbskel.geometry.surface_queries import Surface
from lbskel.preprocess import proxy
from lbskel.preprocess.proxy import face_budget, simplify_to_proxy, surface_with_proxy
from lbskel.preprocess.simplification import topology_of
from lbskel.shapes import capsule, sphere, torus

FACES = 2 / np.sqrt(3) / proxy.SHORT_EDGE**2  # that are left of an area of one squared radius


@pytest.mark.parametrize(("radius", "n_faces"), [(0.01, FACES * 4 * np.pi**2 / 0.01), (0.001, 128_000)])
def test_long_thin_shapes_keep_more_faces(radius, n_faces):
    """On a torus area / radius^2 is 4 pi^2 / radius; flat faces are nearer to the axis."""
    mesh = torus(1.0, radius, 440, 20)
    assert face_budget(mesh) == pytest.approx(n_faces, rel=0.03)
    opened = Mesh(mesh.vertices, mesh.faces[1:])  # has no volume
    assert face_budget(opened) == pytest.approx(n_faces, rel=0.03)


def test_the_thin_parts_of_a_thick_shape_count_by_their_own_radius():
    """Area / radius^2 is 4 pi on the ball, and 12 pi^2 over the radius of the ring; the mean radius is the ball's."""
    ball, ring = sphere(5), torus(3.0, 0.03, 1200, 20)
    both = Mesh(
        np.concatenate([ball.vertices, ring.vertices]), np.concatenate([ball.faces, ring.faces + len(ball.vertices)])
    )
    assert 2 * both.volume / both.area > 0.5
    assert face_budget(both) == pytest.approx(FACES * (4 * np.pi + 12 * np.pi**2 / 0.03), rel=0.03)


def test_a_mesh_of_at_most_16_000_faces_is_contracted_whole():
    assert face_budget(torus(1.0, 0.3, 80, 100)) == 16_000
    assert face_budget(torus(1.0, 0.01, 80, 20)) == 16_000


def test_a_shape_with_few_thin_parts_has_a_proxy_of_16_000_faces():
    assert face_budget(torus(1.0, 0.3, 300, 60)) == 16_000


def test_a_surface_that_is_inside_out_is_as_thick():
    mesh = torus(1.0, 0.01, 440, 20)
    assert face_budget(Mesh(mesh.vertices, mesh.faces[:, ::-1])) == face_budget(mesh) > 16_000


def test_a_surface_without_area_has_no_radius():
    flat = Mesh(np.zeros((3, 3)), np.tile([[0, 1, 2], [0, 2, 1]], (8001, 1)))
    assert face_budget(flat) == 16_000


@pytest.mark.parametrize(("radius", "n_along", "n_around"), [(0.35, 300, 60), (0.02, 2400, 48)])
def test_the_proxy_maps_every_vertex_and_has_a_source_for_each_of_its_own(radius, n_along, n_around):
    """Also that of a thin shape."""
    mesh = torus(1.0, radius, n_along, n_around)
    proxy = simplify_to_proxy(mesh)
    surface = surface_with_proxy(mesh, proxy)
    assert len(proxy.mesh.faces) < len(mesh.faces)
    assert surface.simplified is not None
    sources = surface.simplified.source_vertices
    assert np.array_equal(proxy.vertex_map.indices[sources], np.arange(len(proxy.mesh.vertices)))
    apart = np.linalg.norm(mesh.vertices - proxy.mesh.vertices[proxy.vertex_map.indices], axis=1)
    assert apart.max() < radius / 2
    assert proxy.mesh.genus == 1


def test_a_small_mesh_is_its_own_proxy():
    mesh = torus(1.0, 0.35, 40, 20)
    assert simplify_to_proxy(mesh).mesh is mesh
    assert surface_with_proxy(mesh, simplify_to_proxy(mesh)).simplified is None


def test_thin_and_thick_parts_of_a_proxy_are_equally_fine():
    """Each has as many faces for its area / squared radius, and both as many as the budget has."""
    thick, thin = capsule(40.0, 1.0, 48), capsule(30.0, 0.25, 48)
    faces = np.concatenate([thick.faces, thin.faces + len(thick.vertices)])
    mesh = Mesh(np.concatenate([thick.vertices, thin.vertices + [0.0, 5.0, 0.0]]), faces)
    coarse = simplify_to_proxy(mesh).mesh
    n_faces = np.bincount(coarse.component_of_vertex[coarse.faces[:, 0]])
    assert n_faces / (2 * np.pi * np.array([40.0, 30.0 / 0.25])) == pytest.approx([FACES, FACES], rel=0.15)
    assert n_faces.sum() == pytest.approx(face_budget(mesh), rel=0.1)


def test_the_boundary_of_an_open_surface_stays():
    whole = torus(1.0, 0.02, 2400, 48)
    mesh = Mesh(whole.vertices, np.delete(whole.faces, np.arange(0, len(whole.faces), 997), axis=0))
    coarse = simplify_to_proxy(mesh).mesh
    assert len(coarse.faces) < len(mesh.faces) / 2
    assert topology_of(coarse) == topology_of(mesh)


def test_the_deviation_of_the_proxy_bounds_the_distance_of_the_surfaces():
    mesh = torus(1.0, 0.35, 300, 60)
    proxy = simplify_to_proxy(mesh)
    surface = surface_with_proxy(mesh, proxy)
    assert surface.simplified is not None
    apart = Surface(mesh).distance(proxy.mesh.vertices[proxy.mesh.faces].mean(axis=1)).max()
    assert 0 < apart <= surface.simplified.deviation
    assert (surface.clearance(mesh.vertices) <= 0.0).all()


def test_a_long_thin_shape_of_very_many_faces_keeps_a_share_of_them(monkeypatch):
    rod = capsule(4.0, 0.1, 24)  # of edges a quarter of its radius long
    for name in ("MAX_FACES", "MAX_SLENDER_FACES"):
        monkeypatch.setattr(proxy, name, 100)
    assert len(rod.faces) > 8 * 100
    assert 100 < face_budget(rod) <= len(rod.faces) // proxy.MAX_REDUCTION


def test_a_proxy_is_not_begun_after_a_deadline(monkeypatch):
    monkeypatch.setattr(proxy, "MAX_FACES", 10)
    with pytest.raises(OutOfTime):
        simplify_to_proxy(capsule(4.0, 0.5, 16), deadline=Deadline(0.0))
