"""The score on a mesh: known values on shapes in closed form, and a verdict for each fault put into a skeleton."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from helpers import joined, mesh_of_branches, moved, nearest_rows, slab

from lbskel import Mesh, MeshError, Skeleton, resample, score, skeletonize
from lbskel.evaluation.measures import MEASURES
from lbskel.geometry.vertex_map import is_in_largest_piece
from lbskel.preprocess import simplify
from lbskel.shapes import capsule, chain_of_tori, cylinder, make, mesh_solid, solid_of, sphere, torus, tube


@pytest.fixture(scope="module")
def limbs():
    """A body with six limbs and its skeleton."""
    shape = make("limbs", n_vertices=1200)
    return shape.mesh, skeletonize(shape.mesh)


@pytest.fixture(scope="module")
def rings(two_rings):
    return two_rings, skeletonize(two_rings)


def without(skeleton, gone, into):
    """Some nodes taken out, their vertices given to another one."""
    target = np.where(np.isin(np.arange(len(skeleton.nodes)), gone), into, np.arange(len(skeleton.nodes)))
    kept = np.setdiff1d(np.arange(len(skeleton.nodes)), gone)
    new_of = np.full(len(skeleton.nodes), -1)
    new_of[kept] = np.arange(len(kept))
    edges = new_of[skeleton.edges]
    return Skeleton(
        skeleton.nodes[kept],
        edges[(edges >= 0).all(axis=1)],
        skeleton.radii[kept],
        new_of[target[skeleton.node_of_vertex]],
    )


def with_edges(skeleton, edges):
    return Skeleton(skeleton.nodes, edges, skeleton.radii, skeleton.node_of_vertex)


def end_branch(skeleton):
    """From the junction to the tip."""
    branches = [b if skeleton.degrees[b[-1]] == 1 else b[::-1] for b in skeleton.branches]
    return next(b for b in branches if skeleton.degrees[b[-1]] == 1)


def chain(points):
    """A polyline as a skeleton without radii and without a map."""
    n = len(points)
    return Skeleton(np.array(points, float), np.stack([np.arange(n - 1), np.arange(1, n)], axis=1), np.zeros(n))


def leg_cut_off(skeleton):
    branch = end_branch(skeleton)
    return without(skeleton, branch[1:], branch[0])


def leg_cut_in_half(skeleton):
    branch = end_branch(skeleton)
    half = len(branch) // 2
    return without(skeleton, branch[half:], branch[half - 1])


def beside_the_middle(skeleton, by):
    """An end branch moved sideways by a share of the radius, all but the three nodes at its ends."""
    branch = end_branch(skeleton)
    along = skeleton.nodes[branch[-1]] - skeleton.nodes[branch[0]]
    aside = np.cross(along, [0.3, 0.5, 0.8])
    nodes = np.array(skeleton.nodes)
    inner = branch[3:-3]
    nodes[inner] += by * skeleton.radii[inner, None] * aside / np.linalg.norm(aside)
    return replace(skeleton, nodes=nodes)


def shaken(skeleton, by=0.3):
    nodes = np.random.default_rng(0).normal(size=skeleton.nodes.shape)
    return replace(skeleton, nodes=skeleton.nodes + by * skeleton.radii[:, None] * nodes)


def short_cut(skeleton):
    return with_edges(skeleton, [*skeleton.edges.tolist(), skeleton.tips[:2].tolist()])


def bristles(skeleton, n=6):
    """Short spurs at a junction."""
    junction, first = skeleton.junctions[0], len(skeleton.nodes)
    aside = np.random.default_rng(0).normal(size=(n, 3))
    aside *= 0.2 * skeleton.radii[junction] / np.linalg.norm(aside, axis=1, keepdims=True)
    return Skeleton(
        np.concatenate([skeleton.nodes, skeleton.nodes[junction] + aside]),
        [*skeleton.edges.tolist(), *([junction, first + i] for i in range(n))],
        np.concatenate([skeleton.radii, np.zeros(n)]),
        skeleton.node_of_vertex,
    )


def loop_cut(skeleton):
    """One edge left out that is no way to anywhere else."""
    fewer = [with_edges(skeleton, np.delete(skeleton.edges, edge, axis=0)) for edge in range(len(skeleton.edges))]
    return next(cut for cut in fewer if cut.n_components == skeleton.n_components)


def spanning_tree(skeleton):
    """Every edge that closes a cycle left out."""
    group, kept = np.arange(len(skeleton.nodes)), []
    for a, b in skeleton.edges.tolist():
        if group[a] != group[b]:
            group[group == group[a]] = group[b]
            kept.append([a, b])
    return with_edges(skeleton, kept)


def nodes_permuted(skeleton):
    permuted = np.random.default_rng(0).permutation(len(skeleton.nodes))
    return replace(skeleton, node_of_vertex=permuted[skeleton.node_of_vertex])


def vertices_permuted(skeleton):
    return replace(skeleton, node_of_vertex=np.random.default_rng(0).permutation(skeleton.node_of_vertex))


def bare(skeleton):
    """Without a map and without radii, as some files have it."""
    return replace(skeleton, node_of_vertex=[], radii=np.zeros(len(skeleton.nodes)))


def test_a_good_skeleton_passes_in_every_measure(limbs, rings):
    fine_rings = chain_of_tori(2, step=0.1)
    for mesh, skeleton in (limbs, (fine_rings, skeletonize(fine_rings))):
        found = score(skeleton, mesh)
        assert set(found.verdicts.values()) == {"pass"}
        assert found.verdict == "pass"
        assert found.passed
    assert score(limbs[1], limbs[0]).extremities == 6
    assert score(rings[1], rings[0]).extremities == 0  # the far side of a ring is no end


@pytest.mark.parametrize(
    ("spoil", "measure"),
    [
        (leg_cut_off, "missed_limb_fraction"),
        (leg_cut_in_half, "missed_limb_fraction"),
        (lambda s: beside_the_middle(s, 0.55), "centeredness_error_worst_branch"),
        (lambda s: beside_the_middle(s, 1.6), "nodes_inside_fraction"),
        (lambda s: beside_the_middle(s, 1.6), "inside_fraction"),
        (shaken, "centeredness_error"),
        (short_cut, "extra_cycles"),
        (short_cut, "inside_fraction"),
        (short_cut, "shortcut_edges"),
        (bristles, "spurs"),
        (nodes_permuted, "coverage"),
        (nodes_permuted, "adjacent_regions"),
        (vertices_permuted, "connected_regions"),
    ],
)
def test_a_skeleton_with_limbs_spoilt(limbs, spoil, measure):
    mesh, skeleton = limbs
    found = score(spoil(skeleton), mesh)
    assert found.verdicts[measure] == "fail", asdict(found)
    assert not found.passed


def rod_with_finger(length, n=17):
    """A rod of radius 0.12 from -1 to 1 with a finger of radius 0.022, and a chain on the rod's axis."""
    rod, finger = np.array([[-1.0, 0, 0], [1, 0, 0]]), np.array([[0.5, 0, 0], [0.5, 0, length]])
    return chain(np.linspace(*rod, n)), mesh_solid(solid_of([(rod, 0.12), (finger, 0.022)]))


