"""Shapes on which curve skeletons go wrong, one function for each kind: flat parts, sharp bends, limbs side by side.

Each function takes the measure that makes the shape hard as a parameter, so that a benchmark can tune at some values
and check at others. ``HARD_SHAPES`` has all of them.
"""

from __future__ import annotations

__all__ = [
    "HARD_SHAPES",
    "acute_fork",
    "horn",
    "lattice",
    "oblique_cross",
    "prongs",
    "spring",
    "tee",
    "torso",
    "twigs",
    "zigzag",
]

import itertools
from collections.abc import Callable

import numpy as np

from lbskel.shapes.catalog import mesh_solid
from lbskel.shapes.flat import leaf, ribbon, twisted_ellipse
from lbskel.shapes.round_cones import BLEND_WIDTH, Branch, solid_of
from lbskel.shapes.thin import vessel_tree
from lbskel.shapes.truth import Shape


def _meshed(branches: list[Branch], name: str, n_vertices: int, blend: float = BLEND_WIDTH) -> Shape:
    """Mesh the solid around branches, as a shape."""
    solid = solid_of(branches, blend=blend)
    return Shape(mesh_solid(solid, n_vertices=n_vertices), solid.truth, name)


def zigzag(*, degrees: float = 35.0, n_bends: int = 4, n_vertices: int = 5000) -> Shape:
    """Build a tube with sharp bends: two tips.

    Parameters
    ----------
    degrees : float
        The angle inside each bend.
    n_bends : int
    n_vertices : int
        Approximate number of vertices.
    """
    half = np.radians(degrees) / 2
    steps = np.array([[np.sin(half), (-1) ** k * np.cos(half)] for k in range(n_bends + 1)])
    flat = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return _meshed([(np.column_stack([flat, np.zeros(len(flat))]), 0.09)], "zigzag", n_vertices)


def acute_fork(*, degrees: float = 15.0, n_vertices: int = 5000) -> Shape:
    """Build a trunk with two limbs that leave it at a small angle: three tips.

    Parameters
    ----------
    degrees : float
        Angle between the limbs.
    n_vertices : int
        Approximate number of vertices.
    """
    half = np.radians(degrees) / 2
    limbs = [[side * np.sin(half) * 2.2, 0, np.cos(half) * 2.2] for side in (-1, 1)]
    branches: list[Branch] = [([[0, 0, -1.0], [0, 0, 0]], 0.13)]
    return _meshed(branches + [([[0, 0, 0], end], [0.11, 0.08]) for end in limbs], "acute fork", n_vertices)


def oblique_cross(*, degrees: float = 40.0, ratio: float = 0.35, n_vertices: int = 5000) -> Shape:
    """Build a thick bar with two thin limbs that leave it in opposite directions at an oblique angle: four tips.

    Parameters
    ----------
    degrees : float
        Angle between the bar and the limbs.
    ratio : float
        Radius of the limbs over that of the bar.
    n_vertices : int
        Approximate number of vertices.
    """
    direction = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0])
    bar, thin = ([[-1.3, 0, 0], [0, 0, 0], [1.3, 0, 0]], 0.25), 0.25 * ratio
    limbs: list[Branch] = [([[0, 0, 0], sign * 1.2 * direction], thin) for sign in (-1, 1)]
    return _meshed([bar, *limbs], "oblique cross", n_vertices)


def prongs(*, n: int = 5, gap: float = 1 / 6, n_vertices: int = 25_000) -> Shape:
    """Build a comb: a handle, a bar and parallel prongs with narrow gaps: n + 1 tips.

    Parameters
    ----------
    n : int
        An odd number of prongs.
    gap : float
        Gap between neighboring prongs, in their radii.
    n_vertices : int
        Approximate number of vertices.
    """
    radius = 0.12
    x = (2 + gap) * radius * (np.arange(n) - (n - 1) / 2)
    bar = np.column_stack([x, np.zeros((n, 2))])
    branches: list[Branch] = [(bar, radius), ([[0, 0, 0], [0, 0, -1.0]], radius)]
    branches += [([point, point + [0, 0, 1.4]], radius) for point in bar]
    return _meshed(branches, "prongs", n_vertices, blend=0.4 * gap)


