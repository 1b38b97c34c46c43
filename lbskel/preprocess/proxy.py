"""The proxy of a surface: a simplified copy that is contracted in its place.

It has MAX_FACES faces, but more where the shape is long and thin: their number follows from its area and mean radius.
"""

from __future__ import annotations

__all__ = ["MAX_FACES", "face_budget", "simplify_to_proxy", "surface_with_proxy"]

import numpy as np
from scipy.spatial import cKDTree

from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.surface_queries import Proxy, Surface
from lbskel.preprocess.result import PreprocessResult
from lbskel.preprocess.simplification import simplify

DEVIATION_MARGIN = 2.0  # safety factor on the proxy's measured deviation before it is trusted for inside tests; a guess

MAX_FACES = 16_000  # faces contracted without a proxy, and of the proxy of a shape that is not long and thin;
# benchmarks/results/resolution.md
SLENDER_FACES = 8.0  # times area / radius^2: the number of faces with edges of half the mean radius
MAX_SLENDER_FACES = 128_000  # upper bound on the faces of long, thin shapes; a guess that bounds the time
# Faces of a long, thin shape for each face of its proxy, above which that bound is raised: upper bound on how coarse a
# proxy is. A coarser one loses tips, and costs more than it saves, since its skeleton leaves the solid;
# benchmarks/results/scaling.md, "Proxies of thin inputs"
MAX_REDUCTION = 2


def face_budget(mesh: Mesh, *, deadline: Deadline = NEVER) -> int:
    """Compute the largest number of faces with which a mesh is contracted.

    It is MAX_FACES, or, for shapes that are long and thin all over, the number with which edges have half the mean
    radius: twice the volume over the area, or the median local radius of a surface that is not closed.

    Parameters
    ----------
    mesh : Mesh
    deadline : Deadline
        After it, OutOfTime is raised.
    """
    if len(mesh.faces) <= MAX_FACES:
        return MAX_FACES
    if mesh.is_closed:
        radius = 2 * abs(mesh.volume) / mesh.area if mesh.area > 0 else 0.0
    else:
        radius = float(np.median(local_radii(mesh, deadline=deadline)[mesh.faces].mean(axis=1)))
    if not radius > 0:
        return MAX_FACES
    upper = max(MAX_SLENDER_FACES, len(mesh.faces) // MAX_REDUCTION)
    return int(np.clip(SLENDER_FACES * mesh.area / radius**2, MAX_FACES, upper))


def simplify_to_proxy(mesh: Mesh, *, deadline: Deadline = NEVER) -> PreprocessResult:
    """Simplify a mesh to its face budget; return it unchanged if it has no more faces or its topology would change.

    Parameters
    ----------
    mesh : Mesh
    deadline : Deadline
        If it passes before the simplification begins, OutOfTime is raised.
    """
    target_faces = face_budget(mesh, deadline=deadline)
    if len(mesh.faces) > target_faces:
        deadline.check()
    return simplify(mesh, target_faces=target_faces)


def surface_with_proxy(mesh: Mesh, proxy: PreprocessResult) -> Surface:
    """Make the surface queries of a mesh, with the proxy that was made of it if that differs.

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
