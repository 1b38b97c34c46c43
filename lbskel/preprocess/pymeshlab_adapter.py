"""The filters of pymeshlab that lbskel uses; no other module imports it, since filter names change between releases.

Run as a script, this file reads one call from standard input and writes the result to standard output, both as npz, so
that pymeshlab may crash without harm (see :mod:`lbskel.preprocess.subprocess_filter`). It imports lbskel only for an
error, to start fast.
"""

# SPDX-License-Identifier: GPL-3.0-or-later, which pymeshlab asks for
from __future__ import annotations

__all__ = ["FILTERS", "remesh_isotropic"]

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray


def remesh_isotropic(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    *,
    target_length: float,
    iterations: int = 10,
    feature_angle: float = 30.0,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Remesh a surface with nearly equilateral triangles, by splits, collapses, flips and tangential smoothing.

    Botsch, Kobbelt 2004, "A remeshing approach to multiresolution modeling", https://doi.org/10.1145/1057432.1057457.

    Parameters
    ----------
    vertices : (n, 3) array of float
    faces : (m, 3) array of int
        A closed or open mesh; pymeshlab may crash on one that is not a manifold.
    target_length : float
        Target edge length, in the units of the vertices.
    iterations : int
        Rounds of these operations.
    feature_angle : float
        Edges whose faces have normals at a larger angle, in degrees, are kept in place; 180 keeps none.

    Raises
    ------
    MissingDependency
        If pymeshlab is not installed.
    """
    pymeshlab = _pymeshlab()
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    absolute = _first_known(pymeshlab, "PureValue", "AbsoluteValue")  # AbsoluteValue before 2023.12
    remesh = _first_known(meshes, "meshing_isotropic_explicit_remeshing", "remeshing_isotropic_explicit_remeshing")
    remesh(
        targetlen=absolute(target_length),
        iterations=iterations,
        featuredeg=feature_angle,
        checksurfdist=False,
    )
    remeshed = meshes.current_mesh()
    return remeshed.vertex_matrix(), remeshed.face_matrix().astype(np.int64)


def _pymeshlab() -> Any:
    """Import pymeshlab at its first use."""
    try:
        import pymeshlab
    except ImportError:
        from lbskel.errors import MissingDependency

        raise MissingDependency("pymeshlab", "preprocess", "isotropic remeshing") from None
    return pymeshlab


def _first_known(owner: Any, *names: str) -> Any:
    """Return the attribute under the first of its names, new and old, that this release has."""
    return next(getattr(owner, name) for name in names if hasattr(owner, name))


FILTERS: dict[str, Callable[..., tuple[NDArray[np.float64], NDArray[np.int64]]]] = {
    "remesh_isotropic": remesh_isotropic,
}


def _serve_one_call() -> None:
    """Read a filter name, a mesh and options; write the resulting mesh."""
    import io
    import os

    output = os.dup(1)
    os.dup2(2, 1)  # what pymeshlab prints must not get into the result
    with np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False) as call:
        options = {name: call[name].item() for name in call.files if name not in ("filter", "vertices", "faces")}
        V, F = FILTERS[str(call["filter"])](call["vertices"], call["faces"], **options)
    data = io.BytesIO()
    np.savez(data, vertices=V, faces=F)
    with os.fdopen(output, "wb") as stream:
        stream.write(data.getbuffer())


if __name__ == "__main__":
    _serve_one_call()
