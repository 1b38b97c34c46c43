"""Solvers of symmetric positive definite systems: factorize once, solve for several right-hand sides.

``SOLVERS`` are the solvers for use. ``CLASSICAL_ITERATIONS`` (Richardson, Jacobi, Gauss-Seidel, SOR, Chebyshev) are
there for study: on the systems of a contraction their error is still above 1 % after 2000 iterations
(``benchmarks/results/solvers.md``). Least squares of rectangular systems: :mod:`lbskel.solvers.least_squares`.
"""

from __future__ import annotations

__all__ = [
    "ALL_SOLVERS",
    "CLASSICAL_ITERATIONS",
    "DIRECT_SOLVERS",
    "SOLVERS",
    "Factorization",
    "factorize",
    "relative_residual",
    "solve_once",
]

from scipy.sparse import csc_array

from lbskel.errors import SolveError, choose
from lbskel.solvers.cholmod import Cholmod
from lbskel.solvers.conjugate_gradients import ConjugateGradientsJacobi, ConjugateGradientsMultigrid
from lbskel.solvers.factorization import Factorization, real_matrix, relative_residual
from lbskel.solvers.stationary import SOR, Chebyshev, GaussSeidel, Jacobi, Richardson
from lbskel.solvers.superlu import SuperLU, solve_once

DIRECT_SOLVERS: dict[str, type[Factorization]] = {"cholmod": Cholmod, "superlu": SuperLU}

SOLVERS: dict[str, type[Factorization]] = {
    **DIRECT_SOLVERS,
    "cg_jacobi": ConjugateGradientsJacobi,
    "cg_amg": ConjugateGradientsMultigrid,
}

CLASSICAL_ITERATIONS: dict[str, type[Factorization]] = {
    "richardson": Richardson,
    "jacobi": Jacobi,
    "gauss_seidel": GaussSeidel,
    "sor": SOR,
    "chebyshev": Chebyshev,
}

ALL_SOLVERS: dict[str, type[Factorization]] = {**SOLVERS, **CLASSICAL_ITERATIONS}


def factorize(A: csc_array, solver: str = "cholmod", *, like: Factorization | None = None) -> Factorization:
    """Factorize a symmetric positive definite matrix.

    Parameters
    ----------
    A : (n, n) csc_array
        Both triangles given; other sparse formats, and dense arrays, are converted.
    solver : str
        A name in SOLVERS, or, for study, in CLASSICAL_ITERATIONS.
    like : Factorization, optional
        A factorization by the same solver of a matrix of the same size. Its fill-reducing ordering is used again by
        ``superlu``, and by ``cholmod`` if the sparsity pattern is the same.

    Raises
    ------
    UnknownChoice
        If no solver has that name.
    SolveError
        If A is complex or not square, has entries that are not finite, or is not numerically positive definite;
        iterative solvers check only that its diagonal is positive, and ``solve`` raises it where they do not converge.
    MissingDependency
        If the solver is ``cg_amg`` and pyamg is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csc_array
    >>> factorize(csc_array([[2.0, -1.0], [-1.0, 2.0]])).solve(np.array([[1.0], [1.0]])).ravel()
    array([1., 1.])
    """
    kind = choose(ALL_SOLVERS, solver, "solver")
    matrix = real_matrix(A)
    if matrix.shape[0] != matrix.shape[1]:
        raise SolveError(f"the matrix must be square, not {matrix.shape[0]} x {matrix.shape[1]}; lstsq takes others")
    return kind(matrix, like)
