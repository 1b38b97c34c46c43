"""What the measures of a mesh mean, in plain sentences, and what lbskel does about each."""

from __future__ import annotations

__all__ = ["FEWEST_FACES", "advised", "sentences"]

from collections.abc import Mapping
from typing import Any

import numpy as np

from lbskel.errors import first_few
from lbskel.geometry.components import components
from lbskel.geometry.mesh import Mesh
from lbskel.preprocess.automatic import COARSE_EDGE, COARSE_SHARE
from lbskel.preprocess.noise import ROUGH
from lbskel.preprocess.orientability import why_no_inside
from lbskel.preprocess.orientation import SHEET, relative_vector_area

FEWEST_FACES = 4  # of a component that can enclose anything
LOOSE = 0.5  # share of the area in components of fewer faces: beyond, it is a soup that stays one
UNEVEN = 1e4  # longest edge over shortest

# What to say where a measure is not 0: one, several, and what is done
_SAYINGS: dict[str, tuple[str, str, str]] = {
    "duplicate_vertices": ("vertex lies", "vertices lie", "at the place of another: merged with it"),
    "duplicate_faces": ("face copies", "faces copy", "another: left out"),
    "repeated_corners": ("face names", "faces name", "a vertex twice: left out"),
    "unreferenced_vertices": ("vertex belongs", "vertices belong", "to no face: mapped to the nearest node"),
    "boundary_loops": ("hole: it is", "holes: they are", "closed, unless it is the rim of a sheet"),
    "nonmanifold_edges": ("edge has", "edges have", "more than two faces: taken as it is, by the robust operator"),
    "nonmanifold_vertices": ("vertex joins", "vertices join", "surfaces that share no edge there: taken as it is"),
    "misoriented_edges": ("edge lies", "edges lie", "between faces that disagree which side is out: turned round"),
    "crossing_faces": ("face cuts", "faces cut", "through others: taken as it is, the skeleton may leave the shape"),
    "needles": ("needle, a face", "needles, faces", "with almost no angle: weighed so that it does no harm"),
    "caps": ("cap, a face", "caps, faces", "with almost no height: weighed so that it does no harm"),
    "zero_area_faces": ("face has", "faces have", "no area: weighed so that it does no harm"),
}


def sentences(facts: Mapping[str, Any]) -> tuple[str, ...]:
    """One for each finding."""
    found = []
    for name, (one, many, does) in _SAYINGS.items():
        if count := facts[name]:
            found.append(f"{count:,} {one if count == 1 else many} {does}.")
    if 0 < facts["crossings_tested"] < 1 and facts["crossing_faces"]:
        found.append(f"{facts['crossings_tested']:.0%} of the faces were tested for cutting through others.")
    if facts["is_inside_out"]:
        found.append("The surface is inside out: turned round.")
    if facts["components"] > 1:
        found.append(f"{facts['components']:,} components: each gets a graph of its own.")
    if facts["coarse_faces"] > COARSE_SHARE and facts["roughness"] <= ROUGH:  # noise makes edges long
        found.append(
            f"{facts['coarse_faces']:.0%} of the faces have an edge longer than {COARSE_EDGE:g} of the thickness: "
            "split, where the mesh is small."
        )
    if facts["roughness"] > ROUGH:
        found.append("The surface is rough, by noise of more than a third of its edges' length: smoothed.")
    if facts["longest_edge"] > UNEVEN * facts["shortest_edge"]:
        found.append("The longest edge is over 10,000 times the shortest: remeshing would help.")
    return tuple(found)


def advised(facts: Mapping[str, Any], prepared: Mesh) -> tuple[str, ...]:
    """Why no skeleton can be expected to stand for the shape, as it is after preparation; empty if it can."""
    label = prepared.component_of_vertex[prepared.faces[:, 0]]
    is_small = np.bincount(label) < FEWEST_FACES
    areas = np.bincount(label, prepared.face_areas)
    if not areas.sum() > 0:
        return ("Contraction is not advised: the faces have no area.",)
    if areas[is_small].sum() > LOOSE * areas.sum():
        return ("Contraction is not advised: most faces hang together with no others; raise merge_close's tolerance.",)
    bodies = [
        (n, p) for n, p in enumerate(components(prepared)) if len(p.mesh.faces) >= FEWEST_FACES and p.mesh.area > 0
    ]
    if faults := [fault for number, part in bodies if (fault := why_no_inside(number, part, prepared))]:
        return (f"Contraction is not advised: {first_few(faults, 2)}.",)
    if relative_vector_area(prepared) > SHEET:
        return ("Contraction is not advised: the surface is a sheet that encloses nothing.",)
    return ()
