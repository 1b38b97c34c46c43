"""The preprocessing that a mesh gets by default: only what it needs before it is contracted.

A closed manifold that is fine and smooth enough is returned unchanged.
"""

from __future__ import annotations

__all__ = [
    "COARSE_EDGE",
    "MAX_COARSE_FRACTION",
    "MAX_FRAGMENT_AREA",
    "PREPARATIONS",
    "preprocess_mesh",
    "removed_fraction",
]

from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError, UnknownChoice, choose, were
from lbskel.geometry.canonical_order import in_canonical_order
from lbskel.geometry.components import MIN_FACES, components, find_crumbs, find_twigs
from lbskel.geometry.deadline import NEVER, Deadline, OutOfTime
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.roughness import ROUGHNESS_LIMIT, roughness
from lbskel.geometry.shape_diameter import local_radii, set_local_radii
from lbskel.geometry.vertex_map import VertexMap
from lbskel.preprocess.cleaning import clean, extract_faces, merge_seams, remove_duplicates
from lbskel.preprocess.degenerate_faces import remove_degenerate
from lbskel.preprocess.holes import close_holes, find_open_ends
from lbskel.preprocess.orientation import fix_orientation, split_nonmanifold
from lbskel.preprocess.pipelines import PIPELINES, STEPS, Pipeline
from lbskel.preprocess.remeshing import smooth_noise
from lbskel.preprocess.result import PreprocessResult, identity_result, preprocess_step
from lbskel.preprocess.subdivision import MAX_FACES, coarse_faces, refine

AUTOMATIC = "auto"
PREPARATIONS = (AUTOMATIC, "none", *PIPELINES)

# Upper bound on coordinates, in the units of the mesh: sums over vertices of their fourth powers stay below 1.8e308.
MAX_COORDINATE = 1e75

# Longest edge of a fine face, as a fraction of the local thickness. On low-poly shapes 0.5 and 0.8 gave the same
# measured accuracy, and 0.8 makes fewer faces; that comparison is not in a committed table.
COARSE_EDGE = 0.8

# Fraction of coarse faces above which a mesh of up to 18,500 faces is refined. Meshes with fewer were measured not to
# gain; that measurement is not in a committed table.
MAX_COARSE_FRACTION = 0.1

# Fraction of the area that is coarse above which any mesh is refined: machine parts have many small faces on their
# fillets and few on their flats. Rows in benchmarks/results/coarse.md: 0.2 to 0.5 are alike; without it six of 13 parts
# are wrong, with 0.1 a ribbon 20 times as wide as thick has false tips, and real meshes are less accurate
MAX_COARSE_AREA = 0.2

# Longest perimeter of a hole that is closed, as a fraction of the diameter bound. The ends of pipes are closed too,
# since a capped end becomes a tip and the closed surface has an inside. A guess; see MAX_DISTANCE.
MAX_HOLE_PERIMETER = 1.1

# Area below which an open component is removed as debris around a hole, as a fraction of the largest component's area.
# A guess.
MIN_OPEN_AREA = 0.01

# Fraction of the area in components that are too small for a skeleton above which the mesh counts as a triangle soup. A
# guess.
MAX_FRAGMENT_AREA = 0.5

# Corner angle, in degrees, up to which a face counts as collinear, as those that close T-junctions do. A guess.
COLLINEAR_ANGLE = 0.01

# Iterations of smoothing of a rough surface; they bound the time. 20 and 60 are alike in benchmarks/results/noise.md
N_SMOOTHING_ITERATIONS = 60


OUT_OF_TIME = "the time limit was reached, so cavities, noise and coarse faces were not looked for"


def preprocess_mesh(
    mesh: Any, how: str | Pipeline | None = AUTOMATIC, *, deadline: Deadline = NEVER
) -> PreprocessResult:
    """Preprocess a mesh for contraction and map its vertices to the result.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    how : str, Pipeline or None
        ``auto`` does what the mesh needs, ``none`` or None nothing; else a pipeline, its name in PIPELINES, its steps
        as text, or the path of a TOML file.
    deadline : Deadline
        After it ``auto`` looks for no cavities, crumbs, noise and coarse faces, and a note says so. The steps of a
        pipeline are always done.

    Raises
    ------
    FormatError
        If ``how`` is the path of a file that is not a pipeline in TOML.
    MeshError
        If coordinates are so large that areas and volumes overflow.
    UnknownChoice
        If there is no such pipeline or step.
    """
    mesh = as_mesh(mesh)
    largest = float(np.abs(mesh.vertices).max())
    if largest > MAX_COORDINATE:
        raise MeshError(
            f"the coordinates of vertex {np.abs(mesh.vertices).max(axis=1).argmax()} are as large as {largest:.3g}: "
            f"beyond {MAX_COORDINATE:g} areas and volumes overflow; scale the mesh down"
        )
    if how is None or how == "none":
        return identity_result(mesh)
    if how == AUTOMATIC:
        return _preprocess_as_needed(mesh, deadline)
    if not isinstance(how, Pipeline | str):
        raise UnknownChoice(f"preprocess must be a Pipeline, a name or None, not {type(how).__name__}")
    if isinstance(how, str) and (how.isidentifier() or not how):
        choose(dict.fromkeys((*PREPARATIONS, *STEPS)), how, "pipeline or step")
    return (how if isinstance(how, Pipeline) else Pipeline.parse(how))(mesh)