def test_a_small_end_may_be_missed_and_a_limb_may_not():
    """From the fillet at the rod over the cap, fingers are 5.0 and 12 of their radii long; 6 make a limb."""
    axis, mesh = rod_with_finger(0.21)
    found = score(axis, mesh)
    assert (found.extremities, found.extremities_missed, found.missed_limb_fraction) == (3, 1, 0)
    assert found.verdicts["extremities_missed"] == "warn"
    assert found.passed
    half = score(chain(axis.nodes[4:]), mesh)
    assert (half.extremities_missed, half.missed_limb_fraction) == (2, 0.5)
    assert not half.passed
    found = score(*rod_with_finger(0.3))
    assert (found.extremities, found.extremities_missed) == (3, 1)
    assert found.missed_limb_fraction == pytest.approx(1 / 3)
    assert not found.passed


@pytest.mark.parametrize("spoil", [loop_cut, spanning_tree])
def test_a_loop_lost(rings, spoil):
    mesh, skeleton = rings
    found = score(spoil(skeleton), mesh)
    assert found.extra_cycles < 0
    assert found.verdicts["extra_cycles"] == "fail"


def test_what_is_spoilt_in_one_respect_is_not_blamed_for_the_others(limbs):
    mesh, skeleton = limbs
    found = score(leg_cut_off(skeleton), mesh).verdicts
    assert [name for name, verdict in found.items() if verdict == "fail"] == ["missed_limb_fraction"]


