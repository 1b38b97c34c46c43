"""Solvers of symmetric positive definite systems: factorize once, solve for several right-hand sides.

Least squares of rectangular systems, by these and by others: :mod:`lbskel.solvers.least_squares`.
"""

from __future__ import annotations

__all__ = ["DIRECT", "SOLVERS", "Factorization", "factorize", "relative_residual", "solve_once"]

from scipy.sparse import csc_array

from lbskel.errors import choose
from lbskel.solvers.cholmod import Cholmod
from lbskel.solvers.conjugate_gradients import ConjugateGradientsJacobi, ConjugateGradientsMultigrid
from lbskel.solvers.factorization import Factorization, relative_residual
from lbskel.solvers.stationary import SOR, Chebyshev, GaussSeidel, Jacobi, Richardson
from lbskel.solvers.superlu import SuperLU, solve_once

DIRECT: dict[str, type[Factorization]] = {"cholmod": Cholmod, "superlu": SuperLU}

SOLVERS: dict[str, type[Factorization]] = {
    **DIRECT,
    "richardson": Richardson,
    "jacobi": Jacobi,
    "gauss_seidel": GaussSeidel,
    "sor": SOR,
    "chebyshev": Chebyshev,
    "cg_jacobi": ConjugateGradientsJacobi,
    "cg_amg": ConjugateGradientsMultigrid,
}


def factorize(A: csc_array, solver: str = "cholmod", *, like: Factorization | None = None) -> Factorization:
    """A factorization of a symmetric positive definite matrix.

    Parameters
    ----------
    A : (n, n) csc_array
        Both triangles given.
    solver : str
        A name in SOLVERS.
    like : Factorization, optional
        One by the same solver of a matrix of the same size, whose fill-reducing ordering serves again.

    Raises
    ------
    UnknownChoice
        If no solver has that name.
    SolveError
        If A is not numerically positive definite.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csc_array
    >>> factorize(csc_array([[2.0, -1.0], [-1.0, 2.0]])).solve(np.array([[1.0], [1.0]])).ravel()
    array([1., 1.])
    """
    return choose(SOLVERS, solver, "solver")(A, like)
