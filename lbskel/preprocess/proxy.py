"""The proxy of a surface: a simplified copy that is contracted in its place.

A shape with few thin parts is simplified to MAX_FACES faces by quadric errors, which is more than it needs. Where a
shape has many thin parts, edges collapse that are short relative to the local radius, so that thin and thick parts stay
equally fine: quadric errors are squared distances, and one that is small for a thick part is as large as a thin one.
"""

from __future__ import annotations

__all__ = ["MAX_FACES", "face_budget", "simplify_to_proxy", "surface_with_proxy"]

import math

import numpy as np
from scipy.spatial import cKDTree

from lbskel.geometry.coarsening import Coarsened, coarsen
from lbskel.geometry.deadline import NEVER, Deadline
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.surface_queries import Proxy, Surface
from lbskel.preprocess.result import PreprocessResult, hausdorff_distance, identity_result, preprocess_step
from lbskel.preprocess.simplification import simplify, topology_of

DEVIATION_MARGIN = 2.0  # safety factor on the proxy's measured deviation before it is trusted for inside tests; a guess

MAX_FACES = 16_000  # faces contracted without a proxy, and of the proxy of a shape with few thin parts;
# benchmarks/results/resolution.md
# Length up to which edges collapse, in local radii; about 18 faces are left for each squared radius. In
# benchmarks/results/proxies.md 0.2 to 0.45 find 0.98 to 1.00 of the tips of fine voxels, 0.75 finds 0.93, and quadric
# errors find 0.97 with as many faces as 0.25 leaves; 0.25 takes a seventh longer than 0.45, and 0.2 a fifth more
SHORT_EDGE = 0.25
MAX_SLENDER_FACES = 128_000  # upper bound on the faces of shapes with many thin parts; a guess that bounds the time
# Faces of such a shape for each face of its proxy, above which that bound is raised: upper bound on how coarse a
# proxy is. A coarser one loses tips, and costs more than it saves, since its skeleton leaves the solid;
# benchmarks/results/scaling.md, "Proxies of thin inputs"
MAX_REDUCTION = 2


def face_budget(mesh: Mesh, *, deadline: Deadline = NEVER) -> int:
    """Compute the largest number of faces with which a mesh is contracted.

    It is MAX_FACES, or the number that is left when short edges have collapsed, if that is larger; and at most
    MAX_SLENDER_FACES, or half the faces of a mesh of many more.

    Parameters
    ----------
    mesh : Mesh
    deadline : Deadline
        After it, OutOfTime is raised.
    """
    most = max(MAX_SLENDER_FACES, len(mesh.faces) // MAX_REDUCTION)
    return MAX_FACES if len(mesh.faces) <= MAX_FACES else int(np.clip(_faces_left(mesh, deadline), MAX_FACES, most))


def simplify_to_proxy(mesh: Mesh, *, deadline: Deadline = NEVER) -> PreprocessResult:
    """Simplify a mesh to its face budget; return it unchanged if it has no more faces or its topology would change.

    Parameters
    ----------
    mesh : Mesh
    deadline : Deadline
        If it passes before the simplification begins, OutOfTime is raised.
    """
    n_faces = face_budget(mesh, deadline=deadline)
    if len(mesh.faces) > n_faces:
        deadline.check()
        if MAX_FACES < _faces_left(mesh, deadline) <= n_faces:
            coarse = _collapse_short_edges(mesh)
            if coarse.mesh is not mesh:
                return coarse
    return simplify(mesh, target_faces=n_faces)


def _faces_left(mesh: Mesh, deadline: Deadline) -> float:
    """Estimate the number of faces that are left when the short edges of a fine mesh have collapsed.

    They are as many as equilateral triangles whose edges are sqrt(2) times as long as the longest that collapse.
    """
    has_area = mesh.face_areas > 0
    radii = local_radii(mesh, deadline=deadline)[mesh.faces[has_area]].mean(axis=1)
    area_of_face = math.sqrt(3) / 2 * (SHORT_EDGE * radii) ** 2
    return float(np.rint((mesh.face_areas[has_area] / area_of_face).sum()))


@preprocess_step
def _collapse_short_edges(mesh: Mesh) -> PreprocessResult:
    """Collapse the edges that are short relative to the local radius, but at boundaries, where the topology stays."""
    max_lengths = SHORT_EDGE * local_radii(mesh)
    max_lengths[mesh.edges[mesh.faces_per_edge != 2]] = 0.0
    before, after = None, Coarsened.unmerged(mesh, mesh.vertex_areas)
    while after is not before:
        before, after = after, coarsen(after, max_lengths)
    if after.mesh is mesh or not (after.was_closed_manifold or topology_of(after.mesh) == topology_of(mesh)):
        return identity_result(mesh)
    note = f"{len(mesh.faces):,} faces were simplified to {len(after.mesh.faces):,}, as few as the local radii allow"
    deviation = hausdorff_distance(mesh, after.mesh) * mesh.diameter_bound
    return PreprocessResult(after.mesh, after.vertex_map, (note,), report={"deviation": deviation})


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
