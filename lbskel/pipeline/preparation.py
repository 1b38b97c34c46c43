"""The first stage: any mesh, preprocessed, brought to unit size, and split into the bodies that get a skeleton."""

from __future__ import annotations

__all__ = ["SIMPLIFY", "Body", "PreparedMesh", "prepare"]

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError, choose, first_few
from lbskel.geometry.components import MIN_FACES, components
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.surface_queries import Surface
from lbskel.geometry.vertex_map import VertexMap
from lbskel.io import as_mesh
from lbskel.pipeline.profiling import StageTimer
from lbskel.preprocess import Pipeline, preprocess_mesh, simplify_to_proxy, surface_with_proxy, why_no_inside
from lbskel.preprocess.result import PreprocessResult, identity_result
from lbskel.refinement.region_map import make_regions_connected, nearest_balls, reassign_to_nearest_node
from lbskel.skeleton.skeleton import Skeleton

SIMPLIFY = ("auto", "none")


@dataclass(frozen=True, eq=False)
class Body:
    """One connected surface with an inside, and the proxy that is contracted in its place.

    Parameters
    ----------
    mesh : Mesh
        In the unit coordinates of the prepared mesh.
    vertices : (k,) array of int
        For each of its vertices, the vertex of the prepared mesh.
    proxy : PreprocessResult
        The mesh simplified to the faces that its thickness needs, or the mesh itself.
    """

    mesh: Mesh
    vertices: NDArray[np.int64]
    proxy: PreprocessResult

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
        The preprocessed mesh, with its centroid at the origin and a diameter bound of 1.
    vertex_map : VertexMap
        From the vertices of the source to those of ``mesh``.
    center : (3,) array of float
    scale : float
        ``mesh.vertices * scale + center`` are the caller's coordinates.
    bodies : tuple of Body
    notes : tuple of str
        What was done to the mesh and what gets no skeleton, a sentence each.
    preprocessing : dict
        The report of the preprocessing pipeline, ready for JSON.
    simplify : str
        Whether bodies have proxies: ``auto`` or ``none``.
    """

    source: Mesh
    mesh: Mesh
    vertex_map: VertexMap
    center: NDArray[np.float64]
    scale: float
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

    def to_unit(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points in the caller's coordinates, brought to those of ``mesh``."""
        return (points - self.center) / self.scale

    def skeleton_to_unit(self, skeleton: Skeleton) -> Skeleton:
        """Bring a skeleton of the source to the coordinates and vertices of ``mesh``.

        Vertices that preprocessing has added are mapped as :func:`lbskel.refine` maps vertices.
        """
        local = replace(
            skeleton,
            nodes=self.to_unit(skeleton.nodes),
            radii=skeleton.radii / self.scale,
            mean_radii=skeleton.mean_radii / self.scale,
        )
        if len(skeleton.node_of_vertex) == 0:
            return local
        known = self.vertex_map.push_forward(skeleton.node_of_vertex, len(self.mesh.vertices))
        if (known >= 0).all():
            return replace(local, node_of_vertex=known)
        nearest = replace(local, node_of_vertex=np.where(known < 0, nearest_balls(local, self.mesh), known))
        connected = make_regions_connected(reassign_to_nearest_node(nearest, self.mesh), self.mesh)
        return replace(local, node_of_vertex=np.where(known < 0, connected.node_of_vertex, known))


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

    Raises
    ------
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
        preprocessed = preprocess_mesh(source, preprocess)
        center, scale = preprocessed.mesh.centroid, preprocessed.mesh.diameter_bound
        if not scale > 0:
            raise MeshError("all vertices of the mesh lie at one point")
        unit = preprocessed.mesh.with_vertices((preprocessed.mesh.vertices - center) / scale)
    bodies: list[Body] = []
    faults: list[str] = []
    n_crumbs = 0
    for number, part in enumerate(components(unit)):
        if len(part.mesh.faces) < MIN_FACES or not part.mesh.area > 0:
            n_crumbs += 1
        elif fault := why_no_inside(number, part, preprocessed.mesh):
            faults.append(fault)
        else:
            with timer("simplify"):
                proxy = simplify_to_proxy(part.mesh) if simplify == "auto" else identity_result(part.mesh)
            bodies.append(Body(part.mesh, part.vertices, proxy))
    if not bodies:
        raise MeshError(_why_no_body(source, faults))
    notes = [*source.notes, *preprocessed.notes]
    if faults:
        notes.append(f"no skeleton could be made of {first_few(faults, 2)}")
    if n_crumbs:
        notes.append(f"{n_crumbs} components with too few faces or no area have no skeleton of their own")
    vertex_map, report = preprocessed.vertex_map, preprocessed.report
    return PreparedMesh(source, unit, vertex_map, center, scale, tuple(bodies), tuple(notes), report, simplify)


def _why_no_body(source: Mesh, faults: list[str]) -> str:
    """Why no part of a mesh can have a skeleton, and the way out."""
    if faults:
        return f"no component of the mesh has an inside: {first_few(faults, 2)}"
    return (
        f"no component of the mesh has {MIN_FACES} faces and an area, out of {len(source.faces)} faces in all; "
        "if the faces should be connected, preprocess='merge_close:tolerance=1e-3' merges their corners"
    )
