"""Local thickness: rays from faces, against shapes whose thickness is known."""

import numpy as np
import pytest
from helpers import joined

from lbskel import Mesh
from lbskel.geometry import shape_diameter
from lbskel.geometry.deadline import Deadline, OutOfTime
from lbskel.geometry.shape_diameter import (
    MIN_RADIUS,
    has_local_radii,
    local_radii,
    local_thickness,
    set_local_radii,
    thickness_along_normal,
)
from lbskel.shapes import cylinder, flat_grid, marching_cubes, solid_of, sphere, torus


def tower(width, height, n, m):
    """A closed box on the plane z = 0, with n by n squares at each end and n by m squares at each side."""
    side, end = flat_grid(n + 1, m + 1), flat_grid(n + 1, n + 1)
    (x, z, _), (s, t, _), zero = side.vertices.T, end.vertices.T, np.zeros(len(side.vertices))
    outlines = [(x, zero), (1 + zero, x), (1 - x, 1 + zero), (zero, 1 - x)]
    sides = [side.with_vertices(np.stack([a, b, z], axis=1)) for a, b in outlines]
    ends = [end.with_vertices(np.stack(at, axis=1)) for at in ((t, s, 0 * s), (s, t, 1 + 0 * s))]
    whole = joined(*sides, *ends)
    corners, index = np.unique(np.round(whole.vertices, 12), axis=0, return_inverse=True)
    return Mesh(corners * [width, width, height], index.ravel()[whole.faces])


def test_thickness_of_a_ball_and_of_a_sheet():
    ball = sphere(3)
    every = np.arange(len(ball.faces))
    # straight through is 2; a slanted ray ends on the sphere a quarter nearer
    assert local_thickness(ball, every) == pytest.approx(np.full(len(every), 1.5), rel=0.02)
    assert np.isinf(local_thickness(flat_grid(), np.array([0]))).all()


def test_thickness_along_the_normal_is_the_diameter_of_a_ball_also_inside_out():
    ball = sphere(3)
    faces = np.arange(0, len(ball.faces), 10)
    for mesh in (ball, Mesh(ball.vertices, ball.faces[:, ::-1])):
        # faces with edges h of 0.15 lie up to h^2 / 3 below the sphere
        assert thickness_along_normal(mesh, faces) == pytest.approx(np.full(len(faces), 2.0), abs=0.02)
    assert np.isinf(thickness_along_normal(flat_grid(), np.array([0]))).all()


def test_the_local_radius_of_a_ball_is_its_radius():
    ball = sphere(3)
    for mesh in (ball, Mesh(ball.vertices, ball.faces[:, ::-1]), ball.with_vertices(1e-3 * ball.vertices + 5)):
        size = mesh.diameter_bound / ball.diameter_bound
        # rays start at the centers of faces, up to h^2 / 3 = 0.0075 below the sphere where edges h are 0.15
        assert local_radii(mesh) == pytest.approx(np.full(len(mesh.vertices), size), rel=0.01)


def test_the_local_radius_of_a_tube_is_that_of_its_circle():
    """Open and closed: polygons of 32 corners are thinner by 1 - cos(pi / 32), half a per cent."""
    ring, pipe = torus(1.0, 0.1, 80, 32), cylinder(0.1, 2.0, 32, 40)
    for mesh in (ring, pipe):
        assert local_radii(mesh) == pytest.approx(np.full(len(mesh.vertices), 0.1), rel=0.03)


def test_local_radii_do_not_change_when_a_mesh_is_turned():
    """The rays start at a distance inside their faces that is not a share of the bounding box."""
    mesh = cylinder(1.0, 3.0, 12)
    c = np.sqrt(0.5)
    turned = mesh.with_vertices(mesh.vertices @ [[c, 0, -c], [0, 1, 0], [c, 0, c]])
    assert turned.diagonal != pytest.approx(mesh.diagonal, rel=0.01)
    assert local_radii(turned) == pytest.approx(local_radii(mesh), rel=1e-12)  # rounding


def test_folded_slivers_of_noise_do_not_make_a_tube_thinner():
    tube = marching_cubes(solid_of([([[-2.0, 0, 0], [2.0, 0, 0]], 1.0)]), 0.15)
    noise = 0.015 * np.random.default_rng(0).normal(size=tube.vertices.shape)
    radii = local_radii(tube.with_vertices(tube.vertices + noise))
    assert np.median(radii) == pytest.approx(1, rel=0.05)  # 0.75 with the rays of faces across the surface


