"""Growth of limbs: a limb without a branch gets one, whether it is found by its end or by what is uncovered."""

import igl
import numpy as np
import pytest
from helpers import box_mesh, mesh_of_branches, nearest_rows, path_in, reversed_proxy, without_faces

from lbskel import Mesh, Skeleton, skeletonize
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement import limb_growth, uncovered_limbs
from lbskel.refinement.limb_growth import grow_limbs, grow_limbs_without_tip
from lbskel.refinement.uncovered_limbs import Limbs
from lbskel.shapes import capsule, make, mesh_solid, solid_of, sphere
from lbskel.skeleton.editing import contract_branches


@pytest.fixture(scope="module")
def whole(tripod):
    return skeletonize(tripod)


@pytest.fixture(params=["by its end", "by what is uncovered"])
def found(request, monkeypatch):
    """Limbs are found in one of the two ways only."""
    if request.param == "by its end":
        monkeypatch.setattr(uncovered_limbs, "MIN_BULGE", 1e9)
    else:
        monkeypatch.setattr(limb_growth, "is_missed", lambda extrema, *_: np.zeros(len(extrema.vertices), dtype=bool))


@pytest.mark.usefixtures("found")
@pytest.mark.parametrize("surface_of", [Surface, reversed_proxy])
@pytest.mark.parametrize("number", range(3))
def test_a_removed_branch_grows_again(whole, tripod, number, surface_of):
    branch = whole.end_branches[number]
    grown = grow_limbs(contract_branches(whole, [branch]), surface_of(tripod))
    assert (len(grown.tips), len(grown.junctions), grown.cycle_rank, grown.n_components) == (3, 1, 0, 1)
    distances = np.linalg.norm(grown.nodes[grown.tips] - whole.nodes[branch[-1]], axis=1)
    tip = grown.tips[distances.argmin()]
    assert distances.min() < whole.radii[branch[-1]]  # within the last inscribed ball
    [again] = [b for b in grown.end_branches if b[-1] == tip]
    axis = np.linalg.norm(grown.nodes[again[1:], None] - whole.nodes[branch], axis=2).min(axis=1)
    assert axis.max() < 0.5 * np.median(whole.radii[branch])  # nodes are half a radius distances
    outer = np.isin(whole.node_of_vertex, branch[4 * len(branch) // 5 :])  # nearer to the tip than to the junction
    assert np.isin(grown.node_of_vertex[outer], again[1:]).all()
    for other in whole.end_branches:  # the vertices at the other ends keep their nodes
        if other[-1] != branch[-1]:
            at_end = np.isin(whole.node_of_vertex, other[len(other) // 2 :])
            assert np.array_equal(grown.nodes[grown.node_of_vertex[at_end]], whole.nodes[whole.node_of_vertex[at_end]])


def test_a_branch_that_ends_halfway_goes_on_from_its_tip(whole, tripod):
    branch = whole.end_branches[0]
    half = contract_branches(whole, [branch[len(branch) // 2 :]])
    grown = grow_limbs(half, Surface(tripod))
    assert (len(grown.tips), len(grown.junctions)) == (3, 1)
    for node in half.nodes:
        assert (grown.nodes == node).all(axis=1).any()
    ends = np.linalg.norm(grown.nodes[grown.tips] - whole.nodes[branch[-1]], axis=1)
    assert ends.min() < whole.radii[branch[-1]]
    assert grown.length == pytest.approx(whole.length, rel=0.05)


@pytest.mark.usefixtures("found")
def test_branches_grow_on_a_bare_loop_too():
    """All branches of a ring with spikes are removed, so there is no tip near any end."""
    shape = make("spiked_ring", n_vertices=2500)
    skeleton = skeletonize(shape.mesh)
    loop = contract_branches(skeleton, skeleton.end_branches)
    assert (len(loop.tips), loop.cycle_rank) == (0, 1)
    grown = grow_limbs(loop, Surface(shape.mesh))
    assert (len(grown.tips), grown.cycle_rank, grown.n_components) == (len(shape.truth.tips), 1, 1)


@pytest.fixture
def limbs_are(monkeypatch):
    """A function that makes the limbs that are found."""

    def set_limbs(limbs):
        monkeypatch.setattr(limb_growth, "is_missed", lambda extrema, *_: np.zeros(len(extrema.vertices), dtype=bool))
        monkeypatch.setattr(limb_growth, "find_limbs", lambda *_: limbs)

    return set_limbs


@pytest.fixture(scope="module")
def rod():
    """From z = -4.5 to 4.5, of radius 0.5."""
    return capsule(8.0, 0.5, 32)


def test_a_branch_follows_the_centerline_to_the_center_of_the_cap(rod, limbs_are):
    z = rod.vertices[:, 2]
    limbs_are(Limbs(np.array([z.argmax()]), np.array([0.5]), np.where(z > 0.5, 0, -1)))
    lower = path_in(rod, np.linspace([0, 0, -4], [0, 0, 0], 9), radius=0.5)
    grown = grow_limbs(lower, Surface(rod))
    new = np.arange(8, len(grown.nodes))
    assert np.array_equal(grown.nodes[:9], lower.nodes)
    assert np.array_equal(grown.edges[8:], np.stack([new[:-1], new[1:]], axis=1))
    assert grown.nodes[-1] == pytest.approx([0, 0, 4], abs=0.05)
    assert np.abs(grown.nodes[:, :2]).max() < 1e-9
    assert (np.diff(grown.nodes[:, 2]) > 0).all()
    assert (grown.node_of_vertex[z > 4.1] == new[-1]).all()


def test_a_limb_whose_cap_has_a_node_gets_no_branch(rod, limbs_are):
    z = rod.vertices[:, 2]
    limbs_are(Limbs(np.array([z.argmax()]), np.array([0.5]), np.where(z > 0.5, 0, -1)))
    whole = path_in(rod, np.linspace([0, 0, -4], [0, 0, 4.1], 17), radius=0.5)
    grown = grow_limbs(whole, Surface(rod))
    assert np.array_equal(grown.nodes, whole.nodes)
    assert np.array_equal(grown.node_of_vertex, whole.node_of_vertex)


def test_a_tip_in_the_cap_is_extended_to_its_center(rod, limbs_are):
    z = rod.vertices[:, 2]
    limbs_are(Limbs(np.array([z.argmax()]), np.array([0.5]), np.where(z > 0.5, 0, -1)))
    short = path_in(rod, np.linspace([0, 0, -4], [0, 0, 3.75], 17), radius=0.5)
    grown = grow_limbs(short, Surface(rod))
    assert len(grown.nodes) == 18
    assert grown.edges[-1].tolist() == [16, 17]
    assert grown.nodes[17] == pytest.approx([0, 0, 4], abs=0.05)


def test_a_branch_does_not_follow_a_centerline_outside(rod, limbs_are, monkeypatch):
    z = rod.vertices[:, 2]
    limbs_are(Limbs(np.array([z.argmax()]), np.array([0.5]), np.where(z > 0.5, 0, -1)))
    outside = np.array([[0.0, 0, 1], [2, 0, 2], [0, 0, 4]])
    monkeypatch.setattr(limb_growth, "trace_limbs", lambda *_: [(outside, np.full(3, 0.5))])
    grown = grow_limbs(path_in(rod, np.linspace([0, 0, -4], [0, 0, 0], 9), radius=0.5), Surface(rod))
    assert np.abs(grown.nodes[:, :2]).max() < 1e-9


@pytest.mark.parametrize(("radius", "height"), [(0.5, 4.0), (4.0, 2.25)])
def test_a_branch_leads_straight_to_the_center_of_the_cap_or_half_the_way(rod, limbs_are, radius, height):
    """In a rod whose upper end is at 4.5, where no ring is whole; a radius of 4 is that of a flat limb."""
    lower = path_in(rod, np.linspace([0, 0, -4], [0, 0, 0], 9), radius=0.5)
    top = rod.vertices[:, 2].argmax()
    limbs_are(Limbs(np.array([top]), np.array([radius]), np.where(np.arange(len(rod.vertices)) == top, 0, -1)))
    grown = grow_limbs(lower, Surface(rod))
    assert np.array_equal(grown.nodes[:9], lower.nodes)
    assert grown.edges[8:].tolist() == [[8, 9]]
    assert grown.nodes[9] == pytest.approx([0, 0, height])
    assert grown.node_of_vertex[top] == 9


@pytest.mark.usefixtures("found")
def test_a_complete_skeleton_is_returned_unchanged(whole, tripod):
    assert grow_limbs(whole, Surface(tripod)) is whole
    ball = sphere(3)
    skeleton = skeletonize(ball)
    assert grow_limbs(skeleton, Surface(ball)) is skeleton


def test_a_limb_without_a_tip_gets_a_branch_and_one_with_a_tip_gets_none(whole, tripod):
    """Before nodes are centered, all tips are short of the ends of their limbs."""
    surface, branches = Surface(tripod), whole.end_branches
    short = contract_branches(whole, [branch[len(branch) // 3 :] for branch in branches])
    assert grow_limbs_without_tip(short, surface) is short
    assert len(grow_limbs(short, surface).nodes) > len(short.nodes)
    gone = contract_branches(short, [short.end_branches[1]])
    grown = grow_limbs_without_tip(gone, surface)
    assert (len(gone.tips), len(grown.tips)) == (2, 3)
    ends = np.array([whole.nodes[branch[-1]] for branch in branches])
    new = [tip for tip in grown.nodes[grown.tips] if not (gone.nodes == tip).all(axis=1).any()]
    assert len(new) == 1
    assert np.linalg.norm(ends - new[0], axis=1).min() < whole.radii[branches[0][-1]]


def test_a_short_limb_of_a_thick_body_gets_a_branch():
    """A tail of radius 0.2 is five of its radii long, but only one of these is beyond 1.75 radii of the body."""
    body, tail = np.array([[-3.0, 0, 0], [3, 0, 0]]), np.array([[1.9, 0, 0], [1.9, 0, -1.8]])
    mesh = mesh_of_branches([(body, 1.0), (tail, 0.2)], step=0.09)
    grown = grow_limbs(path_in(mesh, np.linspace(*body, 25), radius=1.0), Surface(mesh))
    assert len(grown.tips) == 3
    assert np.linalg.norm(grown.nodes[grown.tips] - tail[1], axis=1).min() < 0.2


def test_each_of_four_short_limbs_in_a_row_gets_a_branch():
    """They stand out of a capsule by 3.5 of their radii, which is less than its own; one of them is beyond its end."""
    feet = np.array([[x, 0, 0] for x in (-0.8, -0.2, 0.4, 1.0)])
    body, limbs = (
        (np.array([[-1.0, 0, 0], [1, 0, 0]]), 0.5),
        [(np.array([foot, foot + [0, 0, 0.85]]), 0.14) for foot in feet],
    )
    skeleton = skeletonize(mesh_solid(solid_of([body, *limbs]), n_vertices=3000))
    tips = skeleton.nodes[skeleton.tips]
    ends = feet + [0, 0, 0.85]
    assert np.linalg.norm(tips[nearest_rows(ends, tips)] - ends, axis=1).max() < 0.3


def test_a_flat_limb_gets_a_branch():
    """An ear six times as wide as thick: no point of its axis is deeper than a fifth of the radius of its area."""
    body, ear = np.array([[-3.0, 0, 0], [3, 0, 0]]), np.array([[0.0, 0, 0], [0, 0, 3.5]])
    mesh = mesh_of_branches([(body, 1.0), (ear, 0.6)], step=0.09)
    flat = np.interp(mesh.vertices[:, 2], [1.0, 1.5], [1.0, 1 / 6])
    mesh = mesh.with_vertices(mesh.vertices * np.stack([0 * flat + 1, flat, 0 * flat + 1], axis=1))
    grown = grow_limbs(path_in(mesh, np.linspace(*body, 25), radius=1.0), Surface(mesh))
    assert len(grown.tips) == 3
    [tip] = grown.tips[grown.nodes[grown.tips, 2] > 1]
    # the ear's end is at 4.1, and a ring around it is as long as a circle of radius 0.4
    assert grown.nodes[tip] == pytest.approx([0, 0, 3.7], abs=0.1)
    assert np.abs(grown.nodes[:, 1]).max() < 0.1


def test_of_three_fins_side_by_side_each_gets_a_branch():
    """Each end is nearer to the axis of the next fin than the mean radius of that fin, which is four times as wide."""
    body = np.array([[-3.0, 0, 0], [3, 0, 0]])
    fins = [(np.array([[x, 0, 0], [x, 0, height]]), 0.2) for x, height in ((-0.65, 3.2), (0, 2.7), (0.65, 3.2))]
    mesh = mesh_of_branches([(body, 1.0), *fins], step=0.09)
    wide = np.interp(mesh.vertices[:, 2], [1.0, 1.3], [1.0, 4.0])
    mesh = mesh.with_vertices(mesh.vertices * np.stack([0 * wide + 1, wide, 0 * wide + 1], axis=1))
    grown = grow_limbs(path_in(mesh, np.linspace(*body, 25), radius=1.0), Surface(mesh))
    assert len(grown.tips) == 2 + 3


def test_a_limb_grows_from_a_node_of_its_own_vertices():
    """The axis of the leg is nearer to that of the tail than the axis of the body is."""
    body, leg = np.array([[-3.0, 0, 0], [3, 0, 0]]), np.array([[0.75, 0, 0], [0.75, 0, -3.5]])
    root, end = np.array([1.5, 0, -1.0]), np.array([1.95, 0, -2.2])
    mesh = mesh_of_branches([(body, 1.0), (leg, 0.3), ([[1.5, 0, 0], root, end], 0.2)], step=0.09)
    nodes = np.concatenate([np.linspace(*body, 25), np.linspace(*leg, 15)[1:]])
    edges = [*([i, i + 1] for i in range(24)), [15, 25], *([i, i + 1] for i in range(25, 38))]
    is_on_leg = (mesh.vertices[:, 2] < -1) & (mesh.vertices[:, 0] < 1.15)
    node_of_vertex = np.where(
        is_on_leg, 25 + nearest_rows(mesh.vertices, nodes[25:]), nearest_rows(mesh.vertices, nodes[:25])
    )
    skeleton = Skeleton(nodes, edges, np.repeat([1.0, 0.3], [25, 14]), node_of_vertex)
    grown = grow_limbs(skeleton, Surface(mesh))
    [branch] = [b for b in grown.end_branches if np.linalg.norm(grown.nodes[b[-1]] - end) < 0.3]
    assert np.abs(grown.nodes[branch[0], 1:]).max() < 0.1
    assert grown.nodes[branch[0], 0] > 1


@pytest.mark.parametrize(("n_sides", "length"), [(100, 12.0), (200, 8.0)])
def test_the_flat_ends_of_a_cylinder_of_long_faces_get_no_fork(n_sides, length):
    """Each side is two triangles; a strip of them is long in its own radii, and its end is on the edge of a cap."""
    around = np.linspace(0, 2 * np.pi, n_sides, endpoint=False)
    ring = np.stack([np.cos(around), np.sin(around), np.zeros(n_sides)], axis=1)
    V = np.concatenate([ring, ring + [0, 0, length], [[0, 0, 0], [0, 0, length]]])
    i, j = np.arange(n_sides), (np.arange(n_sides) + 1) % n_sides
    bottom, top = np.full(n_sides, 2 * n_sides), np.full(n_sides, 2 * n_sides + 1)
    corners = [(i, j, n_sides + j), (i, n_sides + j, n_sides + i), (bottom, j, i), (top, n_sides + i, n_sides + j)]
    skeleton = skeletonize((V, np.concatenate([np.stack(each, axis=1) for each in corners])))
    assert (len(skeleton.tips), len(skeleton.junctions)) == (2, 0)
    # as small as the rounding of the contraction of a mesh that is symmetric but for the diagonals of its sides
    assert np.abs(skeleton.nodes[:, :2]).max() < 0.01


@pytest.mark.parametrize(
    ("sides", "n_faces"),
    [((0.2, 3, 9), 12), ((0.2, 3, 9), 48), ((0.2, 5, 10), 192), ((0.2, 3, 15), 768), ((0.05, 2, 12), 768)],
)
def test_the_corners_of_a_thin_plate_of_few_faces_are_no_limbs(sides, n_faces):
    """They are far from the balls of the plate's axis; up to 26 tips without looking from one corner to the other."""
    plate = box_mesh(sides)
    while len(plate.faces) < n_faces:
        plate = Mesh(*igl.upsample(plate.vertices, plate.faces))
    skeleton = skeletonize(plate)
    assert (len(skeleton.tips), len(skeleton.junctions)) == (2, 0)


@pytest.mark.parametrize(
    ("axis", "step"),
    [
        ((0.4378, 0.4218, -0.794), 0.25),
        ((1, 2, 3), 0.25),
        ((-0.7332, 0.6717, 0.1065), 0.15),
        ((-0.64, -0.13, 0.76), 0.2),
        ((0.68, 0.73, 0.07), 0.3),
    ],
)
def test_the_teeth_of_a_jagged_cut_are_no_limbs(axis, step):
    """Whole faces beyond two planes are left out of a tube, as a vessel is cropped."""
    axis = np.array(axis) / np.linalg.norm(axis)
    whole = mesh_of_branches([([[0, 0, 0], 12 * axis], 1.0)], step=step)
    along = whole.vertices[whole.faces].mean(axis=1) @ axis
    skeleton = skeletonize(without_faces(whole, np.flatnonzero((along < 2) | (along > 10))))
    assert (len(skeleton.tips), skeleton.report["score"]["verdict"]) == (2, "pass")
    assert np.sort(skeleton.nodes[skeleton.tips] @ axis) == pytest.approx([2, 10], abs=step)
