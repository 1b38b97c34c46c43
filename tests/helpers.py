"""Functions that several test files use."""

import numpy as np

from lbskel import Mesh


def joined(*meshes):
    """Several meshes as one, their vertices one after the other."""
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, first[:-1], strict=True)]),
    )


def moved(mesh, by):
    """The mesh moved along x."""
    return mesh.with_vertices(mesh.vertices + [by, 0, 0])
