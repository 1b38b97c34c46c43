"""The heat method: geodesic distances and extended values by one factorization for many queries.

Heat that has flowed for a short time t from the sources, (M + t S) u = delta, decreases away from them. In the order of
the heat, distances are propagated from triangle to triangle (:mod:`lbskel.applications.unfolded_distances`). The
distances of the paper are smoother and less accurate: they are the function phi whose gradient is closest to
-grad u / |grad u|, from K phi = div of that field, with the stiffness K of the triangles of the gradient: Crane,
Weischedel, Wardetzky 2013, "Geodesics in heat", https://doi.org/10.1145/2516971.2516977. These triangles are those of
the intrinsic Delaunay triangulation, of the tufted cover if the mesh is open or not manifold: Sharp, Crane 2020,
https://doi.org/10.1111/cgf.14069, section 6.1. The ratio of the heat of values to the heat of ones extends values to
all vertices, nearly the value of the nearest source: Sharp, Soliman, Crane 2019, "The vector heat method",
https://doi.org/10.1145/3243651, section 5.1.
"""

from __future__ import annotations

__all__ = ["HeatMethod", "Sources"]

from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components

from lbskel.applications.constrained_systems import checked_indices
from lbskel.applications.symmetric import require_symmetric
from lbskel.applications.unfolded_distances import UnfoldedSurface, single_sheet
from lbskel.errors import MeshError, SolveError
from lbskel.geometry.arrays import finite_numbers
from lbskel.geometry.intrinsic_triangulation import IntrinsicTriangulation, half_edge_twins
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.scaling import unit_scale
from lbskel.geometry.sorting import unique_inverse
from lbskel.operators import Laplacian, Operator, apply_operator
from lbskel.operators.gradients import gradient_matrix, unit_gradients
from lbskel.operators.robust import tufted_delaunay
from lbskel.solvers import Factorization, factorize

# Time of the flow, in squared mean edge lengths, as in the paper. Shorter times are better on irregular meshes, worse
# on regular grids, where the heat prefers the directions of edges: benchmarks/results/applications_geodesics.md.
TIME = 1.0
# What takes the place of the squared edge length where masses are degrees, so that the time has no unit: where six
# equilateral triangles of edge h meet, D + 4 (D - A) is a multiple of M + h^2 S with areas and cotangents.
SQUARED_EDGE = 4.0
# Least share of the heat that has to arrive at the farthest vertex; below about 1e-308 it is zero, without a gradient.
# A vertex may be twice as far from a source as from the vertex that is tried; the share there is the square.
MIN_HEAT = 1e-140
TIME_GROWTH = 4.0  # factor of the time where less arrives, which doubles the reach
MAX_GROWTHS = 40  # a guess: reaches 2^40 times as far

Sources: TypeAlias = int | ArrayLike


