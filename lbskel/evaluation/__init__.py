"""Scores of skeletons, distances to known skeletons, and diagnostics of discrete Laplacians."""

from lbskel.evaluation.ground_truth import GroundTruthDistances, ground_truth_distances
from lbskel.evaluation.measures import MEASURES, Measure, Score
from lbskel.evaluation.operator_health import laplacian_diagnostics
from lbskel.evaluation.operator_report import LaplacianDiagnostics

__all__ = [
    "MEASURES",
    "GroundTruthDistances",
    "LaplacianDiagnostics",
    "Measure",
    "Score",
    "ground_truth_distances",
    "laplacian_diagnostics",
]
