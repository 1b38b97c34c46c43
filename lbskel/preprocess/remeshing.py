"""A surface meshed anew by pymeshlab, and noise smoothed away."""

from __future__ import annotations

__all__ = ["remesh_isotropic", "smooth_noise"]

import numpy as np
from scipy.sparse import coo_array, diags_array

from lbskel.errors import MeshError, UnknownChoice, choose
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import local_thickness
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.result import PreprocessResult, identity_result, measured
from lbskel.preprocess.subprocess_filter import run_in_subprocess
from lbskel.preprocess.transfer import transfer_map

LENGTHS = ("diagonal", "thickness")
THIN = 0.05  # share of the area that may be thinner than what the edges are fitted to
SAMPLE = 3000  # faces that tell how thick the shape is
LONGEST = 0.02  # of the diagonal: horns and ears on a thick body would be lost to longer edges
MOST_FACES = 2_000_000

MOST_ITERATIONS = 1000
TAUBIN = 0.5, -0.53  # steps there and back, so that low frequencies pass: lambda and mu with a pass band of 0.1


@measured
def remesh_isotropic(
    mesh: Mesh, *, edge: float = 0.01, of: str = "diagonal", feature_angle: float = 30.0
) -> PreprocessResult:
    """Nearly equilateral triangles of one size on the same surface, by pymeshlab in a process of its own.

    Parameters
    ----------
    mesh : Mesh
    edge : float
        Length of the edges, as a fraction of what ``of`` names.
    of : str
        ``diagonal``, or ``thickness``: of the thinnest parts, leaving out a twentieth of the area; edges are then not
        longer than a fiftieth of the diagonal.
    feature_angle : float
        Edges with a larger angle between their normals, in degrees, stay.

    Raises
    ------
    UnknownChoice
        If the length is not positive, so small that millions of faces would come of it, or relative to something else.
    MissingDependency
        If pymeshlab is not installed.
    """
    choose(dict.fromkeys(LENGTHS), of, "length")
    if not edge > 0:
        raise UnknownChoice(f"edge must be positive, not {edge}")
    length = edge * mesh.diagonal if of == "diagonal" else min(edge * _thin_part(mesh), LONGEST * mesh.diagonal)
    n_faces = mesh.area / max(length, 1e-300) / max(length, 1e-300) * 4 / np.sqrt(3)
    if not n_faces < MOST_FACES:
        raise UnknownChoice(f"edge={edge:g} would make more than {MOST_FACES:,} faces; make it larger")
    try:
        remeshed = run_in_subprocess("remesh_isotropic", mesh, target_length=length, feature_angle=feature_angle)
    except MeshError as error:
        return identity_result(mesh, f"the mesh was not remeshed: {error}")
    note = f"{len(mesh.faces):,} faces were remeshed to {len(remeshed.faces):,}"
    return transfer_map(mesh, remeshed, note)


def _thin_part(mesh: Mesh) -> float:
    """The local thickness that all but a twentieth of the area has."""
    sample = np.arange(0, len(mesh.faces), 1 + len(mesh.faces) // SAMPLE)
    thickness = np.minimum(local_thickness(mesh, sample), mesh.diagonal)
    order = np.argsort(thickness)
    areas = mesh.face_areas[sample][order]
    passed = np.cumsum(areas) >= THIN * areas.sum()
    return float(thickness[order][passed.argmax()])


@measured
def smooth_noise(mesh: Mesh, *, iterations: int = 10) -> PreprocessResult:
    """Smooth noise of a few edge lengths away without shrinking the shape; rims stay.

    Taubin 1995, "A signal processing approach to fair surface design", https://doi.org/10.1145/218380.218473.

    Parameters
    ----------
    mesh : Mesh
    iterations : int
        Times that every vertex is moved there and back.

    Raises
    ------
    UnknownChoice
        If it is negative, or more than a thousand.
    """
    if not 0 <= iterations <= MOST_ITERATIONS:
        raise UnknownChoice(f"iterations must lie within 0 and {MOST_ITERATIONS:,}, not {iterations}")
    n, (i, j) = len(mesh.vertices), mesh.edges.T
    adjacency = coo_array((np.ones(2 * len(i)), (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(n, n)).tocsr()
    mean = diags_array(1 / np.maximum(adjacency.sum(axis=1), 1)) @ adjacency
    is_fixed = np.bincount(i, minlength=n) + np.bincount(j, minlength=n) == 0
    is_fixed[mesh.edges[mesh.faces_per_edge != 2]] = True
    V = np.array(mesh.vertices)
    for _ in range(iterations):
        for share in TAUBIN:
            V = np.where(is_fixed[:, None], V, V + share * (mean @ V - V))
    return PreprocessResult(
        mesh.with_vertices(V), VertexMap.identity(n), (f"noise was smoothed by {iterations} iterations",)
    )