@dataclass(frozen=True, eq=False)
class HeatMethod:
    """Geodesic distances on a mesh, factorized at the first query and used again by all others.

    Parameters
    ----------
    mesh : Mesh, or what :func:`lbskel.as_mesh` takes
        Open, non-manifold, of several components or with degenerate faces too.
    operator : str or callable
        A name in OPERATORS or a function from a Mesh to a Laplacian: symmetric. It diffuses.

    Raises
    ------
    MeshError
        If the mesh has no area, or the operator is not symmetric or not defined on it.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import sphere
    >>> method = lbskel.HeatMethod(sphere(4))
    >>> float(method.distance([0]).max().round(1))
    3.1
    """

    mesh: Mesh
    operator: str | Operator = "robust"
    _unit: NDArray[np.float64] = field(init=False, repr=False)
    _exponent: int = field(init=False, repr=False)
    _laplacian: Laplacian = field(init=False, repr=False)

    def __post_init__(self) -> None:
        mesh = as_mesh(self.mesh)
        unit, k = unit_scale(mesh.vertices)
        laplacian = apply_operator(self.operator, mesh.with_vertices(unit))
        require_symmetric(laplacian)
        for name, value in {"mesh": mesh, "_unit": unit, "_exponent": k, "_laplacian": laplacian}.items():
            object.__setattr__(self, name, value)

    def distance(self, sources: Sources, *, unfolded: bool = True) -> NDArray[np.float64]:
        """Compute the distance of every vertex to the nearest of the sources.

        Parameters
        ----------
        sources : int, (s,) array_like of int, or (n,) array_like of bool
            Vertices; a mask stands for those where it is true.
        unfolded : bool
            Whether distances are propagated across unfolded triangles in the order of the heat, where the operator
            hardly matters. If not, they are those of the paper: less accurate, smooth where two paths are equally
            short, and best with the operators of cotangents.

        Returns
        -------
        (n,) array of float
            In the units of the mesh; infinite in components without a source and at vertices that no face uses. If not
            unfolded, also infinite at vertices that the operator does not connect to a source.

        Raises
        ------
        MeshError
            If a source is no vertex of the mesh.
        SolveError
            If the operator is not positive semidefinite, or heat does not reach every vertex of a component.
        """
        vertices = self._checked(sources)
        active, used = self._active, self.mesh.used_vertices
        heat = (np.bincount(vertices, minlength=len(self._component)) > 0).astype(np.float64)
        distances = np.full(len(heat), np.inf)
        if len(active):
            heat[active] = self._heat.solve(heat[active], refined=False)
        if unfolded:  # last to vertices without heat, which the operator couples with no other
            distances = self._surface.distance(vertices, used[np.argsort(-heat[used])])
        elif len(active):
            distances = self._integrated(vertices, heat)
        distances[vertices] = 0.0
        scaled: NDArray[np.float64] = np.ldexp(distances, self._exponent)
        return scaled

    def _integrated(self, sources: NDArray[np.int64], heat: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) distances whose gradient is closest to the unit vectors opposite to the gradient of the heat."""
        potential, component = np.zeros(len(heat)), self._component
        free = np.delete(self._active, self._pinned)
        field = unit_gradients(self._gradient[0], -heat)
        potential[free] = self._poisson.solve(self._divergence @ field, refined=False)
        distances = np.full(len(heat), np.inf)
        for part in np.setdiff1d(component[sources], [-1]):
            members, own = component == part, sources[component[sources] == part]
            distances[members] = np.maximum(potential[members] - potential[own].mean(), 0.0)
        return distances

    def distances(self, sources: ArrayLike, *, unfolded: bool = True) -> NDArray[np.float64]:
        """Compute the distance of every vertex to each of the sources.

        Parameters
        ----------
        sources : (s,) array_like of int, or (n,) array_like of bool
        unfolded : bool
            As for :meth:`distance`.

        Returns
        -------
        (n, s) array of float
            As :meth:`distance` returns for one source each.
        """
        return np.stack([self.distance(each, unfolded=unfolded) for each in self._checked(sources)], axis=1)

    def extend(self, sources: ArrayLike, values: ArrayLike) -> NDArray[np.float64]:
        """Extend values at some vertices to all: nearly the value of the nearest source, blended where two are near.

        Parameters
        ----------
        sources : (s,) array_like of int, or (n,) array_like of bool
            Vertices; a mask stands for those where it is true, in ascending order.
        values : (s,) or (s, c) array_like of float

        Returns
        -------
        (n,) or (n, c) array of float
            Between the smallest and the largest value for operators with positive weights. NaN where no heat arrives:
            in components without a source, or where an operator with negative weights makes the heat negative.

        Raises
        ------
        MeshError
            If a source is no vertex, or there is not one finite value for each.
        """
        vertices, given = self._checked(sources), finite_numbers(values, "values")
        if given.ndim not in (1, 2) or len(given) != len(vertices):
            raise MeshError(f"there must be a finite value for each of {len(vertices)} sources, not {given.shape}")
        columns = np.concatenate([np.ones((len(vertices), 1)), given.reshape(len(vertices), -1)], axis=1)
        right = np.zeros((len(self.mesh.vertices), columns.shape[1]))
        np.add.at(right, vertices, columns)
        heat = np.zeros_like(right)
        heat[self._active] = self._heat.solve(right[self._active])
        isolated = np.setdiff1d(vertices, self._active)
        heat[isolated] = right[isolated]
        total = np.where(heat[:, :1] > 0, heat[:, :1], np.nan)
        extended: NDArray[np.float64] = heat[:, 1:] / total
        return extended[:, 0] if given.ndim == 1 else extended

    def gradient_error(self, distance: NDArray[np.float64]) -> float:
        """Compute the mean deviation of the gradient's length from 1, over the area that the distance reaches.

        Parameters
        ----------
        distance : (n,) array of float
            As :meth:`distance` returns.
        """
        is_finite = np.isfinite(distance)
        G, areas = self._gradient
        reached = is_finite[self._triangulation[0].faces].all(axis=1) & (areas > 0)
        gradients = (G @ np.ldexp(np.where(is_finite, distance, 0.0), -self._exponent)).reshape(2, -1)
        deviations = np.abs(np.hypot(*gradients) - 1.0)[reached]
        return float(np.average(deviations, weights=areas[reached])) if reached.any() else 0.0

    def _checked(self, sources: Sources) -> NDArray[np.int64]:
        """Return the sources as a vector of vertices."""
        given: ArrayLike = sources if np.iterable(sources) else np.array([sources])
        vertices = checked_indices(given, len(self.mesh.vertices), "sources", distinct=False)
        if not len(vertices):
            raise MeshError("there is no source: give at least one vertex")
        return vertices

    @cached_property
    def _component(self) -> NDArray[np.int64]:
        """(n,) component of each vertex, where surface and operator connect it to others, numbered from 0; else -1."""
        S = self._laplacian.stiffness.copy()
        S.eliminate_zeros()
        surface = self.mesh.component_of_vertex
        label = unique_inverse(connected_components(S, directed=False)[1] * (surface.max() + 1) + surface)[1]
        has_mass = np.bincount(label, self._laplacian.mass.diagonal()) > 0
        is_active = (has_mass & (np.bincount(label) > 1))[label]
        component = np.full(len(label), -1)
        component[is_active] = np.unique(label[is_active], return_inverse=True)[1]
        return component

    @cached_property
    def _active(self) -> NDArray[np.int64]:
        """The vertices that belong to a component."""
        return np.flatnonzero(self._component >= 0)

    @cached_property
    def _pinned(self) -> NDArray[np.int64]:
        """For each component, the number of its first vertex among the active ones."""
        return np.unique(self._component[self._active], return_index=True)[1]

    @cached_property
    def _triangulation(self) -> tuple[IntrinsicTriangulation, int]:
        """The intrinsic Delaunay triangulation of the surface or of its cover, and the number of its sheets."""
        twins = half_edge_twins(self.mesh.faces)
        if twins is None or (twins < 0).any():
            return tufted_delaunay(self._unit, self.mesh.faces)[0], 2
        return single_sheet(self._unit, self.mesh.faces), 1

    @cached_property
    def _surface(self) -> UnfoldedSurface:
        triangles, n_sheets = self._triangulation
        if n_sheets > 1:
            triangles = single_sheet(self._unit, self.mesh.faces)
        return UnfoldedSurface(triangles.faces, triangles.lengths, len(self._component))

    @cached_property
    def _gradient(self) -> tuple[csr_array, NDArray[np.float64]]:
        """Gradient of functions on the triangles, and the areas of these."""
        triangulation = self._triangulation[0]
        return gradient_matrix(triangulation.faces, triangulation.lengths, len(self.mesh.vertices))

    @cached_property
    def _divergence(self) -> csr_array:
        """Integrated divergence at the active vertices that are not pinned."""
        G, areas = self._gradient
        weights = np.concatenate([areas, areas]) / self._triangulation[1]
        return (G[:, np.delete(self._active, self._pinned)].T @ diags_array(weights)).tocsr()

    @cached_property
    def _heat(self) -> Factorization:
        """(M + t S) of the active vertices, with a time for each component at which heat arrives everywhere."""
        S, M = (each[self._active][:, self._active] for each in (self._laplacian.stiffness, self._laplacian.mass))
        component, triangulation = self._component[self._active], self._triangulation[0]
        corners = self._component[triangulation.faces[:, 0]]
        inside = corners >= 0
        n = len(self._pinned)
        edges = np.bincount(corners[inside], triangulation.lengths[inside].mean(axis=1), n)
        times = TIME * (edges / np.maximum(np.bincount(corners[inside], minlength=n), 1)) ** 2
        if self._laplacian.mass_unit == "number":
            times[:] = TIME * SQUARED_EDGE
        right = np.zeros(len(self._active))
        right[self._pinned] = 1.0
        for _ in range(MAX_GROWTHS):
            factor = factorize((M + diags_array(times[component]) @ S).tocsc())
            heat = np.abs(factor.solve(right, refined=False))
            least = np.full(n, np.inf)
            np.minimum.at(least, component, heat)
            is_short = least < MIN_HEAT * heat[self._pinned]
            if not is_short.any():
                return factor
            times = np.where(is_short, TIME_GROWTH * times, times)
        raise SolveError("no time was found after which heat arrives at every vertex")

    @cached_property
    def _poisson(self) -> Factorization:
        """Stiffness of the triangulation without the first vertex of each component, where the solution is zero."""
        return factorize((self._divergence @ self._gradient[0][:, np.delete(self._active, self._pinned)]).tocsc())
