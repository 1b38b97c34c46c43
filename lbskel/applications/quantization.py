"""High-pass quantization: deltas are rounded in place of positions, so that the error is smooth and hardly visible.

The rounding error of delta = S V is divided by the eigenvalues of S: high frequencies get little of it and low ones
much, which anchors bound. Rounded positions, in contrast, have white noise. Sorkine, Cohen-Or, Toledo 2003, "High-pass
quantization for mesh encoding", https://doi.org/10.2312/SGP/SGP03/042-051.
"""

from __future__ import annotations

__all__ = ["QuantizedDeltas", "quantize_deltas", "round_to_bits"]

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.applications.anchor_selection import greedy_anchors
from lbskel.errors import checked_count
from lbskel.geometry.arrays import read_only
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators import Operator, apply_operator

MAX_BITS = 32  # of a coordinate; more than the 24 of a float in single precision
ANCHOR_BITS = 3 * 32  # bits of the position of an anchor: three floats in single precision


def round_to_bits(values: NDArray[np.float64], bits: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Round to 2^bits equidistant values over the largest range of a column.

    Parameters
    ----------
    values : (n, c) array of float
    bits : int

    Returns
    -------
    codes : (n, c) array of int
        From 0 to 2^bits - 1.
    rounded : (n, c) array of float
    """
    low = values.min(axis=0)
    step = float((values.max(axis=0) - low).max()) / (2**bits - 1)
    if not step > 0:
        return np.zeros(values.shape, dtype=np.int64), np.array(values)
    codes = np.rint((values - low) / step).astype(np.int64)
    return codes, low + step * codes


def coded_bits(codes: NDArray[np.int64]) -> float:
    """Compute the bits that a row of (n, c) codes takes on average, each column coded as in JPEG.

    The number of digits of each magnitude is coded by its frequencies, whose table is small; the digits after the first
    and the sign are stored. The entropy of the codes themselves is too low where most differ: at most log2 n.

    ITU-T T.81 1992, "Digital compression and coding of continuous-tone still images", annex F.1.2.
    """
    n_digits = np.frexp(np.abs(codes))[1]
    total = float(n_digits.mean(axis=0).sum())
    for column in n_digits.T:
        shares = np.unique(column, return_counts=True)[1] / len(column)
        total -= float(shares @ np.log2(shares))
    return total


@dataclass(frozen=True, eq=False)
class QuantizedDeltas:
    """Rounded differential coordinates with anchors, and the surface that they give.

    Parameters
    ----------
    codes : (n, 3) array of int
        Rounded deltas, from 0 to 2^bits - 1.
    anchors : (k,) array of int
        Vertices stored with their positions, in the order in which they were chosen.
    mesh : Mesh
        The reconstructed surface.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> rounded = lbskel.quantize_deltas(torus(1.0, 0.3), bits=8)
    >>> rounded.bits_per_vertex > 0
    True
    """

    codes: NDArray[np.int64]
    anchors: NDArray[np.int64]
    mesh: Mesh

    @cached_property
    def bits_per_vertex(self) -> float:
        """Bits of the codes about their medians, and of positions and indices of anchors; the faces are not counted."""
        n = len(self.codes)
        centered = self.codes - np.rint(np.median(self.codes, axis=0)).astype(np.int64)
        return coded_bits(centered) + len(self.anchors) * (ANCHOR_BITS + float(np.log2(n))) / n


def quantize_deltas(
    mesh: Any,
    *,
    bits: int = 8,
    n_anchors: int = 20,
    operator: str | Operator = "graph",
    anchor_weight: float = 1.0,
    solver: str = "cholmod",
) -> QuantizedDeltas:
    """Round the deltas of a surface, choose anchors where the error is largest, and reconstruct the surface.

    Parameters
    ----------
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
    bits : int
        Of each coordinate of a delta, from 1 to 32.
    n_anchors, operator, anchor_weight, solver
        As for :func:`lbskel.least_squares_mesh`, with the same errors. A decoder has the connectivity only, which
        determines ``graph``; for other operators it also needs the weights, which are not counted.

    Raises
    ------
    UnknownChoice
        If the bits are out of range.

    References
    ----------
    Sorkine, Cohen-Or, Toledo 2003, sections 3 and 4.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> ring = torus(1.0, 0.3, 24, 12)
    >>> rounded = lbskel.quantize_deltas(ring, bits=8, n_anchors=4)
    >>> rounded.bits_per_vertex < 24, float(abs(rounded.mesh.vertices - ring.vertices).max()) < 0.02
    (True, True)
    """
    given: Mesh = as_mesh(mesh)
    checked_count(bits, "bits", 1, MAX_BITS)
    laplacian = apply_operator(operator, given)
    stiffness = laplacian.stiffness / laplacian.weight_unit
    scaled, exponent = unit_scale(given.vertices)  # areas of tiny meshes vanish, products of huge ones overflow
    center = given.with_vertices(scaled).centroid
    V = scaled - center
    codes, deltas = round_to_bits(stiffness @ V, int(bits))
    anchors, X = greedy_anchors(stiffness, deltas, V, n_anchors, weight=anchor_weight, solver=solver)
    return QuantizedDeltas(read_only(codes), read_only(anchors), given.with_vertices(np.ldexp(X + center, exponent)))
