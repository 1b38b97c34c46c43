"""Many small bodies at once: surfaces apart from each other are contracted and refined as one surface.

The time of a small body is not that of its faces but that of the calls, tens of milliseconds whatever its size. The
operators, the collapse and the passes are local, so they take any number of closed surfaces that do not overlap; the
components of the resulting graph are the skeletons of the bodies. A body is treated alone if its vertices are not
mapped to one component of its own, or if this is not a tree.
"""

from __future__ import annotations

__all__ = ["skeletonize_bodies"]

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.pipeline.preparation import Body
from lbskel.preprocess.result import identity_result
from lbskel.skeleton.skeleton import Skeleton

# Number of small bodies below which each is treated alone, as those of ordinary scenes are; a guess
MIN_BODIES = 100
# Largest number of faces of a small body: benchmarks/results/scaling.md has the time of bodies of 80 faces, and alone a
# body of 500 faces takes hardly longer; a guess
MAX_FACES = 500
# Largest number of vertices of a group: as many as a surface has cells at least in the search for the ends of its limbs
# (refinement.surface_cells.N_CELLS), so that ends are found as on each body alone
MAX_VERTICES = 2000

Result: TypeAlias = tuple[Skeleton, dict[str, Any]]


def skeletonize_bodies(bodies: Sequence[Body], skeletonize: Callable[[Body], Result]) -> list[Result]:
    """Make the skeleton and the report of each body; many small ones are treated in groups.

    Parameters
    ----------
    bodies : sequence of Body
    skeletonize : callable
        Makes the skeleton and the report of one body, which may consist of several closed surfaces.
    """
    small = [number for number, body in enumerate(bodies) if _is_small(body)]
    results: dict[int, Result] = {}
    if len(small) >= MIN_BODIES:
        for group in _groups(small, bodies):
            results |= _skeletonize_group({number: bodies[number] for number in group}, skeletonize)
    return [results[number] if number in results else skeletonize(body) for number, body in enumerate(bodies)]


def _is_small(body: Body) -> bool:
    """Whether a body is a small closed surface without handles or open ends."""
    mesh = body.mesh
    return len(mesh.faces) <= MAX_FACES and not body.is_piece and mesh.genus == 0 and body.proxy.mesh is mesh


def _groups(small: Sequence[int], bodies: Sequence[Body]) -> list[list[int]]:
    """Divide bodies into groups without overlapping bounding boxes; a body that overlaps an earlier one is left out."""
    ends = np.cumsum([len(bodies[number].mesh.vertices) for number in small])
    cuts = np.flatnonzero(np.diff(ends // MAX_VERTICES)) + 1
    groups = []
    for group in np.split(np.array(small), cuts):
        vertices = [bodies[number].mesh.vertices for number in group]
        low, high = (np.array([extreme(V, axis=0) for V in vertices]) for extreme in (np.min, np.max))
        overlaps = ((low[:, None] <= high) & (low <= high[:, None])).all(axis=2)
        groups.append(group[~np.triu(overlaps, 1).any(axis=0)].tolist())
    return groups


def _skeletonize_group(group: dict[int, Body], skeletonize: Callable[[Body], Result]) -> dict[int, Result]:
    """Make the skeletons of a group of bodies, without those for which :func:`_parts` has none."""
    sizes = [len(body.mesh.vertices) for body in group.values()]
    first = np.cumsum([0, *sizes[:-1]])
    faces = [body.mesh.faces + start for body, start in zip(group.values(), first, strict=True)]
    mesh = Mesh(np.concatenate([body.mesh.vertices for body in group.values()]), np.concatenate(faces))
    vertices = np.concatenate([body.vertices for body in group.values()])
    whole, report = skeletonize(Body(mesh, vertices, identity_result(mesh)))
    return {
        number: (part, _report_of(part, body, report))
        for (number, body), part in zip(group.items(), _parts(whole, np.array(sizes)), strict=True)
        if part is not None
    }


def _parts(whole: Skeleton, sizes: NDArray[np.int64]) -> list[Skeleton | None]:
    """For bodies of these numbers of vertices, the tree to which all vertices of the body, and no others, are mapped.

    None where there is no such tree.
    """
    component = whole.component_of_node
    of_vertex, body_of_vertex = component[whole.node_of_vertex], np.repeat(np.arange(len(sizes)), sizes)
    first = np.cumsum(sizes) - sizes
    is_alone = np.ones(len(sizes), dtype=bool)
    is_alone[body_of_vertex[of_vertex != np.repeat(of_vertex[first], sizes)]] = False
    is_alone &= np.bincount(of_vertex[first], minlength=whole.n_components)[of_vertex[first]] == 1
    by_component = np.argsort(component, kind="stable")
    ends = np.cumsum(np.bincount(component))
    edges_by_component = whole.edges[np.argsort(component[whole.edges[:, 0]], kind="stable")]
    n_edges = np.bincount(component[whole.edges[:, 0]], minlength=len(ends))
    edge_ends = np.cumsum(n_edges)
    new_index = np.empty(len(whole.nodes), dtype=np.int64)
    parts: list[Skeleton | None] = []
    for body, (start, size) in enumerate(zip(first, sizes, strict=True)):
        own = of_vertex[start]
        nodes = by_component[ends[own - 1] if own else 0 : ends[own]]
        new_index[nodes] = np.arange(len(nodes))
        parts.append(
            Skeleton(
                whole.nodes[nodes],
                new_index[edges_by_component[edge_ends[own] - n_edges[own] : edge_ends[own]]],
                whole.radii[nodes],
                new_index[whole.node_of_vertex[start : start + size]],
                mean_radii=whole.mean_radii[nodes],
            )
            if is_alone[body] and n_edges[own] == len(nodes) - 1
            else None
        )
    return parts


def _report_of(skeleton: Skeleton, body: Body, report: dict[str, Any]) -> dict[str, Any]:
    """Return the report of one body of a group, with the steps of the group."""
    counts = {"cycle_rank": 0, "tips": len(skeleton.tips), "junctions": len(skeleton.junctions)}
    return {**report, "vertices": len(body.mesh.vertices), "faces": len(body.mesh.faces), **counts}
