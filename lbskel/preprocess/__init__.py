"""From the mesh that a user has to one that the algorithms can take; the only place that may import pymeshlab."""

__all__ = [
    "PIPELINES",
    "PREPARATIONS",
    "STEPS",
    "MeshReport",
    "Pipeline",
    "PreprocessResult",
    "check",
    "prepare",
    "simplify",
    "why_no_inside",
]

from lbskel.preprocess.automatic import PREPARATIONS, prepare
from lbskel.preprocess.diagnostics import MeshReport, check
from lbskel.preprocess.orientability import why_no_inside
from lbskel.preprocess.pipelines import PIPELINES, STEPS, Pipeline
from lbskel.preprocess.result import PreprocessResult
from lbskel.preprocess.simplification import simplify
