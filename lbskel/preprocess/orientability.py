"""Whether a connected surface has an inside at all, without which no curve can run through its middle.

A sheet has none either, but a curve along it is of use. What is flat has its two sides in one place, and nothing is
between them. A surface of one side, as a Moebius strip, has no orientation, so neither side of it is the inside; where
nearly all of it still parts an inside from an outside, by the winding numbers on both sides, it is a body with a fault.
"""

from __future__ import annotations

__all__ = ["no_inside", "why_no_inside"]

import igl
import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.components import Component
from lbskel.geometry.mesh import Mesh

FLAT = 1e-5  # of the extent: a thickness below cannot be told from none by rays, which start as far beside their face
SAMPLE = 500  # faces that are asked what they part
BESIDE = 1e-4  # of the extent: how far from a face its two sides are looked at
INSIDE, OUTSIDE = 0.75, 0.25  # winding numbers beyond which a side is one or the other; a strip has a half on each
PARTING = 0.5  # share of the area that must part an inside from an outside


def why_no_inside(number: int, part: Component, whole: Mesh) -> str:
    """Which component has no inside, at which place of the whole, why, and the way out; empty if it may have one."""
    found = no_inside(part.mesh)
    if found is None:
        return ""
    reason, vertex = found
    place = ", ".join(f"{x:.6g}" for x in whole.vertices[part.vertices[vertex]])
    return f"component {number}, at ({place}), {reason}"


def no_inside(mesh: Mesh) -> tuple[str, int] | None:
    """Why nothing can lie inside a connected surface with an area, and a vertex where that shows; None if it may."""
    if not mesh.is_closed_manifold:
        seam = _seam(mesh)
        if len(seam) == 0 or _parting_share(mesh) > PARTING:
            return None
        return "has one side only, as a Moebius strip has: give it a thickness, or cut it open there", int(seam[0])
    is_unit = 0.5 <= mesh.diameter_bound <= 2  # so that no product of lengths underflows
    unit = mesh if is_unit else mesh.with_vertices((mesh.vertices - mesh.centroid) / mesh.diameter_bound)
    apart = 2 * abs(unit.volume) / (unit.area * unit.diameter_bound) if unit.area > 0 else 0.0
    if apart > FLAT:
        return None
    reason = f"has its sides {apart:.1g} of its extent apart, too near to tell inside from outside: give it a thickness"
    return reason, int(mesh.faces[0, 0])


def _seam(mesh: Mesh) -> NDArray[np.int64]:
    """Vertices at edges whose two faces disagree however faces are turned; empty where the surface has two sides."""
    turned = Mesh(mesh.vertices, igl.bfs_orient(mesh.faces)[0])
    start, end = turned.half_edges.T
    balance = np.bincount(turned.edge_of_half_edge, weights=np.where(start < end, 1, -1))
    return turned.edges[(turned.faces_per_edge == 2) & (balance != 0)].ravel()


def _parting_share(mesh: Mesh) -> float:
    """The share of the area that has an inside on one of its sides and an outside on the other, from a sample."""
    chosen = np.arange(0, len(mesh.faces), 1 + len(mesh.faces) // SAMPLE)
    A, B, C = mesh.vertices[mesh.faces[chosen]].transpose(1, 0, 2)
    normals = np.cross(B - A, C - A)
    areas = np.linalg.norm(normals, axis=1)
    aside = (
        BESIDE
        * mesh.diameter_bound
        * np.divide(normals, areas[:, None], out=np.zeros_like(A), where=areas[:, None] > 0)
    )
    centers = (A + B + C) / 3
    places = np.concatenate([centers - aside, centers + aside])
    around = np.abs(igl.fast_winding_number(mesh.vertices, mesh.faces, places)).reshape(2, -1)
    parts = (around.max(axis=0) > INSIDE) & (around.min(axis=0) < OUTSIDE)
    return float(areas[parts].sum() / areas.sum()) if areas.any() else 0.0
