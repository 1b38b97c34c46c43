"""What a mesh is, and what of it stands in the way of a skeleton: counted and measured, nothing changed."""

from __future__ import annotations

__all__ = ["MeshReport", "check"]

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from lbskel.geometry.components import components
from lbskel.geometry.mesh import Mesh
from lbskel.preprocess.automatic import COARSE_EDGE, preprocess_mesh
from lbskel.preprocess.cleaning import tidy
from lbskel.preprocess.degenerate_faces import corner_angles
from lbskel.preprocess.holes import boundary_loops
from lbskel.preprocess.messages import advised, sentences
from lbskel.preprocess.noise import roughness
from lbskel.preprocess.orientation import SHEET, relative_vector_area
from lbskel.preprocess.self_intersections import crossing_faces
from lbskel.preprocess.subdivision import coarse_share
from lbskel.preprocess.vertex_umbrellas import fans_of

SHARP = 0.5  # degrees: of a corner that makes a face degenerate by its angles, as remove_degenerate has it
NO_AREA = 1e-12  # of the squared diagonal: of a face that is degenerate by its area
MOST_COMPONENTS = 1000  # that are looked at one by one


@dataclass(frozen=True)
class MeshReport:
    """What :func:`check` found; lengths are fractions of the diagonal, angles are in degrees.

    Parameters
    ----------
    vertices, faces, components : int
    boundary_loops, boundary_edges : int
        Rims of holes, and edges of one face.
    nonmanifold_edges, nonmanifold_vertices : int
        Edges of more than two faces; vertices where surfaces meet in a point or an edge.
    misoriented_edges : int
        Edges whose two faces disagree which side is out.
    is_inside_out : bool
        Whether a closed surface has a negative volume.
    crossing_faces : int
        Faces found to cut through others.
    crossings_tested : float
        Share of the faces that were tested for it.
    duplicate_vertices, duplicate_faces, repeated_corners, unreferenced_vertices : int
        ``repeated_corners`` counts faces that name a vertex twice.
    zero_area_faces, needles, caps : int
        Degenerate by area; by an angle near 0 and by one near 180 degrees.
    smallest_angle, largest_angle : float
    shortest_edge, median_edge, longest_edge : float
    genera : tuple of int or None
        Of each component, once duplicates are merged; None where it is not closed.
    sheets : int
        Components that enclose nothing to speak of.
    coarse_faces : float
        Share of the faces with an edge that is long against the thickness of the shape, from a sample.
    roughness : float
        Height of noise, in edge lengths, as :func:`lbskel.preprocess.noise.roughness` has it.
    diagonal, area : float
        In the units of the mesh.
    volume : float or None
        None unless the mesh is a closed manifold.
    findings : tuple of str
        A sentence for each thing found, with what lbskel does about it.
    is_advised : bool
        Whether a skeleton can be expected to stand for the shape.
    """

    vertices: int
    faces: int
    components: int
    boundary_loops: int
    boundary_edges: int
    nonmanifold_edges: int
    nonmanifold_vertices: int
    misoriented_edges: int
    is_inside_out: bool
    crossing_faces: int
    crossings_tested: float
    duplicate_vertices: int
    duplicate_faces: int
    repeated_corners: int
    unreferenced_vertices: int
    zero_area_faces: int
    needles: int
    caps: int
    smallest_angle: float
    largest_angle: float
    shortest_edge: float
    median_edge: float
    longest_edge: float
    genera: tuple[int | None, ...]
    sheets: int
    coarse_faces: float
    roughness: float
    diagonal: float
    area: float
    volume: float | None
    findings: tuple[str, ...] = ()
    is_advised: bool = True

    def as_dict(self) -> dict[str, Any]:
        """All of it, plain enough for JSON."""
        return asdict(self)


def check(mesh: Mesh) -> MeshReport:
    """Look a mesh over before it is contracted.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    MeshReport

    Raises
    ------
    MeshError
        If coordinates are so large that areas overflow.

    Examples
    --------
    >>> from lbskel import Mesh, check
    >>> from lbskel.shapes import torus
    >>> ring = torus(1.0, 0.3)
    >>> check(ring).findings
    ()
    >>> print(*check(Mesh(ring.vertices, ring.faces[:-1])).findings)
    1 hole: it is closed, unless it is the rim of a sheet.
    """
    prepared = preprocess_mesh(mesh).mesh
    tidied = tidy(mesh).mesh
    F = mesh.faces
    has_corners = (F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])
    angles = np.degrees(corner_angles(mesh.vertices[F[has_corners]])) if has_corners.any() else np.zeros((1, 3))
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    diagonal = mesh.diagonal
    lengths = np.linalg.norm(end - start, axis=1) / (diagonal or 1.0)
    is_cap = angles.max(axis=1) > 180 - SHARP
    crossing, tested = crossing_faces(tidied)
    directed = mesh.half_edges[:, 0] * len(mesh.vertices) + mesh.half_edges[:, 1]
    of_two = mesh.faces_per_edge[mesh.edge_of_half_edge] == 2
    parts = [part.mesh for part in components(tidied)] if tidied.n_components <= MOST_COMPONENTS else [tidied]
    fans = fans_of(tidied)
    report = MeshReport(
        vertices=len(mesh.vertices),
        faces=len(F),
        components=mesh.n_components,
        boundary_loops=len(boundary_loops(tidied)),
        boundary_edges=int((mesh.faces_per_edge == 1).sum()),
        nonmanifold_edges=int((mesh.faces_per_edge > 2).sum()),
        nonmanifold_vertices=len(np.unique(tidied.faces[fans.of_corner != tidied.faces])),
        misoriented_edges=int(of_two.sum() - len(np.unique(directed[of_two]))),
        is_inside_out=bool(tidied.is_closed_manifold and tidied.volume < 0),
        crossing_faces=len(crossing),
        crossings_tested=tested,
        duplicate_vertices=len(mesh.used_vertices) - len(np.unique(mesh.vertices[mesh.used_vertices], axis=0)),
        duplicate_faces=int(has_corners.sum()) - len(np.unique(np.sort(F[has_corners], axis=1), axis=0)),
        repeated_corners=int((~has_corners).sum()),
        unreferenced_vertices=len(mesh.vertices) - len(mesh.used_vertices),
        zero_area_faces=int((mesh.face_areas <= NO_AREA * diagonal**2).sum()),
        needles=int(((angles.min(axis=1) < SHARP) & ~is_cap).sum()),
        caps=int(is_cap.sum()),
        smallest_angle=float(angles.min()),
        largest_angle=float(angles.max()),
        shortest_edge=float(lengths.min()),
        median_edge=float(np.median(lengths)),
        longest_edge=float(lengths.max()),
        genera=tuple(part.genus for part in parts),
        sheets=sum(relative_vector_area(part) > SHEET for part in parts),
        coarse_faces=coarse_share(tidied, COARSE_EDGE),
        roughness=roughness(tidied),
        diagonal=diagonal,
        area=mesh.area,
        volume=mesh.volume if mesh.is_closed_manifold else None,
    )
    return _told(report, mesh, prepared)


def _told(report: MeshReport, mesh: Mesh, prepared: Mesh) -> MeshReport:
    """The report with what it means."""
    facts = report.as_dict()
    facts.update(findings=sentences(facts), is_advised=True)
    reasons = advised(facts, prepared)
    facts.update(findings=(*facts["findings"], *reasons), is_advised=not reasons)
    return MeshReport(**facts)
