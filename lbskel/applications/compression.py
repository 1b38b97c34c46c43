"""Compression of positions by a basis that the decoder computes from the faces alone, with a rate and an error.

``spectral``: the first eigenvectors of the graph Laplacian. Karni, Gotsman 2000, "Spectral compression of mesh
geometry", https://doi.org/10.1145/344779.344924. ``geometry_aware``: u_i = argmin |L u|^2 + sum_j (u(a_j) - [i = j])^2
for anchors a_j and L = I - D^-1 A, whose coefficients are the positions of the anchors. Anchors are added where the
error is largest. Sorkine, Cohen-Or, Irony, Toledo 2005, "Geometry-aware bases for shape approximation",
https://doi.org/10.1109/TVCG.2005.33. Coefficients are rounded to multiples of one step.
"""

from __future__ import annotations

__all__ = ["BASES", "CompressedMesh", "compress"]

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array

from lbskel.errors import MeshError, UnknownChoice, choose
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.solvers import Factorization, factorize
from lbskel.solvers.eigenproblem import smallest_eigenpairs

BASES = ("spectral", "geometry_aware")
BITS_OF_A_FLOAT = 64
MAX_BITS = 32  # of a coefficient; beyond, positions have fewer digits than that


@dataclass(frozen=True, eq=False, repr=False)
class CompressedMesh:
    """Rounded coefficients of the positions of a mesh, which is decoded from these fields alone.

    Parameters
    ----------
    basis : str
        A name in BASES.
    faces : (m, 3) array of int
        What connectivity coders store; not counted in the rate.
    n_vertices : int
    coefficients : (k, 3) array of int
    step : float
        What a coefficient is multiplied with, in the units of the mesh.
    origin : (3,) array of float
        Added to all positions.
    anchors : (k,) array of int
        Vertices, of the basis ``geometry_aware``; else empty.
    """

    basis: str
    faces: NDArray[np.int64]
    n_vertices: int
    coefficients: NDArray[np.int64]
    step: float
    origin: NDArray[np.float64]
    anchors: NDArray[np.int64]

    def __repr__(self) -> str:
        k = len(self.coefficients)
        rate = f"{self.bits_per_vertex:.3g} bits a vertex"
        return f"CompressedMesh({self.basis}, {k} of {self.n_vertices} functions, {rate})"

    @property
    def bits_per_vertex(self) -> float:
        """Rate: entropy of the coefficients of each coordinate, anchors, origin and step, over the vertices."""
        k = len(self.coefficients)
        total = 4 * BITS_OF_A_FLOAT + len(self.anchors) * np.log2(max(self.n_vertices, 2))
        for column in self.coefficients.T:
            share = np.unique(column, return_counts=True)[1] / k
            total -= k * float(share @ np.log2(share))
        return float(total / self.n_vertices)

    @cached_property
    def mesh(self) -> Mesh:
        """The decoded mesh, with the faces and the vertex order of the original."""
        coefficients = np.multiply(self.coefficients, self.step, dtype=np.float64)
        if self.basis == "spectral":
            V = _graph_eigenvectors(self.faces, self.n_vertices, len(coefficients)) @ coefficients
        else:
            V = _interpolate(self.faces, self.n_vertices, self.anchors, coefficients)
        return Mesh(V + self.origin, self.faces)

    def rms_error(self, mesh: Any) -> float:
        """Compute the root mean square distance of the decoded vertices from those of a mesh, in its units.

        Parameters
        ----------
        mesh : Mesh, or what :func:`lbskel.as_mesh` takes
            The original.
        """
        offsets = self.mesh.vertices - as_mesh(mesh).vertices
        scale = float(np.abs(offsets).max())
        return scale * float(np.sqrt(((offsets / scale) ** 2).sum(axis=1).mean())) if scale > 0 else 0.0


