"""What every step of preprocessing gives: a mesh, the way of each vertex to it, and what was measured.

The way is kept exactly through merges, collapses and removals. Where a surface is meshed anew, a vertex goes to a point
of the new surface, which its barycentric weights tell; the vertex that it is mapped to is then the one of most weight.
"""

from __future__ import annotations

__all__ = ["PreprocessResult", "distance_between", "identity_result", "measured", "measures"]

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import wraps
from inspect import signature
from typing import Any, Concatenate, ParamSpec

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap

Options = ParamSpec("Options")

SAMPLES = 4_000  # points of each surface from which the distance to the other is measured


@dataclass(frozen=True, eq=False)
class PreprocessResult:
    """A mesh and where the vertices of the one before it went.

    Parameters
    ----------
    mesh : Mesh
    vertex_map : VertexMap
        From the vertices of the input to those of ``mesh``.
    notes : tuple of str
        What was done, a sentence each.
    weights : (n, k) sparse array, optional
        Barycentric weights of each input vertex on the vertices of ``mesh``, where the surface was meshed anew.
    report : dict
        Each step with its options and what it changed, plain enough for JSON.
    """

    mesh: Mesh
    vertex_map: VertexMap
    notes: tuple[str, ...] = ()
    weights: csr_array | None = None
    report: dict[str, Any] = field(default_factory=dict)

    def compose(self, step: Callable[[Mesh], PreprocessResult]) -> PreprocessResult:
        """The result of another step on ``mesh``, with the way from the vertices that this one began with."""
        after = step(self.mesh)
        vertex_map = self.vertex_map.compose(after.vertex_map)
        weights = None
        if self.weights is not None or after.weights is not None:
            weights = csr_array(self._all_weights() @ after._all_weights())
        steps = [*self.report.get("steps", []), *after.report.get("steps", [])]
        return PreprocessResult(after.mesh, vertex_map, self.notes + after.notes, weights, {"steps": steps})

    def pull_back(self, values: ArrayLike, *, missing: float = np.nan) -> NDArray[Any]:
        """Values at the vertices of ``mesh`` brought back to the vertices of the input.

        Real numbers are interpolated where the surface was meshed anew; whole numbers, as labels are, and truth values
        are those of the vertex in ``vertex_map``.

        Parameters
        ----------
        values : (k, ...) array_like
        missing : float
            Of vertices that have no place in ``mesh``; whole numbers have -1 there.
        """
        given = np.asarray(values)
        there, target = self.vertex_map.is_mapped, self.vertex_map.indices
        if given.dtype.kind != "f":
            back = given[target]
            back[~there] = -1 if given.dtype.kind == "i" else 0
            return back
        flat = given.reshape(len(given), -1)
        back = flat[target] if self.weights is None else self.weights @ flat
        back[~there] = missing
        return back.reshape(len(there), *given.shape[1:])

    def _all_weights(self) -> csr_array:
        """``weights``, which an exact way has too: one for each vertex that is mapped."""
        if self.weights is not None:
            return self.weights
        mapped = np.flatnonzero(self.vertex_map.is_mapped)
        shape = (len(self.vertex_map), len(self.mesh.vertices))
        return csr_array((np.ones(len(mapped)), (mapped, self.vertex_map.indices[mapped])), shape=shape)


def identity_result(mesh: Mesh, *notes: str) -> PreprocessResult:
    """The mesh itself, every vertex where it was."""
    return PreprocessResult(mesh, VertexMap.identity(len(mesh.vertices)), notes)


def measured(
    step: Callable[Concatenate[Mesh, Options], PreprocessResult],
) -> Callable[Concatenate[Mesh, Options], PreprocessResult]:
    """The step with a report: its name and options, the measures of the mesh before and after, and what it reports."""

    @wraps(step)
    def with_report(mesh: Mesh, *arguments: Options.args, **options: Options.kwargs) -> PreprocessResult:
        result = step(mesh, *arguments, **options)
        given = signature(step).bind(mesh, *arguments, **options)
        given.apply_defaults()
        record = {
            "step": step.__name__,
            "options": {name: value for name, value in list(given.arguments.items())[1:] if value is not None},
            "before": measures(mesh),
            "after": measures(result.mesh),
            "notes": list(result.notes),
            **result.report,
        }
        return replace(result, report={"steps": [record]})

    return with_report


def measures(mesh: Mesh) -> dict[str, Any]:
    """What a step may change of a mesh: sizes, topology, area."""
    return {
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "components": mesh.n_components,
        "boundary_edges": int((mesh.faces_per_edge == 1).sum()),
        "nonmanifold_edges": int((mesh.faces_per_edge > 2).sum()),
        "euler_characteristic": mesh.euler_characteristic,
        "is_closed_manifold": mesh.is_closed_manifold,
        "area": mesh.area,
    }


def distance_between(one: Mesh, other: Mesh) -> float:
    """The Hausdorff distance of two surfaces, from evenly picked vertices and centers of faces of each to the other.

    It is a lower bound, exact where the surfaces differ most at such a point; as a fraction of the first's diagonal.
    """
    if one is other:
        return 0.0
    return max(_farthest(one, other), _farthest(other, one)) / (one.diagonal or 1.0)


def _farthest(one: Mesh, other: Mesh) -> float:
    """The largest distance of the samples of one surface from another."""
    vertices, faces = (some[:: 1 + 2 * len(some) // SAMPLES] for some in (one.used_vertices, one.faces))
    points = np.concatenate([one.vertices[vertices], one.vertices[faces].mean(axis=1)])
    return float(Surface(other).distance(points).max())