def test_parts_of_different_thickness_have_radii_of_their_own():
    V = np.concatenate([sphere(3).vertices, 0.1 * sphere(3).vertices + [5, 0, 0]])
    n = len(sphere(3).vertices)
    radii = local_radii(Mesh(V, np.concatenate([sphere(3).faces, sphere(3).faces + n])))
    assert radii[:n] == pytest.approx(np.full(n, 1.0), rel=0.01)
    assert radii[n:] == pytest.approx(np.full(n, 0.1), rel=0.01)


def test_at_the_end_of_a_limb_the_radius_grows_no_faster_than_the_distance():
    """A ray from the end of a box of 0.2 x 0.2 x 4 is twenty times as long as the box is wide."""
    mesh = tower(0.2, 4.0, 4, 40)
    assert mesh.is_closed_manifold
    assert mesh.volume == pytest.approx(0.2 * 0.2 * 4)
    ends = np.flatnonzero(np.isin(mesh.faces, np.flatnonzero(mesh.vertices[:, 2] == 0)).all(axis=1))
    assert thickness_along_normal(mesh, ends) == pytest.approx(np.full(len(ends), 4.0), rel=1e-3)
    radii = local_radii(mesh)
    i, j = mesh.edges.T
    lengths = np.linalg.norm(mesh.vertices[i] - mesh.vertices[j], axis=1)
    assert (np.abs(radii[i] - radii[j]) <= lengths + 1e-12).all()
    is_end = (mesh.vertices[:, 2] == 0) | (mesh.vertices[:, 2] == 4.0)
    assert radii[~is_end] == pytest.approx(np.full((~is_end).sum(), 0.1), rel=1e-3)
    # in the middle of an end the nearest side is half the width away
    assert 0.1 < radii[is_end].max() <= 0.1 + 0.1 + 1e-12


def test_single_rays_that_are_too_short_or_miss_do_not_count():
    """A face hidden under another stops its ray, or a face opposite it is missing: five of six rays go on."""
    ball = sphere(3)
    n, face = len(ball.vertices), ball.vertices[ball.faces[0]]
    hidden = 0.9 * (face.mean(axis=0) + 0.2 * (face - face.mean(axis=0)))
    stopped = Mesh(np.concatenate([ball.vertices, hidden]), np.append(ball.faces, [[n, n + 1, n + 2]], axis=0))
    opened = Mesh(ball.vertices, ball.faces[1:])
    assert thickness_along_normal(stopped, np.array([0]))[0] < 0.2
    assert np.isinf(thickness_along_normal(opened, np.arange(len(opened.faces)))).sum() == 1
    for mesh in (stopped, opened):
        assert local_radii(mesh)[:n] == pytest.approx(np.full(n, 1.0), rel=0.01)


def test_radii_of_sheets_flat_parts_and_vertices_without_a_face_are_finite():
    sheet = flat_grid()
    V = np.concatenate([sheet.vertices, [[9, 9, 9]]])
    radii = local_radii(Mesh(V, sheet.faces))
    assert radii[-1] == 0
    # no ray hits anything: as large as can be
    assert radii[:-1] == pytest.approx(np.full(len(V) - 1, Mesh(V, sheet.faces).diameter_bound))
    plate = tower(1.0, 1e-3, 10, 1)
    is_inner = (np.abs(plate.vertices[:, :2] - 0.5) < 0.45).all(axis=1)
    # a plate far thinner than its triangles, six of 0.005 at each vertex, has the radius of those
    assert local_radii(plate)[is_inner] == pytest.approx(np.full(2 * 81, MIN_RADIUS * np.sqrt(0.03 / np.pi)))


def test_radii_are_computed_once_for_a_mesh():
    ball = sphere(2)
    assert local_radii(ball) is local_radii(ball)
    with pytest.raises(ValueError, match="read-only"):
        local_radii(ball)[0] = 1


def test_no_faces_have_no_thickness():
    assert local_thickness(sphere(1), np.array([], dtype=np.int64)).shape == (0,)


def test_a_fan_of_needles_is_measured_from_fewer_faces(monkeypatch):
    t = 2 * np.pi * np.arange(600) / 600
    i, j = np.arange(600), (np.arange(600) + 1) % 600
    rim = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    faces = [np.stack([i, j, np.full(600, 600)], axis=1), np.stack([j, i, np.full(600, 601)], axis=1)]
    fan = Mesh(np.concatenate([rim, [[0, 0, 1.0], [0, 0, -1.0]]]), np.concatenate(faces))
    all_faces = local_radii(fan)
    assert fan.aabb_tree.overlap > 30
    monkeypatch.setattr(shape_diameter, "MAX_OVERLAP", 10.0)
    assert local_radii(fan.with_vertices(fan.vertices)) == pytest.approx(all_faces, rel=0.1, abs=0.05)


