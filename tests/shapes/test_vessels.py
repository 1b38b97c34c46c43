"""Trees of vessels: Murray's law of radii and angles, distances between vessels."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lbskel.shapes.round_cones import solid_of
from lbskel.shapes.vessels import LENGTH, murray_branches


@pytest.fixture(scope="module")
def branches():
    return murray_branches(12, seed=2)


def forks(branches):
    """For each branch but the first: the radii of parent, thicker and thinner child, and their directions."""
    for axis, radii in branches[1:]:
        for trunk, thick in branches:
            found = np.flatnonzero((trunk == axis[0]).all(axis=1))
            if len(found) and (found[0] > 0):
                k = found[0]
                around = trunk[k] - trunk[k - 1], trunk[k + 1] - trunk[k], axis[1] - axis[0]
                yield (thick[k], thick[k + 1], radii[0]), [each / np.linalg.norm(each) for each in around]


def test_every_fork_follows_the_laws_of_murray(branches):
    found = list(forks(branches))
    assert len(found) == 12
    for (r, a, b), (parent, thick, thin) in found:
        assert a**3 + b**3 == pytest.approx(r**3)
        assert b < a < r
        # the first pieces of vessels are off their directions by half of a step of at most 0.06 radians
        cosines = (r**4 + a**4 - b**4) / (2 * r**2 * a**2), (r**4 + b**4 - a**4) / (2 * r**2 * b**2)
        assert (parent @ thick, parent @ thin) == pytest.approx(cosines, abs=0.1)
        assert thick @ thin == pytest.approx(
            np.cos(np.arccos(cosines).sum()), abs=0.15
        )  # to opposite sides, in a plane


def test_lengths_and_radii_are_of_the_solid(branches):
    truth = solid_of(branches).truth
    assert (truth.n_tips, truth.genus, truth.n_components, len(truth.junctions)) == (14, 0, 1, 12)
    for path in truth.branches:
        steps = np.linalg.norm(np.diff(truth.nodes[path], axis=0), axis=1)
        # a tenth for what of the ends lies in thicker vessels
        assert LENGTH[0] <= steps.sum() / np.median(truth.radii[path]) * 1.1
        assert steps.sum() / np.median(truth.radii[path]) <= LENGTH[1] * 1.1


def test_vessels_keep_apart(branches):
    axes = [axis for axis, _ in branches]
    for number, (axis, radii) in enumerate(branches):
        beyond = np.linalg.norm(axis - axis[0], axis=1) > 5.5 * radii[0] / 0.4  # clear of its fork, whatever the ratio
        others = np.concatenate(axes[:number]) if number else np.empty((0, 3))
        if beyond.any() and len(others):
            apart = cKDTree(others).query(axis[beyond])[0]
            assert (apart > 1.9 * radii[beyond]).all()


def test_the_least_radius_and_the_number_of_forks_are_kept():
    assert min(radii.min() for _, radii in murray_branches(30, min_radius=0.3, seed=1)) >= 0.3
    assert len(murray_branches(5, seed=3)) == 6
    assert len(murray_branches(0)) == 1


def test_a_seed_gives_one_tree():
    first, second, other = (murray_branches(4, seed=seed) for seed in (0, 0, 1))
    assert all((a[0] == b[0]).all() for a, b in zip(first, second, strict=True))
    assert not np.array_equal(first[0][0], other[0][0])
