"""Mirror symmetry: the better half of a skeleton and its mirror image, where the surface is symmetric."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers import loop_in, nearest_rows, path_in
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import lbskel
from lbskel import Mesh, Skeleton
from lbskel.geometry.mirrors import principal_axes
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.mirror_symmetry import find_symmetries, keep_mirror_symmetry, make_mirror_symmetric
from lbskel.shapes import capsule, mesh_solid, solid_of, torus, with_local_noise
from lbskel.shapes.hard import HARD_SHAPES


def pear(sides=32):
    """A rod whose upper half is thicker, and whose ends are bent towards x: only y = 0 is a plane of symmetry."""
    rod = capsule(4.0, 0.6, sides)
    V = np.array(rod.vertices)
    V[:, :2] *= np.where(V[:, 2:] > 0, 1.5, 1.0)
    V[:, 0] += 0.1 * V[:, 2] ** 2
    return Mesh(V, rod.faces)


def forked(left, right, junction=0.0):
    """A trunk along z that ends in a junction at height ``junction`` over y = 0, and two branches along y."""
    trunk = [[0, junction, -0.6], [0, junction, -0.3], [0, junction, 0]]
    nodes = np.array([*trunk, *([0, y, 0] for y in (*left, *right))], dtype=float)
    first_right = 3 + len(left)
    chains = [0, 1, 2, *range(3, first_right)], [2, *range(first_right, len(nodes))]
    edges = np.concatenate([np.stack([chain[:-1], chain[1:]], axis=1) for chain in chains])
    return with_nearest_nodes(Skeleton(nodes, edges, np.zeros(len(nodes))), pear())


def with_nearest_nodes(skeleton, mesh):
    return replace(skeleton, node_of_vertex=cKDTree(skeleton.nodes).query(mesh.vertices)[1])


def planes_of(mesh):
    """The planes of symmetry of a mesh, relative to the radii of its skeleton."""
    return [symmetry.plane for symmetry in find_symmetries(lbskel.skeletonize(mesh), Surface(mesh))]


def asymmetry(skeleton, axis=1):
    """Largest distance of the mirror image of a node from the nearest node."""
    images = skeleton.nodes * np.where(np.arange(3) == axis, -1, 1)
    return cKDTree(skeleton.nodes).query(images)[0].max()


def test_the_half_that_covers_more_replaces_the_other():
    mesh = pear()
    skeleton = forked([0.3, 0.6], [-0.3])
    for given in (skeleton, replace(skeleton, nodes=skeleton.nodes * [1, -1, 1])):
        result = make_mirror_symmetric(with_nearest_nodes(given, mesh), Surface(mesh))
        assert sorted(result.nodes[result.tips, 1].round(9)) == [-0.6, 0, 0.6]
        assert asymmetry(result) == pytest.approx(0, abs=1e-9)
        assert len(result.junctions) == 1
        assert result.n_components == 1


def test_balls_outside_cover_nothing():
    """The right half ends far outside, in a ball that touches much of the surface."""
    mesh = pear()
    skeleton = forked([0.3, 0.5, 0.7], [-0.3, -3.0])
    for given in (skeleton, replace(skeleton, nodes=skeleton.nodes * [1, -1, 1])):
        result = make_mirror_symmetric(with_nearest_nodes(given, mesh), Surface(mesh))
        assert sorted(result.nodes[result.tips, 1].round(9)) == [-0.7, 0, 0.7]


def test_a_skeleton_on_the_plane_keeps_the_nodes_of_both_sides():
    mesh = pear()
    chain = with_nearest_nodes(Skeleton([[0, 0, -0.6], [0, 0, 0], [0, 0, 0.6]], [[0, 1], [1, 2]], np.zeros(3)), mesh)
    given = replace(chain, node_of_vertex=np.where(mesh.vertices[:, 1] > 0, 1, chain.node_of_vertex))
    assert len(find_symmetries(given, Surface(mesh))) == 1
    assert np.array_equal(make_mirror_symmetric(given, Surface(mesh)).node_of_vertex, given.node_of_vertex)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(
    ("heights", "is_moved"),
    [
        ([0.01, 0.01, 0.01, 0.01, 0.01, 0.5], True),
        ([0.01, 0.01, 0.01, 0.01, 0.01, 2.5], False),  # four radii aside
        ([0.0, 0.1, 0.2, 0.3, 0.4, 0.5], False),
    ],
)
def test_a_branch_along_the_plane_with_an_end_aside_is_moved_onto_it(heights, is_moved, side):
    mesh = pear()
    nodes = np.zeros((7, 3))
    nodes[:, 2] = np.linspace(-0.6, 0.6, 7)
    nodes[1:, 1] = side * np.array(heights)
    edges = np.stack([np.arange(6), np.arange(1, 7)], axis=1)
    given = with_nearest_nodes(Skeleton(nodes, edges, np.zeros(7)), mesh)
    result = make_mirror_symmetric(given, Surface(mesh))
    assert (len(result.nodes) == 7 and np.abs(result.nodes[:, 1]).max() < 1e-9) == is_moved


@pytest.mark.parametrize(("width", "tips"), [(1.6, [-3.95, 0, 0, 3.95]), (2.6, [-1.43, 0, 0, 1.43])])
def test_the_half_that_reaches_more_ends_is_taken_unless_it_covers_too_little(width, tips):
    """A flat body with a thin tail on each side: one half has the branch of its tail, the other covers its flank."""
    body, tails = np.array([[0.0, 0, -3], [0, 0, 3]]), np.array([[0.0, -2.5, 0.5], [0, 2.5, 0.5]])
    mesh = mesh_solid(solid_of([(body, 1.0), (tails, 0.15)]), n_vertices=4000)
    mesh = mesh.with_vertices(mesh.vertices * [1, width, 1])
    trunk, flank = np.linspace(*body, 9), np.linspace([0, -0.55 * width, -2.5], [0, -0.55 * width, 2.5], 9)
    tail = np.linspace([0, 0, 0.5], [0, 2.5 * width - 0.05, 0.5], 10)[1:]
    chains = [np.arange(9), [4, *range(9, 18)], [4, *range(18, 27)]]
    edges = np.concatenate([np.stack([chain[:-1], chain[1:]], axis=1) for chain in map(np.array, chains)])
    given = with_nearest_nodes(Skeleton(np.concatenate([trunk, tail, flank]), edges, np.zeros(27)), mesh)
    result = make_mirror_symmetric(given, Surface(mesh))
    assert sorted(result.nodes[result.tips, 1]) == pytest.approx(tips, abs=0.01)


def test_the_layers_of_a_folded_band_stay_apart():
    """A belt around y = 0 whose section is 0.15 thick and 9 high, so that mean radii reach across the gap."""
    mesh = torus(1.0, 0.3, 96, 32)
    mesh = mesh.with_vertices(mesh.vertices * [6, 0.5, 30])
    x = np.linspace(-6, 6, 41)
    y = 0.5 * np.sqrt(np.maximum(1 - x**2 / 36, 0))
    ring = np.concatenate([np.stack([x, y + 0.02, 0 * x], axis=1), np.stack([x, -y, 0 * x], axis=1)[-2:0:-1]])
    result = make_mirror_symmetric(loop_in(mesh, ring), Surface(mesh))
    assert asymmetry(result) == pytest.approx(0, abs=1e-9)
    assert np.abs(result.nodes[:, 1]).max() > 0.45
    assert result.cycle_rank == 1


def test_a_branch_whose_end_would_leave_its_limb_is_not_moved_onto_the_plane():
    """Most of it runs along the stem of a fork, and its end in one of the two prongs, which are 0.2 apart."""
    stem = np.array([[0.0, 0, -4], [0, 0, 0]])
    prongs = [np.array([[0.0, 0, 0], [0, y, 1.0], [0, y, 3.0]]) for y in (-0.4, 0.4)]
    mesh = mesh_solid(solid_of([(stem, 0.5), *((prong, 0.3) for prong in prongs)]), n_vertices=4000)
    path = np.concatenate(
        [np.linspace(*stem, 13), np.linspace(*prongs[1][:2], 4)[1:], np.linspace(*prongs[1][1:], 7)[1:]]
    )
    given = path_in(mesh, path)
    assert len(find_symmetries(given, Surface(mesh))) == 2  # the path is in the other plane
    assert make_mirror_symmetric(given, Surface(mesh)).nodes[:, 1] == pytest.approx(given.nodes[:, 1], abs=1e-3)


def test_every_vertex_has_a_node_on_its_side():
    mesh = pear()
    result = make_mirror_symmetric(forked([0.3, 0.6], [-0.3]), Surface(mesh))
    heights = result.nodes[result.node_of_vertex, 1] * mesh.vertices[:, 1]
    assert heights.min() >= -1e-9
    assert set(result.node_of_vertex[mesh.vertices[:, 1] > 0.3]) != set(result.node_of_vertex)
    nearest = np.linalg.norm(mesh.vertices - result.nodes[cKDTree(result.nodes).query(mesh.vertices)[1]], axis=1)
    chosen = np.linalg.norm(mesh.vertices - result.nodes[result.node_of_vertex], axis=1)
    assert np.allclose(chosen, nearest, atol=0.1)  # the vertices mirror each other to within that


def test_a_vertex_has_the_image_of_the_node_of_its_twin():
    mesh = pear()
    given = forked([0.3, 0.6], [-0.3])
    given = replace(given, node_of_vertex=np.where(mesh.vertices[:, 1] > 0, 4, given.node_of_vertex))
    result = make_mirror_symmetric(given, Surface(mesh))
    heights = result.nodes[result.node_of_vertex, 1]
    assert heights[mesh.vertices[:, 1] > 1e-3].round(9).tolist() == [0.6] * int((mesh.vertices[:, 1] > 1e-3).sum())
    assert set(heights[mesh.vertices[:, 1] < -1e-3].round(9)) == {-0.6}


def test_nodes_near_the_plane_are_moved_onto_it_or_to_the_side_of_their_branch():
    result = make_mirror_symmetric(forked([-0.02, 0.3, 0.6], [-0.3, -0.5], junction=0.05), Surface(pear()))
    assert np.abs(result.nodes[:, 1]).round(9).tolist().count(0) == 3  # the trunk and the junction
    assert sorted(np.abs(result.nodes[:, 1]).round(9))[3:] == [0.02, 0.02, 0.3, 0.3, 0.6, 0.6]
    assert asymmetry(result) == pytest.approx(0, abs=1e-9)


def test_a_branch_that_crosses_the_plane_along_nodes_on_it_gets_one_between_them():
    box = trimesh.creation.box((2, 3, 0.75)).subdivide()
    mesh = Mesh(box.vertices, box.faces)
    assert mesh.centroid[0] == 0
    x, y = [-0.7, -0.4, 0, 0, 0, 0, 0.4, 0.7], np.linspace(1, -1, 8)
    skeleton = path_in(mesh, np.stack([x, y, np.zeros(8)], axis=1))
    symmetric = make_mirror_symmetric(skeleton, Surface(mesh))
    assert np.isfinite(symmetric.nodes).all()


def test_a_branch_that_crosses_the_plane_gets_a_node_on_it():
    mesh = pear()
    across = Skeleton([[0, -0.5, 0], [0, 0.4, 0.9], [0, 0.6, 1.2]], [[0, 1], [1, 2]], np.zeros(3))
    result = make_mirror_symmetric(with_nearest_nodes(across, mesh), Surface(mesh))
    assert len(result.nodes) == 5
    assert [0, 0, 0.5] in result.nodes.round(9).tolist()
    assert asymmetry(result) == pytest.approx(0, abs=1e-9)


def test_a_loop_on_one_side_leaves_the_skeleton_as_it_is():
    mesh = pear()
    given = forked([0.3, 0.5], [-0.3])
    nodes = np.concatenate([given.nodes, [[0.1, 0.4, 0.2]]])
    looped = Skeleton(nodes, [*given.edges, [3, 6], [6, 4]], np.zeros(7))
    looped = with_nearest_nodes(looped, mesh)
    assert make_mirror_symmetric(looped, Surface(mesh)) is looped


def test_half_of_an_oblique_trunk_is_not_taken():
    """Either half and its image cover one end of the rod, and neither covers both."""
    mesh = pear()
    nodes = np.linspace([0.2, 0.4, -1.8], [0.2, -0.4, 1.8], 9)
    oblique = with_nearest_nodes(Skeleton(nodes, np.stack([np.arange(8), np.arange(1, 9)], axis=1), np.zeros(9)), mesh)
    assert make_mirror_symmetric(oblique, Surface(mesh)) is oblique


def test_the_planes_of_a_turned_torus():
    turn = Rotation.from_euler("xyz", [20, 30, 40], degrees=True).as_matrix()
    mesh = torus(1.0, 0.3)
    planes = planes_of(mesh.with_vertices(mesh.vertices @ turn.T + 5))
    normals = np.array([plane.normal for plane in planes])
    assert np.abs(normals @ turn[:, 2]).max() == pytest.approx(1)
    assert normals @ normals.T == pytest.approx(np.eye(len(normals)), abs=2e-3)


def test_the_plane_of_a_body_with_one_arm_moved_is_fitted():
    turn = Rotation.from_euler("xyz", [20, 30, 40], degrees=True).as_matrix()
    mesh = HARD_SHAPES["torso"]().mesh
    vertices = np.array(mesh.vertices)
    vertices[(vertices[:, 0] > 0.7) & (vertices[:, 2] < 0.4), 1] -= 0.1
    mesh = mesh.with_vertices(vertices @ turn.T)
    axis = np.abs(principal_axes(mesh) @ turn[:, 0]).max()
    assert np.degrees(np.arccos(axis)) > 0.5
    (plane,) = planes_of(mesh)
    assert np.degrees(np.arccos(abs(plane.normal @ turn[:, 0]))) < 0.2


@pytest.fixture(scope="module")
def tailed():
    """A body along z with a tail along y, too thin to move the centroid: the mesh, and the axes of both."""
    body, tail = np.array([[0.0, 0, -3], [0, 0, 3]]), np.array([[0.0, 0, 0.5], [0, 2.5, 0.5]])
    return mesh_solid(solid_of([(body, 1.0), (tail, 0.1)]), n_vertices=4000), body, tail


def body_with_tail(tailed, *aside):
    """The mesh and a skeleton on the axes; some nodes of the body are moved aside."""
    mesh, body, tail = tailed
    nodes = np.concatenate([np.linspace(*body, 13), np.linspace(*tail, 11)[1:]])
    chains = np.arange(13), np.array([7, *range(13, 23)])
    edges = np.concatenate([np.stack([chain[:-1], chain[1:]], axis=1) for chain in chains])
    is_on_tail = np.linalg.norm(mesh.vertices[:, :2], axis=1) > 1.05
    on_body, on_tail = (nearest_rows(mesh.vertices, part) for part in (nodes[:13], nodes[13:]))
    nodes[list(aside), 1] = 0.6
    return mesh, Skeleton(nodes, edges, np.zeros(len(nodes)), np.where(is_on_tail, 13 + on_tail, on_body))


def test_an_end_branch_on_one_side_stays_as_it_is(tailed):
    """All of the body but one node off the plane is symmetric; the tail leads towards y."""
    mesh, moved = body_with_tail(tailed, 2)
    [across] = [found for found in find_symmetries(moved, Surface(mesh)) if abs(found.plane.normal[1]) > 0.9]
    assert across.is_one_sided.tolist() == [False] * 13 + [True] * 10
    result = make_mirror_symmetric(moved, Surface(mesh))
    tail = result.nodes[np.abs(result.nodes[:, 1]) > 0.2]
    assert sorted(tail[:, 1]) == pytest.approx(np.linspace(0.25, 2.5, 10), abs=1e-3)  # normals are within 1e-3
    assert (len(result.tips), result.n_components) == (3, 1)
    assert result.nodes[result.node_of_vertex[mesh.vertices[:, 1] > 1.2], 1].min() > 0.9


def test_branches_on_one_side_that_fork_make_a_mesh_asymmetric(tailed):
    mesh, given = body_with_tail(tailed)
    nodes = np.concatenate([given.nodes, given.nodes[-1:] + [[0.05, 0, 0.0], [-0.05, 0, 0]]])
    edges = [*given.edges.tolist(), [22, 23], [22, 24]]
    forked_tail = Skeleton(nodes, edges, np.zeros(25), given.node_of_vertex)
    normals = [found.plane.normal for found in find_symmetries(forked_tail, Surface(mesh))]
    assert np.abs(normals)[:, 1].max() < 0.1


def test_a_mesh_without_area_has_no_plane_of_symmetry():
    flat = Mesh(np.zeros((3, 3)), [[0, 1, 2]])
    assert find_symmetries(with_nearest_nodes(Skeleton([[0, 0, 0]], [], [0.0]), flat), Surface(flat)) == []


def test_the_skeleton_of_a_torso_is_symmetric():
    shape = HARD_SHAPES["torso"]()
    (plane,) = planes_of(shape.mesh)
    skeleton = lbskel.skeletonize(shape.mesh)
    tips = skeleton.nodes[skeleton.tips]
    assert cKDTree(tips).query(plane.mirrored(tips))[0].max() < 0.01 * skeleton.mean_radii.min()


def test_a_bent_end_is_no_reason_to_double_a_branch_along_the_plane():
    """Noise bends an end of a ribbon into a corner, where the mean radius is small."""
    shape = HARD_SHAPES["ribbon"](ratio=7.0, length=3.0)
    skeleton = lbskel.skeletonize(with_local_noise(shape.mesh, 0.1))
    distances = lbskel.ground_truth_distances(skeleton, shape.truth)
    assert (distances.n_tips, len(skeleton.junctions)) == (2, 0)
    assert distances.accuracy_95 < 0.1  # 0.02 without noise; two branches side by side are 1.1 off


def test_nodes_that_moved_apart_are_made_symmetric_again():
    """A path along a capsule, symmetric about z = 0: one end moved aside, and both sides share it."""
    mesh, z = capsule(4.0, 0.5, 32), np.linspace(-2, 2, 5)
    before = path_in(mesh, np.stack([0 * z, 0 * z, z], axis=1))
    nodes = np.array(before.nodes)
    nodes[-1] = [0.1, 0, 2.2]
    again = keep_mirror_symmetry(before, replace(before, nodes=nodes), Surface(mesh)).nodes
    assert np.abs(again - again[::-1] * [1, 1, -1]).max() < 1e-12
    assert again[-1, 2] == pytest.approx(2.1, abs=1e-12)


def test_nodes_that_were_not_symmetric_are_left():
    mesh, z = capsule(4.0, 0.5, 32), np.array([-2.0, -1, 0, 1, 1.5])
    before = path_in(mesh, np.stack([0 * z + 0.1, 0.1 + 0 * z, z], axis=1))
    after = replace(before, nodes=before.nodes + [0, 0, 0.1])
    assert keep_mirror_symmetry(before, after, Surface(mesh)).nodes == pytest.approx(after.nodes)


def test_an_end_branch_on_one_side_is_not_drawn_to_its_mirror_image(tailed):
    """The plane is at the centroid, which the tail draws towards y by 0.02."""
    mesh, before = body_with_tail(tailed)
    moved = replace(before, nodes=before.nodes + [0, 0.2, 0])
    again = keep_mirror_symmetry(before, moved, Surface(mesh)).nodes
    assert np.abs(again[:13, 1]).max() < 0.05
    assert again[13:, 1] == pytest.approx(moved.nodes[13:, 1], abs=0.01)


def test_a_branch_that_led_to_the_other_side_alone_is_contracted():
    """An eyelet on the middle of a rod: both halves of the rod end at one of its two junctions, in the plane."""
    angles = np.linspace(0, 2 * np.pi, 25)
    eyelet = np.stack([10 + 1.2 * np.cos(angles), 0 * angles, 2.6 + 1.2 * np.sin(angles)], axis=1)
    eyelet[-1] = eyelet[0]
    mesh = mesh_solid(solid_of([([[0, 0, 0], [20, 0, 0]], 2.0), (eyelet, 0.4)], blend=0.02), n_vertices=6000)
    skeleton = lbskel.skeletonize(mesh)
    assert (len(skeleton.tips), skeleton.cycle_rank) == (2, 1)