def test_a_large_mesh_is_measured_from_every_third_face(monkeypatch):
    tube = cylinder(n=60, m=30)
    every = local_radii(tube)
    monkeypatch.setattr(shape_diameter, "ALL_RAYS", len(tube.faces) // 10)
    third = tube.with_vertices(tube.vertices)
    n_rays = []
    monkeypatch.setattr(
        shape_diameter,
        "thickness_along_normal",
        lambda mesh, faces, **options: n_rays.append(len(faces)) or thickness_along_normal(mesh, faces, **options),
    )
    assert local_radii(third) == pytest.approx(every, rel=0.02)
    assert n_rays == [-(-len(tube.faces) // 3)]


def test_each_vertex_of_a_large_mesh_has_a_face_with_a_ray(monkeypatch):
    """A tube of slender faces, five radii long, whose numbers leave out every face at one line of vertices."""
    tube = cylinder(0.1, 4.0, n=12, m=9)
    every = local_radii(tube)
    on_line = np.flatnonzero(np.abs(tube.vertices[:, :2] - tube.vertices[0, :2]).max(axis=1) < 1e-9)
    at_line = np.isin(tube.faces, on_line).any(axis=1)
    F = np.empty_like(tube.faces)
    is_third = np.arange(len(F)) % 3 == 0
    F[is_third], F[~is_third] = np.split(tube.faces[np.argsort(at_line, kind="stable")], [is_third.sum()])
    monkeypatch.setattr(shape_diameter, "ALL_RAYS", len(F) // 10)
    # the ends of a ray along the normal lie on the same two flat sides of the tube
    assert local_radii(Mesh(tube.vertices, F)) == pytest.approx(every, rel=1e-9)


def test_radii_are_not_measured_after_a_deadline():
    with pytest.raises(OutOfTime):
        local_radii(sphere(2), deadline=Deadline(0.0))


def test_known_radii_are_returned_where_none_have_been_measured():
    mesh, measured = torus(1.0, 0.3, 12, 8), torus(1.0, 0.3)
    known = np.arange(1.0, len(mesh.vertices) + 1)
    assert not has_local_radii(mesh)
    set_local_radii(mesh, known)
    assert has_local_radii(mesh)
    assert np.array_equal(local_radii(mesh), known)
    radii = local_radii(measured)
    set_local_radii(measured, 3 * radii)
    assert local_radii(measured) is radii


def test_slivers_of_a_noisy_surface_do_not_count_where_few_faces_have_rays(monkeypatch):
    """Marching cubes leave slivers, whose normals the noise turns along the surface."""
    step = 0.06
    tube = marching_cubes(solid_of([([[-1.5, 0.0, 0.0], [1.5, 0.0, 0.0]], 1.0)]), step)
    V, F = tube.vertices, tube.faces
    noisy = Mesh(V + 0.1 * step * np.random.default_rng(0).normal(size=V.shape), F)
    monkeypatch.setattr(shape_diameter, "ALL_RAYS", len(F) // 10)
    # half of the radii are within the noise of a local thickness; with two rays at a vertex, the median was 0.2
    assert np.median(local_radii(noisy)) == pytest.approx(1.0, rel=0.1)


def test_the_faces_of_a_fan_do_not_count_for_the_vertices_of_its_rim(monkeypatch):
    """A closed cylinder of length 10 whose caps are fans: half of the caps' thickness is 5."""
    sides, angles = 200, 2 * np.pi * np.arange(200) / 200
    rim, i = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1), np.arange(200)
    j, low, high = (i + 1) % sides, np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    V = np.concatenate([rim, rim + [0, 0, 10], [[0, 0, 0], [0, 0, 10]]])
    F = [(i, j, j + sides), (i, j + sides, i + sides), (j, i, low), (i + sides, j + sides, high)]
    fan = Mesh(V, np.concatenate([np.stack(face, axis=1) for face in F]))
    monkeypatch.setattr(shape_diameter, "ALL_RAYS", len(fan.faces) // 10)
    assert np.median(local_radii(fan)) == pytest.approx(1.0, rel=0.01)