def _preprocess_as_needed(mesh: Mesh, deadline: Deadline) -> PreprocessResult:
    """Clean a mesh, repair it towards a closed manifold, smooth it if it is rough, and refine it if it is coarse.

    The repair changes nothing but defects: bodies that touch are split only where all of them become closed manifolds.
    """
    result, open_ends = clean(mesh), np.empty((0, 10))
    if not result.mesh.is_closed_manifold:
        result = result.compose(merge_seams).compose(remove_duplicates).compose(_remove_dangling)
        result = result.compose(_remove_fragments).compose(fix_orientation).compose(_remove_open_debris)
        open_ends = find_open_ends(result.mesh)
        result = result.compose(lambda given: close_holes(given, max_perimeter=MAX_HOLE_PERIMETER))
        result = result.compose(lambda given: remove_degenerate(given, angle=COLLINEAR_ANGLE))
        # where an edge has an odd number of faces, splitting cannot give every edge two
        split = result if (result.mesh.faces_per_edge % 2).any() else result.compose(split_nonmanifold)
        if split.mesh.is_closed_manifold and _are_small(split.mesh).sum() <= _are_small(result.mesh).sum():
            result = split  # bodies that touch; neither an inner wall, nor a fin, nor debris
    elif (_component_volumes(result.mesh) < 0).any():
        result = result.compose(fix_orientation)
    for step in (_remove_cavities, _remove_crumbs, _smooth_if_rough, partial(_refine_if_coarse, deadline=deadline)):
        if deadline.seconds_left > 0:
            with suppress(OutOfTime):
                result = result.compose(step)
    if deadline.seconds_left < 0:
        result = replace(result, notes=(*result.notes, OUT_OF_TIME))
    steps = [step for step in result.report.get("steps", []) if step["notes"]]
    report = {**result.report, "pipeline": AUTOMATIC, "steps": steps, "open_ends": open_ends.tolist()}
    return replace(result, report=report)


def removed_fraction(result: PreprocessResult) -> float:
    """Compute the fraction of the area in the components that preprocessing has removed as too small or as debris.

    Parameters
    ----------
    result : PreprocessResult
        Of :func:`preprocess_mesh`.
    """
    kept = 1.0
    for step in result.report.get("steps", []):
        if step["step"] in _REMOVALS and step["before"]["area"] > 0:
            kept *= step["after"]["area"] / step["before"]["area"]
    return 1.0 - kept


def _smooth_if_rough(mesh: Mesh) -> PreprocessResult:
    """Smooth a rough surface."""
    if roughness(mesh) <= ROUGHNESS_LIMIT:
        return identity_result(mesh)
    return smooth_noise(mesh, iterations=N_SMOOTHING_ITERATIONS)


def _refine_if_coarse(mesh: Mesh, deadline: Deadline) -> PreprocessResult:
    """Refine a coarse mesh; faces that are not connected have no thickness."""
    if find_crumbs(mesh).all():
        return identity_result(mesh)
    ordered, vertex_map, mirror = in_canonical_order(mesh)  # whose radii are needed next, if it is not refined
    set_local_radii(mesh, local_radii(ordered, deadline=deadline)[vertex_map.indices])
    is_coarse = coarse_faces(mesh, COARSE_EDGE)
    has_many = len(mesh.faces) <= MAX_FACES and is_coarse.mean() > MAX_COARSE_FRACTION
    if not (has_many or mesh.face_areas[is_coarse].sum() > MAX_COARSE_AREA * mesh.area):
        return identity_result(mesh)
    refined = refine(ordered, max_edge_length=COARSE_EDGE)  # which divides faces in the sense of their orientation
    n, n_refined = len(mesh.vertices), len(refined.mesh.vertices)
    old_index = np.concatenate([np.argsort(vertex_map.indices), np.arange(n, n_refined)])
    vertices = np.concatenate([mesh.vertices, refined.mesh.vertices[n:] * mirror])
    outward = old_index[refined.mesh.faces[:, :: int(mirror.prod())]]
    return replace(refined, mesh=Mesh(vertices, outward, mesh.notes), vertex_map=VertexMap.identity(n))


def _component_areas(mesh: Mesh) -> NDArray[np.float64]:
    """(c,) area of each component."""
    return np.asarray(np.bincount(mesh.component_of_vertex[mesh.faces[:, 0]], mesh.face_areas), dtype=np.float64)


def _are_small(mesh: Mesh) -> NDArray[np.bool_]:
    """(c,) which components have a negligible share of the area of the largest."""
    areas = _component_areas(mesh)
    is_small: NDArray[np.bool_] = areas < MIN_OPEN_AREA * areas.max()
    return is_small