def rod_with_axis(shift, n=13):
    """A capsule of radius 0.5 round the z axis, and a chain in it at some distance from the axis."""
    mesh = capsule(4.0, 0.5, 32)
    z = np.linspace(-2, 2, n)
    nodes = np.stack([np.full(n, shift), np.zeros(n), z], axis=1)
    nearest = np.abs(mesh.vertices[:, 2:] - z).argmin(axis=1)
    return Skeleton(nodes, np.stack([np.arange(n - 1), np.arange(1, n)], axis=1), np.zeros(n), nearest), mesh


@pytest.mark.parametrize("shift", [0.0, 0.1, 0.2])
def test_the_distance_from_the_middle_is_measured_in_radii(shift):
    found = score(*rod_with_axis(shift))
    # the radius is the mean distance of the node's vertices, which grows with the shift s to r (1 + s^2 / 4 r^2), 4 %
    # at 0.2; that they do not all lie in the plane of the section adds up to 2 %
    assert found.centeredness_error == pytest.approx(shift / 0.5, rel=0.06, abs=1e-9)
    assert found.centeredness_error_worst_branch == pytest.approx(shift / 0.5, rel=0.06, abs=1e-9)
    assert (found.nodes_inside_fraction, found.inside_fraction, found.rms_curvature) == (1, 1, 0)


def test_what_is_outside_is_told_as_a_share():
    skeleton, mesh = rod_with_axis(0.0)
    nodes = np.array(skeleton.nodes)
    nodes[7:, 0] += 3.0
    found = score(replace(skeleton, nodes=nodes), mesh)
    assert found.nodes_inside_fraction == 7 / 13
    assert found.verdicts["nodes_inside_fraction"] == "fail"


def test_bending_is_the_radius_over_the_radius_of_the_bend():
    mesh = torus(1.0, 0.2, 96, 16)
    angle = 2 * np.pi * np.arange(48) / 48
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(48)], axis=1)
    ring = Skeleton(circle, np.stack([np.arange(48), (np.arange(48) + 1) % 48], axis=1), np.zeros(48))
    # 48 chords, and an inscribed radius two percent short in 16-gons
    assert score(ring, mesh).rms_curvature == pytest.approx(0.2, rel=0.03)


def test_a_skeleton_without_a_map_is_measured_by_its_nearest_balls(limbs):
    mesh, skeleton = limbs
    found = score(bare(skeleton), mesh)
    assert (found.connected_regions, found.adjacent_regions) == (None, None)
    assert found.verdicts["adjacent_regions"] == "not measured"
    assert found.verdict == "pass"
    assert not score(bare(leg_cut_off(skeleton)), mesh).passed


def test_moving_turning_and_scaling_change_nothing(limbs):
    mesh, skeleton = limbs
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    before = asdict(score(skeleton, mesh))
    after = asdict(
        score(
            replace(skeleton, nodes=1e6 * (skeleton.nodes @ turn.T) + 1e7),
            mesh.with_vertices(1e6 * (mesh.vertices @ turn.T) + 1e7),
        )
    )
    # a sample or a vertex on the border of a count may change sides by rounding
    assert after == pytest.approx(before, rel=1e-3, abs=1e-4)


def test_open_meshes_have_the_cycles_of_the_closed_surface():
    mesh = torus(1.0, 0.3, 48, 16)
    holed = Mesh(mesh.vertices, mesh.faces[3:])
    skeleton = skeletonize(mesh)
    for preprocess in (None, "auto"):
        assert score(skeleton, holed, preprocess=preprocess).extra_cycles == 0
        assert score(loop_cut(skeleton), holed, preprocess=preprocess).extra_cycles == -1


