"""The filters of pymeshlab that lbskel uses; nothing else imports it, since their names change between releases."""

from __future__ import annotations

__all__ = ["remesh_isotropic"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MissingDependency


def remesh_isotropic(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    *,
    target_length: float,
    iterations: int = 10,
    feature_angle: float = 30.0,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Nearly equilateral triangles on the same surface, by splits, collapses, flips and tangential smoothing.

    Botsch, Kobbelt 2004, "A remeshing approach to multiresolution modeling", https://doi.org/10.1145/1057432.1057457.

    Parameters
    ----------
    vertices, faces
        A closed or open mesh.
    target_length : float
        Wanted length of the edges, in the units of the vertices.
    feature_angle : float
        Edges with a larger angle between their normals, in degrees, stay where they are; 180 for a surface without.

    Raises
    ------
    MissingDependency
        If pymeshlab is not installed.
    """
    try:
        import pymeshlab
    except ImportError:
        raise MissingDependency("pymeshlab", "preprocess", "isotropic remeshing") from None
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.meshing_isotropic_explicit_remeshing(
        targetlen=pymeshlab.PureValue(target_length),
        iterations=iterations,
        featuredeg=feature_angle,
        checksurfdist=False,
    )
    remeshed = meshes.current_mesh()
    return remeshed.vertex_matrix(), remeshed.face_matrix().astype(np.int64)