def torso(*, degrees: float = 6.0, n_vertices: int = 5000) -> Shape:
    """Build a torso with a head, two arms and two nearly parallel legs: five tips.

    Parameters
    ----------
    degrees : float
        Angle between the legs.
    n_vertices : int
        Approximate number of vertices.
    """
    half = np.radians(degrees) / 2
    hip, chest, head = np.zeros(3), np.array([0, 0, 0.75]), np.array([0, 0, 1.35])
    branches: list[Branch] = [([hip, chest], [0.24, 0.28]), ([chest, chest + [0, 0, 0.4], head], [0.1, 0.1, 0.16])]
    for side in (-1, 1):
        knee = hip + [side * 0.15, 0, -0.15]
        foot = knee + 1.4 * np.array([side * np.sin(half), 0, -np.cos(half)])
        branches.append(([hip, knee, foot], [0.13, 0.125, 0.08]))
        branches.append(([chest, chest + [side * 0.35, 0, 0.0], chest + [side * 0.75, 0.1, -0.85]], [0.1, 0.1, 0.065]))
    return _meshed(branches, "torso", n_vertices, blend=0.3)


def twigs(*, ratio: float = 0.15, n_vertices: int = 5000) -> Shape:
    """Build a thick trunk with six thin twigs: eight tips.

    Parameters
    ----------
    ratio : float
        Radius of the twigs over that of the trunk.
    n_vertices : int
        Approximate number of vertices.
    """
    heights, radius = np.linspace(-1.2, 1.2, 6), 0.3
    trunk = np.column_stack([np.zeros((8, 2)), [-1.7, *heights, 1.7]])
    branches: list[Branch] = [(trunk, radius)]
    for k, height in enumerate(heights):
        direction = np.array([np.cos(2.4 * k), np.sin(2.4 * k), 0.4])
        branches.append(([[0, 0, height], [0, 0, height] + 0.9 * direction], ratio * radius))
    return _meshed(branches, "twigs", n_vertices)


def horn(*, ratio: float = 10.0, n_vertices: int = 5000) -> Shape:
    """Build a spiral whose radius decreases along it: two tips.

    Parameters
    ----------
    ratio : float
        Largest radius over the smallest.
    n_vertices : int
        Approximate number of vertices.
    """
    s = np.linspace(0, 1, 121)
    angle, spread = 1.7 * np.pi * s, 1.0 - 0.55 * s
    axis = np.stack([spread * np.cos(angle), spread * np.sin(angle), 1.3 * s], axis=1)
    return _meshed([(axis, 0.3 * (1 - (1 - 1 / ratio) * s))], "horn", n_vertices)


def tee(*, ratio: float = 1.0, n_vertices: int = 5000) -> Shape:
    """Build a bar with one limb that leaves it at a right angle: three tips.

    Parameters
    ----------
    ratio : float
        Radius of the limb over that of the bar.
    n_vertices : int
        Approximate number of vertices.
    """
    bar: Branch = ([[-1, 0, 0], [0, 0, 0], [1, 0, 0]], 0.18)
    return _meshed([bar, ([[0, 0, 0], [0, 0, 1.2]], 0.18 * ratio)], "tee", n_vertices)


def lattice(*, n: int = 3, n_vertices: int = 5000) -> Shape:
    """Build the edges of a grid of n by n by 2 points, without tips.

    Parameters
    ----------
    n : int
        Points in the first two directions; for 3 the genus is 16.
    n_vertices : int
        Approximate number of vertices.
    """
    points = list(itertools.product(range(n), range(n), range(2)))
    pairs = [(a, b) for a, b in itertools.combinations(points, 2) if np.abs(np.subtract(a, b)).sum() == 1]
    return _meshed([([a, b], 0.16) for a, b in pairs], "lattice", n_vertices)


def spring(*, gap: float = 0.5, n_vertices: int = 5000) -> Shape:
    """Build a helix of three turns close to each other: two tips.

    Parameters
    ----------
    gap : float
        Gap between neighboring turns, in radii of the tube.
    n_vertices : int
        Approximate number of vertices.
    """
    t, radius = np.linspace(0, 6 * np.pi, 217), 0.14
    height = (2 + gap) * radius * t / (2 * np.pi)
    return _meshed([(np.stack([0.7 * np.cos(t), 0.7 * np.sin(t), height], axis=1), radius)], "spring", n_vertices)


HARD_SHAPES: dict[str, Callable[..., Shape]] = {
    "twisted ellipse": twisted_ellipse,
    "ribbon": ribbon,
    "leaf": leaf,
    "zigzag": zigzag,
    "acute fork": acute_fork,
    "oblique cross": oblique_cross,
    "prongs": prongs,
    "torso": torso,
    "vessels": vessel_tree,
    "twigs": twigs,
    "horn": horn,
    "tee": tee,
    "lattice": lattice,
    "spring": spring,
}
