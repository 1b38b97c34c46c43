"""Creatures: for a seed one surface, in one piece, with a tip for each limb; limbs keep apart beyond their feet."""

import itertools

import numpy as np
import pytest

from lbskel.errors import MeshError
from lbskel.shapes import creatures, torus
from lbskel.shapes.creatures import ANGLE, FROM_LIMBS, FROM_TRUNK, N_LIMBS, N_SEGMENTS, creature, creature_branches
from lbskel.shapes.round_cones import solid_of

SEEDS = (0, 1, 2)


@pytest.fixture(scope="module", params=SEEDS)
def seed_and_shape(request):
    return request.param, creature(request.param, n_vertices=1500)


def branches_of(seed):
    return creature_branches(np.random.default_rng(seed))


def sampled(axis, radii):
    """Points a hundredth of each segment apart, as arc lengths, centers and radii."""
    lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1)))
    row = np.linspace(0, len(axis) - 1, 100 * (len(axis) - 1) + 1)
    columns = (np.interp(row, np.arange(len(axis)), column) for column in (lengths, *axis.T, radii))
    arc_lengths, *centers, between = columns
    return arc_lengths, np.stack(centers, axis=1), between


def limbs_of(branches):
    """For each limb its points, and their distances from the trunk's surface along it, in its radii; and its angle."""
    trunk, thick = branches[0]
    for axis, radii in branches[1:]:
        (node,) = np.flatnonzero((trunk == axis[0]).all(axis=1))
        tangent, direction = trunk[node + 1] - trunk[node - 1], axis[1] - axis[0]
        cosine = tangent @ direction / np.linalg.norm(tangent) / np.linalg.norm(direction)
        arc_lengths, centers, between = sampled(axis, radii)
        heights = (arc_lengths - thick[node] / np.sqrt(1 - cosine**2)) / radii[0]
        yield heights, centers, between, np.degrees(np.arccos(cosine))


def gap(centers, radii, others, other_radii):
    """The least distance of the spheres of two axes."""
    apart = np.linalg.norm(centers[:, None] - others, axis=2)
    return (apart - radii[:, None] - other_radii).min()


def test_the_mesh_is_in_one_piece_with_a_tip_for_each_limb(seed_and_shape):
    seed, shape = seed_and_shape
    assert shape.mesh.is_closed_manifold
    assert (shape.mesh.genus, shape.mesh.n_components) == (0, 1)
    n_limbs = len(branches_of(seed)) - 1
    assert N_LIMBS[0] <= n_limbs <= N_LIMBS[1]
    assert (shape.truth.n_tips, shape.truth.genus, shape.truth.n_components) == (n_limbs + 2, 0, 1)


def test_a_seed_gives_one_mesh(seed_and_shape):
    seed, shape = seed_and_shape
    again, other = creature(seed, n_vertices=1500), creature(seed + 1, n_vertices=1500)
    assert np.array_equal(again.mesh.vertices, shape.mesh.vertices)
    assert np.array_equal(again.mesh.faces, shape.mesh.faces)
    assert np.array_equal(again.truth.nodes, shape.truth.nodes)
    assert not np.array_equal(other.truth.nodes, shape.truth.nodes)


@pytest.mark.parametrize("seed", range(20))
def test_limbs_keep_apart_beyond_their_feet(seed):
    branches = branches_of(seed)
    _, centers, radii = sampled(*branches[0])
    limbs = list(limbs_of(branches))
    for heights, own, own_radii, angle in limbs:
        # the tangent of an arc is that of the chord from the node before to the node after, but for rounding
        assert ANGLE[0] - 1e-6 <= angle <= ANGLE[1] + 1e-6
        beyond = heights > FROM_TRUNK
        assert gap(own[beyond], own_radii[beyond], centers, radii) > 0
    for (first, own, own_radii, _), (second, other, other_radii, _) in itertools.combinations(limbs, 2):
        one, two = first > FROM_LIMBS, second > FROM_LIMBS
        assert gap(own[one], own_radii[one], other[two], other_radii[two]) > 0


def test_the_trunk_is_an_arc():
    axis, radii = branches_of(3)[0]
    steps = np.diff(axis, axis=0)
    turns = np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))
    assert len(steps) == N_SEGMENTS
    assert turns == pytest.approx(turns.mean())
    assert np.linalg.norm(steps, axis=1) == pytest.approx(np.linalg.norm(steps[0]))
    assert 0.6 <= radii.min() < radii.max() <= 1


def test_a_surface_with_a_tunnel_is_tried_again(monkeypatch):
    ring, mesh_solid, solids = torus(1.0, 0.3), creatures.mesh_solid, []

    def first_a_ring(solid, *, n_vertices):
        solids.append(solid)
        return ring if len(solids) == 1 else mesh_solid(solid, n_vertices=n_vertices)

    monkeypatch.setattr(creatures, "mesh_solid", first_a_ring)
    shape = creature(0, n_vertices=1000)
    random = np.random.default_rng(0)
    first, second = (solid_of(creature_branches(random)).truth.nodes for _ in range(2))
    assert np.array_equal(solids[0].truth.nodes, first)
    assert np.array_equal(shape.truth.nodes, second)
    assert shape.mesh.genus == 0

    monkeypatch.setattr(creatures, "mesh_solid", lambda solid, *, n_vertices: ring)
    with pytest.raises(MeshError, match="seed 5: take another seed"):
        creature(5)
