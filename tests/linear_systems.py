"""Linear systems of the tests of solvers, with known condition numbers."""

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array, vstack

from lbskel import laplacian
from lbskel.shapes import torus

EPSILON = np.finfo(float).eps


def shifted_laplacian(mesh, shift=0.1):
    """The graph Laplacian plus a multiple of the identity: eigenvalues from the shift to shift + 12 on these meshes."""
    S = laplacian(mesh, operator="graph").stiffness
    return (S + shift * eye_array(S.shape[0])).tocsc()


def right_hand_sides(n, columns=3):
    return np.random.default_rng(0).normal(size=(n, columns))


def ill_conditioned(n=2000):
    """Fourth differences along a chain, as in Au's normal equations, and their condition number, 2.6e12."""
    chain = diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1])
    extreme = 2 - 2 * np.cos(np.array([n, 1]) * np.pi / (n + 1))
    return (chain @ chain).tocsc(), (extreme[0] / extreme[1]) ** 2


def rectangular(weight=1.0):
    """W_L L over the identity, as in a step of the contraction; the condition number is about 13 times the weight."""
    L = laplacian(torus(1.0, 0.3, 14, 9), operator="graph").stiffness
    return csr_array(vstack([weight * L, eye_array(L.shape[0])]))


def right_hand_side(K, columns=3):
    return np.random.default_rng(0).normal(size=(K.shape[0], columns))
