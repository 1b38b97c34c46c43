"""Smoothing: diffusion of the positions along a Laplacian, dX/dt = -M^-1 S X, by explicit and implicit steps.

- ``explicit``:  X' = X - t M^-1 S X, stable for t <= 2 / lambda_max
- ``implicit``:  (M + t S) X' = M X, stable for every t
- ``curvature_flow``:  the implicit step with M and S of the present surface, as in a contraction
- ``bilaplacian``:  (M + t^2 S M^-1 S) X' = M X, which changes low frequencies least
- ``taubin``:  X' = (1 - mu K)(1 - lambda K) X with K = D^-1 S, D the diagonal of S; passes low frequencies unchanged
- ``polynomial``:  X' = p(K) X, p the Chebyshev expansion of exp(-(k / c)^2) of degree 6: six products and no system

With ``random_walk``, I - K takes the mean of the neighbors, and both filters need no matrices
(:mod:`lbskel.applications.neighbor_means`).

Desbrun, Meyer, Schroeder, Barr 1999, "Implicit fairing of irregular meshes using diffusion and curvature flow",
https://doi.org/10.1145/311535.311576; Taubin 1995, "A signal processing approach to fair surface design",
https://doi.org/10.1145/218380.218473; for polynomials by Chebyshev, Taubin, Zhang, Golub 1996,
"Optimal surface smoothing as filter design", European Conference on Computer Vision. Implicit steps are solved for the
displacement, as are those of a contraction.
"""

from __future__ import annotations

__all__ = ["SMOOTHING_METHODS", "smooth"]

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array, csr_array

from lbskel.applications.constrained_systems import ConstrainedSystem, checked_indices
from lbskel.applications.neighbor_means import NeighborMeans, boundary_vertices, edge_keys
from lbskel.applications.smoothing_filters import FILTERS, Positions, Step, average, average_of_neighbors
from lbskel.applications.squared_matrices import matrix_product
from lbskel.applications.volume import has_volume, keep_volumes
from lbskel.errors import MeshError, SolveError, UnknownChoice, checked_count, choose, is_number
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.operators import Laplacian, Operator, apply_operator
from lbskel.operators.assembly import diagonal_matrix

# Default time step in mean vertex areas, and default iterations: near the smallest distance to the clean surface after
# noise of a quarter of the mean edge length (benchmarks/results/applications_smoothing.md, "Settings"). None means half
# of the largest stable step for ``explicit``; filters have no step.
DEFAULTS: dict[str, tuple[float | None, int]] = {
    "explicit": (None, 3),
    "implicit": (0.25, 2),
    "curvature_flow": (0.25, 2),
    "bilaplacian": (0.5, 4),
    "taubin": (None, 30),
    "polynomial": (None, 1),
}
# Least M_ii / t of a step of ``curvature_flow``, relative to |S_ii|: the root of the rounding error. Where the sum of
# M / t over a part is d times that of S, rounding errors of S X move the part by up to EPSILON / d, and mass that is
# added slows it down by up to d; neither is above this at d = 1.5e-8.
LEAST_MASS = math.sqrt(float(np.finfo(np.float64).eps))


def _largest_row(K: csr_array, held: NDArray[np.int64]) -> float:
    """Compute the largest sum of magnitudes in a free row: Gershgorin's bound on the largest eigenvalue."""
    row_sums: NDArray[np.float64] = abs(K).sum(axis=1)
    row_sums[held] = 0
    return float(row_sums.max(initial=0.0))


def _explicit(L: Laplacian, t: float | None, held: NDArray[np.int64], solver: str) -> Step:
    K = L.strong().tocsr()
    largest = _largest_row(K, held)
    stable = 2 / largest if largest > 0 else np.inf
    if t is None:
        t = stable / 2 if largest > 0 else 0.0
    if t > stable:
        raise SolveError(
            f"an explicit step is stable up to a time_step of {stable:.3g} on this mesh, not {t:.3g}; take more, "
            "smaller steps, or the method 'implicit', which is stable for every time_step"
        )
    is_free = np.ones((K.shape[0], 1))
    is_free[held] = 0
    factor = -t * is_free

    def step(X: Positions) -> Positions:
        moved: Positions = factor * (K @ X)
        return moved

    return step


