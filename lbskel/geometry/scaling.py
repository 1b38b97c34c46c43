"""Scaling: by powers of two, which is exact, and to other units."""

from __future__ import annotations

__all__ = ["require_scale", "unit_scale", "unit_vertices"]

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import UnknownChoice, is_number

if TYPE_CHECKING:
    from lbskel.geometry.mesh import Mesh


def require_scale(scale: float) -> None:
    """Raise UnknownChoice unless a factor between units is a positive, finite number.

    Parameters
    ----------
    scale : float
    """
    if not (is_number(scale) and scale > 0 and math.isfinite(scale)):
        raise UnknownChoice(f"scale must be a positive number, not {scale!r}")


def unit_scale(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], int]:
    """Divide vertices by 2^k so that the largest absolute coordinate is in [1/2, 1), exactly and without overflow.

    Parameters
    ----------
    vertices : (n, 3) array of float

    Returns
    -------
    scaled : (n, 3) array of float
    k : int
    """
    k = int(np.frexp(np.abs(vertices).max())[1])
    return np.ldexp(vertices, -k), k


def unit_vertices(mesh: Mesh) -> tuple[NDArray[np.float64], int]:
    """Scale the vertices of a mesh that have a face by :func:`unit_scale`; their mean takes the place of all others.

    Vertices without a face may be anywhere.

    Parameters
    ----------
    mesh : Mesh
    """
    used = mesh.used_vertices
    if len(used) == len(mesh.vertices):
        return unit_scale(mesh.vertices)
    own, k = unit_scale(mesh.vertices[used])
    scaled: NDArray[np.float64] = np.tile(own.mean(axis=0), (len(mesh.vertices), 1))
    scaled[used] = own
    return scaled, k
