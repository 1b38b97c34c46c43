"""lbskel: discrete Laplace-Beltrami operators and curve skeletons by Laplacian contraction."""

from lbskel.applications.spectrum import eigenpairs
from lbskel.contraction.flow import PRESETS, Contraction, ContractionSettings, Status, Step, contract
from lbskel.contraction.settings import STRATEGIES
from lbskel.contraction.surgery import CollapsedGraph, collapse, collapse_mesh
from lbskel.contraction.weights import WEIGHTS
from lbskel.errors import (
    FormatError,
    LbskelError,
    MeshError,
    MissingDependency,
    OperatorError,
    SolveError,
    UnknownChoice,
)
from lbskel.evaluation.ground_truth import GroundTruthDistances, ground_truth_distances
from lbskel.evaluation.operator_health import LaplacianDiagnostics, laplacian_diagnostics
from lbskel.evaluation.measures import Score
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io import as_mesh, read_mesh, read_points, read_skeleton, write_mesh, write_skeleton
from lbskel.operators import OPERATORS, Laplacian, laplacian
from lbskel.pipeline.assembly import assemble
from lbskel.pipeline.batch import skeletonize_many
from lbskel.pipeline.evaluation import score
from lbskel.pipeline.preparation import Body, PreparedMesh, prepare
from lbskel.pipeline.stages import refine, skeletonize, to_skeleton
from lbskel.preprocess import PIPELINES, MeshReport, Pipeline, PreprocessResult, check
from lbskel.skeleton.joining import join_components
from lbskel.skeleton.pruning import merge_junctions, prune
from lbskel.skeleton.resampling import resample
from lbskel.skeleton.simplification import simplify_branches
from lbskel.skeleton.skeleton import Skeleton
from lbskel.solvers import SOLVERS, factorize
from lbskel.solvers.least_squares import LEAST_SQUARES, lstsq

__version__ = "0.1.0"

__all__ = [
    "LEAST_SQUARES",
    "OPERATORS",
    "PIPELINES",
    "PRESETS",
    "SOLVERS",
    "STRATEGIES",
    "WEIGHTS",
    "Body",
    "CollapsedGraph",
    "Contraction",
    "ContractionSettings",
    "FormatError",
    "GroundTruthDistances",
    "Laplacian",
    "LaplacianDiagnostics",
    "LbskelError",
    "Mesh",
    "MeshError",
    "MeshReport",
    "MissingDependency",
    "OperatorError",
    "Pipeline",
    "PointCloud",
    "PreparedMesh",
    "PreprocessResult",
    "Score",
    "Skeleton",
    "SolveError",
    "Status",
    "Step",
    "UnknownChoice",
    "as_mesh",
    "assemble",
    "check",
    "collapse",
    "collapse_mesh",
    "contract",
    "eigenpairs",
    "factorize",
    "ground_truth_distances",
    "join_components",
    "laplacian",
    "laplacian_diagnostics",
    "lstsq",
    "merge_junctions",
    "prepare",
    "prune",
    "read_mesh",
    "read_points",
    "read_skeleton",
    "refine",
    "resample",
    "score",
    "simplify_branches",
    "skeletonize",
    "skeletonize_many",
    "to_skeleton",
    "write_mesh",
    "write_skeleton",
]
