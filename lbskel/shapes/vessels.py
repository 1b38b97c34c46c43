"""Trees of vessels by Murray's law: at each fork the cubes of the radii of the two children sum to that of the parent.

The angles between them are those of least work (Murray 1926, "The physiological principle of minimum work applied to
the angle of branching of arteries", https://doi.org/10.1085/jgp.9.6.835): the cosine of the angle between the parent,
of radius r, and a child of radius a beside one of radius b is ``(r^4 + a^4 - b^4) / (2 r^2 a^2)``.
"""

from __future__ import annotations

__all__ = ["murray_branches"]

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lbskel.shapes.round_cones import Branch

# Ranges of the ratio of the two children's radii, of the length of a vessel in its radii, of its turn in radians.
RATIO, LENGTH, TURN = (0.45, 0.95), (10.0, 20.0), (-0.6, 0.6)
# Least distance of the axes of two vessels, in sums of their radii; and distance from a fork, in radii of the parent,
# beyond which it is required of vessels that meet at the fork. Guesses.
CLEARANCE, FORK = 2.0, 5.0
# Number of random planes that are tried for a fork before the vessel is left without one; a guess.
N_TRIES = 30


@dataclass(frozen=True, eq=False)
class _Vessel:
    """A bent axis of one radius, and its direction at the end."""

    axis: NDArray[np.float64]
    radius: float
    direction: NDArray[np.float64]


def murray_branches(n_forks: int, *, min_radius: float = 0.0, seed: int = 0) -> list[Branch]:
    """Grow a tree of vessels from the origin along +z, the trunk of radius 1.

    Parameters
    ----------
    n_forks : int
        Number of forks; fewer if all ends are too thin, or no place is left between the vessels.
    min_radius : float
        Least radius of a vessel; the trunk has radius 1.
    seed : int
        Seed of the random choice of the ends that fork, ratios, lengths, turns and planes.

    Returns
    -------
    list of Branch
        Each follows the thicker child at its forks; the thinner ones begin branches of their own.
    """
    random = np.random.default_rng(seed)
    vessels = [_bent(np.zeros(3), np.array([0.0, 0, 1]), 1.0, random)]
    children: dict[int, tuple[int, int]] = {}
    ends = [0]
    while ends and len(children) < n_forks:
        end = ends.pop(random.integers(len(ends)))
        pair = _fork(vessels, end, min_radius, random)
        if pair:
            children[end] = (len(vessels), len(vessels) + 1)
            ends += children[end]
            vessels += pair
    return [_path(first, vessels, children) for first in (0, *(thinner for _, thinner in children.values()))]


def _path(first: int, vessels: list[_Vessel], children: dict[int, tuple[int, int]]) -> Branch:
    """Join a vessel with its thicker child, that one's thicker child, and so on; a fork has the parent's radius."""
    points, radii = [vessels[first].axis], [np.full(len(vessels[first].axis), vessels[first].radius)]
    while first in children:
        first = children[first][0]
        points.append(vessels[first].axis[1:])
        radii.append(np.full(len(points[-1]), vessels[first].radius))
    return np.concatenate(points), np.concatenate(radii)


def _fork(
    vessels: list[_Vessel], parent: int, min_radius: float, random: np.random.Generator
) -> tuple[_Vessel, _Vessel] | None:
    """Build the two children of a vessel, the thicker one first; None if they are too thin or find no place."""
    r, direction = vessels[parent].radius, vessels[parent].direction
    ratio = random.uniform(*RATIO)
    thick = r / (1 + ratio**3) ** (1 / 3)
    thin = ratio * thick
    if thin < min_radius:
        return None
    fork = vessels[parent].axis[-1]
    for _ in range(N_TRIES):
        axis = _across(direction, random)
        first, second = (
            _bent(fork, _rotated(direction, axis, sign * _angle(r, a, b)), a, random)
            for sign, a, b in ((1, thick, thin), (-1, thin, thick))
        )
        others = [vessel for number, vessel in enumerate(vessels) if number != parent]
        if all(
            _is_clear(child.axis, child.radius, others)
            and _is_clear(_beyond(child.axis, fork, FORK * r), child.radius, [vessels[parent]])
            for child in (first, second)
        ) and _is_clear(
            _beyond(first.axis, fork, FORK * r),
            thick,
            [_Vessel(_beyond(second.axis, fork, FORK * r), thin, direction)],
        ):
            return first, second
    return None


def _angle(parent: float, own: float, other: float) -> float:
    """Compute the angle of least work between the parent and a child."""
    return float(np.arccos((parent**4 + own**4 - other**4) / (2 * parent**2 * own**2)))


def _bent(
    start: NDArray[np.float64], direction: NDArray[np.float64], radius: float, random: np.random.Generator
) -> _Vessel:
    """Build an arc of a circle that begins in a direction, with a point in every radius."""
    length, turn = radius * random.uniform(*LENGTH), random.uniform(*TURN)
    axis = _across(direction, random)
    n = int(np.ceil(length / radius))
    steps = [length / n * _rotated(direction, axis, turn * (k + 0.5) / n) for k in range(n)]
    points = start + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    return _Vessel(points, radius, _rotated(direction, axis, turn))


def _across(direction: NDArray[np.float64], random: np.random.Generator) -> NDArray[np.float64]:
    """Choose a unit vector normal to a direction at random."""
    normal = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    return _rotated(normal / np.linalg.norm(normal), direction, random.uniform(0, 2 * np.pi))


def _rotated(vector: NDArray[np.float64], axis: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """Rotate a vector around a unit vector normal to it."""
    rotated: NDArray[np.float64] = np.cos(angle) * vector + np.sin(angle) * np.cross(axis, vector)
    return rotated


def _beyond(points: NDArray[np.float64], center: NDArray[np.float64], distance: float) -> NDArray[np.float64]:
    """Select the points that are farther than ``distance`` from a center."""
    selected: NDArray[np.float64] = points[np.linalg.norm(points - center, axis=1) > distance]
    return selected


def _is_clear(points: NDArray[np.float64], radius: float, vessels: list[_Vessel]) -> bool:
    """Return whether the points are far enough from the axes of vessels."""
    return all(
        len(points) == 0
        or len(vessel.axis) == 0
        or np.linalg.norm(points[:, None] - vessel.axis, axis=2).min() > CLEARANCE * (radius + vessel.radius)
        for vessel in vessels
    )
