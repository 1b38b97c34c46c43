"""Measures and defects of a mesh that matter for its skeleton, counted without changing the mesh."""

from __future__ import annotations

__all__ = ["MeshReport", "check"]

from collections import Counter
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from lbskel.errors import counted
from lbskel.geometry.components import components
from lbskel.geometry.mesh import as_mesh
from lbskel.geometry.normals import vector_lengths
from lbskel.geometry.roughness import roughness
from lbskel.preprocess.automatic import COARSE_EDGE, preprocess_mesh
from lbskel.preprocess.cleaning import clean
from lbskel.preprocess.degenerate_faces import corner_angles
from lbskel.preprocess.holes import boundary_loops
from lbskel.preprocess.messages import describe_findings, reasons_against_contraction
from lbskel.preprocess.orientation import MIN_SHEET_VECTOR_AREA, relative_vector_area
from lbskel.preprocess.self_intersections import self_intersecting_faces
from lbskel.preprocess.subdivision import coarse_faces
from lbskel.preprocess.vertex_umbrellas import find_umbrellas

# Corner angle, in degrees, below which (or above 180 minus which) a face is a needle (a cap): the default of
# remove_degenerate.
DEGENERATE_ANGLE = 0.5

MIN_FACE_AREA = 1e-12  # area up to which a face is degenerate, relative to the squared diameter bound; a guess

# Number of components above which genus and sheets are measured on the whole mesh instead of one by one. A guess that
# bounds the time.
MAX_COMPONENTS = 1000

MAX_GENERA_SHOWN = 5  # different genera that are printed


