"""The first stage: any mesh, preprocessed, brought to unit size, and split into the bodies that get a skeleton."""

from __future__ import annotations

__all__ = ["SIMPLIFY", "Body", "PreparedMesh", "prepare"]

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.errors import MeshError, choose, counted, first_few
from lbskel.geometry.canonical_order import in_canonical_order
from lbskel.geometry.components import MIN_FACES, components, find_crumbs, find_inner
from lbskel.geometry.deadline import OutOfTime
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.shape_diameter import has_local_radii, local_radii, set_local_radii
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.unit_frame import UnitFrame
from lbskel.geometry.vertex_map import VertexMap
from lbskel.io import as_mesh
from lbskel.pipeline.profiling import StageTimer
from lbskel.preprocess import (
    Pipeline,
    is_flat_sheet,
    is_sheet,
    name_component,
    preprocess_mesh,
    simplify_to_proxy,
    surface_with_proxy,
    why_no_inside,
)
from lbskel.preprocess.proxy import MAX_FACES
from lbskel.preprocess.result import PreprocessResult, identity_result
from lbskel.refinement.region_map import complete_regions
from lbskel.skeleton.skeleton import Skeleton

SIMPLIFY = ("auto", "none")

# No further bodies are prepared once less than this share of the time limit is left, which is then for the skeletons of
# those prepared: benchmarks/results/scaling.md has the time limits that hold with it, of 10,000 shells
RESERVED_SHARE = 0.5

# Expected time of simplification over the time that preprocessing has taken. Simplification cannot be cut short once it
# has begun, so it does not begin where more time is expected than is left. Up to 4 in benchmarks/results/scaling.md,
# and 18 for a vertex of 50,000 faces.
SIMPLIFY_RATIO = 3.0


@dataclass(frozen=True, eq=False)
class Body:
    """One connected surface with an inside, and the proxy that is contracted in its place.

    Parameters
    ----------
    mesh : Mesh
        In the unit coordinates of the prepared mesh.
    vertices : (k,) array of int
        For each vertex of ``mesh``, the vertex of the prepared mesh.
    proxy : PreprocessResult
        The mesh simplified to the number of faces that its thickness needs, or the mesh itself.
    open_ends : (e, 7) array of float
        Center, mean radius and vector area of each boundary loop before it was closed, where branches may end; in unit
        coordinates.
    is_inner : bool
        Whether it lies inside another body.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> (body,) = lbskel.prepare(torus(1.0, 0.2)).bodies
    >>> body.mesh.genus, body.is_piece
    (1, False)
    """

    mesh: Mesh
    vertices: NDArray[np.int64]
    proxy: PreprocessResult
    open_ends: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 7)))
    is_inner: bool = False

    @cached_property
    def is_piece(self) -> bool:
        """Whether its surface was open or non-manifold, and neither flat nor inside another: maybe a piece of one."""
        is_open = len(self.open_ends) > 0 or not self.mesh.is_closed_manifold
        return is_open and not self.is_inner and not is_flat_sheet(self.mesh)

    @cached_property
    def surface(self) -> Surface:
        """Queries on the mesh: distances, sections, inside tests."""
        return surface_with_proxy(self.mesh, self.proxy)


