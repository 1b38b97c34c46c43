"""The cotangent Laplacian of the intrinsic Delaunay triangulation of the same surface: weights >= 0 but at boundaries.

A boundary edge has one triangle and cannot be flipped, so its weight is negative opposite an obtuse angle; ``robust``
has no boundary.

Bobenko, Springborn 2007, "A discrete Laplace-Beltrami operator for simplicial surfaces",
https://doi.org/10.1007/s00454-007-9006-1. If a triangle is degenerate, all edges of its component are first lengthened
by the same amount, which makes the worst triangle there valid: Sharp, Crane 2020, https://doi.org/10.1111/cgf.14069,
section 4 (mollification).
"""

from __future__ import annotations

__all__ = ["MOLLIFY_FACTOR", "intrinsic_delaunay", "mollified_lengths", "oriented_faces", "require_orientation"]

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.csgraph import connected_components

from lbskel.errors import MeshError, first_few
from lbskel.geometry.intrinsic_triangulation import (
    IntrinsicTriangulation,
    cotangents_of_lengths,
    delaunay,
    half_edge_twins,
)
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.scaling import unit_vertices
from lbskel.geometry.sorting import distinct
from lbskel.operators.assembly import stiffness_of_corner_weights
from lbskel.operators.base import Laplacian
from lbskel.operators.corner_angles import incident_vertices, zero_degenerate
from lbskel.operators.masses import voronoi_mass

# Smallest slack of triangle inequalities, relative to the mean edge of a component. A guess; Sharp, Crane 2020: 1e-5.
MOLLIFY_FACTOR = 1e-6


def mollified_lengths(
    faces: NDArray[np.int64], lengths: NDArray[np.float64], factor: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Lengthen all edges of a connected component as much as its thinnest triangle needs for its inequalities to hold.

    Parameters
    ----------
    faces : (m, 3) array of int
    lengths : (m, 3) array of float
        Length of the edge opposite each corner.
    factor : float
        Smallest slack of the triangle inequalities, relative to the mean edge length of the component.

    Returns
    -------
    lengths : (m, 3) array of float
    is_thin : (m,) array of bool
        The faces whose inequalities did not hold.
    """
    a, b, c = lengths.T
    sums = a + b + c
    excess = 2 * np.maximum(np.maximum(a, b), c) - sums
    if not (excess + factor * lengths.max() > 0).any():
        return lengths, np.zeros(len(faces), dtype=bool)
    n = int(faces.max()) + 1
    edges = coo_array((np.ones(2 * len(faces)), (np.tile(faces[:, 0], 2), faces[:, 1:].T.ravel())), shape=(n, n))
    component = connected_components(edges, directed=False)[1][faces[:, 0]]
    means = np.bincount(component, sums / 3) / np.maximum(np.bincount(component), 1)
    offsets = np.maximum(excess + factor * means[component], 0.0)
    largest = np.zeros(len(means))
    np.maximum.at(largest, component, offsets)
    return lengths + largest[component, None], offsets > 0


def oriented_faces(faces: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Return the (m, 3) faces, oriented consistently, and their half-edge twins; None if that is not possible.

    Parameters
    ----------
    faces : (m, 3) array of int
    """
    twins = half_edge_twins(faces)
    if twins is None:
        faces = igl.bfs_orient(faces)[0]
        twins = half_edge_twins(faces)
    return None if twins is None else (faces, twins)


def require_orientation(mesh: Mesh, operator: str) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the (m, 3) faces, oriented consistently, and their half-edge twins.

    Parameters
    ----------
    mesh : Mesh
    operator : str
        The name of the operator that needs them, for the message.

    Raises
    ------
    MeshError
        If a face uses a vertex twice, an edge has more than two faces, or the mesh cannot be oriented.
    """
    if (oriented := oriented_faces(mesh.faces)) is not None:
        return oriented
    F = mesh.faces
    repeated = np.flatnonzero((F[:, 0] == F[:, 1]) | (F[:, 1] == F[:, 2]) | (F[:, 2] == F[:, 0]))
    crowded = mesh.edges[mesh.faces_per_edge > 2]
    if len(repeated):
        fault = f"faces that use a vertex twice: {first_few(repeated)}"
    elif len(crowded):
        fault = f"edges of more than two faces: {first_few(map(tuple, crowded.tolist()))}"
    else:
        fault = "faces that cannot be oriented alike, as those of a Moebius strip"
    raise MeshError(f"{operator} is not defined with {fault}; use the operator 'robust', which takes any mesh")


def intrinsic_delaunay(mesh: Mesh, *, mollify_factor: float = MOLLIFY_FACTOR) -> Laplacian:
    """Build the intrinsic Delaunay Laplacian with the Voronoi mass of the given triangles.

    Parameters
    ----------
    mesh : Mesh
        Orientable, with at most two faces at every edge. Boundary edges are not flipped.
    mollify_factor : float
        Slack of every triangle inequality, relative to the mean edge length of its component.

    Raises
    ------
    MeshError
        If an edge has more than two faces, a face uses a vertex twice, or the mesh cannot be oriented.
    """
    faces, twins = require_orientation(mesh, "intrinsic_delaunay")
    n, lengths = len(mesh.vertices), igl.edge_lengths(unit_vertices(mesh)[0], faces)
    if not lengths.any():
        return Laplacian(csc_array((n, n)), voronoi_mass(mesh), treated_vertices=np.unique(faces))
    lengths, is_thin = mollified_lengths(faces, lengths, mollify_factor)
    flipped = delaunay(IntrinsicTriangulation(faces, lengths, twins))
    # the rounding of flips may make mollified triangles degenerate again
    cotangents, degenerate = zero_degenerate(cotangents_of_lengths(flipped.lengths))
    stiffness = stiffness_of_corner_weights(n, flipped.faces, cotangents / 2)
    mollified = incident_vertices(mesh, is_thin[:, None])
    treated = distinct(np.append(mollified, flipped.faces[degenerate.any(axis=1)]))
    return Laplacian(stiffness, voronoi_mass(mesh), treated_vertices=treated)
