"""Compression of positions by a basis that the decoder computes from the faces alone, with a rate and an error.

``spectral``: the first eigenvectors of the graph Laplacian. Karni, Gotsman 2000, "Spectral compression of mesh
geometry", https://doi.org/10.1145/344779.344924. ``geometry_aware``: u_i = argmin |L u|^2 + sum_j (u(a_j) - [i = j])^2
for anchors a_j and L = I - D^-1 A; the coefficients are the positions of the anchors, which are added where the error
is largest. Sorkine, Cohen-Or, Irony, Toledo 2005, "Geometry-aware bases for shape approximation",
https://doi.org/10.1109/TVCG.2005.33. Coefficients are rounded to multiples of one step.

The eigenvectors of a multiple eigenvalue are any basis of their space, and rounding, which differs between processors,
chooses among these. So equal eigenvalues are taken all or none, with the basis that Gram-Schmidt makes of the
projections of random vectors; the sum then depends on rounding by its errors alone.
"""

from __future__ import annotations

__all__ = ["BASES", "CompressedMesh", "compress"]

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.applications.anchor_selection import greedy_anchors
from lbskel.applications.differential_coordinates import AnchoredLaplacian, uncoupled_rows
from lbskel.applications.quantization import coded_bits
from lbskel.errors import MeshError, checked_count, choose
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators import Laplacian
from lbskel.operators.assembly import diagonal_matrix
from lbskel.operators.combinatorial import random_walk
from lbskel.solvers.eigenproblem import RELATIVE_GAP, smallest_eigenpairs

BASES = ("spectral", "geometry_aware")
BITS_OF_A_FLOAT = 64
MAX_BITS = 32  # of a coefficient; beyond, positions have fewer digits than that
# Eigenvalues count as equal up to this gap, relative to their size and mean spacing. It bounds the errors of the spaces
# by 1e-9, those of the residuals over it, and is above the gap up to which the solver may miss one of several values.
EQUAL_GAP = 10 * RELATIVE_GAP
SEED = 0  # of the random vectors, which are part of the format


@dataclass(frozen=True, eq=False, repr=False)
class CompressedMesh:
    """Rounded coefficients of the positions of a mesh, which is decoded from these fields alone.

    Another processor, or number of threads, decodes the same positions up to a millionth of the size of the mesh.
    Vertices without a face are not coded: they are decoded at the origin.

    Parameters
    ----------
    basis : str
        A name in BASES.
    faces : (m, 3) array of int
        The connectivity, which coders of its own kind store; not counted in the rate.
    n_vertices : int
    coefficients : (k, 3) array of int
    step : float
        Factor of the coefficients, in the units of the mesh.
    origin : (3,) array of float
        Added to all positions.
    anchors : (k,) array of int
        The anchors of the basis ``geometry_aware``; for ``spectral`` empty.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> packed = lbskel.compress(torus(1.0, 0.3), 20)
    >>> len(packed.mesh.vertices) == len(torus(1.0, 0.3).vertices)
    True
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
        """Rate: bits of coefficients of each coordinate, anchors, origin and step, over the vertices with a face."""
        k, n = len(self.coefficients), len(self._compact[0])
        total = 4 * BITS_OF_A_FLOAT + len(self.anchors) * np.log2(max(n, 2))
        return float((total + k * coded_bits(self.coefficients)) / n)

    @cached_property
    def _compact(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(u,) vertices that have a face, and (m, 3) the faces by their numbers in it."""
        return _without_unused(self.faces)

    @cached_property
    def mesh(self) -> Mesh:
        """The decoded mesh, with the faces and the vertex order of the original."""
        coefficients = np.multiply(self.coefficients, self.step, dtype=np.float64)
        used, faces = self._compact
        V = np.zeros((self.n_vertices, 3))
        if self.basis == "spectral":
            V[used] = _graph_eigenvectors(faces, len(used), len(coefficients)) @ coefficients
        else:
            V[used] = _interpolate(faces, len(used), np.searchsorted(used, self.anchors), coefficients)
        return Mesh(V + self.origin, self.faces)

    def rms_error(self, mesh: Any) -> float:
        """Compute the root mean square distance of the decoded vertices with a face from those of a mesh, in its units.

        Parameters
        ----------
        mesh : Mesh, or what :func:`lbskel.as_mesh` takes
            The original.

        Raises
        ------
        MeshError
            If it has another number of vertices.
        """
        original: Mesh = as_mesh(mesh)
        if len(original.vertices) != self.n_vertices:
            raise MeshError(f"a mesh of {self.n_vertices} vertices was compressed, not one of {len(original.vertices)}")
        offsets = (self.mesh.vertices - original.vertices)[self._compact[0]]
        scale = float(np.abs(offsets).max())
        return scale * float(np.sqrt(((offsets / scale) ** 2).sum(axis=1).mean())) if scale > 0 else 0.0