@dataclass(frozen=True, eq=False)
class PreparedMesh:
    """A mesh ready for contraction.

    Parameters
    ----------
    source : Mesh
        What the caller gave.
    mesh : Mesh
        The preprocessed mesh in its canonical order, in unit coordinates: its centroid is at the origin, its diameter
        bound is 1, and it is mirrored where that makes it the same as for the mirror image of the source.
    vertex_map : VertexMap
        From the vertices of the source to those of ``mesh``.
    frame : UnitFrame
        From the caller's coordinates to unit coordinates and back.
    bodies : tuple of Body
    notes : tuple of str
        What was done to the mesh, and which parts get no skeleton, a sentence each.
    preprocessing : dict
        The report of the preprocessing pipeline, ready for JSON.
    simplify : str
        Whether bodies have proxies: ``auto`` or ``none``.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> prepared = lbskel.prepare(torus(5.0, 1.0))
    >>> round(prepared.frame.scale), len(prepared.bodies)
    (12, 1)
    """

    source: Mesh
    mesh: Mesh
    vertex_map: VertexMap
    frame: UnitFrame
    bodies: tuple[Body, ...]
    notes: tuple[str, ...]
    preprocessing: dict[str, Any] = field(repr=False)
    simplify: str = "auto"

    @cached_property
    def surface(self) -> Surface:
        """Queries on the whole mesh for its score, which do not depend on whether a proxy was contracted."""
        if len(self.bodies) == 1 and self.bodies[0].mesh is self.mesh:
            if self.simplify == "auto":
                return self.bodies[0].surface
            return surface_with_proxy(self.mesh, simplify_to_proxy(self.mesh))
        return Surface(self.mesh)

    def skeleton_to_unit(self, skeleton: Skeleton) -> Skeleton:
        """Convert a skeleton of the source to the coordinates and vertices of ``mesh``.

        Vertices that preprocessing has added go to nodes near them, see
        :func:`lbskel.refinement.region_map.complete_regions`.
        """
        local = replace(
            skeleton,
            nodes=self.frame.to_unit(skeleton.nodes),
            radii=skeleton.radii / self.frame.scale,
            mean_radii=skeleton.mean_radii / self.frame.scale,
        )
        if len(skeleton.node_of_vertex) == 0:
            return local
        known = self.vertex_map.push_forward(skeleton.node_of_vertex, len(self.mesh.vertices))
        return replace(local, node_of_vertex=complete_regions(local, known, self.mesh))


def prepare(
    mesh: Any, *, preprocess: str | Pipeline | None = "auto", simplify: str = "auto", timer: StageTimer | None = None
) -> PreparedMesh:
    """Preprocess a mesh, bring it to unit size and split it into bodies.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object
    preprocess : str, Pipeline or None
        ``auto`` does what the mesh needs, None nothing; else a pipeline, its text, or its name in PIPELINES.
    simplify : str
        ``auto`` makes a proxy of bodies of more faces than their thickness needs; ``none`` contracts every vertex.
    timer : StageTimer, optional
        Measures the stages. Where its time limit leaves no time, bodies are left out or not simplified.

    Raises
    ------
    FormatError
        If the mesh is a path and no mesh can be read from it.
    MeshError
        If the input is no mesh, or no part of it has an inside.
    UnknownChoice
        If a name is in no table.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> prepared = lbskel.prepare(torus(5.0, 1.0))
    >>> len(prepared.bodies), round(prepared.mesh.diameter_bound, 6)
    (1, 1.0)
    """
    choose(dict.fromkeys(SIMPLIFY), simplify, "way to simplify")
    timer = timer or StageTimer()
    with timer("read"):
        source = as_mesh(mesh)
    with timer("preprocess"):
        preprocessed = preprocess_mesh(source, preprocess, deadline=timer.deadline)
        ordered, new_index, mirror = preprocessed.mesh, VertexMap.identity(len(preprocessed.mesh.vertices)), np.ones(3)
        if timer.has_time_for("canonical order"):
            ordered, new_index, mirror = in_canonical_order(preprocessed.mesh)
        scale = ordered.diameter_bound
        if not scale > 0:
            raise MeshError("all vertices of the mesh lie at one point")
        unit = ordered.with_vertices((ordered.vertices - ordered.centroid) / scale)
        if unit.n_components == 1 and has_local_radii(ordered):  # rays may end at other components
            set_local_radii(unit, local_radii(ordered) / scale)
    frame = UnitFrame(ordered.centroid * mirror, scale, mirror)
    in_place = ordered.with_vertices(ordered.vertices * mirror)
    bodies: list[Body] = []
    cuts = np.array(preprocessed.report.get("open_ends", [])).reshape(-1, 10)
    areas = cuts[:, 4:7] / scale * mirror / scale
    open_ends = np.column_stack([frame.to_unit(cuts[:, :3]), cuts[:, 3] / scale, areas])
    faults: list[str] = []
    owner = _owners(frame.to_unit(cuts[:, 7:]), unit)
    is_crumb, expected, n_left_out = find_crumbs(unit), SIMPLIFY_RATIO * timer.seconds["preprocess"], 0
    for number, part in enumerate(components(unit)):
        if is_crumb[number]:
            continue
        if bodies and timer.seconds_left < RESERVED_SHARE * (timer.time_limit or 0.0):
            timer.skip("prepare bodies")
            n_left_out += 1
            continue
        if fault := why_no_inside(number, part, in_place):
            faults.append(fault)
        else:
            proxy = identity_result(part.mesh)
            is_large = len(part.mesh.faces) > MAX_FACES
            if simplify == "auto" and (not is_large or timer.has_time_for("simplify", seconds=expected)):
                with timer("simplify"):
                    proxy = _proxy_in_time(part.mesh, proxy, timer)
            bodies.append(Body(part.mesh, part.vertices, proxy, open_ends[owner == number]))
    if not bodies:
        raise MeshError(_why_no_body(source, faults))
    is_inner = find_inner([body.proxy.mesh for body in bodies])
    bodies = [replace(body, is_inner=bool(inner)) for body, inner in zip(bodies, is_inner, strict=True)]
    notes = [*source.notes, *preprocessed.notes]
    if faults:
        notes.append(f"no skeleton could be made of {first_few(faults, 2)}")
    notes += _notes_on_bodies(bodies, in_place)
    if is_crumb.any():
        notes.append(f"too small for a skeleton: {counted(is_crumb.sum(), 'component')}")
    if n_left_out:
        notes.append(f"no time was left for {counted(n_left_out, 'component')}")
    vertex_map, report = preprocessed.vertex_map.compose(new_index), preprocessed.report
    return PreparedMesh(source, unit, vertex_map, frame, tuple(bodies), tuple(notes), report, simplify)


