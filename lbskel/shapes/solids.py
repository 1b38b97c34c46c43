"""Solids around known axes, one function each: two to five units large, every tip clear of the branch it grows from.

All coordinates and radii were chosen by hand so that the shapes differ in genus, tips, junctions and branch thickness.
"""

from __future__ import annotations

__all__ = [
    "cube_frame",
    "dumbbell",
    "hand",
    "helix",
    "knot",
    "ladder",
    "limbs",
    "octopus",
    "rings",
    "spiked_ring",
    "tree",
    "tripod",
]

import itertools

import numpy as np
from numpy.typing import NDArray

from lbskel.shapes.round_cones import Branch, Solid, solid_of

ORIGIN = np.zeros(3)


def _loop(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Close a polyline: append its first point."""
    return np.concatenate([points, points[:1]])


def _ring(n: int, radius: float = 1.0) -> NDArray[np.float64]:
    """Sample a circle around the origin in the plane z = 0 at (n, 3) points."""
    angle = 2 * np.pi * np.arange(n) / n
    return radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)


def limbs() -> Solid:
    """Build a thick body with six limbs of different lengths and radii that start at its two ends: six tips."""
    back, front = np.array([-0.45, 0, 0]), np.array([0.45, 0, 0])
    ends = [
        (back, [-1.1, 0.75, -0.35], 0.18, 0.14),
        (back, [-1.1, -0.75, -0.35], 0.12, 0.10),
        (back, [-1.3, 0.0, 0.75], 0.09, 0.08),
        (front, [1.2, 0.7, -0.3], 0.15, 0.13),
        (front, [1.1, -0.8, -0.2], 0.10, 0.09),
        (front, [1.35, 0.05, 0.7], 0.20, 0.17),
    ]
    return solid_of([([back, front], 0.3)] + [([start, end], radii) for start, end, *radii in ends])


def tripod() -> Solid:
    """Build three legs of one radius and three lengths that start at one point: three tips."""
    directions = _ring(3) + np.array([0, 0, -0.5])
    return solid_of([([ORIGIN, length * leg], 0.14) for length, leg in zip((0.8, 1.0, 1.2), directions, strict=True)])


def dumbbell() -> Solid:
    """Build two balls of different size joined by a thin bar: one branch whose radius varies by a factor of five."""
    return solid_of([([[-1, 0, 0], [-0.3, 0, 0], [0.65, 0, 0], [1, 0, 0]], [0.5, 0.1, 0.1, 0.25])])


def helix() -> Solid:
    """Build two and a half turns of a helix: two tips."""
    t = np.linspace(0, 5 * np.pi, 181)
    return solid_of([(np.stack([0.6 * np.cos(t), 0.6 * np.sin(t), 0.09 * t], axis=1), 0.12)])


def knot() -> Solid:
    """Build a trefoil knot: genus 1, no tips."""
    t = 2 * np.pi * np.arange(180) / 180
    axis = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1) / 3
    return solid_of([(_loop(axis), 0.16)])


def spiked_ring() -> Solid:
    """Build a ring with five spikes that point outwards, some also upwards or downwards: genus 1, five tips."""
    ring = _ring(120)
    spikes = [(0, 0.9, 0.0), (24, 0.5, 0.5), (48, 0.75, -0.3), (72, 0.6, 0.6), (96, 1.05, 0.2)]
    axes = [[ring[i], (1 + length) * ring[i] + [0, 0, rise]] for i, length, rise in spikes]
    return solid_of([(_loop(ring), 0.17)] + [(axis, [0.12, 0.08]) for axis in axes])


def ladder() -> Solid:
    """Build two rails with five rungs: genus 4, four tips."""
    heights = np.linspace(-1.0, 1.0, 5)
    rails = [np.array([[x, 0, z] for z in (-1.5, *heights, 1.5)]) for x in (-0.45, 0.45)]
    rungs = list(zip(rails[0][1:-1], rails[1][1:-1], strict=True))
    return solid_of([(rail, 0.11) for rail in rails] + [(rung, 0.08) for rung in rungs])


def cube_frame() -> Solid:
    """Build the twelve edges of a cube: genus 5, eight junctions, no tips."""
    corners = list(itertools.product((-0.8, 0.8), repeat=3))
    edges = [
        (a, b) for a, b in itertools.combinations(corners, 2) if sum(x != y for x, y in zip(a, b, strict=True)) == 1
    ]
    return solid_of([(edge, 0.13) for edge in edges])


def rings(genus: int = 2) -> Solid:
    """Build a row of rings, the center circles of neighbors touching in a point; for genus 0, a rod.

    Parameters
    ----------
    genus : int
        Number of rings.
    """
    if genus == 0:
        return solid_of([([[-0.8, 0, 0], [0.8, 0, 0]], 0.25)])
    return solid_of([(_loop(_ring(96) + np.array([2 * i, 0, 0])), 0.25) for i in range(genus)])


def octopus() -> Solid:
    """Build eight curled arms and a head that start at one point: nine tips."""
    s = np.linspace(0, 1, 33)
    radial, height = 1.5 * s, 0.3 * np.sin(np.pi * s**0.8) - 0.55 * s + 0.25 * s**4
    branches: list[Branch] = [([ORIGIN, [0, 0, 0.25], [-0.12, 0, 0.95]], [0.2, 0.22, 0.34])]
    for i in range(8):
        angle = 2 * np.pi * (i + 0.5) / 8 + 0.5 * s**2
        axis = np.stack([radial * np.cos(angle), radial * np.sin(angle), height], axis=1)
        branches.append((axis, 0.15 - 0.06 * s))
    return solid_of(branches)


def hand() -> Solid:
    """Build a forearm, a palm and five fingers whose axes all meet in the middle of the palm: six tips."""
    fingers = [(-62, 0.95, 0.13), (-21, 1.25, 0.11), (-3, 1.38, 0.115), (15, 1.28, 0.11), (34, 1.05, 0.095)]
    branches: list[Branch] = [(ORIGIN, 0.36), ([ORIGIN, [0, 0, -0.5], [0, 0, -1.15]], [0.3, 0.19, 0.24])]
    for degrees, length, radius in fingers:
        direction = np.array([np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))])
        knuckle = 0.6 * length * direction
        branches.append(
            ([ORIGIN, knuckle, knuckle + 0.4 * length * direction + [0, -0.12, 0]], [radius, radius, 0.8 * radius])
        )
    return solid_of(branches)


def _subtree(
    start: NDArray[np.float64], direction: NDArray[np.float64], side: NDArray[np.float64], length: float, level: int
) -> list[Branch]:
    """List a bough and, recursively, the boughs that start at its end: three at the first fork, two at the others."""
    end = start + length * direction
    boughs: list[Branch] = [([start, end], [0.14 * 0.8**level, 0.12 * 0.8**level])]
    if level == 3:
        return boughs
    n = 3 if level == 0 else 2
    binormal = np.cross(direction, side)
    for i in range(n):
        turn = 2 * np.pi * i / n + 0.9 * level
        lateral = np.cos(turn) * side + np.sin(turn) * binormal
        child_direction = np.cos(0.62) * direction + np.sin(0.62) * lateral
        normal = np.cross(child_direction, lateral)
        boughs += _subtree(end, child_direction, normal / np.linalg.norm(normal), 0.72 * length, level + 1)
    return boughs


def tree() -> Solid:
    """Build a trunk that forks in three, then twice in two, with radii decreasing by a fifth: thirteen tips."""
    return solid_of(_subtree(np.array([0, 0, -1.0]), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), 0.85, 0))
