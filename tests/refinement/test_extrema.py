"""Geodesic extrema: the ends of limbs, and the ends that no tip reaches."""

from unittest.mock import patch

import igl
import numpy as np
import pytest
from helpers import joined, moved, path_in

from lbskel import Mesh, skeletonize
from lbskel.geometry.components import components
from lbskel.geometry.deadline import NEVER, Deadline, OutOfTime
from lbskel.refinement import extrema
from lbskel.refinement.extrema import GeodesicExtrema, _are_disks, find_extrema, is_missed
from lbskel.refinement.surface_cells import N_CELLS, surface_cells
from lbskel.shapes import capsule, chain_of_tori, make, sphere, torus, tube


def test_the_vertices_of_a_limb_lie_about_its_end(tripod):
    found = find_extrema(tripod)
    assert len(found.vertices) == 3
    assert found.limb_of_vertex[found.vertices].tolist() == [0, 1, 2]
    distances = np.linalg.norm(tripod.vertices[:, None] - tripod.vertices[found.vertices], axis=2)
    is_outer = distances.min(axis=1) < found.lengths.min() / 2
    assert (distances.argmin(axis=1) == found.limb_of_vertex)[is_outer].all()
    assert 0.5 < (found.limb_of_vertex >= 0).mean() < 1


@pytest.mark.parametrize(
    ("mesh", "n_ends"),
    [
        (capsule(4.0, 0.5, 16), 2),
        (sphere(4), 0),
        (torus(1.0, 0.3), 0),
        (chain_of_tori(2, step=0.15), 0),
        (tube([[0, 0, 0], [2, 0, 0], [2, 2, 0]], 0.3), 2),
    ],
    ids=["capsule", "sphere", "torus", "two rings", "angle"],
)
def test_the_ends_of_simple_shapes(mesh, n_ends):
    assert len(find_extrema(mesh).vertices) == n_ends


@pytest.mark.parametrize("first", [0, 7, 15])
@pytest.mark.parametrize("n_splits", [0, 1])
def test_the_ends_of_an_elliptic_plate_do_not_depend_on_where_its_fans_begin(first, n_splits):
    """Along the edges of a fan the way to most of the rim leads around its first vertex, and strips of it are limbs."""
    angles, n = 2 * np.pi * (np.arange(60) + first) / 60, 60
    rim, i, inner = np.stack([4 * np.cos(angles), np.sin(angles), 0 * angles], axis=1), np.arange(60), np.arange(1, 59)
    j, zero = (i + 1) % n, 0 * inner
    triples = [(i, j, n + j), (i, n + j, n + i), (zero, inner + 1, inner), (zero + n, n + inner, n + inner + 1)]
    plate = Mesh(np.concatenate([rim, rim + [0, 0, 0.2]]), np.concatenate([np.stack(each, axis=1) for each in triples]))
    for _ in range(n_splits):
        plate = Mesh(*igl.upsample(plate.vertices, plate.faces))
    ends = plate.vertices[find_extrema(plate).vertices]
    assert sorted(ends[:, 0]) == pytest.approx([-4, 4], abs=0.1)  # or the vertices next to them
    assert len(skeletonize(plate).tips) == 2


def test_the_ends_lie_where_the_true_tips_are():
    for name in ("tripod", "dumbbell"):
        shape = make(name, n_vertices=1500, noise=0.25)
        found = find_extrema(shape.mesh)
        tips = shape.truth.nodes[shape.truth.tips]
        distances = np.linalg.norm(shape.mesh.vertices[found.vertices][:, None] - tips, axis=2)
        radii = shape.truth.radii[shape.truth.tips]
        assert sorted(distances.argmin(axis=1)) == list(range(len(tips)))
        # an end is a radius from the center of the last ball; half a radius more for noise and the cells' size
        assert (distances.min(axis=1) < 1.5 * radii[distances.argmin(axis=1)]).all()


