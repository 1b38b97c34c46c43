"""Preprocessing of meshes and clouds: check, repair, simplify, remesh; the only package that imports pymeshlab."""

__all__ = [
    "CLOUD_PREPARATIONS",
    "MAX_FACES",
    "PIPELINES",
    "PREPARATIONS",
    "STEPS",
    "MeshReport",
    "Pipeline",
    "PreprocessResult",
    "check",
    "face_budget",
    "is_flat_sheet",
    "is_sheet",
    "name_component",
    "oriented_surface",
    "preprocess_mesh",
    "reconstruct_surface",
    "simplify",
    "simplify_to_proxy",
    "surface_with_proxy",
    "why_no_inside",
]

from lbskel.preprocess.automatic import PREPARATIONS, preprocess_mesh
from lbskel.preprocess.diagnostics import MeshReport, check
from lbskel.preprocess.orientability import is_flat_sheet, is_sheet, name_component, why_no_inside
from lbskel.preprocess.outward_faces import oriented_surface
from lbskel.preprocess.pipelines import PIPELINES, STEPS, Pipeline
from lbskel.preprocess.point_cleaning import CLOUD_PREPARATIONS
from lbskel.preprocess.proxy import MAX_FACES, face_budget, simplify_to_proxy, surface_with_proxy
from lbskel.preprocess.reconstruction import reconstruct_surface
from lbskel.preprocess.result import PreprocessResult
from lbskel.preprocess.simplification import simplify
