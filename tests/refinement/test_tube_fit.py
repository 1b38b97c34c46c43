"""Round tubes fitted to the surface."""

from dataclasses import replace

import igl
import numpy as np
import pytest
from helpers import box_mesh, joined, loop_in, path_in, without_faces

from lbskel import Mesh, Skeleton, ground_truth_distances, skeletonize
from lbskel.geometry.deadline import Deadline, OutOfTime
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.containment import segments_outside
from lbskel.refinement.radii import mean_axis_distances
from lbskel.refinement.region_map import nearest_balls
from lbskel.refinement.tube_fit import _along_gaps, _kept_inside, fit_tubes, tube_radii
from lbskel.shapes import capsule, cylinder, make, mesh_solid, solid_of, torus, tube, with_local_noise
from lbskel.shapes.hard import HARD_SHAPES


def bent_path(z, offsets):
    """Points along the z axis, off it by offsets along x."""
    return np.stack([offsets, 0 * z, z], axis=1)


def test_values_are_interpolated_along_branches_and_the_largest_counts_where_these_meet():
    """A loop of nodes 0 to 3 with a tail to 6, a path of two nodes, and a node without edges."""
    edges = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [4, 5], [5, 6], [7, 8]]
    skeleton = Skeleton(np.random.default_rng(0).random((10, 3)), edges, np.ones(10))
    values = np.array([9.0, 2, 9, 5, 8, 3, 0, 3, 1, 6])
    found = _along_gaps(skeleton, values, np.isin(np.arange(10), [1, 3, 5, 6, 9]))
    assert found.tolist() == [5, 2, 3.5, 5, 3, 3, 0, 3, 1, 6]  # at 0 the loop has 2 and 5, and the tail 3


def test_a_path_beside_the_axis_of_a_capsule_goes_to_it():
    mesh, z = capsule(4.0, 0.5, 32), np.linspace(-2, 2, 17)
    fitted = fit_tubes(path_in(mesh, bent_path(z, 0.1 + 0 * z)), Surface(mesh))
    # half a fifth of a radius remains only where the end caps leave the last nodes free
    assert np.abs(fitted.nodes[2:-2, 0]).max() < 0.01 * 0.5
    assert fitted.nodes[:, 2] == pytest.approx(z, abs=0.05)


def test_a_curved_tube_is_followed_and_not_cut_short():
    """The polyline of a circle has to be outside it at its nodes, and inside it between them."""
    mesh, angle = torus(1.0, 0.2, 96, 32), np.linspace(0, 2 * np.pi, 40, endpoint=False)
    loop = loop_in(mesh, 0.99 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1), radius=0.2)
    fitted = fit_tubes(loop, Surface(mesh))
    # that the loop bends as little as it may leaves a hundredth of the radius of the tube
    assert np.hypot(*fitted.nodes[:, :2].T) == pytest.approx(1, abs=0.01 * 0.2)


def test_a_junction_is_found_from_the_visible_sides_of_its_limbs():
    """The contracted skeleton of an octopus is a third of a radius off where its arms are still joined."""
    shape = make("octopus", n_vertices=3000)
    fitted = skeletonize(shape.mesh)
    distances = ground_truth_distances(fitted, shape.truth)
    assert distances.accuracy < 0.03
    assert distances.accuracy_95 < 0.2  # 0.28 without the fit


def test_nodes_inside_keep_their_places_where_their_balls_would_shrink_by_more_than_a_fifth():
    """The first that moves goes to a ball of 0.84 of its own, the second of 0.7; the third is outside."""
    mesh, z = capsule(4.0, 0.5, 32), np.linspace(-2, 2, 17)
    offsets = np.zeros(17)
    offsets[12] = 0.8
    path = path_in(mesh, bent_path(z, offsets))
    moved = np.array(path.nodes)
    moved[[4, 8, 12], 0] = 0.08, 0.15, 0.45
    kept = _kept_inside(path, moved, Surface(mesh))
    assert kept[[4, 8, 12], 0].tolist() == [0.08, 0, 0.45]


