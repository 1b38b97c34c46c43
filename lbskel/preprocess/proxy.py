"""The proxy of a surface: a simplified copy with edges of a fraction of the local radius, contracted in its place.

The number of faces follows from the shape-diameter function of Shapira, Shamir, Cohen-Or 2008,
https://doi.org/10.1007/s00371-007-0197-5, sampled by single rays.
"""

from __future__ import annotations

__all__ = ["MAX_FACES", "face_budget", "simplify_to_proxy", "surface_with_proxy"]

import numpy as np
from scipy.spatial import cKDTree

from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import thickness_along_normal
from lbskel.geometry.surface_queries import Proxy, Surface
from lbskel.preprocess.result import PreprocessResult
from lbskel.preprocess.simplification import simplify

DEVIATION_MARGIN = 2.0  # safety factor on the proxy's measured deviation before it is trusted for inside tests; a guess

MAX_FACES = 16_000  # faces contracted without a proxy; benchmarks/results/resolution.md
MIN_PROXY_FACES = 12_000  # faces of a proxy at least: with 8,000 the shapes of resolution.md were a tenth less accurate
EDGE = 0.4  # proxy edge length aimed at, in local radii; with 0.5 the armadillo lost claws
N_SAMPLES = 1_000  # faces at which the local radius is sampled
MIN_RADIUS = 0.001  # lower bound on radii, relative to the diameter bound: anything thinner is a crease; a guess
EQUILATERAL_AREA = 0.433  # area of an equilateral triangle of edge length 1, sqrt(3) / 4
SLENDER_FACES = 2.0  # times area^3 / volume^2: the number of faces with edges of half the mean radius 2 volume / area
MAX_SLENDER_FACES = 128_000  # upper bound on the faces of long, thin shapes; a guess that bounds the time


def face_budget(mesh: Mesh) -> int:
    """Compute the largest number of faces with which a mesh is contracted.

    It gives edges of a fraction of the local radius, between bounds that are wider for shapes that are long and thin
    all over.

    Parameters
    ----------
    mesh : Mesh
    """
    squared_volume = mesh.volume**2 if mesh.is_closed else 0.0
    if not squared_volume > 0:
        return MAX_FACES
    upper = int(np.clip(SLENDER_FACES * mesh.area**3 / squared_volume, MAX_FACES, MAX_SLENDER_FACES))
    if len(mesh.faces) <= upper:
        return upper
    sample = np.flatnonzero(mesh.face_areas)[:: 1 + len(mesh.faces) // N_SAMPLES]
    radii = np.maximum(thickness_along_normal(mesh, sample) / 2, MIN_RADIUS * mesh.diameter_bound)
    areas = mesh.face_areas[sample]
    area_in_edges = (areas / radii**2).sum() * mesh.area / areas.sum() / EDGE**2
    return int(np.clip(area_in_edges / EQUILATERAL_AREA, MIN_PROXY_FACES, upper))


def simplify_to_proxy(mesh: Mesh) -> PreprocessResult:
    """Simplify a mesh to its face budget; return it unchanged if it has no more faces or its topology would change.

    Parameters
    ----------
    mesh : Mesh
    """
    return simplify(mesh, target_faces=face_budget(mesh))


def surface_with_proxy(mesh: Mesh, proxy: PreprocessResult) -> Surface:
    """Make the surface queries of a mesh and of the proxy that was made of it, where that differs.

    Parameters
    ----------
    mesh : Mesh
    proxy : PreprocessResult
        Made by :func:`simplify_to_proxy`, with the deviation in its report.
    """
    deviations = [step["deviation"] for step in proxy.report.get("steps", []) if "deviation" in step]
    if not deviations:
        return Surface(mesh)
    sources = proxy.vertex_map.one_source_per_target(len(proxy.mesh.vertices))
    if (sources < 0).any():  # the proxy was remeshed
        sources = np.where(sources < 0, cKDTree(mesh.vertices).query(proxy.mesh.vertices)[1], sources)
    return Surface(mesh, Proxy(proxy.mesh, proxy.vertex_map, sources, DEVIATION_MARGIN * deviations[0]))
