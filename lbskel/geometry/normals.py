"""Normals of triangles, lengths of vectors, and vectors scaled to unit length."""

from __future__ import annotations

__all__ = ["normalized", "row_dots", "triangle_normals", "vector_lengths"]

import numpy as np
from numpy.typing import NDArray


def triangle_normals(A: NDArray[np.float64], B: NDArray[np.float64], C: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3) normals (B - A) x (C - A) of triangles; their length is twice the area.

    Parameters
    ----------
    A, B, C : (..., 3) array of float
        Corners, counter-clockwise as seen from the tip of the normal; the shapes are broadcast.
    """
    normals: NDArray[np.float64] = np.cross(B - A, C - A)
    return normals


def vector_lengths(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """(...) lengths of vectors, bit for bit those of ``numpy.linalg.norm``, which takes five times as long.

    Parameters
    ----------
    vectors : (..., 3) array of float
    """
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    lengths: NDArray[np.float64] = np.sqrt(x * x + y * y + z * z)
    return lengths


def row_dots(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) dot products of the rows of two arrays, bit for bit those of ``(a * b).sum(axis=1)``, in less time.

    Parameters
    ----------
    a, b : (k, 3) array of float
    """
    x, y, z = (a * b).T
    dots: NDArray[np.float64] = x + y + z
    return dots


def normalized(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3) vectors scaled to length 1; zero vectors stay zero.

    Parameters
    ----------
    vectors : (k, 3) array of float
    """
    lengths = vector_lengths(vectors)[:, None]
    unit: NDArray[np.float64] = np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0)
    return unit