def _component_volumes(mesh: Mesh) -> NDArray[np.float64]:
    """(c,) volume of each component, negative where it is inside out."""
    if mesh.n_components == 1:
        return np.array([mesh.volume])
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    origin = np.zeros(int(label.max()) + 1, dtype=np.int64)
    origin[label] = mesh.faces[:, 0]
    A, B, C = mesh.vertices[mesh.faces.T] - mesh.vertices[origin[label]]
    return np.asarray(np.bincount(label, np.einsum("ij,ij->i", A, np.cross(B, C))) / 6, dtype=np.float64)


@preprocess_step
def _remove_cavities(mesh: Mesh) -> PreprocessResult:
    """Remove closed inward surfaces inside others: a cavity belongs to the solid around it, which has one skeleton."""
    if mesh.n_components == 1:
        return identity_result(mesh)
    label, volumes = mesh.component_of_vertex[mesh.faces[:, 0]], _component_volumes(mesh)
    if not (volumes < 0).any():
        return identity_result(mesh)
    parts = components(mesh)
    walls = [k for k in np.flatnonzero(volumes < 0).tolist() if parts[k].mesh.is_closed_manifold]
    walls = [k for k in walls if parts[k].mesh.volume < 0]
    outer = mesh.faces[~np.isin(label, walls)]
    if not walls or len(outer) == 0:
        return identity_result(mesh)
    points = np.array([parts[k].mesh.vertices[0] for k in walls])
    is_inside = np.abs(igl.winding_number(mesh.vertices, outer, points)) > 0.5
    cavities = np.array(walls)[is_inside]
    if len(cavities) == 0:
        return identity_result(mesh)
    note = f"{were(len(cavities), 'cavity')} filled, as part of the solid around"
    return extract_faces(mesh, mesh.faces[~np.isin(label, cavities)], note)


@preprocess_step
def _remove_dangling(mesh: Mesh) -> PreprocessResult:
    """Remove the faces with a free edge that hang on an edge of two other faces, where all others are closed."""
    n_faces = mesh.faces_per_edge[mesh.edge_of_half_edge].reshape(3, -1)
    is_dangling = (n_faces == 1).any(axis=0) & (n_faces > 2).any(axis=0)
    if not is_dangling.any() or is_dangling.all() or not Mesh(mesh.vertices, mesh.faces[~is_dangling]).is_closed:
        return identity_result(mesh)
    note = f"{were(is_dangling.sum(), 'dangling face')} removed from a closed surface"
    return extract_faces(mesh, mesh.faces[~is_dangling], note)


@preprocess_step
def _remove_fragments(mesh: Mesh) -> PreprocessResult:
    """Remove the crumbs before the repair: whether the wall of each is inside others would take most of its time.

    A crumb of too few faces to enclose a volume stays, since the repair may close it.
    """
    n_faces = np.bincount(mesh.component_of_vertex[mesh.faces[:, 0]])
    return _without_crumbs(mesh, find_crumbs(mesh) & (n_faces >= MIN_FACES))


@preprocess_step
def _remove_crumbs(mesh: Mesh) -> PreprocessResult:
    """Remove the components that are too small for a skeleton of their own."""
    return _without_crumbs(mesh, find_crumbs(mesh))


def _without_crumbs(mesh: Mesh, is_crumb: NDArray[np.bool_]) -> PreprocessResult:
    """Remove some of the components, unless they are all."""
    if not is_crumb.any() or is_crumb.all():
        return identity_result(mesh)
    is_removed = is_crumb[mesh.component_of_vertex[mesh.faces[:, 0]]]
    note = f"{were(is_crumb.sum(), 'component')} removed as too small for a skeleton"
    if (area := mesh.face_areas[is_removed].sum()) > MAX_FRAGMENT_AREA * mesh.area:
        share = f"with {area / mesh.area:.0%} of the area"
        note += f", {share}: if the faces should be connected, raise the tolerance of merge_close"
    return extract_faces(mesh, mesh.faces[~is_removed], note)


@preprocess_step
def _remove_open_debris(mesh: Mesh) -> PreprocessResult:
    """Remove small open components but twigs that were cut off; small closed components are kept as bodies."""
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    is_small = _are_small(mesh)
    is_open = np.zeros(len(is_small), dtype=bool)
    is_open[mesh.component_of_vertex[mesh.edges[mesh.faces_per_edge == 1]]] = True
    is_debris = is_open & is_small & ~find_twigs(mesh, is_small)
    if not is_debris.any():
        return identity_result(mesh)
    what = f"smaller than {MIN_OPEN_AREA:g} of the largest one's area and no piece of a limb"
    note = f"{were(is_debris.sum(), 'open component')} removed as {what}"
    return extract_faces(mesh, mesh.faces[~is_debris[label]], note)


_REMOVALS = {step.__name__ for step in (_remove_fragments, _remove_open_debris, _remove_crumbs)}