def test_holes_that_touch_at_a_vertex_are_two():
    mesh = capsule(4.0, 0.5, 32)
    at_vertex = np.flatnonzero((mesh.faces == mesh.faces[0, 0]).any(axis=1))
    opposite = next(face for face in at_vertex if len(np.intersect1d(mesh.faces[face], mesh.faces[0])) == 1)
    holed = Mesh(mesh.vertices, np.delete(mesh.faces, [0, opposite], axis=0))
    assert score(skeletonize(mesh), holed, preprocess=None).extra_cycles == 0


def test_a_skeleton_far_outside_covers_nothing_and_reaches_no_end(limbs):
    mesh, skeleton = limbs
    found = score(replace(skeleton, nodes=skeleton.nodes + [100.0, 0, 0]), mesh)
    assert found.coverage == 0
    assert found.extremities_missed == found.extremities


def test_the_mesh_is_prepared_as_it_is_for_the_skeleton(rings):
    mesh, _ = rings
    corners = mesh.faces.ravel()
    soup = Mesh(mesh.vertices[corners], np.arange(len(corners)).reshape(-1, 3))  # as STL has it: no vertex is shared
    skeleton = skeletonize(soup)
    assert len(skeleton.node_of_vertex) == len(corners)
    found = score(skeleton, soup)
    assert found == score(skeleton, (soup.vertices, soup.faces))
    assert (found.extra_components, found.extra_cycles, found.passed) == (0, 0, True)
    with pytest.raises(MeshError, match="no component of the mesh has 4 faces and an area"):
        score(skeleton, soup, preprocess=None)


def test_a_shortcut_between_two_legs_is_longer_than_both_are_wide():
    corners = [[0, 0, 0], [0, 0, 4], [1.2, 0, 4], [1.2, 0, 0]]
    mesh = mesh_solid(solid_of([(np.array(corners, float), 0.3)]), n_vertices=3000)
    z = np.arange(0, 4.01, 0.2)
    legs = [[0, 0, each] for each in z], [[1.2, 0, each] for each in z[::-1]]
    skeleton = chain([*legs[0], [0.4, 0, 4], [0.8, 0, 4], *legs[1]])
    assert score(skeleton, mesh).shortcut_edges == 0
    across = [5, len(skeleton.nodes) - 6]  # 1.2 long at the same height; mean radii of both ends are 0.3 each
    assert score(with_edges(skeleton, [*skeleton.edges.tolist(), across]), mesh).shortcut_edges == 1


@pytest.mark.parametrize(("n_skipped", "n_shortcuts"), [(1, 0), (2, 1)])
def test_regions_are_as_wide_as_the_edges_of_the_mesh(n_skipped, n_shortcuts):
    """Rings of a tube five radii apart, with edges a little over five: ten are no shortcut, fifteen are one."""
    n, rings = 8, 10
    mesh = cylinder(1.0, 5.0 * (rings - 1), n=n, m=rings)
    z = np.linspace(22.5, -22.5, rings)
    skeleton = Skeleton(np.stack([0 * z, 0 * z, z], axis=1), [[k, k + 1] for k in range(rings - 1)], np.ones(rings))
    skeleton = replace(skeleton, node_of_vertex=np.repeat(np.arange(rings), n))
    assert score(skeleton, mesh, preprocess=None).shortcut_edges == 0
    others = [edge for edge in skeleton.edges.tolist() if edge[1] <= 3 or edge[0] >= 4 + n_skipped]
    skipping = with_edges(skeleton, [*others, [3, 4 + n_skipped]])
    assert score(skipping, mesh, preprocess=None).shortcut_edges == n_shortcuts


def test_regions_with_that_of_a_neighbor_between_them_are_no_shortcut():
    """Two rings of a tube lie between the regions of an edge; they are those of a node beside these, or farther on."""
    n, rings = 8, 10
    mesh, z = cylinder(1.0, 45.0, n=n, m=rings), np.linspace(22.5, -22.5, rings)
    chains = [[0, 1], [1, 2], [2, 3], [6, 7], [7, 8], [8, 9], [4, 5]]
    node = np.repeat(np.array([0, 1, 2, 3, 4, 4, 6, 7, 8, 9]), n)
    for between, n_shortcuts in (([3, 4], 0), ([2, 4], 1)):
        edges = [*chains, [3, 6], between]
        skeleton = Skeleton(np.stack([0 * z, 0 * z, z], axis=1), edges, np.ones(rings), node)
        assert score(skeleton, mesh, preprocess=None).shortcut_edges == n_shortcuts


