"""Contraction and attraction weights: lbskel's rules and the published ones.

Au's W_L multiplies a dimensionless Laplacian, so it must be dimensionless; each published formula for its first value
is a length or an inverse length. Here the formulas are evaluated on the mesh scaled to diameter bound 1, where they
give the same value at every size of the input. Au, Tai, Chu, Cohen-Or, Lee 2008,
https://doi.org/10.1145/1399504.1360643, section 4; Cao, Tagliasacchi, Olson, Zhang, Su 2010,
https://doi.org/10.1109/SMI.2010.25; and the constants of the programs that accompany the papers.
"""

from __future__ import annotations

__all__ = [
    "ATTRACTIONS",
    "INITIAL_WEIGHT_RULES",
    "WEIGHTS",
    "mean_ring_area",
    "ring_areas",
    "ring_shrinkage",
    "shortest_ring_edges",
]

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.point_stars import ring_edges
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.surface_queries import Surface

# Upper bound on the distance that the first step smooths over, in local radii, as a multiple of ``initial_weight``. Of
# 1, 2, 3 and 4, tried with c = 0.5 or 0.35, only 4 kept the ends of armadillo, koala, spot and elephant, and the
# thirteen shapes were most accurate with 3 and 4; that comparison is not in a committed table.
LOCAL_FACTOR = 4.0

MIN_AREA_RATIO = 1e-12  # lower bound on areas relative to their initial value, so that W_H stays under 1e6; a guess


def _sums_at_vertices(mesh: Mesh, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) sum of (m,) values over the faces at each vertex."""
    sums = np.bincount(mesh.faces.ravel(), weights=np.repeat(values, 3), minlength=len(mesh.vertices))
    return np.asarray(sums, dtype=np.float64)


def ring_areas(mesh: Mesh) -> NDArray[np.float64]:
    """(n,) total area of the triangles at each vertex."""
    return _sums_at_vertices(mesh, mesh.face_areas)


def mean_ring_area(mesh: Mesh) -> float:
    """Mean ring area of the vertices whose ring area is positive, cached in the mesh."""
    mean: float = Surface(mesh).memoize("mean ring area", lambda: _mean_of_positive(ring_areas(mesh)))
    return mean


def _mean_of_positive(values: NDArray[np.float64]) -> float:
    """Mean of the values that are positive."""
    return float(values[values > 0].mean())


def _by_local_radius(mesh: Mesh, constant: float) -> NDArray[np.float64]:
    """W_L = c * min(4 local radius, mean radius) / sqrt(mean ring area): how far the first step smooths.

    The mean radius, averaged over the area, makes thick parts become lines after the thin ones, which they would pull
    into themselves otherwise.
    """
    radii, areas = local_radii(mesh), ring_areas(mesh)
    mean = float(np.average(radii, weights=areas)) if areas.any() else np.inf
    return (constant * np.minimum(LOCAL_FACTOR * radii, mean)) ** 2


def _by_diffusion_length(mesh: Mesh, constant: float) -> float:
    """W_L = c * diameter bound / sqrt(mean ring area): the first step smooths over the fraction c of the diameter."""
    return constant**2


def _by_average_area(mesh: Mesh, constant: float) -> float:
    """W_L = c * sqrt(mean face area), as printed by Au et al. 2008."""
    return constant**2 * float(mesh.face_areas.mean()) * mean_ring_area(mesh)


def _by_total_area(mesh: Mesh, constant: float) -> float:
    """W_L = c * sqrt(total area), another reading of Au et al. 2008."""
    return constant**2 * mesh.area * mean_ring_area(mesh)


def _by_inverse_area(mesh: Mesh, constant: float) -> float:
    """W_L = c / sqrt(mean face area), from the demo program of Au et al."""
    return constant**2 / float(mesh.face_areas.mean()) * mean_ring_area(mesh)


def _by_inverse_area_in_box(mesh: Mesh, constant: float) -> float:
    """W_L = c * longest side of the bounding box / sqrt(mean face area), from the program of Cao et al. 2010."""
    side = float(np.ptp(mesh.vertices[mesh.used_vertices], axis=0).max())
    return side**2 * _by_inverse_area(mesh, constant)


def _by_inverse_edge_in_box(mesh: Mesh, constant: float) -> float:
    """W_L = c * longest side of the bounding box / mean over the vertices of their mean edge, Cao et al. 2010."""
    side = float(np.ptp(mesh.vertices[mesh.used_vertices], axis=0).max())
    centers, lengths = _ring_lengths(mesh)
    count = np.bincount(centers)
    means = np.bincount(centers, lengths)[count > 0] / count[count > 0]
    return (constant * side / float(means.mean())) ** 2 * mean_ring_area(mesh)


def _ring_lengths(mesh: Mesh) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(r,) vertex and (r,) length of each edge of each ring."""
    pairs = ring_edges(mesh)
    return pairs[:, 0], vector_lengths(mesh.vertices[pairs[:, 0]] - mesh.vertices[pairs[:, 1]])


def shortest_ring_edges(mesh: Mesh) -> NDArray[np.float64]:
    """(n,) length of the shortest edge of each vertex; infinite for a vertex without an edge."""
    centers, lengths = _ring_lengths(mesh)
    shortest = np.full(len(mesh.vertices), np.inf)
    np.minimum.at(shortest, centers, lengths)
    return shortest