def _solved(M: csc_array, B: csc_array, held: NDArray[np.int64], solver: str) -> Step:
    """Make the step X -> D of the system (M + B) (X + D) = M X, solved for D."""
    system = ConstrainedSystem((M + B).tocsc(), held, solver=solver)
    zeros = np.zeros((len(held), 3))
    return lambda X: system.solve(zeros, -(B @ X))


def _implicit(L: Laplacian, t: float | None, held: NDArray[np.int64], solver: str) -> Step:
    assert t is not None  # only explicit steps have a default of their own
    return _solved(L.mass / t, L.stiffness, held, solver)


def _curvature_flow(L: Laplacian, t: float | None, held: NDArray[np.int64], solver: str) -> Step:
    """Take an implicit step with mass added to parts that are shrunk to points, whose place is lost in rounding."""
    assert t is not None
    M, couplings = L.mass / t, np.abs(L.stiffness.diagonal())
    couplings[couplings == 0] = 1  # any value above zero: a vertex without neighbors stays
    added = diagonal_matrix(np.maximum(LEAST_MASS * couplings - M.diagonal(), 0))
    return _solved(M + added, L.stiffness, held, solver)


def _bilaplacian(L: Laplacian, t: float | None, held: NDArray[np.int64], solver: str) -> Step:
    assert t is not None
    # divided by the time step, so that entries have no unit and do not overflow
    return _solved(L.mass / t, matrix_product(L.stiffness, L.strong() * t), held, solver)


MakeStep = Callable[[Laplacian, float | None, NDArray[np.int64], str], Step]


def _filtering(make_filter: Callable[[Step], Step]) -> MakeStep:
    return lambda L, t, held, solver: make_filter(average(L, held))


SMOOTHING_METHODS: dict[str, MakeStep] = {
    "explicit": _explicit,
    "implicit": _implicit,
    "curvature_flow": _curvature_flow,
    "bilaplacian": _bilaplacian,
    **{name: _filtering(make_filter) for name, make_filter in FILTERS.items()},
}
"""By name: from a Laplacian, a time step, the vertices held and a solver to a function from positions to displacements.
"""


