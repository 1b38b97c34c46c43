"""Limbs: pieces of surface that are told from spots, their axes, and tips that reach their ends."""

import numpy as np
import pytest

from lbskel import Mesh, Skeleton
from lbskel.geometry.surface_queries import Surface
from lbskel.refinement.level_sets import find_geodesic_caps
from lbskel.refinement.tips import MIN_LIMB_LENGTH, extend_tips
from lbskel.shapes import capsule, mesh_solid, solid_of, sphere


def hook():
    """A thick body with a thin limb that turns round by 150 degrees, and the axis of that."""
    body = np.array([[-1.0, 0, 0], [0, 0, 0]])
    angle = np.linspace(0, np.radians(150), 12)
    bend = np.stack([0.5 + 0.3 * np.sin(angle), 0.3 - 0.3 * np.cos(angle), 0 * angle], axis=1)
    ahead = (bend[-1] - bend[-2]) / np.linalg.norm(bend[-1] - bend[-2])
    limb = np.concatenate([[[0.0, 0, 0]], bend, bend[-1] + np.linspace(0.05, 0.4, 8)[:, None] * ahead])
    return mesh_solid(solid_of([(body, 0.3), (limb, 0.1)]), n_vertices=1200), limb


def test_the_half_of_a_rod_is_a_limb_and_its_axis_is_straight():
    rod = capsule(4.0, 0.5, 48)
    piece = np.where(rod.vertices[:, 2] > 0.3, 7, -1)
    (number, limb) = next(iter(find_geodesic_caps(rod, piece).items()))
    assert number == 7
    assert limb.end == pytest.approx([0, 0, 2.5], abs=1e-9)
    # from the pole: a quarter of a circle, and 1.7 along the rod, less the row of vertices at the border
    assert limb.length == pytest.approx(0.5 * np.pi / 2 + 1.7, rel=0.05)
    # the cap has less area than the cylinder of its length by 1 - 2 / pi
    assert limb.radius == pytest.approx(0.5 * (1 - (np.pi / 2 - 1) * 0.5 / limb.length), rel=0.05)
    assert limb.axis[:, :2] == pytest.approx(0, abs=1e-6)
    assert (np.diff(limb.axis[:, 2]) > 0).all()
    assert 0.3 < limb.axis[0, 2] < 0.3 + 0.25  # a step of half a radius
    assert limb.axis[-1, 2] == pytest.approx(2.0, abs=0.1)  # the rows of vertices are 0.06 to 0.1 apart


def test_a_cap_and_a_flat_spot_are_no_limbs():
    ball = sphere(4)
    for height, most in ((0.0, 2.5), (0.9, 2.1)):  # half a ball, and what is nearly flat
        limb = find_geodesic_caps(ball, np.where(ball.vertices[:, 2] > height, 0, -1))[0]
        # distances along edges are up to 15 % too long
        assert limb.length / limb.radius < 1.15**2 * most
        assert limb.length / limb.radius < MIN_LIMB_LENGTH


def test_what_has_no_border_is_no_limb():
    ball = sphere(2)
    assert find_geodesic_caps(ball, np.zeros(len(ball.vertices), dtype=int)) == {}
    assert find_geodesic_caps(ball, np.full(len(ball.vertices), -1)) == {}
    assert find_geodesic_caps(ball, np.where(np.arange(len(ball.vertices)) == 5, 0, -1)) == {}


def test_pieces_do_not_see_each_other():
    rod = capsule(4.0, 0.5, 24)
    z = rod.vertices[:, 2]
    both = find_geodesic_caps(rod, np.select([z > 0.3, z < -0.3], [0, 1], -1))
    alone = find_geodesic_caps(rod, np.where(z > 0.3, 0, -1))
    assert sorted(both) == [0, 1]
    assert both[0].length == alone[0].length
    assert both[1].axis == pytest.approx(both[0].axis * [1, 1, -1], abs=1e-6)


def test_a_tip_follows_a_limb_that_turns_back():
    mesh, limb = hook()
    far = np.linalg.norm(mesh.vertices[:, None] - limb, axis=2)
    on_limb = (far.min(axis=1) < 0.15) & (far.argmin(axis=1) > 0)
    # drawn back to where the limb begins, and out of it
    nodes = np.array([[-1.0, 0, 0], [-0.5, 0, 0], [0, 0, 0], [0.4, -0.2, 0]])
    node = np.where(on_limb, 3, np.abs(mesh.vertices[:, :1] - nodes[:3, 0]).argmin(axis=1))
    short = Skeleton(nodes, [[0, 1], [1, 2], [2, 3]], np.zeros(4), node)
    long = extend_tips(short, Surface(mesh))
    assert len(long.tips) == 2
    apart = np.linalg.norm(long.nodes[:, None] - limb, axis=2).min(axis=1)
    assert np.count_nonzero(long.nodes[:, 0] > 0.2) > 4
    # the limb's axis is known at points 0.07 apart, its radius is 0.1
    assert apart[long.nodes[:, 0] > 0.2].max() < 0.06
    assert np.linalg.norm(long.nodes[long.tips] - limb[-1], axis=1).min() < 0.05
    assert long.n_components == 1
    assert np.linalg.norm(mesh.vertices - long.nodes[long.node_of_vertex], axis=1)[on_limb].max() < 0.25


def test_a_crumpled_piece_does_no_harm():
    rng = np.random.default_rng(0)
    V, F = rng.normal(size=(40, 3)), rng.integers(40, size=(120, 3))
    F = F[(F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])]
    V[5] = V[6]
    for limb in find_geodesic_caps(Mesh(V, F), rng.integers(-1, 3, size=40)).values():
        assert np.isfinite(limb.axis).all()