def test_a_flat_part_is_covered_to_its_edges():
    """A slab five times as wide as thick on both sides of its axis."""
    mesh, x = slab(8.0, 4.0, 0.4), np.linspace(-3.8, 3.8, 39)
    nodes = np.column_stack([x, 0 * x, 0 * x])
    node = nearest_rows(mesh.vertices, nodes)
    skeleton = Skeleton(nodes, [[k, k + 1] for k in range(38)], np.ones(39), node)
    assert score(skeleton, mesh, preprocess=None).coverage > 0.9
    squeezed = replace(skeleton, nodes=nodes * [0.01, 1, 1])  # regions about one wide: those beyond |x| = 2 are too far
    assert score(squeezed, mesh, preprocess=None).coverage < 0.75


def test_a_thick_part_is_covered_by_a_node_off_its_center():
    """A ball of radius 1 on a rod of radius 0.1, whose one node is 0.8 off its center: no other is as far from it."""
    z = np.concatenate([np.linspace(0, 10, 60, endpoint=False), 11 - np.cos(np.linspace(0.1, np.pi - 0.1, 40))])
    radii = np.concatenate([np.full(60, 0.1), np.sin(np.linspace(0.1, np.pi - 0.1, 40))])
    mesh = tube(np.column_stack([0 * z, 0 * z, z]), radii, sides=24, rounded=True)
    nodes = np.array([*([0, 0, each] for each in np.linspace(0, 10, 41)), [0.8, 0, 11]])
    skeleton = Skeleton(nodes, [[k, k + 1] for k in range(41)], np.ones(42), nearest_rows(mesh.vertices, nodes))
    assert score(skeleton, mesh, preprocess=None).coverage > 0.9


def test_coverage_is_a_share_of_the_area():
    """A rod with nine tenths of its vertices at one end, which alone has nodes."""
    z = np.concatenate([np.linspace(0, 1, 80, endpoint=False), np.linspace(1, 4, 10)])
    mesh = tube(np.stack([0 * z, 0 * z, z], axis=1), 0.25, sides=24)
    found = score(chain([[0, 0, each] for each in np.linspace(0, 0.5, 6)]), mesh)
    # two radii of the last node reach sqrt(3) radii along the rod: 0.93 of 4, and one of the two ends
    assert found.coverage == pytest.approx((0.5 + 3**0.5 * 0.25) / 4, abs=0.03)


def test_what_is_near_the_surface_is_a_share_of_the_length():
    mesh = tube([[0, 0, 0], [0, 0, 4]], 0.5, sides=24)
    inner = [[0, 0, z] for z in (0.5, 1.5, 2.5)]
    # five of eight nodes run 0.02 under the surface, and a part of the edge that leads to them is as near
    near = [[0.48, 0, z] for z in (2.7, 2.8, 2.9, 3.0, 3.1)]
    skeleton = chain(inner + near)
    lengths = skeleton.edge_lengths
    shares = lengths[3:].sum() / lengths.sum(), lengths[2:].sum() / lengths.sum()
    assert shares[0] < score(skeleton, mesh).near_surface_fraction < sum(shares) / 2


def test_what_is_near_the_surface_does_not_depend_on_the_number_of_nodes():
    mesh = sphere(2)
    skeleton = skeletonize(mesh, tip_position="surface")
    few, many = (score(resample(skeleton, n_nodes=n), mesh).near_surface_fraction for n in (8, 80))
    assert few == pytest.approx(many, abs=0.01)  # half of the distance between nodes
    assert skeleton.report["passed"]


def test_a_wrong_map_puts_no_node_near_the_surface(limbs):
    """Vertices far away make the mean distance to a node's own large, but not the local radius at these vertices."""
    mesh, skeleton = limbs
    assert score(nodes_permuted(skeleton), mesh).near_surface_fraction < 0.05


def test_coverage_is_by_the_local_radius_where_a_node_is_near_the_surface():
    """A chain on the surface of a rod, 0.49 of its radius 0.5 from the axis: no point is two radii of it away."""
    skeleton, mesh = rod_with_axis(0.49, n=25)
    found = score(skeleton, mesh)
    assert found.near_surface_fraction > 0.9
    assert found.coverage == 1