def compress(mesh: Any, k: int, *, basis: str = "spectral", bits: int = 12) -> CompressedMesh:
    """Compress the positions of a mesh to k rounded coefficients for each coordinate.

    Parameters
    ----------
    mesh : Mesh, or what :func:`lbskel.as_mesh` takes
    k : int
        Number of functions of the basis.
    basis : {"spectral", "geometry_aware"}
        For the second, k is at least the number of connected components, isolated vertices included.
    bits : int
        The coefficients are rounded to 2^bits steps over their range.

    Raises
    ------
    UnknownChoice
        If there is no such basis, or a number is out of its range.
    MeshError
        If there are more components than anchors.

    References
    ----------
    Karni, Gotsman 2000, https://doi.org/10.1145/344779.344924, section 3; Sorkine et al. 2005,
    https://doi.org/10.1109/TVCG.2005.33, equation 4.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> mesh = torus(1.0, 0.3)
    >>> packed = lbskel.compress(mesh, 60)
    >>> packed.bits_per_vertex < 6, packed.rms_error(mesh) < 0.01
    (True, True)
    """
    mesh = as_mesh(mesh)
    choose(dict.fromkeys(BASES), basis, "basis")
    n = len(mesh.vertices)
    if not (isinstance(k, int | np.integer) and 0 < k <= n):
        raise UnknownChoice(f"the number of functions must be an integer from 1 to {n}, not {k!r}")
    if not (isinstance(bits, int | np.integer) and 0 < bits <= MAX_BITS):
        raise UnknownChoice(f"the bits of a coefficient must be an integer from 1 to {MAX_BITS}, not {bits!r}")
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    origin = low / 2 + high / 2
    V, exponent = unit_scale(mesh.vertices - origin)
    if basis == "spectral":
        anchors = np.empty(0, dtype=np.int64)
        coefficients = _graph_eigenvectors(mesh.faces, n, int(k)).T @ V
    else:
        anchors = _choose_anchors(mesh, V, int(k))
        coefficients = V[anchors]
    step = float(np.abs(coefficients).max()) / 2 ** (bits - 1)
    rounded = np.rint(coefficients / step).astype(np.int64) if step > 0 else np.zeros(coefficients.shape, np.int64)
    return CompressedMesh(basis, mesh.faces, n, rounded, float(np.ldexp(step, exponent)), origin, anchors)


def _adjacency(faces: NDArray[np.int64], n: int) -> csc_array:
    """Build the adjacency matrix, with entries of one."""
    i, j = faces[:, [0, 1, 2]].ravel(), faces[:, [1, 2, 0]].ravel()
    A = csc_array((np.ones(len(i)), (i, j)), shape=(n, n))
    A = A + A.T
    A.setdiag(0.0)
    A.eliminate_zeros()
    return A.sign().tocsc()


def _graph_eigenvectors(faces: NDArray[np.int64], n: int, k: int) -> NDArray[np.float64]:
    """Compute the first eigenvectors of D - A."""
    A = _adjacency(faces, n)
    S = (diags_array(A.sum(axis=0)) - A).tocsc()
    return smallest_eigenpairs(S, csc_array(diags_array(np.ones(n))), k)[1]


def _interpolate(
    faces: NDArray[np.int64], n: int, anchors: NDArray[np.int64], positions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Find the smoothest positions close to those of the anchors."""
    factor, is_anchor = _normal_equations(_umbrella(faces, n), anchors)
    right = np.zeros((n, 3))
    right[anchors] = positions
    return factor.solve(is_anchor[:, None] * right)


def _umbrella(faces: NDArray[np.int64], n: int) -> csc_array:
    """Build I - D^-1 A; rows of isolated vertices are zero."""
    A = _adjacency(faces, n)
    degrees = A.sum(axis=0)
    return csc_array(diags_array((degrees > 0) * 1.0) - diags_array(1 / np.maximum(degrees, 1)) @ A)


def _normal_equations(L: csc_array, anchors: NDArray[np.int64]) -> tuple[Factorization, NDArray[np.float64]]:
    """Factorize L^T L + P^T P, for the selection P of the anchors."""
    is_anchor = np.zeros(L.shape[0])
    is_anchor[anchors] = 1.0
    return factorize((L.T @ L + diags_array(is_anchor)).tocsc()), is_anchor


def _choose_anchors(mesh: Mesh, V: NDArray[np.float64], k: int) -> NDArray[np.int64]:
    """Choose anchors: a vertex of each component, then in rounds where the error is largest among the neighbors.

    A round at most doubles their number, so that there are about log2 k factorizations.
    """
    n = len(V)
    anchors = np.unique(mesh.component_of_vertex, return_index=True)[1]
    if len(anchors) > k:
        raise MeshError(
            f"{len(anchors)} connected components, isolated vertices included, need as many anchors, not {k}"
        )
    L = _umbrella(mesh.faces, n)
    i, j = mesh.edges.T
    while len(anchors) < k:
        factor, is_anchor = _normal_equations(L, anchors)
        error = np.linalg.norm(factor.solve(is_anchor[:, None] * V) - V, axis=1)
        error[anchors] = -1.0
        largest = error.copy()
        np.maximum.at(largest, i, error[j])
        np.maximum.at(largest, j, error[i])
        order = np.argsort(-error, kind="stable")
        peaks = order[(error >= largest)[order] & (error[order] >= 0)]
        anchors = np.concatenate([anchors, peaks[: min(len(anchors), k - len(anchors))]])
    return anchors