@dataclass(frozen=True)
class MeshReport:
    """Measures and findings of :func:`check`; lengths are fractions of the diameter bound.

    Parameters
    ----------
    vertices, faces, components : int
    boundary_loops, boundary_edges : int
        Boundary loops of holes; edges with exactly one face.
    nonmanifold_edges, nonmanifold_vertices : int
        Edges with more than two faces; vertices where surfaces meet in a point or an edge.
    misoriented_edges : int
        Edges whose two faces have opposite orientation.
    is_inside_out : bool
        Whether the mesh is closed and its volume negative.
    self_intersecting_faces : int
        Faces found to intersect others.
    self_intersection_sample : float
        Fraction of the faces that were tested for it.
    duplicate_vertices, duplicate_faces, repeated_corners, unreferenced_vertices : int
        ``repeated_corners`` counts faces that name a vertex twice.
    zero_area_faces, needles, caps : int
        Faces that are degenerate by their area, by an angle near 0, and by an angle near 180 degrees.
    min_angle_deg, max_angle_deg : float
        Extreme corner angles, in degrees.
    shortest_edge, median_edge, longest_edge : float
    genera : tuple of int or None
        Genus of each component after duplicates are merged; None where it is not a closed manifold. With more than 1000
        components, the genus of the whole mesh alone.
    sheets : int
        Components whose relative vector area is that of a sheet, which encloses no volume.
    coarse_fraction : float
        Fraction of the faces with an edge that is long relative to the local thickness.
    roughness : float
        Height of noise, in edge lengths, as :func:`lbskel.geometry.roughness.roughness` measures it.
    diameter_bound, area : float
        In the units of the mesh.
    volume : float or None
        In the units of the mesh; None unless the mesh is a closed manifold.
    findings : tuple of str
        A sentence for each defect, and for each step that preprocessing takes by default.
    is_advised : bool
        Whether a skeleton can be expected to represent the shape.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import flat_grid
    >>> report = lbskel.check(flat_grid(4, 4))
    >>> report.faces
    18
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
    self_intersecting_faces: int
    self_intersection_sample: float
    duplicate_vertices: int
    duplicate_faces: int
    repeated_corners: int
    unreferenced_vertices: int
    zero_area_faces: int
    needles: int
    caps: int
    min_angle_deg: float
    max_angle_deg: float
    shortest_edge: float
    median_edge: float
    longest_edge: float
    genera: tuple[int | None, ...]
    sheets: int
    coarse_fraction: float
    roughness: float
    diameter_bound: float
    area: float
    volume: float | None
    findings: tuple[str, ...] = ()
    is_advised: bool = True

    def as_dict(self) -> dict[str, Any]:
        """Return all fields as a dictionary that JSON can hold."""
        return asdict(self)

    def __str__(self) -> str:
        counts = Counter("open" if genus is None else f"genus {genus}" for genus in self.genera).most_common()
        genera = ", ".join(kind if len(self.genera) == 1 else f"{n:,} {kind}" for kind, n in counts[:MAX_GENERA_SHOWN])
        more = ", ..." if len(counts) > MAX_GENERA_SHOWN else ""
        edges = f"{self.shortest_edge:.2g}, {self.median_edge:.2g}, {self.longest_edge:.2g}"
        lines = [
            f"{counted(self.vertices, 'vertex')}, {counted(self.faces, 'face')}, "
            f"{counted(self.components, 'component')}: {genera}{more}",
            f"  edges     shortest, median and longest {edges} of the diameter bound, {self.diameter_bound:.6g}",
            f"  angles    {self.min_angle_deg:.2g} to {self.max_angle_deg:.4g} degrees",
            *(f"  found     {finding}" for finding in self.findings or ["Nothing that prevents a skeleton."]),
        ]
        return "\n".join(lines)


def check(mesh: Any) -> MeshReport:
    """Measure a mesh and list its defects before it is contracted.

    Parameters
    ----------
    mesh : Mesh, (vertices, faces), path or mesh object

    Returns
    -------
    MeshReport
        ``print`` shows it as ``lbskel check`` does.

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
    1 hole in the surface. 1 hole is closed with 1 face.
    """
    mesh = as_mesh(mesh)
    prepared = preprocess_mesh(mesh)
    cleaned = clean(mesh).mesh
    F = mesh.faces
    is_distinct = (F[:, 0] != F[:, 1]) & (F[:, 1] != F[:, 2]) & (F[:, 2] != F[:, 0])
    angles = np.degrees(corner_angles(mesh.vertices[F[is_distinct]])) if is_distinct.any() else np.zeros((1, 3))
    start, end = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    bound = mesh.diameter_bound
    lengths = vector_lengths(end - start) / (bound or 1.0)
    is_cap = angles.max(axis=1) > 180 - DEGENERATE_ANGLE
    intersecting, tested = self_intersecting_faces(cleaned)
    directed = mesh.half_edges[:, 0] * len(mesh.vertices) + mesh.half_edges[:, 1]
    is_interior = mesh.faces_per_edge[mesh.edge_of_half_edge] == 2
    parts = [part.mesh for part in components(cleaned)] if cleaned.n_components <= MAX_COMPONENTS else [cleaned]
    umbrellas = find_umbrellas(cleaned)
    report = MeshReport(
        vertices=len(mesh.vertices),
        faces=len(F),
        components=mesh.n_components,
        boundary_loops=len(boundary_loops(cleaned)),
        boundary_edges=int((mesh.faces_per_edge == 1).sum()),
        nonmanifold_edges=int((mesh.faces_per_edge > 2).sum()),
        nonmanifold_vertices=len(np.unique(cleaned.faces[umbrellas.of_corner != cleaned.faces])),
        misoriented_edges=int(is_interior.sum() - len(np.unique(directed[is_interior]))),
        is_inside_out=bool(cleaned.is_closed_manifold and cleaned.volume < 0),
        self_intersecting_faces=len(intersecting),
        self_intersection_sample=tested,
        duplicate_vertices=len(mesh.used_vertices) - len(np.unique(mesh.vertices[mesh.used_vertices], axis=0)),
        duplicate_faces=int(is_distinct.sum()) - len(np.unique(np.sort(F[is_distinct], axis=1), axis=0)),
        repeated_corners=int((~is_distinct).sum()),
        unreferenced_vertices=len(mesh.vertices) - len(mesh.used_vertices),
        zero_area_faces=int((mesh.face_areas <= MIN_FACE_AREA * bound**2).sum()),
        needles=int(((angles.min(axis=1) < DEGENERATE_ANGLE) & ~is_cap).sum()),
        caps=int(is_cap.sum()),
        min_angle_deg=float(angles.min()),
        max_angle_deg=float(angles.max()),
        shortest_edge=float(lengths.min()),
        median_edge=float(np.median(lengths)),
        longest_edge=float(lengths.max()),
        genera=tuple(part.genus for part in parts),
        sheets=sum(relative_vector_area(part) > MIN_SHEET_VECTOR_AREA for part in parts),
        coarse_fraction=float(coarse_faces(cleaned, COARSE_EDGE).mean()),
        roughness=roughness(cleaned),
        diameter_bound=bound,
        area=mesh.area,
        volume=mesh.volume if mesh.is_closed_manifold else None,
    )
    reasons = reasons_against_contraction(prepared)
    findings = (*describe_findings(report.as_dict(), prepared.notes), *reasons)
    return replace(report, findings=findings, is_advised=not reasons)
