"""What a mesh needs before it is contracted, and no more: a sound closed surface, fine and smooth enough, is kept."""

from __future__ import annotations

__all__ = ["COARSE_EDGE", "COARSE_SHARE", "PREPARATIONS", "preprocess_mesh"]

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import MeshError, UnknownChoice
from lbskel.geometry.mesh import Mesh
from lbskel.preprocess.cleaning import merge_close, remove_duplicates, tidy, without_unused
from lbskel.preprocess.degenerate_faces import remove_degenerate
from lbskel.preprocess.holes import close_holes
from lbskel.preprocess.noise import ROUGH, roughness
from lbskel.preprocess.orientation import fix_orientation, split_nonmanifold
from lbskel.preprocess.pipelines import PIPELINES, Pipeline
from lbskel.preprocess.remeshing import smooth_noise
from lbskel.preprocess.result import PreprocessResult, identity_result, measured
from lbskel.preprocess.subdivision import coarse_share, refine

AUTOMATIC = "auto"
PREPARATIONS = (AUTOMATIC, "none", *PIPELINES)

LARGEST = 1e75  # whose fourth powers, of sums over vertices, are finite

COARSE_EDGE = 0.8  # of the local thickness; of low-poly shapes, 0.5 and 0.8 measured alike, and 0.8 has fewer faces
COARSE_SHARE = 0.1  # of the faces; meshes with fewer measured no better for being refined
LARGEST_HOLE = 1.0  # rim against diagonal: the ends of pipes too, since a capped end is a tip and gives an inside
CRUMB = 0.01  # of the largest component's area: smaller open pieces are what fell off around holes
LINE = 0.01  # degrees: of faces that are no more than a line, as closing T-junctions makes them
FEW_FACES = 20_000  # more are not too coarse, or long to measure
SMOOTHINGS = 60  # of noise of up to a limb's radius; 30 left skeletons a fifth further off, 120 were a tenth better


def preprocess_mesh(mesh: Mesh, how: str | Pipeline | None = AUTOMATIC) -> PreprocessResult:
    """The mesh to be contracted, and the way of the vertices to it.

    Parameters
    ----------
    mesh : Mesh
    how : str, Pipeline or None
        ``auto`` for what it needs; ``none`` or None for nothing; a name in PIPELINES, steps as text, or a TOML file.

    Raises
    ------
    MeshError
        If coordinates are so large that areas and volumes overflow.
    UnknownChoice
        If there is no such pipeline or step.
    """
    largest = float(np.abs(mesh.vertices).max())
    if largest > LARGEST:
        raise MeshError(
            f"the coordinates of vertex {np.abs(mesh.vertices).max(axis=1).argmax()} are as large as {largest:.3g}: "
            f"beyond {LARGEST:g} areas and volumes overflow; scale the mesh down"
        )
    if how is None or how == "none":
        return identity_result(mesh)
    if how == AUTOMATIC:
        return _needed(mesh)
    if not isinstance(how, Pipeline | str):
        raise UnknownChoice(f"preprocess must be a Pipeline, a name or None, not {type(how).__name__}")
    return (how if isinstance(how, Pipeline) else Pipeline.parse(how))(mesh)


def _needed(mesh: Mesh) -> PreprocessResult:
    """Tidied; made a closed manifold as far as that changes nothing but damage; smoothed if rough, split if coarse."""
    result = tidy(mesh)
    if not result.mesh.is_closed_manifold:
        result = result.compose(merge_close).compose(remove_duplicates).compose(fix_orientation)
        result = result.compose(_without_crumbs).compose(lambda given: close_holes(given, largest=LARGEST_HOLE))
        result = result.compose(lambda given: remove_degenerate(given, angle=LINE))
        apart = result.compose(split_nonmanifold)
        if apart.mesh.is_closed_manifold and _areas(apart.mesh).min() >= CRUMB * _areas(apart.mesh).max():
            result = apart  # bodies that touch; no wall, fin or crumb
    elif result.mesh.volume < 0:
        result = result.compose(fix_orientation)
    if roughness(result.mesh) > ROUGH:
        result = result.compose(lambda given: smooth_noise(given, iterations=SMOOTHINGS))
    if len(result.mesh.faces) <= FEW_FACES and coarse_share(result.mesh, COARSE_EDGE) > COARSE_SHARE:
        result = result.compose(lambda given: refine(given, edge=COARSE_EDGE))
    steps = [step for step in result.report.get("steps", []) if step["notes"]]
    result.report.update(pipeline=AUTOMATIC, steps=steps)
    return result


def _areas(mesh: Mesh) -> NDArray[np.float64]:
    """(c,) area of each component."""
    return np.asarray(np.bincount(mesh.component_of_vertex[mesh.faces[:, 0]], mesh.face_areas), dtype=np.float64)


@measured
def _without_crumbs(mesh: Mesh) -> PreprocessResult:
    """The mesh without its smallest open components; small closed ones are bodies of their own."""
    label = mesh.component_of_vertex[mesh.faces[:, 0]]
    areas = _areas(mesh)
    is_open = np.zeros(len(areas), dtype=bool)
    is_open[mesh.component_of_vertex[mesh.edges[mesh.faces_per_edge == 1]]] = True
    is_crumb = is_open & (areas < CRUMB * areas.max())
    if not is_crumb.any():
        return identity_result(mesh)
    note = f"{is_crumb.sum()} open components of less than {CRUMB:g} of the largest one's area were left out"
    return without_unused(mesh, mesh.faces[~is_crumb[label]], note)