def test_a_node_outside_an_open_surface_is_inside_within_half_a_radius():
    """Chains beside a pipe without ends, 0.1 and 1 outside its radius of 0.5; beside a closed rod neither is inside."""
    pipe = cylinder(0.5, 4.0, 32, 41)
    skeleton = chain(np.linspace([0, 0, -1.8], [0, 0, 1.8], 19))
    near, far = (replace(skeleton, nodes=skeleton.nodes + [shift, 0, 0]) for shift in (0.6, 1.5))
    assert score(near, pipe, preprocess=None).nodes_inside_fraction == 1
    assert score(near, pipe, preprocess=None).inside_fraction == 1
    assert score(far, pipe, preprocess=None).nodes_inside_fraction == 0
    assert score(far, pipe, preprocess=None).inside_fraction == 0
    assert score(near, capsule(4.0, 0.5, 32)).nodes_inside_fraction == 0


def test_sections_of_several_branches_do_not_count(limbs):
    # next to a junction the section is that of the body, whose centroid is not on the axis of the limb
    mesh, skeleton = limbs
    assert score(skeleton, mesh).centeredness_error < 0.05


def test_the_worst_branch_is_told_from_the_mean(limbs):
    mesh, skeleton = limbs
    found = score(beside_the_middle(skeleton, 0.55), mesh)
    assert found.centeredness_error_worst_branch > 0.4
    assert found.centeredness_error < 0.25


def test_the_worst_branch_of_many_is_measured():
    shape = make("tree")  # 22 branches
    skeleton = skeletonize(shape.mesh)
    assert skeleton.report["score"]["measures"]["centeredness_error_worst_branch"] < 0.1
    found = score(beside_the_middle(skeleton, 0.8), shape.mesh)
    assert found.verdicts["centeredness_error_worst_branch"] == found.verdict == "fail"


def test_a_cycle_that_is_not_around_its_tunnel_fails():
    """A ring inside the tube of a torus, joined to nothing, in place of the one around its hole."""
    mesh = torus(1.0, 0.3)
    skeleton = skeletonize(mesh)
    assert score(skeleton, mesh).tunnels_missed == 0
    shrunk = replace(skeleton, nodes=[0.95, 0, 0] + 0.1 * skeleton.nodes)
    found = score(shrunk, mesh)
    assert (found.extra_cycles, found.tunnels_missed, found.verdicts["tunnels_missed"]) == (0, 1, "fail")
    opened = replace(skeleton, edges=skeleton.edges[1:], report={"loops_opened": 1})
    assert score(opened, mesh).tunnels_missed == 0  # on purpose


def test_a_cycle_lost_is_not_made_up_for_by_one_too_many_elsewhere():
    ring, rod = torus(1.0, 0.2, 48, 12), moved(capsule(3.0, 0.3, 16), 4.0)
    mesh = joined(ring, rod)
    skeleton = skeletonize(mesh)
    assert score(skeleton, mesh).extra_cycles == 0
    nodes_of_rod = np.flatnonzero(skeleton.nodes[:, 0] > 2.5)
    cut = loop_cut(skeleton).edges.tolist()
    first, last = nodes_of_rod[skeleton.nodes[nodes_of_rod, 2].argsort()[[0, -1]]].tolist()
    assert score(with_edges(skeleton, cut), mesh).extra_cycles == -1
    assert score(with_edges(skeleton, [*cut, [first, last]]), mesh).extra_cycles == 2


def test_components_too_small_for_a_skeleton_need_none():
    mesh = capsule(4.0, 0.5, 16)
    triangle = Mesh(np.eye(3) * 0.1 + 5, [[0, 1, 2]])
    skeleton, _ = rod_with_axis(0.0)
    assert score(bare(skeleton), joined(mesh, triangle), preprocess=None).extra_components == 0


