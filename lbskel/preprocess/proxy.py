"""The proxy of a surface: a simplified copy that is contracted in its place.

It has MAX_FACES faces, but more where the shape has many thin parts: their number follows from its local radii.
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

MAX_FACES = 16_000  # faces contracted without a proxy, and of the proxy of a shape with few thin parts;
# benchmarks/results/resolution.md
# Faces of an area of one squared local radius: their edges are half the radius long. "Faces for each squared local
# radius" in benchmarks/results/resolution.md
FACES_PER_SQUARED_RADIUS = 8.0
MAX_SLENDER_FACES = 128_000  # upper bound on the faces of shapes with many thin parts; a guess that bounds the time
# Faces of such a shape for each face of its proxy, above which that bound is raised: upper bound on how coarse a
# proxy is. A coarser one loses tips, and costs more than it saves, since its skeleton leaves the solid;
# benchmarks/results/scaling.md, "Proxies of thin inputs"
MAX_REDUCTION = 2


def face_budget(mesh: Mesh, *, deadline: Deadline = NEVER) -> int:
    """Compute the largest number of faces with which a mesh is contracted.

    It is MAX_FACES, or the number with which edges have half the local radius, if that is larger, to two digits: rays
    along the edges of a mesh of voxels may hit one face or another, so that its local radii depend on rounding errors.

    Parameters
    ----------
    mesh : Mesh
    deadline : Deadline
        After it, OutOfTime is raised.
    """
    if len(mesh.faces) <= MAX_FACES:
        return MAX_FACES
    has_area = mesh.face_areas > 0
    radii = local_radii(mesh, deadline=deadline)[mesh.faces[has_area]].mean(axis=1)
    needed = FACES_PER_SQUARED_RADIUS * float((mesh.face_areas[has_area] / radii**2).sum())
    rounded = float(f"{needed:.1e}")
    return int(np.clip(rounded, MAX_FACES, max(MAX_SLENDER_FACES, len(mesh.faces) // MAX_REDUCTION)))


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