def test_lengths_and_radii_are_those_of_round_limbs():
    """Each half of a rod is a limb: 2 along its side and a quarter of a circle; half the surface is its area."""
    rod = capsule(4.0, 0.5, 32)
    found = find_extrema(rod)
    assert sorted(rod.vertices[found.vertices, 2]) == pytest.approx([-2.5, 2.5], abs=0.05)
    length = 2 + 0.5 * np.pi / 2
    assert found.lengths == pytest.approx(length, rel=0.15)  # to the center of the last cell before the two halves meet
    assert found.radii == pytest.approx(rod.area / 2 / (2 * np.pi * found.lengths), rel=0.1)


@pytest.mark.parametrize(("height", "n_ends"), [(0.8, 1), (-0.8, 0)])
def test_a_pit_has_no_end_where_a_limb_has_one(height, n_ends):
    """A ball with a rod on top, or a hole drilled into it, of the same size."""
    ball = sphere(5)
    x, y, z = ball.vertices.T
    angle = np.arccos(np.clip(z, -1, 1))
    is_top = angle < 0.3
    along = np.clip((0.3 - angle) / 0.2, 0, 1)[is_top]  # up the side, and then across the end
    across = np.minimum(angle / 0.1, 1)[is_top] * np.sin(0.3) / np.hypot(x, y)[is_top].clip(1e-9)
    moved = np.array(ball.vertices)
    moved[is_top] = np.stack([x[is_top] * across, y[is_top] * across, np.cos(0.3) + height * along], axis=1)
    inside_out, rod = Mesh(moved, ball.faces[:, ::-1]), capsule(6.0, 0.5)
    sheet = Mesh([[9.0, 0, 0], [10, 0, 0], [9, 1, 0]], [[0, 1, 2]])
    for mesh in (
        ball.with_vertices(moved),
        inside_out,
        joined(inside_out, rod.with_vertices(rod.vertices + 9.0)),  # each component by its own orientation
        joined(ball.with_vertices(moved), sheet),  # and by whether it is closed
    ):
        ends = find_extrema(mesh).vertices
        assert np.isin(ends, np.flatnonzero(is_top)).sum() == n_ends


def test_limbs_of_every_component_are_found():
    rod = capsule(4.0, 0.5, 12)
    two = joined(rod, moved(rod, 3.0))
    ends = two.vertices[find_extrema(two).vertices]
    assert sorted(np.round(ends[:, 0])) == [0, 0, 3, 3]
    assert np.abs(ends[:, 2]) == pytest.approx(2.5, abs=0.15)


def test_large_components_have_the_ends_that_they_have_alone_and_small_ones_share_their_cells():
    """The two rods would share 2000 cells, of which each has as many alone."""
    large, ring, small = capsule(4.0, 0.5, 48), torus(1.0, 0.3, 64, 40), capsule(2.0, 0.3, 8)
    assert len(small.vertices) < N_CELLS <= len(ring.vertices) < len(large.vertices)
    whole = joined(small, ring, moved(large, 9.0), moved(small, 6.0))
    found, alone = find_extrema(whole), find_extrema(moved(large, 9.0))
    first = len(small.vertices) + len(ring.vertices)
    assert found.vertices[:2].tolist() == (alone.vertices + first).tolist()
    assert found.lengths[:2].tolist() == alone.lengths.tolist()
    assert found.radii[:2].tolist() == alone.radii.tolist()
    assert sorted(np.round(whole.vertices[found.vertices[2:], 0])) == [0, 0, 6, 6]
    stop = first + len(large.vertices)
    assert found.limb_of_vertex[first:stop].tolist() == alone.limb_of_vertex.tolist()
    assert found.limb_of_vertex[found.vertices].tolist() == [0, 1, 2, 3, 4, 5]
    assert (found.limb_of_vertex[len(small.vertices) : first] == -1).all()


def test_the_ends_of_a_component_are_found_once():
    one, other = capsule(4.0, 0.5, 48), moved(capsule(4.0, 0.5, 48), 3.0)
    parts = components(both := joined(one, other))
    assert components(both) is parts
    ends = [find_extrema(part.mesh) for part in parts]
    with patch.object(extrema, "surface_cells", side_effect=AssertionError):
        assert len(find_extrema(both).vertices) == sum(len(each.vertices) for each in ends) == 4


