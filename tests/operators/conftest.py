"""Meshes of several kinds of triangles for the tests of operators."""

import numpy as np
import pytest

from lbskel import Mesh
from lbskel.shapes import make, sphere, torus

RANDOM = np.random.default_rng(7)


def soup(n_faces=400):
    """Triangles with random corners: some obtuse, some thin, edges with many faces."""
    F = np.array([RANDOM.choice(60, 3, replace=False) for _ in range(n_faces)])
    return Mesh(RANDOM.normal(size=(60, 3)), F)


def real():
    return make("dinosaur", n_vertices=1500).mesh


def distorted():
    mesh = torus(1.0, 0.4, 30, 15)
    return mesh.with_vertices(mesh.vertices + 0.02 * RANDOM.normal(size=mesh.vertices.shape))


MESHES = {"soup": soup(), "real": real(), "distorted": distorted(), "sphere": sphere(2)}


@pytest.fixture(params=MESHES)
def mesh(request):
    """Meshes of random, real, distorted and regular triangles."""
    return MESHES[request.param]


@pytest.fixture(scope="session")
def meshes_by_kind():
    """The meshes of :func:`mesh` by name."""
    return MESHES


def noisy(mesh, by, seed=0):
    return mesh.with_vertices(mesh.vertices + by * np.random.default_rng(seed).normal(size=mesh.vertices.shape))


@pytest.fixture(scope="session")
def rough():
    """A torus with obtuse triangles, and some with an angle below a degree: 288 vertices."""
    mesh = noisy(torus(1.0, 0.4, 24, 12), 0.05)
    V = mesh.vertices.copy()
    V[30] = 0.005 * V[30] + 0.995 * V[31]
    return mesh.with_vertices(V)