def smooth(
    mesh: Any,
    *,
    method: str = "bilaplacian",
    time_step: float | None = None,
    iterations: int | None = None,
    operator: str | Operator = "cotangent",
    fixed: ArrayLike = (),
    fix_boundary: bool = True,
    keep_volume: bool = False,
    solver: str = "cholmod",
) -> Mesh:
    """Smooth a surface by diffusion of its positions.

    Vertices without a mass stay where they are: those without a face, and those without an area if masses are areas.

    Parameters
    ----------
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes
    method : {"explicit", "implicit", "curvature_flow", "bilaplacian", "taubin", "polynomial"}
        The formulas are at the top of :mod:`lbskel.applications.smoothing`. All but ``curvature_flow`` keep the
        matrices of the given mesh, and factorize once. Parts that ``curvature_flow`` has shrunk to points stay about
        where they are; an operator with negative weights, as ``cotangent`` has where angles are obtuse, may throw them
        out of the shape before, and ``robust`` does not.
    time_step : float, optional
        Time step of each iteration: an area, and for ``random_walk``, whose masses are degrees, a number without unit.
        Features narrower than about its square root vanish. By default 0.5 mean vertex areas for ``bilaplacian``, 0.25
        for ``implicit`` and ``curvature_flow``, half of the largest stable step for ``explicit``; ``taubin`` and
        ``polynomial`` have none. For ``random_walk`` the mean degree takes the place of the mean vertex area. Means are
        of the whole mesh: components as small as an edge of the others shrink to points, unless smoothed alone. With
        cotangents one nearly flat triangle makes the stable step so short that ``explicit`` moves hardly any vertex;
        with ``random_walk`` it does not.
    iterations : int, optional
        By default 4 for ``bilaplacian``, 2 for ``implicit`` and ``curvature_flow``, 3 for ``explicit``, 30 for
        ``taubin``, 1 for ``polynomial``.
    operator : str or callable
        A name in OPERATORS, or a function from a Mesh to a Laplacian.
    fixed : (k,) array_like of int, or (n,) array_like of bool
        Vertices that stay where they are.
    fix_boundary : bool
        Whether vertices of edges with one face stay too: all, where no triangles share vertices. Merge those at one
        place first, by the preprocessing step ``merge_close``.
    keep_volume : bool
        Whether each component keeps the volume that it encloses.
    solver : str
        A name in SOLVERS.

    Returns
    -------
    Mesh
        The same faces and order of vertices, in the caller's units.

    Raises
    ------
    MeshError
        If the mesh has no area, an index in ``fixed`` is no vertex, the volume to keep is not defined, or a vertex has
        too many neighbors for ``bilaplacian``.
    SolveError
        If an explicit step is not stable, a system is singular, the positions get infinite, or no offset restores the
        volume.
    UnknownChoice
        If no method, operator or solver has that name, or a value is out of range.

    References
    ----------
    Desbrun, Meyer, Schroeder, Barr 1999, equations 8 and 14. Taubin 1995, section 3.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import sphere
    >>> smaller = lbskel.smooth(sphere(3), method="implicit", time_step=0.5, iterations=1)
    >>> round(float(smaller.vertices[0] @ smaller.vertices[0]) ** 0.5, 2)
    0.5
    """
    given: Mesh = as_mesh(mesh)
    make_step = choose(SMOOTHING_METHODS, method, "method")
    default_step, default_iterations = DEFAULTS[method]
    iterations = default_iterations if iterations is None else iterations
    _check_ranges(method, time_step, iterations)
    is_fixed = np.zeros(len(given.vertices), dtype=bool)
    is_fixed[checked_indices(fixed, len(given.vertices), "fixed vertices")] = True
    keys = edge_keys(given)
    if fix_boundary:
        is_fixed[boundary_vertices(len(given.vertices), keys)] = True
    if keep_volume and not has_volume(given, is_fixed):
        raise MeshError(
            "the volume to keep is not defined: faces are not consistently oriented, or the boundary is not fixed; "
            "see lbskel.check"
        )
    is_short = operator == "random_walk" and method in FILTERS
    if is_short:
        means = NeighborMeans(len(given.vertices), keys)
        areas: NDArray[Any] = means.degrees
    else:
        laplacian = apply_operator(operator, given)
        areas = laplacian.mass.diagonal()
    if not areas.max() > 0:
        raise MeshError("the mesh has no area: every face is degenerate; see lbskel.check")
    has_area = areas > 0
    is_fixed |= ~has_area
    held = np.flatnonzero(is_fixed)
    t = time_step
    if t is None and default_step is not None:
        t = default_step * float(areas[has_area].mean())
        t = t if is_short else t / laplacian.weight_unit
    scaled, exponent = unit_scale(given.vertices)
    weights = np.where(has_area, areas, 0) / areas.max()
    center = weights @ scaled / weights.sum()  # which diffusion does not move
    X = scaled - center
    step = FILTERS[method](average_of_neighbors(means, held)) if is_short else make_step(laplacian, t, held, solver)
    for number in range(iterations):
        if method == "curvature_flow" and number > 0:
            present = given.with_vertices(np.ldexp(X + center, exponent))
            step = make_step(apply_operator(operator, present), t, held, solver)
        moved = X + step(X)
        if not np.isfinite(moved).all():
            raise SolveError("the positions are not finite; take a smaller time_step")
        X = keep_volumes(X, moved, given, is_fixed) if keep_volume else moved
    result = np.ldexp(X + center, exponent)
    result[is_fixed] = given.vertices[is_fixed]
    return given.with_vertices(result)


def _check_ranges(method: str, time_step: float | None, iterations: int) -> None:
    """Raise if a number is out of its range."""
    if time_step is not None and method in FILTERS:
        raise UnknownChoice(f"the method {method!r} has no time_step: its filter is set by the iterations alone")
    if time_step is not None and not (is_number(time_step) and math.isfinite(time_step) and time_step > 0):
        raise UnknownChoice(f"time_step must be an area above zero, not {time_step!r}")
    checked_count(iterations, "iterations", 1)
