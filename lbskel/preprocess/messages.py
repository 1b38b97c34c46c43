"""The measures of a mesh as sentences: what was found, and what preprocessing does about it."""

from __future__ import annotations

__all__ = ["as_sentence", "describe_findings", "reasons_against_contraction"]

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from lbskel.errors import counted, first_few
from lbskel.geometry.components import MIN_FACES, components
from lbskel.geometry.roughness import ROUGHNESS_LIMIT
from lbskel.preprocess.automatic import COARSE_EDGE, MAX_COARSE_FRACTION, MAX_FRAGMENT_AREA, removed_fraction
from lbskel.preprocess.orientability import why_no_inside
from lbskel.preprocess.orientation import MIN_SHEET_VECTOR_AREA, relative_vector_area
from lbskel.preprocess.result import PreprocessResult

MAX_EDGE_RATIO = 1e4  # longest over shortest edge above which remeshing is suggested; a guess

MAX_COMPONENTS_NAMED = 2  # components without an inside that are named in a sentence

# For each measure that should be 0: the sentence for one, for several, and its end. What is done about it say the notes
# of the preprocessing, which alone name vertices without faces, duplicate faces and repeated corners.
_DEFECTS: dict[str, tuple[str, str, str]] = {
    "duplicate_vertices": ("vertex lies", "vertices lie", "at the position of another"),
    "boundary_loops": ("hole", "holes", "in the surface"),
    "nonmanifold_edges": (
        "edge has",
        "edges have",
        "more than two faces: if not split, handled by the robust operator",
    ),
    "nonmanifold_vertices": ("vertex joins", "vertices join", "surfaces that share no edge there"),
    "misoriented_edges": ("edge lies", "edges lie", "between faces of opposite orientation"),
    "self_intersecting_faces": ("face intersects", "faces intersect", "others: kept, the skeleton may leave the shape"),
    "needles": ("needle triangle", "needle triangles", "(angle near 0): if not removed, handled by the operator"),
    "caps": ("cap triangle", "cap triangles", "(angle near 180 degrees): if not removed, handled by the operator"),
    "zero_area_faces": ("face has", "faces have", "no area: if not removed, handled by the operator"),
}


def as_sentence(note: str) -> str:
    """Write a note of what was done as a sentence of what is done when a skeleton is made.

    Parameters
    ----------
    note : str
        As preprocessing makes it: without a capital and a full stop.
    """
    return f"{note[0].upper()}{note[1:]}.".replace(" was ", " is ").replace(" were ", " are ")


def describe_findings(facts: Mapping[str, Any], notes: Iterable[str]) -> tuple[str, ...]:
    """Write one sentence for each defect, and for each thing that preprocessing does.

    Parameters
    ----------
    facts : mapping
        The fields of a :class:`~lbskel.preprocess.diagnostics.MeshReport`.
    notes : iterable of str
        Those of :func:`~lbskel.preprocess.automatic.preprocess_mesh`.
    """
    found = []
    for name, (one, many, action) in _DEFECTS.items():
        if count := facts[name]:
            found.append(f"{count:,} {one if count == 1 else many} {action}.")
    sample = facts["self_intersection_sample"]
    if sample < 1 and facts["self_intersecting_faces"]:
        share = f"{sample:.0%}" if sample >= 0.01 else "Less than 1%"
        found.append(f"{share} of the faces were tested for self-intersections, so there may be more.")
    if facts["is_inside_out"]:
        found.append("The surface is inside out.")
    if facts["components"] > 1:
        found.append(f"{facts['components']:,} components: each that is not removed gets a graph of its own.")
    # noise makes edges long, so a rough surface is not called coarse
    if facts["coarse_fraction"] > MAX_COARSE_FRACTION and facts["roughness"] <= ROUGHNESS_LIMIT:
        found.append(
            f"{facts['coarse_fraction']:.0%} of the faces have an edge longer than {COARSE_EDGE:g} of the local "
            "thickness."
        )
    if facts["roughness"] > ROUGHNESS_LIMIT:
        found.append("The surface is rough, with noise higher than a sixth of its edge length.")
    if facts["longest_edge"] > MAX_EDGE_RATIO * facts["shortest_edge"]:
        found.append("The longest edge is over 10,000 times the shortest: remeshing would help.")
    return (*found, *map(as_sentence, notes))


def reasons_against_contraction(result: PreprocessResult) -> tuple[str, ...]:
    """Explain why no skeleton can be expected to represent a preprocessed mesh; empty if one can.

    Parameters
    ----------
    result : PreprocessResult
        Of :func:`~lbskel.preprocess.automatic.preprocess_mesh`.
    """
    prepared = result.mesh
    label = prepared.component_of_vertex[prepared.faces[:, 0]]
    is_small = np.bincount(label) < MIN_FACES
    areas = np.bincount(label, prepared.face_areas)
    if not areas.sum() > 0:
        return ("Contraction is not advised: the faces have no area.",)
    if len(prepared.faces) < MIN_FACES:
        return (f"Contraction is not advised: a surface of {counted(len(prepared.faces), 'face')} has no inside.",)
    if max(areas[is_small].sum() / areas.sum(), removed_fraction(result)) > MAX_FRAGMENT_AREA:
        return ("Contraction is not advised: most faces are not connected; raise the tolerance of merge_close.",)
    bodies = [
        (number, part)
        for number, part in enumerate(components(prepared))
        if len(part.mesh.faces) >= MIN_FACES and part.mesh.area > 0
    ]
    if faults := [fault for number, part in bodies if (fault := why_no_inside(number, part, prepared))]:
        return (f"Contraction is not advised: {first_few(faults, MAX_COMPONENTS_NAMED)}.",)
    if relative_vector_area(prepared) > MIN_SHEET_VECTOR_AREA:
        return ("Contraction is not advised: the surface is a sheet that encloses no volume.",)
    return ()