def test_noise_is_averaged_over_all_vertices():
    mesh, z = capsule(6.0, 0.5, 48), np.linspace(-3, 3, 25)
    rng = np.random.default_rng(0)
    noisy = mesh.with_vertices(mesh.vertices * (1 + [0.1, 0.1, 0] * rng.standard_normal((len(mesh.vertices), 1))))
    fitted = fit_tubes(path_in(noisy, bent_path(z, 0.05 * rng.standard_normal(25))), Surface(noisy))
    # a ring of 48 vertices with a deviation of a tenth has its center off by 0.1 sqrt(2 / 48) = 0.02 radii
    assert np.hypot(*fitted.nodes[2:-2, :2].T).mean() < 0.02 * 0.5


def test_a_flat_part_keeps_its_places():
    """The other tests start as far from the axis, and end on it."""
    rod, z = capsule(4.0, 0.05, 64), np.linspace(-2, 2, 9)
    mesh = rod.with_vertices(rod.vertices * [20, 1, 1])
    path = path_in(mesh, bent_path(z, 0.1 + 0 * z))
    # its sections are no circles, and a round tube would pull a tenth
    assert np.abs(fit_tubes(path, Surface(mesh)).nodes - path.nodes).max() < 0.01


def test_the_fit_turns_and_scales_with_the_mesh():
    mesh, z = capsule(4.0, 0.5, 32), np.linspace(-2, 2, 17)
    path = path_in(mesh, bent_path(z, 0.1 * np.cos(3 * z)))
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    turned = mesh.with_vertices(1e3 * mesh.vertices @ turn)
    one = fit_tubes(path, Surface(mesh))
    other = fit_tubes(path_in(turned, 1e3 * path.nodes @ turn), Surface(turned))
    assert other.nodes / 1e3 == pytest.approx(one.nodes @ turn, abs=1e-9)


def bent_plate(is_closed):
    """A plate of 3 by 2 by 0.06, bent to an arc of radius 1, and a path in its middle; or the plate with a hole."""
    box = box_mesh((3.0, 2.0, 0.06))
    V, F = igl.upsample(box.vertices, box.faces, 4)
    V = np.stack([(1 + V[:, 2]) * np.sin(V[:, 0]), V[:, 1], (1 + V[:, 2]) * np.cos(V[:, 0])], axis=1)
    mesh, angle = Mesh(V, F if is_closed else F[1:]), np.linspace(-1.2, 1.2, 7)
    return mesh, path_in(mesh, np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1))


@pytest.mark.parametrize("is_closed", [True, False])
def test_nothing_leaves_a_thin_part_that_is_bent(is_closed):
    """A path that bends less leaves it: the plate is a thirtieth as thick as the tubes."""
    mesh, path = bent_plate(is_closed)
    fitted, surface = fit_tubes(path, Surface(mesh)), Surface(mesh)
    assert surface.contains(fitted.nodes[surface.contains(path.nodes)]).all()
    if is_closed:
        was_outside, is_outside = (segments_outside(s.nodes, path.edges, surface) for s in (path, fitted))
        assert not (is_outside & ~was_outside).any()


def test_a_node_that_is_outside_already_may_stay_so():
    mesh, path = bent_plate(is_closed=True)
    nodes = np.array(path.nodes)
    nodes[3] *= 1.2
    assert np.isfinite(fit_tubes(replace(path, nodes=nodes), Surface(mesh)).nodes).all()