def _notes_on_bodies(bodies: Sequence[Body], mesh: Mesh) -> list[str]:
    """Tell which bodies are sheets and which lie inside others, by their place on the preprocessed mesh."""
    kinds = {
        "sheets enclose no volume, so their branches run along the surface; give them a thickness, or leave them out": [
            is_sheet(body.mesh) for body in bodies
        ],
        "bodies inside others, as the inner wall of a pipe, have skeletons of their own; leave one surface of a wall "
        "out": [body.is_inner for body in bodies],
    }
    vertex = np.array([body.vertices[0] for body in bodies])
    names = [name_component(int(mesh.component_of_vertex[v]), mesh.vertices[v]) for v in vertex]
    return [f"{what}: {first_few(compress(names, which), 2)}" for what, which in kinds.items() if any(which)]


def _owners(rims: NDArray[np.float64], mesh: Mesh) -> NDArray[np.int64]:
    """(k,) component of the vertex nearest to a point on the rim of each cut, in the middle of which may be another."""
    if len(rims) == 0:
        return np.empty(0, dtype=np.int64)
    used = mesh.used_vertices
    owners: NDArray[np.int64] = mesh.component_of_vertex[used[cKDTree(mesh.vertices[used]).query(rims)[1]]]
    return owners


def _proxy_in_time(mesh: Mesh, unchanged: PreprocessResult, timer: StageTimer) -> PreprocessResult:
    """Simplify a mesh, or return it unchanged if the time limit is over before that."""
    try:
        return simplify_to_proxy(mesh, deadline=timer.deadline)
    except OutOfTime:
        timer.skip("simplify")
        return unchanged


def _why_no_body(source: Mesh, faults: list[str]) -> str:
    """Say why no part of a mesh can have a skeleton, and what to do."""
    if faults:
        return f"no component of the mesh has an inside: {first_few(faults, 2)}"
    return (
        f"no component of the mesh has {MIN_FACES} faces and an area, of {counted(len(source.faces), 'face')} in all; "
        "if the faces should be connected, preprocess='merge_close:tolerance=1e-3' merges their corners"
    )
