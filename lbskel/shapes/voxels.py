"""Surfaces of sets of voxels: lattices, porous blocks, brushes, trees and plates, with thousands of features.

Made by marching cubes between voxels inside and outside (Lorensen, Cline 1987, https://doi.org/10.1145/37402.37422), so
surfaces are closed and bars one voxel wide have eight faces per voxel.
"""

from __future__ import annotations

__all__ = ["brush", "lattice", "perforated_plate", "porous_block", "voxel_surface", "voxel_tree"]

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from lbskel.errors import MeshError, UnknownChoice
from lbskel.geometry.mesh import Mesh


def voxel_surface(filled: ArrayLike) -> Mesh:
    """Mesh the surface of the filled voxels, of side 1; voxels that touch along an edge or at a corner are separate.

    Parameters
    ----------
    filled : (x, y, z) array_like of bool or int
        Voxels with any number but 0 are filled.

    Raises
    ------
    MeshError
        If the array has another shape or real numbers other than 0 and 1, or no voxel is filled.
    """
    labels = np.asarray(filled)
    if labels.dtype.kind not in "biu" and not np.isin(labels, [0, 1]).all():
        raise MeshError(
            f"filled must be of bool or int, not gray values of {labels.dtype}: compare them with a threshold"
        )
    given = (labels != 0).astype(np.float64)
    if given.ndim != 3 or not given.any():
        raise MeshError(f"filled must have shape (x, y, z) and a voxel that is filled; its shape is {given.shape}")
    inside = np.pad(given, 1)
    x, y, z = inside.shape
    points = np.stack(np.meshgrid(*map(np.arange, (z, y, x)), indexing="ij"), axis=-1).reshape(-1, 3)[:, ::-1] - 1.0
    V, F, _ = igl.marching_cubes(inside.transpose(2, 1, 0).ravel(), points, x, y, z, 0.5)
    mesh = Mesh(V, F)
    return mesh if mesh.volume > 0 else Mesh(V, mesh.faces[:, ::-1])


def lattice(n: int, *, spacing: int = 3) -> Mesh:
    """Build a cubic lattice of bars, n nodes along each axis; its genus is 3 n^2 (n - 1) - n^3 + 1.

    Parameters
    ----------
    n : int
    spacing : int
        Distance of two nodes, in bar widths; at least 2.

    Raises
    ------
    UnknownChoice
        If the spacing is less than 2, which leaves no holes between the bars.
    """
    if not spacing >= 2:
        raise UnknownChoice(f"spacing must be at least 2, not {spacing}")
    on = np.arange(spacing * (n - 1) + 1) % spacing == 0
    return voxel_surface(sum(np.meshgrid(on, on, on, indexing="ij"), np.zeros((), dtype=np.int64)) >= 2)


def porous_block(size: int, *, grain: float = 1.0, filled: float = 0.5, seed: int = 0) -> Mesh:
    """Build the largest part of a block of random noise that exceeds a threshold, without cavities.

    Parameters
    ----------
    size : int
        Side of the block, in voxels.
    grain : float
        Standard deviation of the Gaussian filter, in voxels; 0 leaves noise of single voxels.
    filled : float
        Fraction of the voxels above the threshold.
    seed : int

    Raises
    ------
    UnknownChoice
        If the fraction does not lie between 0 and 1.
    """
    if not 0 < filled <= 1:
        raise UnknownChoice(f"filled must be above 0 and at most 1, not {filled}")
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=(size,) * 3), grain)
    return voxel_surface(_largest_part(noise > np.quantile(noise, 1 - filled)))


def brush(n: int, *, length: int = 12, spacing: int = 3) -> Mesh:
    """Build a plate with n^2 bristles of width 1.

    Parameters
    ----------
    n : int
    length : int
        Length of a bristle, in its width.
    spacing : int
        Distance of neighboring bristles, in their width.
    """
    on = np.arange(spacing * n + 1) % spacing == 1
    filled = np.zeros((len(on), len(on), length + 2), dtype=bool)
    filled[:, :, :2] = True
    filled[np.ix_(on, on)] = True
    return voxel_surface(filled)


def voxel_tree(n: int, *, length: int = 20, spacing: int = 4) -> Mesh:
    """Build a trunk with n limbs, each with n twigs, alternately on its two sides; twigs and trunk have n^2 + 2 tips.

    Parameters
    ----------
    n : int
    length : int
        Length of a twig, in its width.
    spacing : int
        Distance of neighboring limbs and of neighboring twigs, in their width.
    """
    on = spacing * np.arange(n)
    filled = np.zeros((on[-1] + 2 * spacing, on[-1] + spacing + 1, 2 * length + 1), dtype=bool)
    filled[:, 0, length] = True
    filled[on + spacing, :, length] = True
    side = (np.arange(n)[:, None] + np.arange(n)) % 2
    for half, is_side in ((slice(length), side == 0), (slice(length, None), side == 1)):
        i, j = np.nonzero(is_side)
        filled[on[i] + spacing, on[j] + spacing, half] = True
    return voxel_surface(filled)


def perforated_plate(n: int, *, spacing: int = 4) -> Mesh:
    """Build a plate of thickness 1 with n^2 square holes, which is its genus.

    Parameters
    ----------
    n : int
    spacing : int
        Distance of neighboring holes, in the thickness of the plate; a hole is ``spacing - 1`` wide.
    """
    on = np.arange(spacing * n + 1) % spacing == 0
    return voxel_surface((on[:, None] | on[None, :])[:, :, None])


def _largest_part(filled: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Keep the largest set of voxels that are connected by faces, and fill what it encloses."""
    labels, _ = ndimage.label(filled)
    part: NDArray[np.bool_] = ndimage.binary_fill_holes(labels == 1 + np.argmax(np.bincount(labels.ravel())[1:]))
    return part