def test_without_edges_or_with_few_vertices_or_without_sections_nothing_is_fitted():
    mesh = capsule(4.0, 0.5, 16)
    alone = Skeleton(np.zeros((1, 3)), np.empty((0, 2)), np.ones(1), np.zeros(len(mesh.vertices), dtype=np.int64))
    short = path_in(mesh, [[0, 0, 2.2], [0, 0, 2.3]])
    z = np.linspace(-2, 2, 1 + len(mesh.vertices) // 4)
    for skeleton in (alone, short, path_in(mesh, bent_path(z, 0.1 + 0 * z))):
        assert fit_tubes(skeleton, Surface(mesh)) is skeleton


def test_a_node_whose_only_vertex_is_on_the_axis_has_a_radius():
    mesh, z = capsule(4.0, 0.5, 48), np.linspace(-2, 2, 17)
    path = path_in(mesh, bent_path(z, 0 * z))
    node_of_vertex = np.where(path.node_of_vertex == 8, 7, path.node_of_vertex)
    node_of_vertex[mesh.vertices[:, 2].argmax()] = 8
    fitted = fit_tubes(replace(path, node_of_vertex=node_of_vertex), Surface(mesh))
    assert np.abs(fitted.nodes[:, 0]).max() < 0.01 * 0.5


def test_tips_move_across_their_branches():
    mesh, z = capsule(4.0, 0.5, 32), np.linspace(-2, 2, 17) + 0.1 * np.sin(np.arange(17.0))
    path = path_in(mesh, bent_path(z, 0.1 + 0 * z))
    fitted = fit_tubes(path, Surface(mesh))
    assert fitted.nodes[[0, -1], 2] == pytest.approx(z[[0, -1]], abs=1e-9)
    assert np.abs(fitted.nodes[2:-2, 0]).max() < 0.01 * 0.5


@pytest.mark.parametrize(("name", "given"), [("acute fork", {}), ("torso", {}), ("torso", {"degrees": 12.0})])
def test_no_branch_turns_back_next_to_a_junction(name, given):
    """Junctions move along the branches that lead through them; nodes next to them have to make way."""
    skeleton = skeletonize(HARD_SHAPES[name](**given).mesh)
    for branch in skeleton.branches:
        steps = np.diff(skeleton.nodes[branch], axis=0)
        assert (np.einsum("ki,ki->k", steps[1:], steps[:-1]) > 0).all()


def test_radii_of_a_bulge_are_those_of_its_tubes():
    """A tube whose radius rises from 0.5 to 0.9 and falls again; nodes are half a radius apart."""
    knots, at_knots = np.array([-3.0, -1, 0, 1, 3]), [0.5, 0.5, 0.9, 0.5, 0.5]
    mesh = mesh_solid(solid_of([(np.stack([0 * knots, 0 * knots, knots], axis=1), at_knots)]), n_vertices=6000)
    z = np.linspace(-3, 3, 25)
    path, radii = path_in(mesh, np.stack([0 * z, 0 * z, z], axis=1)), np.interp(z, knots, at_knots)
    found, means = tube_radii(path, Surface(mesh)), mean_axis_distances(path, mesh.vertices)
    assert np.abs(found / radii - 1).max() < 0.1  # bending rounds the corners of the profile
    assert np.abs(found - radii).mean() < 0.5 * np.abs(means - radii).mean()


def test_nodes_that_are_kept_in_order_stay_inside():
    """What goes back so that a branch does not turn back may leave the surface between its nodes."""
    angles = np.linspace(0, 1.5, 40)
    arc = 2 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    mesh = tube(arc, 0.35, sides=16, rounded=True)
    places = 0.3 + np.array([0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9])
    path = path_in(mesh, 2 * np.stack([np.cos(places), np.sin(places), 0 * places], axis=1))
    fitted = fit_tubes(path, Surface(mesh))
    before, after = fitted.nodes[1:-1] - fitted.nodes[:-2], fitted.nodes[2:] - fitted.nodes[1:-1]
    assert (np.einsum("ki,ki->k", before, after) > 0).all()
    assert not segments_outside(fitted.nodes, fitted.edges, Surface(mesh)).any()


def test_what_closes_a_cut_does_not_count_for_radii():
    """Whose vertex is on the axis."""
    skeleton = skeletonize(cylinder(1.0, 12.0, 24, 40))
    assert skeleton.mean_radii == pytest.approx(np.ones(len(skeleton.nodes)), abs=0.01)
    pipe = cylinder(1.0, 12.0, 24, 40)
    with_center = Mesh(np.append(pipe.vertices, [[0, 0, 6.0]], axis=0), pipe.faces)
    path = path_in(with_center, bent_path(np.linspace(-6, 6, 25), np.zeros(25)))
    cut = np.array([[0, 0, 6.0, 1.0, 0, 0, np.pi]])
    assert tube_radii(path, Surface(with_center), cuts=cut)[-1] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("sides", [20, 200])
def test_the_rim_of_a_flat_cap_does_not_count_for_radii(sides):
    """It is farther from a tip that is a radius below the cap."""
    skeleton = skeletonize(tube(np.linspace([0, 0, 0], [0, 0, 10], 60), 1.0, sides=sides))
    assert skeleton.mean_radii == pytest.approx(np.ones(len(skeleton.nodes)), abs=0.01)


def test_the_surface_beside_a_slit_counts_for_radii():
    """The whole of a narrow part lies within half the mean radius of a slit along it."""
    z, angles = np.linspace(0, 8, 81), np.linspace(0, 2 * np.pi, 25)[:-1]
    radii = 0.2 - 0.12 * np.exp(-(((z - 4) / 0.4) ** 2))
    vessel = tube(np.outer(z, [0, 0, 1]), radii, sides=24, rounded=True)
    centers = vessel.vertices[vessel.faces].mean(axis=1)
    is_slit = (np.abs(centers[:, 2] - 4) < 1) & (np.abs(np.arctan2(centers[:, 1], centers[:, 0])) < 2 * angles[1])
    skeleton = skeletonize(without_faces(vessel, np.flatnonzero(is_slit)))
    narrow = np.abs(skeleton.nodes[:, 2] - 4).argmin()
    assert skeleton.mean_radii[narrow] == pytest.approx(0.08, rel=0.15)  # the noise of what closes the slit


@pytest.mark.parametrize("narrowest", [0.15, 0.4])
def test_no_branch_turns_back_where_a_straight_tube_narrows_and_widens(narrowest):
    """A vessel with a stenosis."""
    x = np.linspace(0, 40, 160)
    radii = 2 - (2 - narrowest) * np.exp(-(((x - 20) / 3) ** 2))
    vessel = tube(np.outer(x, [1, 0, 0]), radii)
    is_cap = (vessel.vertices[vessel.faces] @ [1, 0, 0] % 40 == 0).all(axis=1)
    skeleton = skeletonize(without_faces(vessel, np.flatnonzero(is_cap)))
    (branch,) = skeleton.branches
    steps = np.diff(skeleton.nodes[branch, 0])
    assert (steps * steps[0] > 0).all()
    assert skeleton.length == pytest.approx(40, abs=0.01)


def test_noise_changes_radii_less_than_it_does_the_mean_distances():
    mesh, z = capsule(6.0, 0.5, 16), np.linspace(-3, 3, 49)
    rough = with_local_noise(mesh, 0.3)
    path = path_in(rough, np.stack([0 * z, 0 * z, z], axis=1))
    found, means = tube_radii(path, Surface(rough)), mean_axis_distances(path, rough.vertices)
    assert np.abs(found - 0.5).mean() < 0.9 * np.abs(means - 0.5).mean()


def test_a_node_without_edges_has_the_mean_distance_of_the_vertices():
    mesh = capsule(1.0, 0.5, 32)
    alone = Skeleton(np.zeros((1, 3)), np.empty((0, 2)), np.ones(1), np.zeros(len(mesh.vertices), dtype=np.int64))
    assert tube_radii(alone, Surface(mesh))[0] == pytest.approx(np.linalg.norm(mesh.vertices, axis=1).mean())


def test_the_deadline_is_checked():
    mesh, z = capsule(4.0, 0.5, 32), np.linspace(-2, 2, 17)
    with pytest.raises(OutOfTime):
        fit_tubes(path_in(mesh, bent_path(z, 0 * z)), replace(Surface(mesh), deadline=Deadline(0.0)))


def test_a_vertex_far_from_all_tubes_hardly_counts():
    """A plate that stands out from a rod, whose vertices are nearest to the rod."""
    rod, fin = capsule(4.0, 0.3, 32), box_mesh((2.0, 0.02, 0.4), (1.2, 0, 0))
    both = joined(rod, fin)
    z = np.linspace(-2, 2, 17)
    path = path_in(both, bent_path(z, 0 * z))
    path = replace(path, node_of_vertex=nearest_balls(path, both.vertices))
    assert np.abs(fit_tubes(path, Surface(both)).nodes[:, 0]).max() < 0.1 * 0.3
