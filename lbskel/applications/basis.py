"""Eigenfunctions as a basis that carries its mass: projection, reconstruction, smoothing by truncation.

The eigenfunctions X of S x = lambda M x are orthonormal in the product x^T M y, not in x^T y: the coefficients of a
function f are X^T M f. Vallet, Levy 2008, "Spectral geometry processing with manifold harmonics",
https://doi.org/10.1111/j.1467-8659.2008.01122.x.
"""

from __future__ import annotations

__all__ = ["SpectralBasis", "spectral_basis"]

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from lbskel.applications.spectrum import eigenpairs
from lbskel.errors import MeshError, checked_count, counted
from lbskel.geometry.arrays import finite_numbers
from lbskel.operators import Laplacian, PolygonMesh, laplacian


@dataclass(frozen=True, eq=False, repr=False)
class SpectralBasis:
    """The smallest eigenpairs of a Laplacian, with the mass in which the functions are orthonormal.

    Parameters
    ----------
    values : (k,) array of float
        Eigenvalues, ascending, in 1 / length^2, but without a unit where masses are degrees.
    functions : (n, k) array of float
        Eigenfunctions, in 1 / length where masses are areas: one over the root of a mass.
    laplacian : Laplacian
        The operator that they belong to, of n vertices.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> basis = lbskel.spectral_basis(torus(1.0, 0.3), 6)
    >>> basis.functions.shape[1], bool(abs(basis.values[0]) < 1e-8)
    (6, True)
    """

    values: NDArray[np.float64]
    functions: NDArray[np.float64]
    laplacian: Laplacian

    def __repr__(self) -> str:
        n, k = self.functions.shape
        values = f"eigenvalues {self.values[0]:.3g} to {self.values[-1]:.3g}"
        return f"SpectralBasis({counted(k, 'function')} on {counted(n, 'vertex')}, {values})"

    @property
    def mass(self) -> csc_array:
        """(n, n) mass matrix."""
        return self.laplacian.mass

    @property
    def area(self) -> float:
        """What eigenvalues are multiplied with to have no unit, in squared units of the coordinates.

        It is the total mass, which is the area of the surface; for ``random_walk`` the sum of the degrees, and for
        weights of one over a length near the area.
        """
        return float(self.mass.sum()) / self.laplacian.weight_unit

    @property
    def positive(self) -> NDArray[np.int64]:
        """Indices of the eigenvalues that are not zero; there is one zero eigenvalue for each component.

        An eigenvalue counts as zero below a millionth of 4 pi / area, the mean spacing of eigenvalues by Weyl's law.
        """
        return np.flatnonzero(self.values * self.area > 4e-6 * np.pi)

    def project(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the coefficients X^T M f of a function.

        Parameters
        ----------
        values : (n,) or (n, c) array of float

        Raises
        ------
        MeshError
            If there is not one row of finite numbers for each vertex.
        """
        rows = finite_numbers(values, "values of a function")
        if rows.ndim not in (1, 2) or len(rows) != len(self.functions):
            raise MeshError(
                f"the function must have one row for each of {len(self.functions)} vertices, not {rows.shape}"
            )
        coefficients: NDArray[np.float64] = self.functions.T @ (self.mass @ rows)
        return coefficients

    def reconstruct(self, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sum the functions with these coefficients; fewer than k use the first functions.

        Parameters
        ----------
        coefficients : (j,) or (j, c) array of float

        Raises
        ------
        MeshError
            If there are more coefficients than functions, or one is not finite.
        """
        rows = finite_numbers(coefficients, "coefficients")
        if rows.ndim not in (1, 2) or len(rows) > len(self.values):
            raise MeshError(f"there are {len(self.values)} functions, for coefficients of shape {rows.shape}")
        values: NDArray[np.float64] = self.functions[:, : len(rows)] @ rows
        return values

    def gram(self) -> NDArray[np.float64]:
        """Compute X^T M X, the identity to rounding."""
        matrix: NDArray[np.float64] = self.functions.T @ (self.mass @ self.functions)
        return matrix

    def residual(self) -> float:
        """Compute the largest |S x - lambda M x|, relative to the largest |S| times |x|."""
        S, X = self.laplacian.stiffness, self.functions
        scale = abs(S).max() * np.abs(X).max()
        return float(np.abs(S @ X - (self.mass @ X) * self.values).max() / scale) if scale > 0 else 0.0


def spectral_basis(
    shape: Any,
    k: int = 100,
    *,
    operator: str | Callable[[Any], Laplacian] | None = None,
    mass: str | None = None,
    solver: str = "cholmod",
) -> SpectralBasis:
    """Compute the k smoothest functions on a surface: the smallest eigenpairs of its Laplacian.

    Parameters
    ----------
    shape : Mesh, PolygonMesh, PointCloud, or what :func:`lbskel.as_mesh` takes
        Open, non-manifold and of several components too; each component has an eigenvalue of zero.
    k : int
        Number of functions; fewer are returned if fewer vertices have an area.
    operator : str or callable, optional
        As in :func:`lbskel.laplacian`: a symmetric one. By default ``robust``; for a polygon mesh ``cotangent``.
    mass : {"voronoi", "barycentric", "full"}, optional
        For a mesh; by default the operator's own.
    solver : str
        A name in SOLVERS.

    Raises
    ------
    MeshError
        If the operator is not defined on the shape or not symmetric, or the shape has no area.
    UnknownChoice
        If there is no such operator, mass or solver, or k is not a positive number.
    SolveError
        If the operator is not positive semidefinite.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import sphere
    >>> mesh = sphere(3)
    >>> basis = lbskel.spectral_basis(mesh, 50)
    >>> smooth = basis.reconstruct(basis.project(mesh.vertices))
    >>> basis.gram().shape, bool(abs(smooth - mesh.vertices).max() < 0.01)
    ((50, 50), True)
    """
    checked_count(k, "the number of functions", 1)
    default = "cotangent" if isinstance(shape, PolygonMesh) else "robust"
    found = laplacian(shape, operator=operator or default, mass=mass)
    values, functions = eigenpairs(found, int(k), solver=solver)
    return SpectralBasis(values, functions, found)