def compress(mesh: Any, k: int, *, basis: str = "spectral", bits: int = 12) -> CompressedMesh:
    """Compress the positions of a mesh to k rounded coefficients for each coordinate.

    Parameters
    ----------
    mesh : Mesh, or what :func:`lbskel.as_mesh` takes
    k : int
        Number of functions of the basis, at least the number of connected components, at most that of vertices with a
        face. The basis ``spectral`` has fewer if the k-th eigenvalue equals the next: of equal ones it has all or none.
    basis : {"spectral", "geometry_aware"}
    bits : int
        The coefficients are rounded to 2^bits steps over their range.

    Raises
    ------
    UnknownChoice
        If there is no such basis, or a number is out of its range.
    MeshError
        If there are more components than functions.

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
    used, faces = _without_unused(mesh.faces)
    positions = mesh.vertices[used]
    checked_count(k, "the number of functions", 1, len(used))
    checked_count(bits, "the bits of a coefficient", 1, MAX_BITS)
    low, high = positions.min(axis=0), positions.max(axis=0)
    origin = low / 2 + high / 2
    V, exponent = unit_scale(positions - origin)
    if mesh.n_components > k:
        raise MeshError(f"{mesh.n_components} connected components need as many functions, not {k}")
    if basis == "spectral":
        anchors = np.empty(0, dtype=np.int64)
        coefficients = _graph_eigenvectors(faces, len(used), int(k)).T @ V
    else:
        anchors = _anchors(faces, V, int(k))
        coefficients = V[anchors]
    step = float(np.abs(coefficients).max(initial=0.0)) / 2 ** (bits - 1)
    rounded = np.rint(coefficients / step).astype(np.int64) if step > 0 else np.zeros(coefficients.shape, np.int64)
    step, n = float(np.ldexp(step, exponent)), len(mesh.vertices)
    return CompressedMesh(basis, mesh.faces, n, rounded, step, origin, used[anchors])


def _without_unused(faces: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the (u,) vertices that have a face, and the (m, 3) faces by their numbers among these."""
    used, corners = np.unique(faces, return_inverse=True)
    return used, corners.reshape(-1, 3)


def _connectivity(faces: NDArray[np.int64], n: int) -> Laplacian:
    """Build D - A and, in the strong form, I - D^-1 A, which is zero at isolated vertices."""
    return random_walk(Mesh(np.zeros((n, 3)), faces))


def _graph_eigenvectors(faces: NDArray[np.int64], n: int, k: int) -> NDArray[np.float64]:
    """Compute the first eigenvectors of D - A, at most k, with one basis for each cluster of equal eigenvalues."""
    S = _connectivity(faces, n).stiffness
    values, X = smallest_eigenpairs(S, diagonal_matrix(np.ones(n)), min(k + 1, n))
    spacing = float(S.diagonal().mean()) / n
    ends = np.flatnonzero(np.diff(values) > EQUAL_GAP * (values[1:] + spacing)) + 1
    if k == n:
        ends = np.append(ends, n)
    random = np.random.RandomState(SEED)  # the generator whose numbers no version of numpy changes
    for start, end in pairwise([0, *ends]):
        cluster = X[:, start:end]
        Q, R = np.linalg.qr(cluster.T @ random.uniform(-1, 1, (n, end - start)))
        X[:, start:end] = cluster @ (Q * np.sign(R.diagonal()))
    return X[:, : ends.max(initial=0)]


def _interpolate(
    faces: NDArray[np.int64], n: int, anchors: NDArray[np.int64], positions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Find the smoothest positions close to those of the anchors."""
    umbrella = _connectivity(faces, n).strong()
    return AnchoredLaplacian(umbrella, anchors, weight=1.0).solve(np.zeros((n, 3)), positions)


def _anchors(faces: NDArray[np.int64], V: NDArray[np.float64], k: int) -> NDArray[np.int64]:
    """Choose k anchors: the vertices without an edge, which nothing else determines, and greedy ones."""
    umbrella = _connectivity(faces, len(V)).strong()
    isolated = np.flatnonzero(uncoupled_rows(umbrella))
    return np.concatenate([isolated, greedy_anchors(umbrella, np.zeros_like(V), V, k - len(isolated))[0]])
