"""The spectrum of a Laplacian: the smallest eigenvalues and their eigenfunctions, S x = lambda M x.

The eigenfunctions are an orthonormal basis of the functions on the surface, in order of increasing frequency. The
numerical method and its paper are in :mod:`lbskel.solvers.eigenproblem`.
"""

from __future__ import annotations

__all__ = ["eigenpairs"]

from lbskel.applications.symmetric import require_symmetric
from lbskel.operators import Laplacian
from lbskel.solvers.eigenproblem import Eigenpairs, smallest_eigenpairs


def eigenpairs(laplacian: Laplacian, k: int, *, solver: str = "cholmod") -> Eigenpairs:
    """Find the k smallest eigenvalues of S x = lambda M x and their eigenfunctions.

    Parameters
    ----------
    laplacian : Laplacian
        Symmetric, positive semidefinite.
    k : int
        Number of eigenpairs; fewer are returned if fewer vertices have an area.
    solver : str
        A name in SOLVERS.

    Returns
    -------
    values : (k,) array of float
        Ascending, in 1 / length^2, but without a unit where masses are degrees.
    functions : (n, k) array of float
        Columns with X^T M X = I; the value of largest magnitude of each is positive.

    Raises
    ------
    MeshError
        If the operator is not symmetric, or the mesh has no area.
    UnknownChoice
        If no solver has that name, or k is not a positive integer.
    SolveError
        If the operator is not positive semidefinite.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.applications import eigenpairs
    >>> from lbskel.shapes import sphere
    >>> values, functions = eigenpairs(lbskel.laplacian(sphere(3)), 4)
    >>> values.round(1) + 0
    array([0., 2., 2., 2.])
    """
    require_symmetric(laplacian)
    return smallest_eigenpairs(laplacian.stiffness, laplacian.mass, k, solver=solver)
