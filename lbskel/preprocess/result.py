"""The result of a preprocessing step: a mesh, the vertex map to it, and a report of what changed.

The vertex map is exact for merges, collapses and removals. Where a surface is remeshed, a vertex is mapped to a point
of the new surface, given by barycentric weights, and the vertex map holds the vertex of largest weight.
"""

from __future__ import annotations

__all__ = [
    "MAX_DISTANCE",
    "PreprocessResult",
    "hausdorff_distance",
    "identity_result",
    "mesh_statistics",
    "preprocess_step",
]

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import wraps
from inspect import signature
from typing import Any, Concatenate, ParamSpec, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap

Options = ParamSpec("Options")

# Points of each surface, at most about this many, from which its distance to the other is measured. A guess that bounds
# the time.
MAX_SAMPLES = 4_000

# Hausdorff distance, relative to the diameter bound, above which a simplified or remeshed surface is another one and is
# rejected. A guess, a fiftieth of the diagonal of the bounding box at first, as which it changed when the mesh was
# rotated. The bound is 0.895 of the diagonal in the median of 26 meshes, those of meshes/ and of examples of libraries
# (0.69 to 1.07), so such shares were divided by 0.9.
MAX_DISTANCE = 0.022


@dataclass(frozen=True, eq=False)
class PreprocessResult:
    """A mesh, and the map of the input's vertices to its vertices.

    Parameters
    ----------
    mesh : Mesh
    vertex_map : VertexMap
        From the vertices of the input to those of ``mesh``.
    notes : tuple of str
        What was done, a sentence each.
    weights : (n, k) sparse array, optional
        Barycentric weights of each input vertex on the k vertices of ``mesh``, if the surface was remeshed.
    report : dict
        Each step with its options and what it changed, ready for JSON.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> result = lbskel.Pipeline(["merge_close"])(torus(1.0, 0.2, 16, 8))
    >>> len(result.mesh.vertices), len(result.vertex_map)
    (128, 128)
    """

    mesh: Mesh
    vertex_map: VertexMap
    notes: tuple[str, ...] = ()
    weights: csr_array | None = None
    report: dict[str, Any] = field(default_factory=dict)

    def compose(self, step: Callable[[Mesh], PreprocessResult]) -> PreprocessResult:
        """Apply another step to ``mesh``; the maps of the new result begin at the vertices of the original input.

        Parameters
        ----------
        step : callable
            Takes a Mesh and returns a PreprocessResult.
        """
        after = step(self.mesh)
        vertex_map = self.vertex_map.compose(after.vertex_map)
        weights = None
        if self.weights is not None or after.weights is not None:
            weights = csr_array(self._weights_or_map() @ after._weights_or_map())
        steps = [*self.report.get("steps", []), *after.report.get("steps", [])]
        return PreprocessResult(after.mesh, vertex_map, self.notes + after.notes, weights, {"steps": steps})

    def pull_back(self, values: ArrayLike, *, missing: float = np.nan) -> NDArray[Any]:
        """Bring values at the vertices of ``mesh`` back to the vertices of the input.

        Real numbers are interpolated where the surface was remeshed; integers, such as labels, and booleans are those
        of the vertex in ``vertex_map``.

        Parameters
        ----------
        values : (k, ...) array_like
        missing : float
            Value at vertices that are not mapped; integers have -1 there, booleans False.
        """
        given = np.asarray(values)
        is_mapped, target = self.vertex_map.is_mapped, self.vertex_map.indices
        if given.dtype.kind != "f":
            values_back: NDArray[Any] = given[target]
            values_back[~is_mapped] = -1 if given.dtype.kind == "i" else 0
            return values_back
        flat = given.reshape(len(given), -1)
        interpolated: NDArray[Any] = flat[target] if self.weights is None else self.weights @ flat
        interpolated[~is_mapped] = missing
        return interpolated.reshape(len(is_mapped), *given.shape[1:])

    def _weights_or_map(self) -> csr_array:
        """(n, k) ``weights``, or the exact vertex map as a sparse matrix of ones."""
        if self.weights is not None:
            return self.weights
        mapped = np.flatnonzero(self.vertex_map.is_mapped)
        shape = (len(self.vertex_map), len(self.mesh.vertices))
        return csr_array((np.ones(len(mapped)), (mapped, self.vertex_map.indices[mapped])), shape=shape)


def identity_result(mesh: Mesh, *notes: str) -> PreprocessResult:
    """Make the result of a step that changes nothing.

    Parameters
    ----------
    mesh : Mesh
    notes : str
        Why nothing was changed, a sentence each.
    """
    return PreprocessResult(mesh, VertexMap.identity(len(mesh.vertices)), notes)


def preprocess_step(
    step: Callable[Concatenate[Mesh, Options], PreprocessResult],
) -> Callable[Concatenate[Any, Options], PreprocessResult]:
    """Decorate a step so that it takes what as_mesh takes and reports its options and the change of the mesh.

    Parameters
    ----------
    step : callable
        Takes a Mesh and keyword options, and returns a PreprocessResult.
    """
    parameters = signature(step)

    @wraps(step)
    def with_report(mesh: Any, *arguments: Options.args, **options: Options.kwargs) -> PreprocessResult:
        mesh = as_mesh(mesh)
        result = step(mesh, *arguments, **options)
        given = parameters.bind(mesh, *arguments, **options)
        given.apply_defaults()
        record = {
            "step": step.__name__,
            "options": {name: value for name, value in list(given.arguments.items())[1:] if value is not None},
            "before": mesh_statistics(mesh),
            "after": mesh_statistics(result.mesh),
            "notes": list(result.notes),
            **result.report,
        }
        return replace(result, report={"steps": [record]})

    return cast("Callable[Concatenate[Any, Options], PreprocessResult]", with_report)


def mesh_statistics(mesh: Mesh) -> dict[str, Any]:
    """Measure what a step may change of a mesh: counts, topology, area. The values are cached in the mesh.

    Parameters
    ----------
    mesh : Mesh
    """
    return dict(Surface(mesh).memoize("statistics", lambda: _measured(mesh)))


def _measured(mesh: Mesh) -> dict[str, Any]:
    """Measure counts, topology and area."""
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


def hausdorff_distance(one: Mesh, other: Mesh) -> float:
    """Estimate the Hausdorff distance of two surfaces, as a fraction of the first one's diameter bound.

    It is measured from evenly picked vertices and face centers of each surface to the other, and thus a lower bound.

    Parameters
    ----------
    one, other : Mesh
    """
    if one is other:
        return 0.0
    return max(_one_sided_distance(one, other), _one_sided_distance(other, one)) / (one.diameter_bound or 1.0)


def _one_sided_distance(one: Mesh, other: Mesh) -> float:
    """Measure the largest distance of samples of one surface from another."""
    vertices, faces = (rows[:: 1 + 2 * len(rows) // MAX_SAMPLES] for rows in (one.used_vertices, one.faces))
    points = np.concatenate([one.vertices[vertices], one.vertices[faces].mean(axis=1)])
    return float(Surface(other).distance(points).max())
