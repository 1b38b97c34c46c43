"""How strong the first pull of a contraction is, and how what has become thin is held: ours and the published rules.

Au's W_L weighs a Laplacian without a unit, so it must have none; each published formula is a length or its inverse.
Here they are taken on the mesh scaled to extent 1, where they mean the same at every size. Au, Tai, Chu, Cohen-Or,
Lee 2008, https://doi.org/10.1145/1399504.1360643, section 4; Cao, Tagliasacchi, Olson, Zhang, Su 2010,
https://doi.org/10.1109/SMI.2010.25, with the constants of the programs that go with the papers.
"""

from __future__ import annotations

__all__ = ["ATTRACTIONS", "INITIAL_WEIGHT_RULES", "WEIGHTS", "mean_ring_area", "ratio_of_areas", "ring_areas"]

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh

THINNEST = 1e-12  # areas are not let fall below this share of their start, which bounds the hold


def _at_vertices(mesh: Mesh, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) sums over the faces at each vertex."""
    sums = np.bincount(mesh.faces.ravel(), weights=np.repeat(values, 3), minlength=len(mesh.vertices))
    return np.asarray(sums, dtype=np.float64)


def ring_areas(mesh: Mesh) -> NDArray[np.float64]:
    """(n,) total area of the triangles at each vertex."""
    return _at_vertices(mesh, mesh.face_areas)


def mean_ring_area(mesh: Mesh) -> float:
    """Mean over the vertices that have any."""
    rings = ring_areas(mesh)
    return float(rings[rings > 0].mean())


def _by_diffusion_length(mesh: Mesh, constant: float) -> float:
    """W_L = c * extent / sqrt(mean ring area): the first step reaches the fraction c of the extent."""
    return constant**2


def _by_average_area(mesh: Mesh, constant: float) -> float:
    """W_L = c * sqrt(average face area), as the paper prints it."""
    return constant**2 * float(mesh.face_areas.mean()) * mean_ring_area(mesh)


def _by_total_area(mesh: Mesh, constant: float) -> float:
    """W_L = c * sqrt(total area), another reading of the paper."""
    return constant**2 * mesh.area * mean_ring_area(mesh)


def _by_inverse_area(mesh: Mesh, constant: float) -> float:
    """W_L = c / sqrt(average face area), as the authors' program has it."""
    return constant**2 / float(mesh.face_areas.mean()) * mean_ring_area(mesh)


def _by_inverse_area_in_box(mesh: Mesh, constant: float) -> float:
    """W_L = c * longest side of the bounding box / sqrt(average face area)."""
    side = float(np.ptp(mesh.vertices[mesh.used_vertices], axis=0).max())
    return side**2 * _by_inverse_area(mesh, constant)


INITIAL_WEIGHT_RULES: dict[
    str, Callable[[Mesh, float], float]
] = {  # tau of the first step, which is W_L^2 * mean ring area
    "diffusion_length": _by_diffusion_length,
    "average_area": _by_average_area,
    "total_area": _by_total_area,
    "inverse_area": _by_inverse_area,
    "inverse_area_in_box": _by_inverse_area_in_box,
}


def ratio_of_areas(before: NDArray[np.float64], now: Mesh) -> NDArray[np.float64]:
    """The area of all triangles at the vertex, which was so much before, over that now."""
    used = before > 0
    rings = np.maximum(ring_areas(now), THINNEST * before)
    return np.where(used, before / np.where(used, rings, 1.0), 1.0)


def _ratio_of_rings(start: Mesh, now: Mesh) -> NDArray[np.float64]:
    """The area of all triangles at the vertex, at the start over now."""
    return ratio_of_areas(ring_areas(start), now)


def _ratio_of_faces(start: Mesh, now: Mesh) -> NDArray[np.float64]:
    """One over the mean, over the triangles at the vertex, of their area now over that at the start."""
    before = start.face_areas
    used = before > 0
    shares = np.where(used, now.face_areas / np.where(used, before, 1.0), 1.0)
    count = np.bincount(start.faces.ravel(), minlength=len(start.vertices))
    mean = np.where(count > 0, _at_vertices(start, shares) / np.maximum(count, 1), 1.0)
    return 1 / np.maximum(mean, THINNEST)


ATTRACTIONS: dict[str, Callable[[Mesh, Mesh], NDArray[np.float64]]] = {  # A_0 / A_t, which is W_H^2
    "ring_areas": _ratio_of_rings,
    "face_areas": _ratio_of_faces,
}

_PROGRAM: Mapping[str, Any] = {"max_contraction_weight": 2048.0, "max_attraction": 1e4}
WEIGHTS: dict[str, Mapping[str, Any]] = {  # settings of a contraction that belong together
    "diffusion_length": {"initial_weight_rule": "diffusion_length", "initial_weight": 0.02, "contraction_growth": 2.0},
    "au2008": {"initial_weight_rule": "average_area", "initial_weight": 1e-3, "contraction_growth": 2.0},
    "au2008_total_area": {"initial_weight_rule": "total_area", "initial_weight": 1e-3, "contraction_growth": 2.0},
    "au2008_demo": {
        "initial_weight_rule": "inverse_area",
        "initial_weight": 0.1,
        "contraction_growth": 2.0,
        "attraction": "face_areas",
        **_PROGRAM,
    },
    "cao2010": {
        "initial_weight_rule": "inverse_area_in_box",
        "initial_weight": 0.1 / 1.6,
        "contraction_growth": 3.0,
        **_PROGRAM,
    },  # box of side 1.6
}