def one_end(mesh, vertex, radius):
    limb_of_vertex = np.full(len(mesh.vertices), -1)
    return GeodesicExtrema(np.array([vertex]), np.array([1.0]), np.array([radius]), limb_of_vertex)


@pytest.mark.parametrize(
    ("last", "limb_radius", "node_radius", "expected"),
    [
        (1.0, 0.1, 0.1, True),  # 1.5 from the end
        (1.0, 0.6, 0.1, False),  # a tip within three radii of the limb
        (1.85, 0.1, 0.1, False),  # 0.65 from the end, within 1.5 radii of the rod, which is 0.5 thick
        (1.6, 0.1, 0.1, True),
        (1.6, 0.1, 0.7, False),  # 0.9 from the end, within 1.5 radii of the node
    ],
)
def test_an_end_is_missed_without_a_tip_or_a_ball_near_it(last, limb_radius, node_radius, expected):
    rod = capsule(4.0, 0.5, 12)
    top = int(rod.vertices[:, 2].argmax())
    skeleton = path_in(rod, [[0, 0, -2], [0, 0, last]], radius=node_radius)
    assert is_missed(one_end(rod, top, limb_radius), rod, skeleton).tolist() == [expected]


def test_an_inner_node_near_an_end_is_no_tip():
    rod = capsule(4.0, 0.5, 12)
    top = int(rod.vertices[:, 2].argmax())
    bent = path_in(rod, [[0, 0, -2], [0, 0, 1.5], [0, 0, -1.9]], radius=0.1)
    assert is_missed(one_end(rod, top, 0.4), rod, bent).tolist() == [True]
    assert is_missed(one_end(rod, top, 0.4), rod, path_in(rod, bent.nodes[:2], radius=0.1)).tolist() == [False]


def test_a_limb_around_cells_that_it_cuts_off_is_a_disk_and_a_belt_of_a_ring_is_none():
    """Without its cap, a band around a pole of a ball has two rims, as a belt of a torus has."""
    ball, ring = (surface_cells(mesh, NEVER) for mesh in (sphere(4), torus(1.0, 0.3, 64, 32)))
    z = sphere(4).vertices[ball.seeds, 2]
    bands = [np.flatnonzero((z > 0.4) & (z < 0.8)), np.flatnonzero(z < -0.4)]
    assert _are_disks(bands, ball).tolist() == [True, True]
    x, y, _ = torus(1.0, 0.3, 64, 32).vertices[ring.seeds].T
    assert _are_disks([np.flatnonzero(np.abs(np.arctan2(y, x)) < 1)], ring).tolist() == [False]


def test_after_a_deadline_ends_are_not_looked_for():
    with pytest.raises(OutOfTime):
        extrema.find_extrema(sphere(2), deadline=Deadline(0.0))


def test_edges_without_length_belong_to_the_surface():
    """The middle rings of a rod are at one point: it has two ends, as before."""
    rod = capsule(8.0, 0.5)
    is_middle = np.abs(rod.vertices[:, 2]) <= 0.6
    pinched = rod.with_vertices(np.where(is_middle[:, None], 0.0, rod.vertices))
    ends = find_extrema(pinched)
    assert np.abs(pinched.vertices[ends.vertices, 2]) == pytest.approx([4.5, 4.5], abs=0.05)
    assert ends.lengths == pytest.approx(4.9, abs=0.2)


@pytest.mark.parametrize("seed", [0, 2])
def test_the_end_of_a_limb_is_its_end_where_cells_are_longer_than_its_radius(seed, monkeypatch):
    """Cells are as large as the whole surface asks for: beside a thick soma, each covers several radii of a neurite."""
    monkeypatch.setattr("lbskel.refinement.surface_cells.N_CELLS", 20)
    monkeypatch.setattr("lbskel.refinement.surface_cells.CELL_AREA", 1e9)
    rod = capsule(8.0, 0.1, 24)
    order = np.random.default_rng(seed).permutation(len(rod.vertices))  # seeds are evenly spaced in the list
    mesh = Mesh(rod.vertices[order], np.argsort(order)[rod.faces])
    assert np.sort(mesh.vertices[find_extrema(mesh).vertices, 2]) == pytest.approx([-4.1, 4.1], abs=0.02)
