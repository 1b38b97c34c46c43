"""Matrices of rigid motions in homogeneous coordinates: built from an axis and an angle, and checked.

Points are column vectors: the rotation is in the first three rows and columns, the translation in the last column, and
the last row is 0, 0, 0, 1. The rotation is by the formula of Rodrigues.
"""

from __future__ import annotations

__all__ = ["checked_motion", "rigid_motion"]

from numbers import Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.errors import MeshError, first_few
from lbskel.geometry.arrays import finite_numbers

# Largest difference of a matrix from that of a rigid motion, no unit. Of ten thousand random rotations printed with
# four digits after the point, R^T R - 1 has entries of up to 1.6e-4, with five or six 1.6e-5 and 1.6e-6.
MAX_SHEAR = 1e-4


def rigid_motion(
    *,
    axis: ArrayLike = (0.0, 0.0, 1.0),
    angle_deg: float = 0.0,
    center: ArrayLike = (0.0, 0.0, 0.0),
    translation: ArrayLike = (0.0, 0.0, 0.0),
) -> NDArray[np.float64]:
    """Build the (4, 4) matrix of a rotation about an axis through a center, followed by a translation.

    Parameters
    ----------
    axis : (3,) array_like of float
        Any length but zero.
    angle_deg : float
        Counterclockwise as seen from the tip of the axis.
    center, translation : (3,) array_like of float
        In the caller's units.

    Raises
    ------
    MeshError
        If a vector is none of three finite numbers, or the axis is zero.

    Examples
    --------
    >>> import lbskel
    >>> quarter = lbskel.rigid_motion(axis=[0, 0, 1], angle_deg=90, center=[1, 0, 0])
    >>> (quarter @ [2, 0, 0, 1]).round(12)[:3] + 0
    array([1., 1., 0.])
    """
    given = {"axis": axis, "center": center, "translation": translation}
    numbers = {name: finite_numbers(each, f"coordinates of the {name}") for name, each in given.items()}
    for name, each in numbers.items():
        if each.shape != (3,):
            raise MeshError(f"the {name} must have three coordinates, not shape {each.shape}")
    direction, middle, shift = numbers.values()
    length = float(np.linalg.norm(direction))
    if not (length > 0 and np.isfinite(length) and isinstance(angle_deg, Real) and np.isfinite(angle_deg)):
        raise MeshError("a rotation needs an axis that is not zero and a finite angle")
    x, y, z = direction / length
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(angle_deg)
    R = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = R, middle - R @ middle + shift
    return motion


def checked_motion(motion: ArrayLike, handle: int) -> NDArray[np.float64]:
    """Return the (4, 4) matrix of a rigid motion of column vectors; raise MeshError if it is another matrix.

    Parameters
    ----------
    motion : (4, 4) array_like of float
    handle : int
        Number of the handle that it moves, for messages.
    """
    what = f"entries of the motion of handle {handle}"
    matrix = finite_numbers(motion, what)
    if matrix.shape != (4, 4):
        raise MeshError(f"{what} must be of shape (4, 4), not {matrix.shape}")
    R = matrix[:3, :3]
    if np.abs(matrix[3] - [0, 0, 0, 1]).max() > MAX_SHEAR:
        hint = "; this one is transposed" if np.abs(matrix[:, 3] - [0, 0, 0, 1]).max() <= MAX_SHEAR else ""
        raise MeshError(
            f"the motion of handle {handle} must have the last row 0, 0, 0, 1, and its translation in the last column, "
            f"not the last row {first_few(matrix[3])}: points are column vectors{hint}"
        )
    if np.abs(R.T @ R - np.eye(3)).max() > MAX_SHEAR or np.linalg.det(R) < 0:
        raise MeshError(
            f"the motion of handle {handle} must be rigid, a rotation in its first three rows and columns: this one "
            "scales, shears or mirrors; see lbskel.rigid_motion"
        )
    return matrix
