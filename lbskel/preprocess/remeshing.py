"""Isotropic remeshing by pymeshlab, and smoothing of noise."""

from __future__ import annotations

__all__ = ["check_reference_length", "remesh_isotropic", "smooth_noise"]

import numpy as np
from scipy.sparse import coo_array, diags_array

from lbskel.errors import MeshError, UnknownChoice, choose, were
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import local_thickness
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import (
    MAX_DISTANCE,
    PreprocessResult,
    hausdorff_distance,
    identity_result,
    preprocess_step,
)
from lbskel.preprocess.subprocess_filter import run_in_subprocess
from lbskel.preprocess.transfer import transfer_map

REFERENCE_LENGTHS = ("diameter_bound", "thickness")

THIN_FRACTION = 0.05  # fraction of the area that may be thinner than the thickness that edges are fitted to; a guess

MAX_SAMPLES = 3000  # faces, at most about this many, at which the thickness is measured; a guess that bounds the time

# Longest edge, relative to the diameter bound, when edges are fitted to the thickness: longer ones would lose horns and
# ears on a thick body. A guess, of the diagonal at first: see MAX_DISTANCE.
MAX_EDGE_LENGTH = 0.022

MAX_FACES = 2_000_000  # faces that remeshing may be asked for; a guess that bounds time and memory

MAX_ITERATIONS = 1000  # of smoothing; a guess that bounds the time

# Taubin's lambda and mu: a step that smooths and one that restores low frequencies. The pass band 1/lambda + 1/mu is
# about 0.1.
TAUBIN_FACTORS = 0.5, -0.53


@preprocess_step
def remesh_isotropic(
    mesh: Mesh, *, edge_length: float = 0.011, relative_to: str = "diameter_bound", feature_angle: float = 30.0
) -> PreprocessResult:
    """Remesh a surface with nearly equilateral triangles of one size, by pymeshlab in a process of its own.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    edge_length : float
        Target edge length, as a fraction of the length that ``relative_to`` names.
    relative_to : str
        ``diameter_bound``, or ``thickness``: the local thickness that 95 % of the area exceeds; edges are then at most
        2.2 % of the diameter bound long.
    feature_angle : float
        Edges whose faces have normals at a larger angle, in degrees, are kept.

    Returns
    -------
    PreprocessResult
        The unchanged mesh and a note if pymeshlab fails on it, or if the surface would move by more than 2.2 % of
        the diameter bound.

    Raises
    ------
    UnknownChoice
        If the length is not positive and finite or is so small that it would make millions of faces, the angle is not
        between 0 and 180, or ``relative_to`` is unknown.
    MissingDependency
        If pymeshlab is not installed.
    """
    check_reference_length(relative_to)
    if not 0 < edge_length < np.inf:
        raise UnknownChoice(f"edge_length must be positive and finite, not {edge_length}")
    if not 0 <= feature_angle <= 180:
        raise UnknownChoice(f"feature_angle must lie between 0 and 180 degrees, not {feature_angle}")
    if relative_to == "diameter_bound":
        length = edge_length * mesh.diameter_bound
    else:
        length = min(edge_length * _thickness_of_thin_parts(mesh), MAX_EDGE_LENGTH * mesh.diameter_bound)
    n_faces = mesh.area / max(length, 1e-300) / max(length, 1e-300) * 4 / np.sqrt(3)
    if not n_faces < MAX_FACES:
        raise UnknownChoice(
            f"remesh_isotropic with edge_length={edge_length:g} of the {relative_to.replace('_', ' ')} would make more "
            f"than {MAX_FACES:,} faces; write the step as "
            f"remesh_isotropic:edge_length=NUMBER:relative_to={relative_to} with a larger number"
        )
    try:
        remeshed = run_in_subprocess("remesh_isotropic", mesh, target_length=length, feature_angle=feature_angle)
    except MeshError as error:
        return identity_result(mesh, f"the mesh was not remeshed: {error}")
    note = f"{were(len(mesh.faces), 'face')} remeshed to {len(remeshed.faces):,}"
    # its collapses keep the topology, but not a limb that is thinner than an edge
    if (distance := hausdorff_distance(mesh, remeshed)) > MAX_DISTANCE:
        reason = f"the surface would move by {distance:.1%} of the diameter bound; make edge_length smaller"
        return identity_result(mesh, f"the mesh was not remeshed: {reason}")
    return transfer_map(mesh, remeshed, note)


def check_reference_length(name: str) -> None:
    """Raise UnknownChoice if a length is none that edges can be relative to.

    Parameters
    ----------
    name : str
    """
    if name == "diagonal":
        raise UnknownChoice("relative_to=diagonal is gone; use diameter_bound with 1.1 times the number")
    choose(dict.fromkeys(REFERENCE_LENGTHS), name, "reference length")


def _thickness_of_thin_parts(mesh: Mesh) -> float:
    """Measure the local thickness that all but the thinnest 5 % of the area reach."""
    sample = np.arange(0, len(mesh.faces), 1 + len(mesh.faces) // MAX_SAMPLES)
    thickness = np.minimum(local_thickness(mesh, sample), mesh.diameter_bound)
    order = np.argsort(thickness)
    areas = mesh.face_areas[sample][order]
    is_reached = np.cumsum(areas) >= THIN_FRACTION * areas.sum()
    return float(thickness[order][is_reached.argmax()])


@preprocess_step
def smooth_noise(mesh: Mesh, *, iterations: int = 10) -> PreprocessResult:
    """Smooth noise of a wavelength of a few edges without shrinking the shape.

    Vertices of edges with other than two faces, as at the boundary, are fixed.

    Taubin 1995, "A signal processing approach to fair surface design", https://doi.org/10.1145/218380.218473.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    iterations : int
        Number of pairs of steps, one that smooths and one that restores.

    Raises
    ------
    UnknownChoice
        If the number is negative, more than a thousand or not whole.
    """
    if not (0 <= iterations <= MAX_ITERATIONS and iterations % 1 == 0):
        raise UnknownChoice(f"iterations must be a whole number from 0 to {MAX_ITERATIONS:,}, not {iterations}")
    n, (i, j) = len(mesh.vertices), mesh.edges.T
    adjacency = coo_array((np.ones(2 * len(i)), (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(n, n)).tocsr()
    mean = diags_array(1 / np.maximum(adjacency.sum(axis=1), 1)) @ adjacency
    is_fixed = np.bincount(i, minlength=n) + np.bincount(j, minlength=n) == 0
    is_fixed[mesh.edges[mesh.faces_per_edge != 2]] = True
    V = np.array(mesh.vertices)
    for _ in range(int(iterations)):
        for factor in TAUBIN_FACTORS:
            V = np.where(is_fixed[:, None], V, V + factor * (mean @ V - V))
    return PreprocessResult(
        mesh.with_vertices(V), VertexMap.identity(n), (f"noise was smoothed by {iterations} iterations",)
    )