INITIAL_WEIGHT_RULES: dict[str, Callable[[Mesh, float], float | NDArray[np.float64]]] = {
    "local_radius": _by_local_radius,
    "diffusion_length": _by_diffusion_length,
    "average_area": _by_average_area,
    "total_area": _by_total_area,
    "inverse_area": _by_inverse_area,
    "inverse_area_in_box": _by_inverse_area_in_box,
    "inverse_edge_in_box": _by_inverse_edge_in_box,
}
"""Functions from a mesh of diameter bound 1 and a constant c to tau of the first step, by name.

tau is W_L^2 times the mean ring area, a number or one for each vertex.
"""


def ring_shrinkage(initial_rings: NDArray[np.float64], mesh: Mesh) -> NDArray[np.float64]:
    """(n,) ring area at the start over that of the mesh now; 1 where there was none at the start.

    Parameters
    ----------
    initial_rings : (n,) array of float
        Ring areas at the start, in squared units of the mesh.
    mesh : Mesh
        With its present positions.
    """
    used = initial_rings > 0
    rings = np.maximum(ring_areas(mesh), MIN_AREA_RATIO * initial_rings)
    return np.where(used, initial_rings / np.where(used, rings, 1.0), 1.0)


def _by_ring_areas(start: Mesh, now: Mesh) -> NDArray[np.float64]:
    """(n,) ring area at the start over that now, as printed by Au et al. 2008."""
    return ring_shrinkage(ring_areas(start), now)


def _by_face_areas(start: Mesh, now: Mesh) -> NDArray[np.float64]:
    """(n,) inverse of the mean area ratio, now over start, of the faces at a vertex; Au et al.'s demo program."""
    initial = start.face_areas
    used = initial > 0
    ratios = np.where(used, now.face_areas / np.where(used, initial, 1.0), 1.0)
    count = np.bincount(start.faces.ravel(), minlength=len(start.vertices))
    mean = np.where(count > 0, _sums_at_vertices(start, ratios) / np.maximum(count, 1), 1.0)
    return 1 / np.maximum(mean, MIN_AREA_RATIO)


def _by_shortest_edges(start: Mesh, now: Mesh) -> NDArray[np.float64]:
    """(n,) squared ratio of the shortest edges at a vertex, start over now: W_H is their ratio; Cao et al. 2010."""
    initial, present = shortest_ring_edges(start), shortest_ring_edges(now)
    used = np.isfinite(initial) & (initial > 0)
    floor = np.sqrt(MIN_AREA_RATIO) * np.where(used, initial, 1.0)
    ratios = np.where(used, initial, 1.0) / np.where(used, np.maximum(present, floor), 1.0)
    squares: NDArray[np.float64] = ratios**2
    return squares


ATTRACTIONS: dict[str, Callable[[Mesh, Mesh], NDArray[np.float64]]] = {
    "ring_areas": _by_ring_areas,
    "face_areas": _by_face_areas,
    "shortest_edges": _by_shortest_edges,
}
"""Functions from the mesh at the start and now to W_H^2 of each vertex, by name; A_0 / A_t, or squared edge lengths."""

# bounds on W_L and W_H in the demo program of Au et al.; the program of Cao et al. has the same
_DEMO_BOUNDS: Mapping[str, Any] = {"max_contraction_weight": 2048.0, "max_attraction": 1e4}
WEIGHTS: dict[str, Mapping[str, Any]] = {
    "local_radius": {"initial_weight_rule": "local_radius", "initial_weight": 0.5, "contraction_growth": 2.0},
    "diffusion_length": {"initial_weight_rule": "diffusion_length", "initial_weight": 0.02, "contraction_growth": 2.0},
    "au2008": {"initial_weight_rule": "average_area", "initial_weight": 1e-3, "contraction_growth": 2.0},
    "au2008_total_area": {"initial_weight_rule": "total_area", "initial_weight": 1e-3, "contraction_growth": 2.0},
    "au2008_demo": {
        "initial_weight_rule": "inverse_area",
        "initial_weight": 0.1,
        "contraction_growth": 2.0,
        "attraction": "face_areas",
        **_DEMO_BOUNDS,
    },
    "cao2010": {
        "initial_weight_rule": "inverse_edge_in_box",
        "initial_weight": 0.2 / 1.6,  # the program scales the bounding box to a longest side of 1.6
        "contraction_growth": 3.0,
        "attraction": "shortest_edges",
        **_DEMO_BOUNDS,
    },
    "cao2010_meshes": {
        "initial_weight_rule": "inverse_area_in_box",
        "initial_weight": 0.1 / 1.6,
        "contraction_growth": 3.0,
        **_DEMO_BOUNDS,
    },
}
"""Settings of the weights that belong together, by name: keyword arguments of ContractionSettings.

- ``local_radius``: lbskel's own; the first step smooths over half the mean radius, but at most two local radii.
- ``diffusion_length``: the first step smooths over 2 % of the diameter bound, whatever the local radius.
- ``au2008``: as printed by Au et al. 2008, from the mean face area.
- ``au2008_total_area``: the same constant with the total area, another reading of the paper.
- ``au2008_demo``: as in the demo program of Au et al.
- ``cao2010``: as in the program of Cao et al. 2010 for points.
- ``cao2010_meshes``: as in that program for meshes.
"""
