"""The value type of every discrete Laplacian: a stiffness matrix and a mass matrix.

Weak form, positive semidefinite: ``stiffness`` S has -w_ij off its diagonal and rows that sum to zero, ``mass`` M holds
the vertex areas, and M^-1 S approximates minus the Laplace-Beltrami operator (Reuter et al. 2009,
https://doi.org/10.1016/j.cag.2009.03.005). libigl has the other sign: ``from_igl`` and ``to_igl`` convert.
"""

from __future__ import annotations

__all__ = ["Laplacian", "from_igl", "to_igl"]

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array

from lbskel.display import Displayed
from lbskel.errors import MeshError, UnknownChoice, counted
from lbskel.geometry.mesh import as_mesh

# S_ii A / M_ii of every operator where six equilateral triangles meet, with A a third of their area
REGULAR_RATIO = 2 * np.sqrt(3)


@dataclass(frozen=True, eq=False, repr=False)
class Laplacian(Displayed):
    """A discrete Laplace-Beltrami operator on the vertices of its mesh.

    Parameters
    ----------
    stiffness : (n, n) csc_array
        S, whose rows sum to zero, positive semidefinite if the operator is. No unit; for ``inverse_distance`` and the
        mean value operators one over a length.
    mass : (n, n) csc_array
        M, the area of each vertex on the diagonal, in squared units of the coordinates, or what ``mass_unit`` says; not
        diagonal for the mass ``full``.
    treated_vertices : (t,) array of int
        Vertices whose row differs from the formula because a triangle there is degenerate, or which are coupled with no
        other, as a point without a triangle, or only with the point that they are a copy of.
    n_clamped_angles : int
        Number of angles that were clamped.
    mass_unit : {"area", "length", "number"}
        What a mass is: a length if the weights are one over a length, a number if the masses are degrees.

    Raises
    ------
    MeshError
        If an entry is not finite, as where the squares of the coordinates overflow.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> mesh = torus(1.0, 0.2)
    >>> laplacian = lbskel.laplacian(mesh)
    >>> float(abs(laplacian.stiffness.sum(axis=1)).max()) < 1e-12, bool(abs(laplacian.mass.sum() - mesh.area) < 1e-9)
    (True, True)
    """

    stiffness: csc_array
    mass: csc_array
    treated_vertices: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    n_clamped_angles: int = 0
    mass_unit: str = "area"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.stiffness.data).all() and np.isfinite(self.mass.data).all()):
            raise MeshError(
                "the operator has entries that are not finite: areas or lengths of this mesh overflow; "
                "scale its coordinates to about unit size"
            )

    def __repr__(self) -> str:
        n, total = self.stiffness.shape[0], float(self.mass.sum())
        treated = f", {len(self.treated_vertices)} treated" if len(self.treated_vertices) else ""
        return f"Laplacian({counted(n, 'vertex')}, {counted(self.stiffness.nnz, 'entry')}, mass {total:.6g}{treated})"

    def _drawings(self) -> list[tuple[str, csc_array]]:
        n, entries = self.stiffness.shape[0], self.stiffness.nnz
        return [(f"stiffness: {n:,} vertices, {entries:,} entries", self.stiffness)]

    def plot(self, mesh: Any) -> Any:
        """Show an interactive page: the mesh, colored by the mean curvature that the operator computes.

        Parameters
        ----------
        mesh : Mesh, or what :func:`lbskel.as_mesh` takes
            The mesh of the operator.

        Returns
        -------
        InlinePage
            Shown by a notebook; ``save(path)`` writes it to a file.

        Raises
        ------
        MeshError
            If the mesh has another number of vertices.
        UnknownChoice
            If the masses are degrees.
        MissingDependency
            If plotly is not installed.

        Examples
        --------
        >>> import lbskel
        >>> from lbskel.shapes import torus
        >>> mesh = torus(1.0, 0.2)
        >>> lbskel.laplacian(mesh).plot(mesh)
        InlinePage(show it in a notebook, or save(path))
        """
        mesh = as_mesh(mesh)
        if len(mesh.vertices) != self.stiffness.shape[0]:
            raise MeshError(f"the mesh has {len(mesh.vertices)} vertices, and the operator {self.stiffness.shape[0]}")
        curvature = np.linalg.norm(self.mean_curvature_normals(mesh.vertices), axis=1)
        return self._plot(mesh=mesh, title=repr(self), field=curvature, field_name="mean curvature")

    @property
    def weight_unit(self) -> float:
        """Unit of the weights: 1 or, where masses are lengths, the mean of S_ii over 2 sqrt(3), about 1 / edge length.

        Masses over it are about the areas of the vertices.
        """
        has_mass = self.mass.diagonal() > 0
        if self.mass_unit != "length" or not has_mass.any():
            return 1.0
        return float(self.stiffness.diagonal()[has_mass].mean() / REGULAR_RATIO)

    def strong(self) -> csc_array:
        """Return M^-1 S, which maps values of a function to minus its Laplacian; rows without positive mass are zero.

        Raises
        ------
        UnknownChoice
            If the mass is not diagonal, so that its inverse is dense.
        """
        areas = self.mass.diagonal()
        if self.mass.count_nonzero() != np.count_nonzero(areas):
            raise UnknownChoice("the strong form needs a diagonal mass; choose 'voronoi' or 'barycentric'")
        inverse = np.divide(1.0, areas, out=np.zeros_like(areas), where=areas > 0)
        return (diags_array(inverse) @ self.stiffness).tocsc()

    def delta(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Apply M^-1 S to (n,) or (n, k) values; for positions the result is the delta-coordinates of Sorkine 2005.

        Sorkine 2005, "Laplacian mesh processing", https://doi.org/10.2312/egst.20051044.

        Raises
        ------
        MeshError
            If there is not one row of values for each vertex.
        UnknownChoice
            If the mass is not diagonal.
        """
        shape, n = np.shape(values), self.stiffness.shape[0]
        if len(shape) not in (1, 2) or shape[0] != n:
            raise MeshError(f"there must be one row of values for each of {n} vertices, not shape {shape}")
        result: NDArray[np.float64] = self.strong() @ values
        return result

    def mean_curvature_normals(self, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the (n, 3) mean curvature normals H n, where H = (k1 + k2) / 2 and n points outward.

        On a sphere of radius R they have length 1/R and point outward. Those of ``graph`` are off by a factor, since
        its weights are blind to lengths, and those of ``anisotropic`` are too short where the surface bends, as it
        damps diffusion there: half as long on a sphere.

        Parameters
        ----------
        vertices : (n, 3) array of float

        Raises
        ------
        MeshError
            If there is not one position for each vertex.
        UnknownChoice
            If the mass is not diagonal, or the masses are degrees.
        """
        if self.mass_unit == "number":
            raise UnknownChoice(
                "this operator has no curvature, as its masses are degrees; build it with mass='voronoi'"
            )
        return self.delta(vertices) / 2


def from_igl(L: Any, M: Any) -> Laplacian:
    """Convert libigl's negative semidefinite ``cotmatrix`` and its ``massmatrix`` to a Laplacian.

    Parameters
    ----------
    L, M : (n, n) sparse matrix or array

    Raises
    ------
    MeshError
        If an entry is not finite.
    """
    return Laplacian(-csc_array(L), csc_array(M))


def to_igl(laplacian: Laplacian) -> tuple[csc_array, csc_array]:
    """Return the (n, n) matrices L and M in libigl's sign: L is negative semidefinite.

    Parameters
    ----------
    laplacian : Laplacian
    """
    return -laplacian.stiffness, laplacian.mass
