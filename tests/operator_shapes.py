"""Shapes of the tests of operators: planes and regular rings, spheres of points, and meshes of degenerate triangles."""

import numpy as np
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from lbskel import Mesh
from lbskel.shapes import flat_grid, sphere

POSITIONS = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [0.3, 0.1, 0.7]])

NEEDLE = Mesh([[0, 0, 0], [1, 0, 0], [1, 1e-17, 0]], [[0, 1, 2]])
CAP = Mesh([[0.1, 0.1, 0.3], [0.2, 0.2, 0.6], [0.3, 0.3, 0.9]], [[0, 1, 2]])
HAIR = Mesh([[2e-300, 2e-300, -1e-300], [0, 0, 1e-300], [0, -2, 2]], [[0, 1, 2]])
POINT = Mesh(np.ones((3, 3)), [[0, 1, 2], [2, 1, 0]])
TWICE = Mesh(np.eye(3), [[0, 1, 2], [0, 1, 2], [0, 0, 1], [2, 2, 2]])
NOTHING = Mesh(np.zeros((3, 3)), [[0, 0, 0]])


# A triangle with sides 3, 4, 5 (the right angle at vertex 0), and beside it one of no area with sides 1, 1, 2.
PYTHAGORAS = Mesh(
    [[0, 0, 0], [4, 0, 0], [0, 3, 0], [6, 0, 0], [7, 0, 0], [8, 0, 0]],
    [[0, 1, 2], [3, 4, 5]],
)


def with_a_flat_face(turned, moved, n=12):
    """A grid of unit squares, and last a face on three vertices of one row, turned and moved; and the grid alone."""
    grid = flat_grid(n, n)
    V = grid.vertices / np.ptp(grid.vertices[:, 0]) * (n - 1)
    row = np.flatnonzero(np.isclose(V[:, 1], V[3 * n, 1]))[[0, 1, -1]]
    placed = V @ turned.T + moved
    return Mesh(placed, [*grid.faces, row]), Mesh(placed, grid.faces)


def stiffness_of_lengths(a, b, c):
    """The cotangent stiffness of one triangle by the law of cosines; a is the length of the edge opposite vertex 0."""
    s = (a + b + c) / 2
    area = np.sqrt(s * (s - a) * (s - b) * (s - c))
    weights = {
        (1, 2): (b**2 + c**2 - a**2) / (8 * area),
        (0, 2): (a**2 + c**2 - b**2) / (8 * area),
        (0, 1): (a**2 + b**2 - c**2) / (8 * area),
    }
    S = np.zeros((3, 3))
    for (i, j), weight in weights.items():
        S[[i, j], [j, i]] -= weight
        S[[i, j], [i, j]] += weight
    return S


def scattered_plane(n=17, seed=0):
    """An irregular triangulation of a square in a tilted plane, its points in that plane, and its inner vertices."""
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(n) / (n - 1), np.arange(n) / (n - 1), indexing="ij")
    P = np.stack([x, y], axis=-1)
    P[1:-1, 1:-1] += random.uniform(-0.4, 0.4, (n - 2, n - 2, 2)) / n
    P = P.reshape(-1, 2)
    F = Delaunay(P).simplices
    turned = np.linalg.qr(random.normal(size=(3, 3)))[0]
    mesh = Mesh(np.column_stack([P, np.zeros(len(P))]) @ turned, F)
    rim = mesh.edges[mesh.faces_per_edge == 1]
    return mesh, P, np.setdiff1d(np.arange(len(P)), rim)


def hexagons(n=9, edge=0.1):
    """Equilateral triangles in the plane, and the vertices more than four rings inside."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    V = edge * np.column_stack([i - 0.5 * j, np.sqrt(0.75) * j, np.zeros(n * n)])
    inner = (np.minimum(i, j) >= 4) & (np.maximum(i, j) < n - 4)
    return Mesh(V, flat_grid(n, n).faces), inner


def fibonacci_sphere(n):
    """Points spread evenly over the unit sphere."""
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + np.sqrt(5)) * k
    return np.column_stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z])


def is_finite(L):
    return np.isfinite(L.stiffness.data).all() and np.isfinite(L.mass.data).all() and (L.mass.data >= -1e-300).all()


@st.composite
def positions(draw):
    """Up to nine points: on top of each other, in a line, in a plane, a hair apart, of any size."""
    chosen = draw(st.lists(st.sampled_from(range(len(POSITIONS))), min_size=3, max_size=9))
    hairs = draw(st.lists(st.sampled_from([0.0, 1e-3, 1e-8, 1e-12, 1e-16, 1e-30, 1e-300]), min_size=9, max_size=9))
    seed, size = draw(st.integers(0, 10)), draw(st.sampled_from([1.0, 1e-100, 1e-12, 1e12, 1e100]))
    directions = np.random.default_rng(seed).normal(size=(9, 3))
    V = POSITIONS[chosen] + np.array(hairs[: len(chosen)])[:, None] * directions[: len(chosen)]
    flat = draw(st.sampled_from([np.ones(3), np.array([1, 1, 0]), np.array([1, 0, 0]), np.array([1, 1e-9, 1e-14])]))
    return size * V * flat


@st.composite
def degenerate_meshes(draw):
    """Faces between any of these points: some name a vertex twice, some come twice."""
    V = draw(positions())
    index = st.integers(0, len(V) - 1)
    return Mesh(V, draw(st.lists(st.tuples(index, index, index), min_size=1, max_size=12)))


@st.composite
def closed_meshes(draw):
    """A closed surface of 42 vertices squeezed and pinched."""
    ball = sphere(1)
    powers = st.sampled_from([1.0, 1e-3, 1e-7, 1e-11, 1e-15, 0.0])
    V = ball.vertices * [draw(powers), draw(powers), draw(powers)]
    pinched = draw(st.lists(st.integers(0, 41), max_size=20))
    V[pinched] = V[draw(st.integers(0, 41))] + draw(powers) * V[pinched]
    return Mesh(V + draw(st.sampled_from([0.0, 1.0, 1e6])), ball.faces)