def test_radii_reach_to_the_surface_of_the_own_body():
    """Two long boxes that cross: the axis of one runs through the other, whose surface is nearer than its own."""
    one = tube([[0, 0, -3], [0, 0, 3]], 0.5, sides=24)
    thin = tube([[-1.5, 0, 0], [1.5, 0, 0]], 0.1, sides=24)
    z = np.linspace(-2.5, 2.5, 26)
    axis = chain([[0, 0, each] for each in z])
    crossing = chain([[each, 0, 0.0] for each in np.linspace(-1.4, 1.4, 29)])
    skeleton = Skeleton(
        np.concatenate([axis.nodes, crossing.nodes]),
        np.concatenate([axis.edges, crossing.edges + 26]),
        np.zeros(55),
        np.concatenate(
            [
                np.abs(one.vertices[:, 2:] - z).argmin(axis=1),
                26 + np.abs(thin.vertices[:, :1] - crossing.nodes[:, 0]).argmin(axis=1),
            ]
        ),
    )
    found = score(skeleton, joined(one, thin), preprocess=None)
    assert found.near_surface_fraction == 0
    assert found.coverage == 1


def test_components_are_counted():
    mesh = capsule(4.0, 0.5, 16)
    two = joined(mesh, moved(mesh, 3.0))
    skeleton, _ = rod_with_axis(0.0)
    found = score(bare(skeleton), two)
    assert found.extra_components == -1
    assert not found.passed


def test_a_single_node_is_the_skeleton_of_a_ball():
    ball = sphere(3)
    found = score(Skeleton(np.zeros((1, 3)), [], np.ones(1)), ball)
    assert (found.centeredness_error, found.rms_curvature, found.coverage) == (None, 0, 1)
    assert found.passed


def test_the_report_is_plain(limbs):
    mesh, skeleton = limbs
    again = json.loads(json.dumps(score(skeleton, mesh).report(), allow_nan=False))
    assert set(again["verdicts"]) == set(MEASURES)
    assert again["verdict"] == "pass"


def test_what_cannot_be_scored_says_why(ring):
    node = np.zeros((1, 3))
    with pytest.raises(MeshError, match="no nodes"):
        score(Skeleton(np.empty((0, 3)), [], []), ring)
    with pytest.raises(MeshError, match="map is for 7 vertices, but the mesh has 128"):
        score(Skeleton(node, [], [0], np.zeros(7)), ring)
    with pytest.raises(MeshError, match="all vertices of the mesh lie at one point"):
        score(Skeleton(node, [], [0]), ring.with_vertices(0 * ring.vertices))


@pytest.mark.parametrize(
    "spoilt", [np.zeros((9, 3)), np.full((9, 3), 1e9), np.random.default_rng(0).normal(size=(9, 3))]
)
def test_any_skeleton_gets_a_score(ring, spoilt):
    edges = np.random.default_rng(1).integers(9, size=(14, 2))
    found = score(Skeleton(spoilt, edges, np.zeros(9)), ring)
    assert np.isfinite([value for value in asdict(found).values() if value is not None]).all()
    assert not found.passed


def test_the_map_of_skeletonize_is_in_one_piece(limbs):
    mesh, skeleton = limbs
    assert is_in_largest_piece(skeleton.node_of_vertex, mesh).all()


def test_vertices_without_a_face_have_no_influence(limbs):
    mesh, skeleton = limbs
    half = without(skeleton, skeleton.end_branches[0][1:], skeleton.end_branches[0][0])
    far = Mesh(np.concatenate([mesh.vertices, mesh.vertices + [9, 0, 0]]), mesh.faces)
    longer = replace(half, node_of_vertex=np.concatenate([half.node_of_vertex, half.node_of_vertex]))
    for one, other in ((half, longer), (replace(half, node_of_vertex=[]), replace(half, node_of_vertex=[]))):
        found, expected = score(other, far, preprocess=None), score(one, mesh, preprocess=None)
        assert asdict(found) == pytest.approx(asdict(expected))


@pytest.mark.parametrize("n_faces", [600, 300, 150])
def test_gaps_between_regions_of_a_decimated_mesh_are_no_fault(n_faces):
    """There are about as many nodes as vertices, so that most regions are single vertices."""
    tube = mesh_of_branches([([[0, 0, 0], [0, 0, 30]], 1.0)], step=0.4)
    coarse = simplify(tube, target_faces=n_faces).mesh
    found = score(skeletonize(coarse), coarse)
    assert (found.verdicts["adjacent_regions"], found.verdict != "fail") == ("pass", True)
