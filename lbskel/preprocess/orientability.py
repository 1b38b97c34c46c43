"""Whether a connected surface has an inside, in which a curve skeleton can lie.

Two kinds of surface have none. A flattened closed surface has both of its sides at the same position. A non-orientable
surface, as a Moebius strip, has no inner side; but if the winding number shows that most of it separates an inside from
an outside, it is taken for a body with a defect. An open sheet has no inside either, and is accepted all the same: a
curve along it is of use. It is told, and a flat one is no piece of a limb.
"""

from __future__ import annotations

__all__ = ["is_flat_sheet", "is_sheet", "name_component", "no_inside", "why_no_inside"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.components import Component
from lbskel.geometry.mesh import Mesh
from lbskel.geometry.normals import normalized, triangle_normals, vector_lengths
from lbskel.preprocess.orientation import MIN_SHEET_VECTOR_AREA, relative_vector_area

# Mean thickness, relative to the diameter bound, below which a closed surface counts as flat: rays start this far from
# their face (RAY_OFFSET of lbskel.geometry.shape_diameter) and cannot measure less. Of an open one, the share of the
# area that its normals lose by their directions; they are within 0.3 degrees.
MIN_THICKNESS = 1e-5

MAX_SAMPLES = 500  # faces, at most about this many, whose two sides are compared; a guess that bounds the time

SIDE_OFFSET = 1e-4  # distance from a face, relative to the diameter bound, at which its sides are tested; a guess

# Winding numbers above which a point is inside and below which it is outside; both sides of a Moebius strip have one
# half. Guesses.
MIN_INSIDE_WINDING, MAX_OUTSIDE_WINDING = 0.75, 0.25

MIN_SEPARATING_FRACTION = 0.5  # fraction of the area that must separate an inside from an outside; a guess


def why_no_inside(number: int, part: Component, whole: Mesh) -> str:
    """Explain which component has no inside, where, why, and what to do; empty if it may have one.

    Parameters
    ----------
    number : int
        Number of the component, for the message.
    part : Component
    whole : Mesh
        The mesh that the component belongs to, in the caller's coordinates.
    """
    found = no_inside(part.mesh)
    if found is None:
        return ""
    reason, vertex = found
    return f"{name_component(number, whole.vertices[part.vertices[vertex]])}, {reason}"


def name_component(number: int, position: NDArray[np.float64]) -> str:
    """Name a component in a message, by its number and a (3,) position on it in the caller's coordinates.

    Parameters
    ----------
    number : int
    position : (3,) array of float
    """
    return f"component {number}, at ({', '.join(f'{x:.6g}' for x in position)})"


def no_inside(mesh: Mesh) -> tuple[str, int] | None:
    """Find why a connected surface of positive area has no inside, and a vertex where that shows; None if it has one.

    Parameters
    ----------
    mesh : Mesh
        Connected.
    """
    if not mesh.is_closed_manifold:
        seam = _orientation_seam(mesh)
        if len(seam) == 0 or _separating_fraction(_in_unit_size(mesh)) > MIN_SEPARATING_FRACTION:
            return None
        return "is non-orientable, as a Moebius strip is: give it a thickness, or cut it open there", int(seam[0])
    unit = _in_unit_size(mesh)  # so that no product of lengths underflows
    thickness = 2 * abs(unit.volume) / (unit.area * unit.diameter_bound) if unit.area > 0 else 0.0
    if thickness > MIN_THICKNESS:
        return None
    reason = f"is flat, its two sides only {thickness:.1g} of its diameter apart: give it a thickness"
    return reason, int(mesh.faces[0, 0])


def is_sheet(mesh: Mesh) -> bool:
    """Whether a connected surface is open and faces one way, so that it encloses no volume, as a hemisphere and more.

    Parameters
    ----------
    mesh : Mesh
        Consistently oriented.
    """
    return not mesh.is_closed and relative_vector_area(mesh) > MIN_SHEET_VECTOR_AREA


def is_flat_sheet(mesh: Mesh) -> bool:
    """Whether a connected surface is open and flat, as the ground that a scene stands on.

    Parameters
    ----------
    mesh : Mesh
        Consistently oriented.
    """
    return not mesh.is_closed and relative_vector_area(mesh) > 1 - MIN_THICKNESS


def _in_unit_size(mesh: Mesh) -> Mesh:
    """Center a mesh, and divide it by its diameter bound."""
    return mesh.with_vertices((mesh.vertices - mesh.centroid) / mesh.diameter_bound)


def _orientation_seam(mesh: Mesh) -> NDArray[np.int64]:
    """Vertices of edges whose faces have opposite orientation after reorientation; empty for an orientable surface."""
    seam = _unbalanced_edges(mesh)
    return seam if len(seam) == 0 else _unbalanced_edges(Mesh(mesh.vertices, igl.bfs_orient(mesh.faces)[0]))


def _unbalanced_edges(mesh: Mesh) -> NDArray[np.int64]:
    """Vertices of edges with two faces that run along them in the same direction."""
    start, end = mesh.half_edges.T
    balance = np.bincount(mesh.edge_of_half_edge, weights=np.where(start < end, 1, -1))
    vertices: NDArray[np.int64] = mesh.edges[(mesh.faces_per_edge == 2) & (balance != 0)].ravel()
    return vertices


def _separating_fraction(mesh: Mesh) -> float:
    """Estimate the fraction of the area with the inside on one side and the outside on the other, from a sample.

    Parameters
    ----------
    mesh : Mesh
        Centered and of unit size: the winding numbers are those of positions in single precision.
    """
    chosen = np.arange(0, len(mesh.faces), 1 + len(mesh.faces) // MAX_SAMPLES)
    A, B, C = mesh.vertices[mesh.faces[chosen]].transpose(1, 0, 2)
    normals = triangle_normals(A, B, C)
    areas = vector_lengths(normals)
    offsets = SIDE_OFFSET * mesh.diameter_bound * normalized(normals)
    centers = (A + B + C) / 3
    points = np.concatenate([centers - offsets, centers + offsets])
    winding = np.abs(igl.fast_winding_number(mesh.vertices, mesh.faces, points)).reshape(2, -1)
    separates = (winding.max(axis=0) > MIN_INSIDE_WINDING) & (winding.min(axis=0) < MAX_OUTSIDE_WINDING)
    return float(areas[separates].sum() / areas.sum()) if areas.any() else 0.0
